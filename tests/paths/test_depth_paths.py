"""Depth paths under other controls, over patches that do not adhere, at tips too steep to."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from support.example_scenes import ALPHA, DELTA0, SCENE, L, adhesive, plain, rescaled, turned
from support.scene_kinds import SCENES, A

from discretization import NotCertifiedError, load_path, minimise
from discretization.surfaces import menisci
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Patches,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

BODIES = {
    "parabola": Parabola(9.0),
    "punch": FlatPunch(0.7),
    "wedge": Wedge(0.12),
    "power": PowerLaw(0.1, 20) + FlatPunch(1.0),
    "tilted": Parabola(3.0).tilted(0.1),
}
SURFACES = {  # γ₁, w, w of opening
    "tension": (1.3, 0.0, None),
    "springs": (0.0, 0.0, None),
    "adhesion": (1.3, 0.02, None),
    "adhesive springs": (0.0, 0.02, None),
    "two works": (1.3, 0.02, 0.1),
}


def scene_of(body, surfaces):
    gamma1, w, opening = SURFACES[surfaces]
    return adhesive(BODIES[body], k=1.9, gamma1=gamma1, w=w, opening=opening)


@pytest.mark.parametrize(
    ("stiffness", "body", "surfaces"),
    [(0.0, body, one) for body in BODIES for one in SURFACES]
    + [(0.6, body, one) for body in BODIES for one in ("springs", "adhesion", "two works")],
)
def test_steps_balance_loads_on_the_depth_path(body, surfaces, stiffness):
    """Every step balances its load and is a state of the depth path."""
    scene = scene_of(body, surfaces)
    load = np.array([0.05, 0.1, 0.2, 0.07, 0.3, 0.01])
    if stiffness:
        path = load_path(scene, drives=load, machine_stiffness=stiffness)
        load = stiffness * (load - path.depth)
    else:
        path = load_path(scene, forces=load)
    again = load_path(scene, depths=path.depth)
    size = np.abs(load).max()
    assert path.force == pytest.approx(load, rel=0, abs=1e-11 * size)
    assert again.half_width == pytest.approx(path.half_width, rel=1e-13, abs=0)
    assert again.force == pytest.approx(path.force, rel=0, abs=1e-12 * size)


@pytest.mark.parametrize("body", BODIES)
def test_nothing_holds_a_contact_without_adhesion(body):
    path = load_path(scene_of(body, "tension"), forces=[0.1, -1e-6])
    assert [event.kind for event in path.events] == ["touch", "pull-off"]
    assert path.half_width[-1] == path.force[-1] == 0.0
    assert path.events[-1].force == pytest.approx(0.0, abs=1e-13)


def test_a_profile_whose_knots_nobody_told_is_loaded_as_exactly():
    x = np.array([-24.0, -22.0, -15.0, -14.0, -7.0, 2.0, 6.0, 16.0])
    spline = Sampled(x, np.abs(x) ** 2.3 / 6, kind="smooth")
    told = Profile(spline.height, spline.slope, extent=spline.extent, convex=True)
    force = load_path(adhesive(told, k=1.9, gamma1=1.3, w=0.02), forces=[40.0]).force[0]
    assert force == pytest.approx(40.0, rel=1e-13, abs=0)


def test_a_change_of_the_load_below_rounding_is_no_instability():
    layer = ElasticLayer(8.827400528964317e-09, 0.0, 5.446432590758204)
    surfaces = SurfaceEnergies.from_work(2.5088464360903674e-07, 2.5088464360903673e-19)
    scene = Scene(layer, surfaces, Wedge(1.6383029836310005e-07), slopes="finite")
    drives = np.array([5.582945e-06, -1.7595097904911395e-05, -1.759509790492899e-05])
    path = load_path(scene, drives=drives, machine_stiffness=5.6e-10)
    assert [event.kind for event in path.events] == ["jump-in"]
    assert path.half_width[2] == pytest.approx(path.half_width[1], rel=1e-13, abs=0)


@pytest.mark.slow
def test_force_that_bends_upwards_with_depth():
    """Finite slopes: P' falls on the way, so that a secant points to where there is no contact."""
    scene = plain(PowerLaw(3e4, 4), w=0.3, slopes="finite")
    loads = [11.5, -0.545, 0.88, -0.7]
    path = load_path(scene, forces=loads)
    assert [event.kind for event in path.events] == ["jump-in"]
    assert np.allclose(path.force, loads, rtol=5e-14, atol=0)


