"""The pull-off of paths on nodes: as if every segment were drawn, at the cost of a few states."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import plain, wavy

from discretization import History, load_path
from discretization.lattice.walk import Walk
from discretization.paths.branch import Snapshot
from discretization.paths.control import Control, Curve
from discretization.paths.lattice_branch import LatticeBranch
from discretization.paths.least_force import bounded
from energy import FlatPunch, Parabola, PowerLaw, Sampled, SurfaceEnergies, Wedge


def rough(kind="smooth"):
    """Waves of three lengths on a parabola."""
    x = np.linspace(-15, 15, 601)
    waves = ((1.7, 0.05, 1.0), (2.9, 0.09, 4.0), (5.3, 0.12, 0.3))
    z = 0.004 * x * x + sum(h * np.cos(2 * np.pi * x / length + s) for length, h, s in waves)
    return Sampled(x, z - z.min(), kind=kind)


def about_an_axis(indenter):
    return replace(plain(indenter), geometry="axisymmetric")


def opening(indenter):
    return replace(plain(indenter), opening=SurfaceEnergies.from_work(1.0, 0.05))


LOOP = np.r_[np.linspace(0, 0.5, 20), np.linspace(0.5, 0.1, 8), np.linspace(0.2, -1.5, 60)]
LOADS = {"forces": 0.5 * LOOP}
DRIVES = {"drives": LOOP, "machine_stiffness": 2.0}
DEPTHS = {"depths": LOOP}
CASES = {
    "parabola": (plain(Parabola(20.0)), DEPTHS),
    "parabola under a load": (plain(Parabola(20.0)), LOADS),
    "wedge": (plain(Wedge(0.1)), DEPTHS),
    "steep": (plain(PowerLaw(0.05, 4.0)), DEPTHS),
    "steep, by a machine": (plain(PowerLaw(0.05, 4.0)), DRIVES),
    "punch": (plain(FlatPunch(2.0)), DEPTHS),
    "axis": (about_an_axis(Parabola(20.0)), DEPTHS),
    "axis under a load": (about_an_axis(PowerLaw(0.05, 4.0)), LOADS),
    "rough": (plain(rough()), DEPTHS),
    "rough under a load": (plain(rough()), LOADS),
    "rough, by a machine": (plain(rough()), DRIVES),
    "rough, straight pieces": (plain(rough("linear")), DEPTHS),
    "opening": (opening(Parabola(20.0)), DEPTHS),
    "rough opening": (opening(rough()), DEPTHS),
}
LONG = ("rough opening", "rough, straight pieces")
NAMES = [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in CASES]
# nodes l/24 apart do not resolve the straight pieces, which changes nothing of what is compared
pytestmark = pytest.mark.filterwarnings("ignore:.*narrower than the spacing may be missed")
TURNS = ("steep", "axis")  # where P is least between states


def followed(name):
    scene, programme = CASES[name]
    return load_path(scene, method="lattice", spacing=1 / 24, **programme)


def drawn(path: History) -> Snapshot:
    """The most tensile state of all recorded ones and of all segments, followed and drawn again."""
    runs = [part for part in path.parts if isinstance(part, list)]
    states = [state for run in runs for state in run if not math.isnan(state.left)]
    return min([*states, *path._turns_of_segments()], key=lambda state: state.force)


@pytest.mark.parametrize("name", NAMES)
def test_the_pull_off_is_that_of_drawing_every_segment(name):
    path = followed(name)
    state = drawn(path)
    found = path.pull_off
    sizes = np.abs(path.force).max(), np.ptp(path.depth[np.isfinite(path.depth)]), 1.0
    pairs = zip(found, (state.force, state.depth, state.half_width), sizes, strict=True)
    for value, expected, size in pairs:
        assert value == pytest.approx(expected, rel=0, abs=1e-13 * size)
    if name in TURNS:
        recorded = [*path.force, *(event.force for event in path.events)]
        assert found.force < min(recorded) - 1e-9 * abs(found.force)


@pytest.mark.parametrize("name", NAMES)
def test_no_force_between_two_states_is_below_its_bound(name):
    path = followed(name)
    seen = 0
    for each in bounded(path._branch, [*path._stretches()]):
        depths = each.stretch.depths
        first, last = (path._branch.contact(depths[i], *each.stretch.lines[i]) for i in (0, -1))
        segment = path._branch.segment(first, last.depth)
        curve = Curve.of(segment, Control(0.0))
        direction = each.stretch.direction
        own = np.searchsorted(direction * depths, direction * segment.depths(curve.t), "right") - 1
        bounds = each.bounds[np.clip(own, 0, depths.size - 2)]
        size = np.abs(curve.value).max()
        assert (curve.value >= bounds - 1e-12 * size).all()
        seen += curve.t.size
    assert seen


class Counted:
    """How often parts of a path are walked again, and how many states are drawn."""

    def __init__(self, monkeypatch):
        self.walks = 0
        self.states = 0
        self.segments = 0
        track = Walk.track
        totals = LatticeBranch.totals
        segment = LatticeBranch.segment

        def counted_track(*given):
            self.walks += 1
            return track(*given)

        def counted_totals(branch, points):
            self.states += len(points)
            return totals(branch, points)

        def counted_segment(*given):
            self.segments += 1
            return segment(*given)

        monkeypatch.setattr(Walk, "track", counted_track)
        monkeypatch.setattr(LatticeBranch, "totals", counted_totals)
        monkeypatch.setattr(LatticeBranch, "segment", counted_segment)


@pytest.mark.parametrize(
    ("scene", "programme"),
    [
        (plain(Parabola(20.0)), {"depths": LOOP}),
        (plain(FlatPunch(2.0)), {"depths": LOOP}),
        (plain(rough()), {"depths": LOOP}),
        (wavy(), {"depths": LOOP * 3 * wavy().critical_separation}),
    ],
    ids=["parabola", "punch", "rough", "wavy"],
)
def test_only_what_may_be_less_is_walked_again_and_drawn(monkeypatch, scene, programme):
    """Parts of at most a third of the segments, and a fifth of the states."""
    spacing = scene.elastocapillary_length / 24
    path = load_path(scene, method="lattice", spacing=spacing, **programme)
    with monkeypatch.context() as patched:
        found = Counted(patched)
        assert path.pull_off.force < 0
    every = Counted(monkeypatch)
    assert drawn(path).force == pytest.approx(path.pull_off.force, rel=1e-12, abs=0)
    assert found.segments == 0
    assert 3 * found.walks <= every.walks
    assert 5 * found.states <= every.states


def test_pull_off_of_a_read_or_continued_path(tmp_path):
    """A path read from a file or continued has the same pull off."""
    scene, programme = CASES["rough"]
    path = followed("rough")
    path.to_csv(tmp_path / "path.csv")
    again = History.from_csv(tmp_path / "path.csv")
    given = {"method": "lattice", "spacing": 1 / 24}
    first = load_path(scene, depths=programme["depths"][:35], **given)
    continued = load_path(scene, depths=programme["depths"][35:], after=first, **given)
    for other in (again, continued):
        assert other.pull_off == pytest.approx(path.pull_off, rel=1e-12, abs=0)


def test_what_is_no_event_of_its_path_is_followed_leg_by_leg():
    """Of a path whose events between two contacts are left out, every segment is drawn again."""
    path = followed("rough")
    kept = tuple(event for event in path.events if event.kind not in ("coalescence", "splitting"))
    assert len(kept) < len(path.events)
    lost = replace(path, events=kept)
    assert lost.pull_off == pytest.approx(path.pull_off, rel=1e-9, abs=0)
