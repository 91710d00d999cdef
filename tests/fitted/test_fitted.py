"""The fitted mesh: rounding-level agreement with the closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import adhesive

from discretization import NotCertifiedError, minimise
from discretization.equilibrium import QUANTITIES
from discretization.fitted.contacts import Contacts, push
from discretization.fitted.single_contact import SingleContact
from discretization.fitted.states import state_of
from energy import FlatPunch, Parabola, PowerLaw, Sampled, Scene, SurfaceEnergies, Wedge, cards
from energy.layer import ElasticLayer


def composed_scene(rng, kind):
    """A convex profile as it is, tilted, or with a shifted parabola on it; with or without w."""
    length, k = 10 ** rng.uniform(-3, 3, 2)
    alpha = 10 ** rng.uniform(-2, 0)
    w = k * (alpha * length) ** 2 / 2 * (rng.random() > 0.2)
    indenter = (
        Parabola(length * 10 ** rng.uniform(0, 2)),
        Wedge(math.atan(alpha * rng.uniform(0.1, 3))),
        FlatPunch(length * 10 ** rng.uniform(-0.5, 1)),
        PowerLaw(alpha * length**-2 * rng.uniform(0.1, 3), 3.0),
    )[kind % 4]
    if kind % 3 == 1:
        indenter = indenter.tilted(rng.uniform(-0.08, 0.08) * alpha)
    if kind % 3 == 2:
        hill = Parabola(length * 20).shifted(rng.uniform(-1, 1) * length)
        indenter = (indenter + hill).shifted(length * 0.3)
    surfaces = SurfaceEnergies.from_work(k * length**2, w)
    return Scene(ElasticLayer(k, 0.0, 1.0), surfaces, indenter), alpha * length * rng.uniform(
        -1.05, 3
    )


def test_composed_profiles_agree_on_both_discretisations():
    rng = np.random.default_rng(4)
    for kind in range(120):
        scene, depth = composed_scene(rng, kind)
        dx = scene.elastocapillary_length / 200
        fitted = minimise(scene, depth, method="fitted")
        lattice = minimise(scene, depth, method="lattice", spacing=dx)
        assert fitted.label == lattice.label
        assert max(fitted.error_estimate.values()) <= 1e-8
        if fitted.contacts.size:
            assert np.abs(fitted.contacts - lattice.contacts).max() <= 0.05 * dx
            assert abs(fitted.force - lattice.force) <= 1e-3 * lattice.scales["force"]


def between(scene, left, right, depth=1e-3):
    """The contact between two lines at a depth, and what judges it."""
    return SingleContact.of(scene), (left, right), depth


def judged(scene, a):
    """What is wrong with a contact between lines at -a and a, in words."""
    with pytest.raises(NotCertifiedError) as problem:
        state_of(*between(scene, -a, a), "adhered")
    return str(problem.value)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_the_force_changes_with_a_line_by_no_more_than_its_bound(slopes):
    """What the estimate of the force's error is made of."""
    scene = adhesive(Parabola(0.02), slopes=slopes)
    a = 0.006
    step = 1e-6
    force = [Contacts(*between(scene, -a, a + side * step)).totals().force for side in (-1, 1)]
    rate = abs(force[1] - force[0]) / (2 * step)
    bound = push(scene, 1e-3, np.array(a))
    assert bound / 2 <= rate <= bound


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("change", [1e-5, -1e-5])
def test_the_certificate_rejects_a_line_out_of_place(slopes, change):
    scene = adhesive(Parabola(0.02), slopes=slopes)
    a = SingleContact.of(scene).find(1, 1e-3)
    assert state_of(*between(scene, -a, a), "adhered").certificate.ok
    assert "violates neighbours (" in judged(scene, a * (1 + change))
    smooth = replace(scene, surfaces=SurfaceEnergies.from_work(scene.gamma1, 0.0))
    a = SingleContact.of(smooth).find(1, 1e-3) * (1 - 1e-5)
    assert "violates penetration, neighbours (" in judged(smooth, a)


