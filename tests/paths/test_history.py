"""Histories: saved, read back, continued, and what they are not sure of."""

from contextlib import nullcontext
from dataclasses import fields, replace

import numpy as np
import pytest
from support.comparison import check
from support.example_scenes import adhesive

from discretization import AccuracyWarning, History, load_path
from energy import ElasticLayer, Parabola, PowerLaw, Profile, Sampled, Scene, SurfaceEnergies, Wedge

PROGRAMME = np.r_[np.linspace(-0.001, 0.01, 20), np.linspace(0.01, -0.01, 30)] * 0.7


def identical(a: History, b: History) -> bool:
    """Equal to the last bit, but for the scenes."""
    for name in (field.name for field in fields(History) if field.name not in ("scene", "branch")):
        first = getattr(a, name)
        second = getattr(b, name)
        if name == "events":
            first, second = (repr(tuple(map(plain, events))) for events in (first, second))
        if isinstance(first, np.ndarray):
            first = first.tobytes()
            second = second.tobytes()
        if first != second:
            return False
    return True


def plain(event):
    """An event as nested tuples of Python numbers; repr tells every bit, and nan equals nan."""
    kind, control, before, after, released, step = event
    states = (*before.lines, *before[:3], *after.lines, *after[:3])
    return kind, float(control), *map(float, states), float(released), int(step)


SCENES = [
    adhesive(Parabola(0.02)),
    adhesive(Wedge(0.05).shifted(0.3)),
    adhesive(Parabola(0.02).tilted(0.04)),
    adhesive(Sampled([-0.03, -0.01, 0.0, 0.02, 0.03], [0.01, 0.001, 0.0, 0.004, 0.02])),
]


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: type(s.indenter).__name__)
def test_a_file_keeps_every_bit(scene, tmp_path):
    path = load_path(scene, depths=PROGRAMME)
    path.to_csv(tmp_path / "path.csv")
    again = History.from_csv(tmp_path / "path.csv")
    assert identical(path, again)
    check([*again.pull_off, again.work()], [*path.pull_off, path.work()], 1e-10)  # found again
    assert repr(again.scene.layer) == repr(scene.layer)
    text = (tmp_path / "path.csv").read_text("utf-8")
    assert "force P [force] > 0 compressive" in text and '"scene"' in text


def test_a_scene_given_in_whole_numbers_of_numpy_is_read_again(tmp_path):
    layer = ElasticLayer(np.int64(3), 0.0, np.float32(2.0))
    scene = Scene(layer, SurfaceEnergies.from_work(1.0, 0.01), PowerLaw(1.0, np.int64(2)))
    load_path(scene, depths=[0.1]).to_csv(tmp_path / "path.csv")
    assert History.from_csv(tmp_path / "path.csv").scene == scene
    other = replace(scene, layer=ElasticLayer(np.int64(4), 0.0, 2.0))
    with pytest.raises(ValueError, match="scene"):
        History.from_csv(tmp_path / "path.csv", other)


def test_no_pull_is_no_pull_off():
    path = load_path(adhesive(Wedge(0.05), w=0.0), depths=[1e-3, 2e-3, -1e-3])  # off its tip
    with pytest.raises(ValueError, match=r"least force = \S+ of this path is not tensile; retract"):
        _ = path.pull_off


@pytest.mark.parametrize(
    "programme",
    [
        {"forces": [0.02, 0.05, -0.01, -0.03]},
        {"drives": [0.02, 0.05, -0.04, -0.06], "machine_stiffness": 3.0},
    ],
)
def test_every_control_continues(programme):
    """To rounding: segments begin at another state, and lines are found from there."""
    scene, (name, values) = adhesive(Parabola(0.02)), next(iter(programme.items()))
    whole, first = (load_path(scene, **programme | {name: part}) for part in (values, values[:2]))
    again = load_path(scene, **programme | {name: values[2:]}, after=first)
    for name in ("depth", "force", "energy", "contacts"):
        one = getattr(again, name)
        other = getattr(whole, name)
        size = 1e-13 * np.nanmax(np.abs(other))
        assert np.allclose(one, other, rtol=0, atol=size, equal_nan=True)
    assert [e.kind for e in again.events] == [e.kind for e in whole.events]
    numbers = [[(e.depth, e.force, e.energy_released) for e in p.events] for p in (whole, again)]
    assert (np.abs(np.subtract(*numbers)) <= 1e-13 * np.abs(numbers[0]).max(axis=0)).all()