def test_a_trial_line_far_from_its_contact_overflows_no_height():
    layer = ElasticLayer(15176.15686299098, 0.0, 299295963.32060844)
    surfaces = SurfaceEnergies.from_work(5161235914605.363, 5161235.914605363)
    body = PowerLaw(3.0625326182347254e-204, 20).shifted(-60182743520.28064)
    depths = [236142.71773194047, -451191.5371889529, 1218124.8445969347]
    path = load_path(Scene(layer, surfaces, body), depths=depths)
    centred = load_path(Scene(layer, surfaces, body.base), depths=depths)
    known = np.spacing(np.abs(depths).max()) / 6e-10  # of a line, as D grows by 6e-10 of its way
    assert np.allclose(path.half_width, centred.half_width, rtol=1e-14, atol=known)


T = math.tan(0.05)
KINK = math.sqrt(0.02)
LINE = {"one": Patches([1.0], [0.0, 1.0]), "both": Patches([-1.0, 1.0], [1.0, 0.0, 1.0])}
DEPTHS = np.array([0.0, 0.05, 0.2, 0.3, 0.06, 0.045, 0.03, 0.01, 0.0, -0.1])


def wedge(delta=0.05, **options):
    """With k = l = 1."""
    return replace(plain(Wedge(delta), w=0.01), **options)


def half(d):
    """Force of the right half of a wedge at depths less than T, retracted: ∫u dx for x > 0.

    The right line rests against what adheres, the one beside the gap where u' = -T, or at the tip.
    """
    p = (d + KINK - T) / T
    q = gap(d)
    start = -T if q else (d - T - d * math.cosh(1)) / math.sinh(1)
    end = (d - T * q) * math.sinh(1 - q) + start * math.cosh(1 - q)  # u' at the edge
    pressed = sum((b - a) * (d - T * (a + b) / 2) for a, b in ((0.0, q), (1.0, p)))
    return pressed + end - start + d - T * p


def gap(d):
    """Where the gap that ends at the edge begins."""

    def over(x):
        return (d - T * x) * math.cosh(1 - x) - T * math.sinh(1 - x) - d + T

    return brentq(over, 0, 0.99, xtol=1e-15) if over(0.0) > 0 else 0.0


@pytest.mark.parametrize("kind", LINE)
def test_a_gap_at_the_edge_of_a_bare_patch(kind):
    """The mesh follows one contact over a pattern, and says so where a gap opens."""
    with pytest.raises(NotCertifiedError, match="use method='lattice'"):
        load_path(wedge(pattern=LINE[kind]), depths=DEPTHS)
    depths = DEPTHS[:-2]
    nodes = {"method": "lattice", "spacing": 1 / 256}
    found = load_path(wedge(pattern=LINE[kind]), depths=depths, **nodes)
    for step in (5, 6, 7):
        d = float(DEPTHS[step])
        beside = half(d) if kind == "both" else d
        assert found.force[step] == pytest.approx(half(d) + beside, rel=1e-3, abs=1e-5)
    opens = next(event for event in found.events if event.kind == "splitting")
    assert opens.depth == pytest.approx(T, rel=0, abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*LINE, "cone"])
def test_gap_closed_like_that_of_a_weak_patch(kind):
    """While it is closed it is that of a patch that all but adheres.

    Gaps over a pattern are followed on nodes, and about an axis not at all.
    """
    options = {"geometry": "axisymmetric"} if kind == "cone" else {}
    nodes = {} if kind == "cone" else {"method": "lattice", "spacing": 1 / 256}
    pattern = LINE.get(kind, LINE["one"])
    nearly = Patches(pattern.edges, np.maximum(pattern.factors, 1e-9))
    opens = 5  # steps before it does
    depths = DEPTHS[1:opens] if kind == "cone" else np.append(DEPTHS[1:8], -0.1)
    bare, other = (
        load_path(wedge(pattern=one, **options), depths=depths, **nodes)
        for one in (pattern, nearly)
    )
    closed = [*range(opens - 1), -1]
    scale = 10 * math.sqrt(1e-9)
    assert bare.force[closed] == pytest.approx(other.force[closed], rel=0, abs=scale)
    assert len(bare.events) >= 2
    assert bare.events[1].depth == pytest.approx(other.events[1].depth, rel=0, abs=scale)


