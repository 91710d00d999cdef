"""Load paths on the lattice: the same events, an exact energy balance, no lattice hysteresis."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive, moved, rippled, steep

from discretization import History, NotCertifiedError, load_path, minimise
from discretization.lattice.state import on_lattice
from discretization.paths.lattice_branch import LatticeBranch
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Patches,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

SPACING = 1e-5
RIPPLED = rippled(0.02, 0.002, 1e-5)
BODIES = [Parabola(0.02), Wedge(0.05).shifted(0.0123), Parabola(0.02).tilted(0.05), FlatPunch(0.03)]


def programme(scene, top=3.0, bottom=-2.0):
    return np.r_[np.linspace(-1, top, 40), np.linspace(top, bottom, 60)] * scene.critical_separation


@pytest.mark.parametrize("body", BODIES, ids=lambda body: type(body).__name__)
def test_the_lattice_walks_the_fitted_path(body):
    scene = adhesive(body)
    depths = programme(scene)
    fine = load_path(scene, depths=depths)
    path = load_path(scene, depths=depths, method="lattice", spacing=SPACING)
    assert [e.kind for e in path.events] == [e.kind for e in fine.events]
    for ours, theirs in zip(path.events, fine.events, strict=True):
        assert abs(ours.depth - theirs.depth) <= 0.02 * scene.critical_separation
        assert abs(ours.energy_released - theirs.energy_released) <= 0.02 * fine.dissipated
    held = (path.half_width > 10 * SPACING) & (fine.half_width > 0)
    assert held.sum() >= 60
    assert np.abs(path.half_width - fine.half_width)[held].max() <= 0.02 * SPACING
    assert np.abs(path.force - fine.force)[held].max() <= 1e-5 * np.abs(fine.force).max()
    assert np.abs(path.energy - fine.energy)[held].max() <= 1e-5 * np.abs(fine.energy).max()


@pytest.mark.parametrize("body", [*BODIES, RIPPLED], ids=lambda body: type(body).__name__)
def test_the_energy_balance_is_exact(body):
    scene = adhesive(body)
    path = load_path(scene, depths=programme(scene), method="lattice", spacing=SPACING)
    assert path.dissipated > 0
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


@pytest.mark.parametrize("body", BODIES[:3], ids=lambda body: type(body).__name__)
def test_a_branch_walked_there_and_back_costs_nothing(body):
    scene = adhesive(body)
    there = np.linspace(-0.5, 3, 50) * scene.critical_separation
    once = load_path(scene, depths=[0.0, there[0]], method="lattice", spacing=SPACING)
    twice = load_path(
        scene, depths=[*there, *there[::-1]], method="lattice", spacing=SPACING, after=once
    )
    assert twice.events == once.events
    scale = scene.stiffness * scene.critical_separation**2 * scene.elastocapillary_length
    assert abs(twice.work() - once.work()) <= 1e-12 * scale
    assert np.array_equal(twice.contacts[2:52], twice.contacts[:51:-1])


def test_states_are_those_of_on_lattice():
    scene = adhesive(Parabola(0.02))
    depths = np.array([0.5, 1.7, 2.9, 1.1, -0.4]) * scene.critical_separation
    path = load_path(scene, depths=depths, method="lattice", spacing=SPACING)
    for step, depth in enumerate(depths):
        state = on_lattice(scene, depth, SPACING)
        assert abs(path.half_width[step] - state.half_width) <= 0.01 * SPACING
        assert abs(path.force[step] - state.force) <= 1e-6 * state.scales["force"]
        assert abs(path.energy[step] - state.energy) <= 1e-6 * state.scales["energy"]


def test_a_rippled_indenter_advances_and_recedes_by_avalanches():
    scene = adhesive(RIPPLED)
    path = load_path(scene, depths=programme(scene), method="lattice", spacing=SPACING)
    jumps = [event for event in path.events if event.kind == "jump"]
    rising = [event for event in jumps if event.after.half_width > event.before.half_width]
    assert len(rising) >= 3 and len(jumps) - len(rising) >= 3
    least = 1e-6 * scene.work_of_adhesion * 0.002
    assert min(event.energy_released for event in jumps) > least
    widths = [event.after.half_width - event.before.half_width for event in rising]
    assert max(widths) <= 0.0021  # at most one wavelength at once, on each side
    smooth = load_path(
        adhesive(rippled(0.02, 0.002, 1e-8)),
        depths=programme(scene),
        method="lattice",
        spacing=SPACING,
    )
    assert [e for e in smooth.events if e.kind == "jump"] == []


def test_adhesion_hysteresis_on_the_lattice():
    fine = adhesive(Parabola(0.02), w=0.001, opening=0.003)
    depths = programme(fine, 2.0, -3.0)
    reference = load_path(fine, depths=depths)
    path = load_path(fine, depths=depths, method="lattice", spacing=2e-6)
    assert path.friction == pytest.approx(reference.friction, rel=1e-3, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


def test_a_lattice_path_is_saved_and_continued_to_the_last_bit(tmp_path):
    scene = adhesive(Sampled([-0.03, -0.01, 0.0, 0.02, 0.03], [0.01, 0.001, 0.0, 0.004, 0.02]))
    depths = programme(scene, 1.5)
    whole = load_path(scene, depths=depths, method="lattice", spacing=SPACING)
    save = tmp_path / "path.csv"
    load_path(scene, depths=depths[:55], method="lattice", spacing=SPACING, save=save)
    again = load_path(scene, depths=depths, method="lattice", spacing=SPACING, save=save)
    assert again.contacts.tobytes() == whole.contacts.tobytes()
    assert again.force.tobytes() == whole.force.tobytes()
    assert History.from_csv(save).energy.tobytes() == whole.energy.tobytes()
    assert len(again.events) == len(whole.events)


def test_what_the_lattice_cannot_do_is_refused():
    scene = adhesive(Parabola(0.02))
    for given, message in (
        ({"depths": [0.1], "method": "lattice"}, "spacing = None with method = 'lattice'"),
        ({"depths": [0.1], "spacing": 1e-5}, "spacing = 1e-05 with method = 'fitted'"),
        ({"depths": [0.1], "method": "mesh"}, "method = 'mesh'"),
        ({"depths": [0.1], "method": "lattice", "spacing": -1.0}, "spacing = -1.0"),
    ):
        with pytest.raises(ValueError, match=message):
            load_path(scene, **given)
    given = {"depths": [1e-3], "method": "lattice", "spacing": SPACING}
    with pytest.raises(ValueError, match="needs gamma1 > 0"):
        load_path(adhesive(Parabola(0.02), gamma1=0.0), **given)
    with pytest.raises(ValueError, match="no load paths"):
        load_path(steep(FlatPunch(0.03)), **given)
    narrow = adhesive(Sampled([-0.01, 0.0, 0.01], [0.0025, 0.0, 0.0025]))
    with pytest.raises(ValueError, match="whole known profile"):
        load_path(narrow, depths=[0.1], method="lattice", spacing=SPACING)


def test_stripes_pin_the_line_and_release_it_by_avalanches():
    period, low, high = 0.004, 0.25, 1.0
    plain = adhesive(Parabola(0.05))
    scene = replace(plain, pattern=Patches.stripes(period, low, high, 0.1))
    depths = programme(scene, 3.0, -2.0)
    path = load_path(scene, depths=depths, method="lattice", spacing=SPACING)
    bare = load_path(plain, depths=depths, method="lattice", spacing=SPACING)
    jumps = [event for event in path.events if event.kind == "jump"]
    assert len(jumps) >= 4 and not [event for event in bare.events if event.kind == "jump"]
    assert min(event.energy_released for event in jumps) > 0
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    # a line rests at the border of a strong stripe, or between the lines of both works
    strong, weak = (
        load_path(
            replace(plain, surfaces=SurfaceEnergies.from_work(plain.gamma1, factor * 0.002)),
            depths=depths,
            method="lattice",
            spacing=SPACING,
        ).half_width
        for factor in (high, low)
    )
    rising = slice(int(np.argmax(path.half_width > 0)), 40)
    assert (path.half_width[rising] >= weak[rising] - 2 * SPACING).all()
    assert (path.half_width[rising] <= strong[rising] + 2 * SPACING).all()


def test_stripes_and_hysteresis_together_keep_the_balance():
    scene = replace(
        adhesive(Parabola(0.05), w=0.001, opening=0.002),
        pattern=Patches.stripes(0.004, 0.25, 1.0, 0.1),
    )
    path = load_path(scene, depths=programme(scene, 4.0, -4.0), method="lattice", spacing=SPACING)
    assert [event for event in path.events if event.kind == "jump"]
    assert path.friction > 0
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


def test_a_defect_holds_the_line_until_it_tears_off():
    """On retraction a strong patch holds the right line until it tears off the inner border."""
    plain = adhesive(Parabola(0.02))
    scene = replace(plain, pattern=Patches([0.006, 0.0066], [1.0, 4.0, 1.0]))
    f, slope, alpha = 0.006**2 / 0.04, 0.006 / 0.02, np.sqrt(2 * 4 * 0.002 / plain.gamma1)
    torn = f + plain.elastocapillary_length * (slope - alpha)  # Eq. (16) of the patch there
    there = np.linspace(-0.8, 2, 60) * scene.critical_separation
    path = load_path(scene, depths=[0.0, *there, *there[::-1]], method="lattice", spacing=SPACING)
    pulled = [e for e in path.events if e.kind == "jump" and e.after.right < e.before.right]
    assert len(pulled) == 1
    assert pulled[0].before.right == pytest.approx(0.006, abs=2 * SPACING)
    assert pulled[0].before.left == pulled[0].after.left  # the other side has no defect
    assert pulled[0].depth == pytest.approx(torn, abs=0.01 * abs(torn))
    again = load_path(plain, depths=[0.0, *there, *there[::-1]], method="lattice", spacing=SPACING)
    assert [e.kind for e in again.events] == ["jump-in"]


def test_patterns_are_checked_and_refused_where_they_cannot_be_followed():
    scene = replace(adhesive(Parabola(0.02)), pattern=Patches([0.0], [1.0, 2.0]))
    with pytest.raises(ValueError, match="depends on the path; use branch='adhered'"):
        minimise(scene, 1e-3, branch="global")
    for edges, factors, message in (
        ([1.0, 0.0], [1, 1, 1], "sort them"),
        ([0.0], [1.0], "one more than"),
        ([0.0], [1.0, -1.0], "not negative"),
        ([np.nan], [1.0, 1.0], "finite numbers"),
    ):
        with pytest.raises(ValueError, match=message):
            Patches(edges, factors)
    with pytest.raises(ValueError, match="must be Patches"):
        replace(scene, pattern=3.0)


def test_a_uniform_pattern_is_no_pattern(tmp_path):
    plain = adhesive(Parabola(0.02), w=0.001)
    doubled = replace(plain, pattern=Patches([-0.003, 0.002], [2.0, 2.0, 2.0]))
    given = {"depths": programme(plain), "method": "lattice", "spacing": SPACING}
    path = load_path(doubled, **given)
    twice = load_path(adhesive(Parabola(0.02), w=0.002), **given)
    assert path.half_width == pytest.approx(twice.half_width, rel=1e-12, abs=1e-15)
    assert path.dissipated == pytest.approx(twice.dissipated, rel=1e-13, abs=0)
    path.to_csv(tmp_path / "path.csv")
    assert History.from_csv(tmp_path / "path.csv").scene.pattern == doubled.pattern


@pytest.mark.parametrize("pattern", [None, Patches([0.004], [1.0, 1.0])])
def test_a_path_does_not_continue_from_a_wrong_state(pattern):
    scene = replace(adhesive(Parabola(0.02)), pattern=pattern)
    branch = LatticeBranch.of(scene, SPACING, 1e-3)
    point = moved(branch, branch.first, 1e-3)
    branch.certify(point)
    ((first, last),) = point.memory
    for links in (-1, 1):
        with pytest.raises(NotCertifiedError, match="neighbours"):
            branch.certify(point._replace(memory=((first, last + links),)))


def one_sided(factors=(0.0, 1.0), edges=(0.05,)):
    """A parabola that adheres on one side only, with k = 1."""
    layer, surfaces = ElasticLayer(1, 0.0, 1.0), SurfaceEnergies.from_work(0.01, 0.00125)
    return Scene(layer, surfaces, Parabola(1.0), pattern=Patches(edges, factors))


def test_a_line_crosses_the_apex_where_nothing_holds_it():
    """On the bare side d = f - l |f'|; from x = 0.05 on adhesion holds the line."""
    h = 1e-4
    depths = [0.02, -0.002, -0.01, -0.04]
    path = load_path(one_sided(), depths=depths, method="lattice", spacing=h)
    left, right = path.contacts[:, 0], path.contacts[:, 1]
    bare = 0.1 - np.sqrt(0.1**2 - 2 * 0.002)  # x²/2 - l x = d
    assert left[1] == pytest.approx(bare, abs=h / 10)
    assert left[2:] == pytest.approx([0.05, 0.05], abs=h)
    u = depths[3] - np.array([left[3], right[3]]) ** 2 / 2
    springs = depths[3] * (right[3] - left[3]) - (right[3] ** 3 - left[3] ** 3) / 6
    assert path.force[3] == pytest.approx(springs + 0.1 * u.sum(), rel=1e-3)
    assert path.force[3] == pytest.approx(-0.00937, abs=2e-5)
    whole = load_path(one_sided(), depths=[*depths, -0.2], method="lattice", spacing=h)
    assert whole.work() == pytest.approx(whole.dissipated, rel=1e-12, abs=0)
    tilted = replace(one_sided(), pattern=Patches([-0.05], [1.0, 0.0]))
    other = load_path(tilted, depths=depths, method="lattice", spacing=h)
    assert other.contacts[:, ::-1] == pytest.approx(-path.contacts, abs=1e-12)