def test_only_the_same_path_is_continued():
    scene = adhesive(Parabola(0.02))
    other = adhesive(Parabola(0.03))
    first = load_path(scene, depths=PROGRAMME[:25])
    for one, given, told in (
        (other, {"depths": PROGRAMME}, r"scene = Scene\(.* differs"),
        (scene, {"forces": PROGRAMME[:25]}, "control = 'force' differs"),
        (scene, {"depths": PROGRAMME, "rtol": 1e-6}, "rtol = 1e-06 differs"),
    ):
        with pytest.raises(ValueError, match=told):
            load_path(one, after=first, **given)


def test_a_file_of_something_else_is_refused(tmp_path):
    (tmp_path / "no.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="holds no load path"):
        History.from_csv(tmp_path / "no.csv")


def test_a_profile_of_functions_is_read_with_its_scene(tmp_path):
    scene = adhesive(Profile(lambda x: 25 * x**2, lambda x: 50 * x, convex=True))
    path = load_path(scene, depths=PROGRAMME)
    path.to_csv(tmp_path / "path.csv")
    assert identical(path, History.from_csv(tmp_path / "path.csv", scene))
    with pytest.raises(ValueError, match="pass the scene that was used"):
        History.from_csv(tmp_path / "path.csv")


def test_a_file_says_what_was_given_of_the_surface_energies(tmp_path):
    path = tmp_path / "path.csv"
    energies = SurfaceEnergies
    by_work = SurfaceEnergies.from_work
    scene = Scene(ElasticLayer(2e3, 0.31, 6e-5), by_work(0.05, 1e-4), Parabola(0.017))
    for surfaces, told, absent in (
        (energies(0.05, 0.03, 0.0799), '"gamma2": 0.03, "gamma12": 0.0799', ('"w"',)),
        (by_work(0.05, 1e-4), '"w": 0.0001', ("gamma2", "gamma12")),
    ):
        scene = replace(scene, surfaces=surfaces)
        load_path(scene, depths=[0.0, 1e-6]).to_csv(path)
        text = path.read_text("utf-8")
        again = History.from_csv(path).scene
        assert told in text and not [name for name in absent if name in text]
        assert again == scene and repr(again) == repr(scene)
    spelt_out = replace(scene, surfaces=energies(0.05, 1e-4, 0.05))
    assert History.from_csv(path, scene=spelt_out).scene == scene
    assert eval(repr(scene.surfaces)) == scene.surfaces


@pytest.mark.parametrize(("links", "off"), [(30, 1e-3), (60, 2.5e-4), (240, 1.6e-5)])
def test_the_pull_off_of_a_contact_that_shrinks_to_nothing(links, off):
    """A tip is lost as its contact shrinks to nothing, where P = -2 √(2wγ₁): of second order."""
    scene = adhesive(Parabola(0.02))
    length = scene.elastocapillary_length
    w = scene.work_of_adhesion
    path = load_path(scene, depths=PROGRAMME, method="lattice", spacing=length / links)
    lost = path.events[-1]
    assert path.pull_off.force == pytest.approx(-2 * np.sqrt(2 * w * scene.gamma1), rel=off)
    assert lost.depth == pytest.approx(-scene.critical_separation, rel=off)
    assert lost.energy_released == pytest.approx(2 * w * length, rel=2 * off)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


@pytest.mark.parametrize(("links", "off"), [(30, 0.066), (60, 0.033), (240, 0.008)])
def test_a_pull_off_force_of_a_few_links_is_told(links, off):
    """At a corner, if hardly one, the last link lets go before the contact has closed."""
    scene = adhesive(Parabola(0.02) + Wedge(1e-6))
    spacing = scene.elastocapillary_length / links
    exact = -2 * np.sqrt(2 * 0.002 * 0.07)
    told = pytest.warns(AccuracyWarning, match="pull-off") if off > 0.03 else nullcontext()
    with told:
        path = load_path(scene, depths=PROGRAMME, method="lattice", spacing=spacing)
    assert path.pull_off.force == pytest.approx((1 - off) * exact, rel=2e-3)