def test_springs_without_tension_attach_and_let_go():
    """Springs without tension attach on touching and let go at the critical separation."""
    R = 0.02
    d = 1.5e-3
    scene = adhesive(Parabola(R), gamma1=0.0)
    k = scene.stiffness
    delta0 = scene.critical_separation
    touched = minimise(scene, d)
    assert touched.half_width == pytest.approx(math.sqrt(2 * R * d), rel=1e-13, abs=0)
    assert touched.force == pytest.approx(4 / 3 * k * touched.half_width * d, rel=1e-13, abs=0)
    lowest = minimise(scene, d, branch="global")
    level = cards.contact_line.cut_level(d, k=k, w=scene.work_of_adhesion)
    assert lowest.half_width == pytest.approx(math.sqrt(2 * R * level), rel=1e-13, abs=0)
    punch = adhesive(FlatPunch(0.013), gamma1=0.0)
    assert minimise(punch, -(1 + 0.9e-14) * delta0).half_width == 0.013
    assert minimise(punch, -(1 + 1.1e-14) * delta0).label == "detached"


def test_a_tilted_parabola_is_one_that_is_moved_and_lowered():
    scene = adhesive(Parabola(0.02).tilted(0.013))
    shift = 0.013 * 0.02  # x²/2R + sx is the parabola moved by -sR and lowered by s²R/2
    state = minimise(scene, 1e-3)
    plain = minimise(adhesive(Parabola(0.02)), 1e-3 + 0.013**2 * 0.02 / 2)
    assert np.allclose(state.contacts + shift, plain.contacts, rtol=1e-13, atol=0)
    assert state.force == pytest.approx(plain.force, rel=1e-13, abs=0)
    assert state.certificate.ok


def test_samples_of_a_parabola_give_the_parabola():
    """A cubic spline through them is the parabola; quadrature has to stop at its knots."""
    x = np.sort(np.random.default_rng(5).uniform(-0.02, 0.02, 301))
    smooth = minimise(adhesive(Sampled(x, x**2 / 0.04, kind="smooth").shifted(0.002)), 1e-3)
    plain = minimise(adhesive(Parabola(0.02)), 1e-3)
    for name in QUANTITIES:
        assert getattr(smooth, name) == pytest.approx(getattr(plain, name), rel=1e-10, abs=0)


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-12])
def test_a_flat_punch_is_neutral_in_any_units_and_nowhere_beside(slopes, rtol):
    """The critical depth from two formulas that round differently; 10⁻¹³ of it is decided."""
    rng = np.random.default_rng(11)
    labels = []
    beside = []
    for _ in range(30):
        unit, k, ratio = 10 ** rng.uniform([-9, -6, -6], [9, 6, -0.05])
        gamma1 = k * unit**2 * 10 ** rng.uniform(-3, 3)
        surfaces = SurfaceEnergies.from_work(gamma1, ratio * gamma1)
        layer = ElasticLayer(k * unit, rng.uniform(0, 0.4), unit)
        scene = Scene(layer, surfaces, FlatPunch(unit * rng.uniform(0.1, 9)), slopes=slopes)
        w = scene.work_of_adhesion
        for d in (scene.critical_separation, math.sqrt(2 * w * layer.h / layer.modulus)):
            labels.append(minimise(scene, -d, rtol=rtol).label)
        if rtol <= 1e-8:
            beside += [minimise(scene, -d * (1 + s * 1e-13), rtol=rtol).label for s in (1, -1)]
    assert set(labels) == {"neutral"}
    assert set(beside[::2]) <= {"detached"} and set(beside[1::2]) <= {"metastable"}


@pytest.mark.parametrize("shift", [-0.05, 0.004, 0.05])
def test_a_punch_beside_the_origin_is_held_at_both_edges(shift):
    """Also where it does not reach over x = 0."""
    punch = FlatPunch(0.013)
    here, there = (minimise(adhesive(body), 1e-3) for body in (punch, punch.shifted(shift)))
    assert there.pinned.all()
    assert there.contacts == pytest.approx(here.contacts + shift, rel=1e-15, abs=0)
    assert there.force == pytest.approx(here.force, rel=1e-13, abs=0)