STEEP = math.tan(0.2)
TIP = Profile(lambda x: STEEP * np.abs(x), lambda x: STEEP * np.sign(x), (-20, 20), [0.0])
OVER = [("line", "small"), ("line", "finite"), ("axisymmetric", "small")]
OVER_ALL = {"pattern": Patches([1.0], [1.0, 1.0])}
NEAR = [0.0, 1e-7, 0.1, 1e-5, -0.1]


@pytest.mark.slow
@pytest.mark.parametrize("more", [OVER_ALL, {"indenter": TIP}])
@pytest.mark.parametrize(("geometry", "slopes"), OVER)
def test_a_tip_that_does_not_adhere_is_that_of_one_contact(geometry, slopes, more):
    """Of an angle above √(2w/γ₁), and as a profile or over a pattern that may have several."""
    scene = wedge(0.2, geometry=geometry, slopes=slopes)
    one, several = (load_path(s, depths=NEAR) for s in (scene, replace(scene, **more)))
    assert several.force == pytest.approx(one.force, rel=1e-9, abs=1e-18)
    assert several.energy == pytest.approx(one.energy, rel=1e-9, abs=1e-18)
    assert [event.kind for event in several.events] == ["touch", "detachment"]


def test_cone_without_adhesion_finite_slopes():
    """A cone that does not adhere is that of one contact at finite slopes."""
    scene = wedge(0.2, geometry="axisymmetric", slopes="finite")
    for d in (1e-7, 1e-3):  # a path, which begins at a radius of 0, takes minutes there
        one, other = (minimise(s, d) for s in (scene, replace(scene, **OVER_ALL)))
        assert (other.force, other.energy) == pytest.approx((one.force, one.energy), rel=1e-9)


@pytest.mark.parametrize("s", [2.0**-21, 2.0**-33])
@pytest.mark.parametrize("phi", [0.05, -0.5, 1.0])
def test_beside_tiny_radii_the_surface_is_that_of_the_mesh(s, phi):
    radius = np.array([s])
    inclined = np.array([phi])
    u, energy = menisci.read(1, radius, inclined)
    _, mesh, stored = menisci.solve(1, radius, np.sin(inclined), 2)
    assert u == pytest.approx(mesh[:, 0], rel=2e-11)
    assert energy == pytest.approx(stored, rel=2e-11)


@pytest.mark.parametrize("name", ["sphere", "cone", "arc", "cubic"])
def test_forces_and_radii_along_a_path_are_of_second_order(name):
    scene = SCENES.get(name) or turned(PowerLaw(0.3 * ALPHA / A**2, 3.0))
    depths = np.linspace(0.1, 1, 37) * DELTA0
    links = (20, 40, 80, 160)
    worst = []
    fitted = load_path(scene, depths=depths)
    for n in links:
        path = load_path(scene, depths=depths, method="lattice", spacing=L / n)
        off = path.force - fitted.force, path.half_width - fitted.half_width
        worst.append([np.abs(part).max() for part in off])
    orders = np.polyfit(np.log(links), np.log(worst), 1)[0]
    assert orders == pytest.approx(np.array([-2, -2]), rel=0, abs=0.25)
    assert worst[-1][0] <= 1e-4 * np.abs(fitted.force).max()
    assert worst[-1][1] <= 1e-4 * A


def test_a_load_is_followed_however_small_its_number_is():
    """A line contact, its force far below any depth as a number."""
    one, other = (
        load_path(scene, forces=[0.0, load], method="lattice", spacing=L / 60)
        for scene, load in ((SCENE, 0.1), (rescaled(SCENE, 1.0, 1e-9), 0.1e-9))
    )
    assert other.half_width == pytest.approx(one.half_width, rel=1e-9, abs=0)


@pytest.mark.slow
def test_a_path_does_not_go_on_beyond_the_steepest_surface():
    """Also where it comes back before it ends: what is asked for in between is judged, too."""
    own = plain(FlatPunch(0.3), w=2e-4, gamma1=0.04, slopes="finite")
    own = replace(own, geometry="axisymmetric")
    assert load_path(own, depths=[0.0, 0.2, 0.0]).force[1] > 0
    told = r"at the contact line r = 0\.3 .* inclined by more than 86"
    with pytest.raises(ValueError, match=told):
        load_path(own, depths=[0.0, 0.3, 0.0])