def test_a_line_left_at_the_apex_does_not_pass():
    branch = LatticeBranch.of(one_sided(), 1e-4, 0.02)
    point = moved(branch, moved(branch, branch.first, 0.02), -0.04)
    ((first, last),) = point.memory
    assert first == branch.row.touch + 500
    branch.certify(point)
    with pytest.raises(NotCertifiedError, match="neighbours"):
        branch.certify(point._replace(memory=((branch.row.touch, last),)))


@pytest.mark.parametrize("opening", [None, 0.002])
def test_a_contact_opens_on_a_bare_patch(opening):
    """It is pulled there, with a contact on either side; on a weak patch it stays whole."""
    scene = one_sided((1.0, 0.0, 1.0), (0.05, 0.1))
    if opening:
        scene = replace(scene, opening=SurfaceEnergies.from_work(scene.gamma1, opening))
    depths = [0.02, -0.02, -0.01, -0.02, -0.3]
    path = load_path(scene, depths=depths, method="lattice", spacing=1e-3)
    assert [len(inner) // 2 for inner in path.inner[:2]] == [0, 1]
    lines = path.at(1).lines
    assert lines[1] == pytest.approx(0.05, abs=1e-3) and lines[2] == pytest.approx(0.1, abs=1e-3)
    assert "splitting" in [event.kind for event in path.events]
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    whole = replace(scene, pattern=Patches((0.05, 0.1), (1.0, 0.5, 1.0)))
    path = load_path(whole, depths=[0.02, -0.02], method="lattice", spacing=1e-3)
    assert path.inner[1] == ()
