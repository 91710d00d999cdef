"""States of one contact of a layer: error estimates, balances, limits, units, corners, refusals."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from support.bonded_layers import (
    BODIES,
    GEOMETRIES,
    QUANTITIES,
    FlatTo,
    layer,
    off,
    random_scene,
    scene_of,
)

from discretization import AccuracyWarning, load_path, minimise
from discretization.layer.body import Body
from discretization.layer.contact import Contact
from discretization.layer.state import Layer
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

EVERY = [(kind, geometry) for geometry in GEOMETRIES for kind in BODIES]


def resting(seed, kind, geometry, **given):
    """A random scene in contact at a depth, and its state good to 1e-6."""
    rng = np.random.default_rng(seed)
    while True:
        scene, depth, _ = random_scene(rng, kind, geometry, **given)
        state = minimise(scene, depth, rtol=1e-6)
        if state.half_width:
            return scene, depth, state


@pytest.mark.parametrize(("kind", "geometry"), EVERY)
@pytest.mark.parametrize("seed", [0, pytest.param([*range(1, 6), 98], marks=pytest.mark.slow)])
def test_errors_are_within_their_estimate(kind, geometry, seed):
    for one in [seed] if seed == 0 else seed:
        scene, depth, state = resting(one, kind, geometry, widest=2.0)
        finer = minimise(scene, depth, rtol=1e-9)
        estimate, rest = ([s.error_estimate[q] for q in QUANTITIES] for s in (state, finer))
        assert (np.array(estimate) <= 1e-6).all()
        assert (off(state, finer) <= np.add(estimate, rest)).all()


@pytest.mark.parametrize(("kind", "geometry"), EVERY)
def test_the_force_is_the_slope_of_the_energy(kind, geometry):
    scene, depth, state = resting(1, kind, geometry)
    step = (
        2e-3 * state.energy_parts["springs"] / max(abs(state.force), 1e-3 * state.scales["force"])
    )
    near, far = (
        (minimise(scene, depth + s).energy - minimise(scene, depth - s).energy) / (2 * s)
        for s in (step, 2 * step)
    )
    extrapolated = near + (near - far) / 3
    assert abs(extrapolated - state.force) <= abs(near - far) / 3 + 1e-6 * state.scales["force"]
    assert abs(near - far) <= 0.02 * state.scales["force"]


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.2, 0.5])
def test_energy_is_least_at_the_line(geometry, nu):
    """A punch as wide as a contact that is a little wider or narrower, with the same profile."""
    scene = scene_of(Parabola(40.0), nu, geometry=geometry)
    state = minimise(scene, 0.03, rtol=1e-9)
    a = state.half_width

    def energy(width):
        """Pressed so deep that all of it is in contact, down to this depth, by ∫P dd."""
        cut = replace(scene, indenter=Parabola(40.0) + FlatPunch(width))
        held = [minimise(cut, d) for d in 0.03 + width**2 / 40 * np.array([1.0, 2.0, 3.0])]
        assert all(one.pinned.any() and one.half_width == width for one in held)
        deep = np.array([one.depth for one in held])
        return float(np.polyval(np.polyfit(deep - 0.03, [one.energy for one in held], 2), 0.0))

    t = np.array([-0.03, -0.015, 0.0, 0.015, 0.03])
    found = [energy(a * (1 + x)) for x in t]
    curve = np.polynomial.Polynomial.fit(t, found, 4).convert()
    assert curve.coef[2] > 0
    assert abs(found[2] - state.energy) <= 1e-8 * state.scales["energy"]
    assert abs(curve.coef[1]) <= 1e-4 * 2 * curve.coef[2]  # least at t = 0, to 1e-4 of a


@pytest.mark.parametrize(("kind", "geometry"), EVERY)
def test_parts_and_fields_make_the_whole(kind, geometry):
    scene, depth, state = resting(2, kind, geometry, nu=0.35)
    parts = state.energy_parts
    scales = state.scales
    assert abs(sum(parts.values()) - state.energy) <= 1e-9 * scales["energy"]
    assert abs(sum(state.force_parts.values()) - state.force) <= 1e-12 * scales["force"]
    assert parts["adhesion"] == pytest.approx(
        -scene.work_of_adhesion * state.contact_area, rel=1e-12
    )
    a = state.half_width
    k = scene.stiffness
    nodes, weights = np.polynomial.legendre.leggauss(30)

    def total(density, ends):
        """∫ over x, or 2πr dr, of panels between these ends, both sides of a line contact."""
        lo = np.array(ends[:-1])[:, None]
        hi = np.array(ends[1:])[:, None]
        x = (lo + hi) / 2 + (hi - lo) / 2 * nodes
        whole = 2 * math.pi * x if scene.axisymmetric else 2.0
        return float((density(x) * whole * weights * (hi - lo) / 2).sum())

    towards = a * 0.5 ** np.arange(1, 30)[::-1]
    far = 60 * (1 + math.sqrt(scene.gamma1))
    under = np.concatenate([[0.0], towards, a - towards[::-1][1:], [a]])
    beside = np.concatenate([[a], a + towards, a + np.linspace(a, a + far, 80)])
    pressed = total(state.pressure, under)
    moved = total(state.displacement, np.concatenate([under, beside[1:]]))
    assert abs(pressed - state.force_parts["pressure"]) <= 1e-6 * scales["force"]
    assert abs(k * moved - state.force) <= 2e-5 * scales["force"]  # what is left of the poles
    assert (state.pressure(np.array([1.01, 3.0]) * a) == 0).all()
    x = np.array([0.3, 1.0]) * a
    assert np.allclose(state.displacement(-x), depth - scene.indenter.height(x), rtol=1e-12)


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [-0.5, 0.3, 0.45])
def test_springs_are_recovered_where_the_tension_is_felt_far(geometry, nu):
    """By a factor of ten in l, a hundredth of the difference is left."""
    c2 = nu * (4 * nu - 1) / (3 * (1 - nu) * (1 - 2 * nu))
    apart = []
    for length in (30.0, 300.0):  # l/h
        gamma = layer(nu).stiffness * length**2
        scene = scene_of(Parabola(1e3 * length), nu, gamma, 1e-6 * gamma, geometry)
        exact, springs = (
            minimise(replace(scene, layer=layer(nu, response=way)), 0.3e-3 * length, rtol=1e-9)
            for way in ("layer", "springs")
        )
        apart.append(off(exact, springs))
    assert (apart[0] <= 100 * (abs(c2) + 0.1) / 30**2).all()
    assert (apart[1] <= 0.02 * apart[0] + 1e-8).all()


@pytest.mark.parametrize(("kind", "geometry"), EVERY)
def test_units_do_not_matter(kind, geometry):
    scene, depth, state = resting(3, kind, geometry)
    for unit, stress in ((1e-8, 1e5), (1e7, 1e-9)):
        w = scene.work_of_adhesion * unit * stress
        tension = scene.gamma1 * unit * stress
        other = Scene(
            layer(scene.layer.nu, unit=unit, stress=stress),
            SurfaceEnergies.from_work(tension, w),
            in_units(scene.indenter, unit),
            geometry=geometry,
        )
        found = minimise(other, depth * unit, rtol=1e-6)
        force = stress * unit ** (2 if scene.axisymmetric else 1)
        own = np.array([getattr(found, q) for q in QUANTITIES]) / (unit, force, force * unit)
        apart = np.abs(own - [getattr(state, q) for q in QUANTITIES])
        assert (apart <= 1e-11 * np.array([state.half_width, *state.scales.values()])).all()


def in_units(body, unit):
    """The body with this unit of lengths."""
    if isinstance(body, Parabola):
        return Parabola(body.R * unit)
    if isinstance(body, PowerLaw):
        return PowerLaw(body.c * unit ** (1 - body.n), body.n)
    return FlatPunch(body.half_width * unit) if isinstance(body, FlatPunch) else body


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_the_line_rests_at_a_corner_inside_a_body(geometry, nu):
    """A flat face that rises with slope 0.3 beyond 1.2: held while D is between its two values."""
    kinked = FlatTo(1.2, 0.3)
    scene = scene_of(kinked, nu, geometry=geometry)
    punch = replace(scene, indenter=FlatPunch(1.2))
    for depth in (0.0, 0.02):
        held = minimise(scene, depth)
        same = minimise(punch, depth)
        assert held.half_width == 1.2
        assert held.pinned[0, 1]
        assert held.force == pytest.approx(same.force, rel=1e-9, abs=1e-15)
        assert held.energy == pytest.approx(same.energy, rel=1e-9)
    wide = minimise(scene, 0.5)
    deficit = scene.surfaces.small_slope_deficit
    assert wide.half_width > 1.2
    assert not wide.pinned[0, 1]
    assert wide.angle_deficit == pytest.approx(deficit, rel=1e-9)
    inside = wide.pressure(np.linspace(1.1, 1.3, 201))
    assert inside.argmax() == 100
    assert inside.max() > 1.2 * max(inside[0], inside[-1])
    assert not minimise(scene, -0.5).contacts.size


def test_corners_a_rounding_away_from_where_they_are_looked_for():
    """Of an element that would end there, too, and of the lowest point."""
    c = 7.905431378799093
    x = np.linspace(-2 * c, 2 * c, 13)
    wide = scene_of(Sampled(x, x * x / (20 * c)), 0.3, geometry="axisymmetric")
    assert minimise(wide, 0.04 * c, rtol=1e-4).half_width > c / 2
    x = np.linspace(-0.5, 0.5, 13)
    same = np.linspace(-0.5, 0.5, 13)
    same[6] = -3e-17
    bodies = [Sampled(z, x * x / 3) for z in (x, same)]
    one, other = (minimise(scene_of(body, 0.3), 0.02, rtol=1e-8) for body in bodies)
    assert abs(one.energy - other.energy) <= 1e-12 * one.scales["energy"]


@pytest.mark.parametrize("at", [0.0, 50.0, 3e4])
def test_elements_are_graded_towards_powers_of_no_integer_only(at):
    """Neither a further power of a profile nor the rounding of a far position counts as one."""
    cubic = Profile(
        lambda x: 0.2 * (x - at) ** 2 + 0.1 * np.abs(x - at) ** 3,
        lambda x: 0.4 * (x - at) + 0.3 * (x - at) * np.abs(x - at),
        extent=(at - 20, at + 20),
        convex=True,
    )
    for smooth in (cubic, Parabola(3.0).shifted(at)):
        assert Body(scene_of(smooth, 0.3)).kinks == []
    for power in (1 + 1e-4, 1.5, 2 + 1e-4):
        assert Body(scene_of(PowerLaw(0.2, power).shifted(at), 0.3)).kinks == [0.0]


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_power_next_to_1_is_as_good_as_a_wedge(geometry):
    """Its slope has a jump in all but name."""
    wedge = Wedge(math.atan(0.2))
    states = [
        minimise(scene_of(body, 0.3, 0.3, 0.0, geometry), 0.3, rtol=1e-8)
        for body in (wedge, PowerLaw(0.2, 1 + 1e-10))
    ]
    assert states[0].half_width > 0
    assert (off(*states) <= 1e-8).all()


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_a_steep_wedge_touches_with_its_tip(nu):
    """As a line force on the surface."""
    scene = scene_of(Wedge(math.atan(0.3)), nu)  # √(2w/γ₁) = 0.17
    some = minimise(scene, 0.004)
    more = minimise(scene, 0.008)
    for state in (some, more):
        assert state.half_width == 0
        assert state.pinned.all()
        assert (state.contacts == 0).all()
        assert state.angle_deficits[0, 1] > math.sqrt(2 * 0.01 / 0.7)  # on the outer side
    assert more.force == pytest.approx(2 * some.force, rel=1e-9)
    assert more.energy == pytest.approx(4 * some.energy, rel=1e-9)
    q = np.geomspace(1e-5, 1e7, 4001)
    k = scene.layer.stiffness_at(q) + scene.gamma1 * q * q
    gives = float(np.trapezoid(q / k, np.log(q))) / math.pi  # u under a force per length
    assert some.force == pytest.approx(0.004 / gives, rel=1e-5)
    assert minimise(scene, 0.2).half_width > 0.01
    assert not minimise(scene, -1e-6).contacts.size


@pytest.mark.parametrize(("kind", "geometry"), EVERY)
def test_without_adhesion_nothing_pulls(kind, geometry):
    scene, depth, _ = resting(4, kind, geometry)
    scene = replace(scene, surfaces=SurfaceEnergies.from_work(scene.gamma1, 0.0))
    state = minimise(scene, abs(depth), rtol=1e-6)
    x = np.linspace(0, state.half_width, 200)
    assert state.pressure(x).min() >= -1e-9 * state.pressure(x).max()
    assert state.force > 0
    if kind != "punch" and state.half_width:
        assert abs(state.angle_deficit) <= 1e-9 * state._deformation.slope
        assert minimise(scene_of(scene.indenter, -0.2, 3e-8, 0.0, geometry), 20.0).force > 0
    assert not minimise(scene, -1e-9).contacts.size
    assert minimise(scene, 0.0).force == pytest.approx(0, abs=1e-9 * state.force)


@pytest.mark.parametrize("at", [0.0, 0.3])
def test_profiles_that_do_not_say_that_they_are_mirrored(at):
    """Samples of a parabola, and its functions, answer as the parabola does."""
    x = np.linspace(-4, 4, 33)
    flat = np.array([-4.0, -2.0, -1.2, 1.2, 2.0, 4.0])
    known = minimise(scene_of(Parabola(40.0)), 0.03, rtol=1e-6)
    parabola = Profile(lambda x: np.square(x) / 80, lambda x: np.asarray(x) / 40, convex=True)
    bodies = [Sampled(x + at, x * x / 80, "smooth")] + [parabola] * (at == 0)
    for body in bodies:
        state = minimise(scene_of(body), 0.03, rtol=1e-6)
        for q in QUANTITIES:
            assert getattr(state, q) == pytest.approx(getattr(known, q), rel=1e-9)
        assert state.contacts.mean() == pytest.approx(at, abs=1e-12)
    faceted = Sampled(flat + at, np.maximum(np.abs(flat) - 1.2, 0) * 0.3)
    one, other = (minimise(scene_of(body), 0.02) for body in (faceted, FlatTo(1.2, 0.3)))
    assert one.half_width == pytest.approx(1.2, rel=1e-12)
    assert one.pinned.all()
    assert one.force == pytest.approx(other.force, rel=1e-9)
    path = load_path(scene_of(bodies[0]), depths=[0.0, 0.03, -1.0], rtol=1e-6)
    assert path.half_width[1] == pytest.approx(state.half_width, rel=1e-6)
    for body in (Sampled(x + at, x * x / 80 + 1e-9 * x, "smooth"), bodies[-1].tilted(1e-6)):
        with pytest.raises(ValueError, match="not mirror-symmetric"):
            minimise(scene_of(body), 0.03)


@pytest.mark.parametrize(
    ("nu", "gamma", "R", "geometry"),
    [(-0.33, 0.35, 1.2, "line"), (-0.31, 0.33, 1.5, "line"), (0.5, 18.0, 260.0, "axisymmetric")],
)
def test_a_contact_is_held_until_it_is_lost(nu, gamma, R, geometry):
    """As closely as the path knows, although a line is looked for with few poles."""
    scene = scene_of(Parabola(R), nu, gamma, 0.005 * gamma, geometry)
    lost = load_path(scene, depths=[0.0, -10.0], rtol=1e-8).events[-1].control
    for away in (1e-4, 1e-5, 1e-6):
        assert not minimise(scene, lost * (1 + away), rtol=1e-6).contacts.size
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AccuracyWarning)  # of a place that is hardly one
            assert minimise(scene, lost * (1 - away), rtol=1e-6).contacts.size


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.49, 0.499, 0.49999, 0.4999999, 0.5])
def test_narrow_contacts_nearly_incompressible(geometry, nu):
    """Whose first pole is felt far away: what is pressed is not what is left of large numbers."""
    scene = scene_of(Parabola(0.4), nu, 0.9, 2e-5, geometry)
    state = minimise(scene, 1e-3, rtol=1e-8)
    assert 1e-3 < state.half_width < 0.1
    assert max(state.certificate.stationarity, state.certificate.force) <= 1e-10


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("gamma", [1e-4, 1e-2, 1.0])
def test_depth_of_a_slight_penetration(gamma, geometry):
    """Beside a flat face that is pressed, under a slope that is less and less too small for it."""

    def inside(rise, places, depth=0.01):
        """How deep the surface dips at so many places, and by the certificate; over |d| and u."""
        body = Body(scene_of(FlatTo(2.0, rise), 0.5, gamma, 0.0, geometry))
        state = Layer(depth, Contact(body, 2.0, 1e-6))
        x = np.exp(np.linspace(-22, 3, places))
        deep = depth - body.height(2.0 + x) - state.displaced(x)[0]
        return float(deep.max()) / (depth + state.size), state.certificate.penetration

    low = 1e-4
    high = 10.0
    for _ in range(18):
        rise = math.sqrt(low * high)
        low, high = (rise, high) if inside(rise, 1001)[0] > 1e-7 else (low, rise)
    assert 1e-3 < low < 9
    for part in (1.0, 0.999, 0.99, 0.9, 0.5):
        dense, found = inside(part * low, 15001)
        assert 0.999 * dense <= found <= dense + 1e-7


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("n", [1.2, 1.3, 1.6, 2.5])
def test_stretched_length_of_sharp_profiles(n, geometry):
    """γ₁/2 ∫f'² of what is in contact, with f' = xⁿ⁻¹."""
    for a in (1e-1, 1e-3, 1e-6):
        scene = scene_of(PowerLaw(1 / n, n), 0.3, 100.0, geometry=geometry)
        turned = int(scene.axisymmetric)
        whole = (
            (math.pi if turned else 1.0) * 100 * a ** (2 * n - 1 + turned) / (2 * n - 1 + turned)
        )
        assert Contact(Body(scene), a, 1e-6).stretched == pytest.approx(whole, rel=1e-8)


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("depth", [0.13, 0.2, 0.4])
def test_a_circle_is_pressed_nearly_to_where_it_is_vertical(depth, geometry):
    """The state is that of the load path, which comes from smaller half-widths."""
    layer = ElasticLayer(1.0, 0.475, 0.5, response="layer")
    surfaces = SurfaceEnergies.from_work(1e-3, 1e-4)
    scene = Scene(layer, surfaces, Circle(1.0), geometry=geometry)
    path = load_path(scene, depths=[0.0, depth / 2, depth])
    state = minimise(scene, depth)
    assert state.half_width == pytest.approx(path.half_width[-1], rel=1e-8)
    assert 0.4 < state.half_width < 0.9


def test_a_pressure_that_rounding_spoils_is_warned_of():
    """A steel half-space without adhesion: Hertz's pressure, or a warning where it is off."""
    layer = ElasticLayer(2e11, 0.3, 0.06, response="layer")
    surfaces = SurfaceEnergies.from_work(10.0, 0.0)
    scene = Scene(layer, surfaces, Parabola(1.0), geometry="axisymmetric")
    reduced = 2e11 / (1 - 0.3**2)
    for rtol in (1e-6, 1e-8, 1e-10):
        state = minimise(scene, 4.88e-7, rtol=rtol)
        x = state.radius * np.array([0.0, 1e-3, 0.1, 0.5, 0.9])
        hertz = 2 * reduced / math.pi * np.sqrt(state.radius**2 - x**2)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            off = np.abs(state.pressure(x) / hertz - 1).max()
        assert off < 1e-3 or "the pressure at x = " in str(caught[0].message)
        assert state.force == pytest.approx(4 / 3 * reduced * state.radius**3, rel=1e-5)
    with pytest.warns(AccuracyWarning, match="is known to .* only: the contact is much narrower"):
        minimise(scene, 4.88e-7, rtol=1e-10).pressure(np.array([0.0]))
