"""The limits of a layer against energies found by quadrature, and against published numbers."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support.comparison import check

from energy import cards

card = cards.layer
R = 0.013
E = 8.3e3
NU = 0.42
H = 1.3e-3
W = 4.3e-3
SOFT = {"R": R, "E": E, "nu": NU, "w": W}
THIN = {"R": R, "E": E, "h": H, "w": W}
G = E / 3
T, DT = (0.5 * part for part in np.polynomial.legendre.leggauss(40))
T = 0.5 + T


def on_half_space(d, a):
    """Energy of a sphere held down inside a: Hertz to there, then as a flat punch."""
    modulus = E / (1 - NU**2)
    lift = d - a**2 / R
    pressed = 8 * modulus * a**5 / (15 * R**2) + 4 * modulus * a**3 / (3 * R) * lift
    return pressed + modulus * a * lift**2 - np.pi * a**2 * W


def flowing(d, a, turned):
    """Energy h³/(6G) ∫ p'² of a thin incompressible layer, what is displaced by quadrature."""
    x = a * T
    dx = a * DT
    inner = x[:, None] * T
    u = (d - inner**2 / (2 * R)) * (inner if turned else 1)
    flow = (u * x[:, None] * DT).sum(axis=1) / (x if turned else 1)  # h³/(3G) |p'|
    length = 2 * np.pi * x if turned else 2 * np.ones_like(x)
    contact = np.pi * a**2 if turned else 2 * a
    return 3 * G / (2 * H**3) * (flow**2 * length * dx).sum() - contact * W


@pytest.mark.parametrize("a", [4e-4, 1.7e-3, 6e-3])
def test_layer_lines_and_forces_are_derivatives_of_energy(a):
    """Lines rest where the energy turns and forces are its derivatives."""
    thin = {"R": R, "E": E, "h": H, "w": W}
    for energy, depth, force in (
        (on_half_space, card.half_space_depth(a, **SOFT), card.half_space_force(a, **SOFT)),
        (
            lambda *at: flowing(*at, True),
            card.incompressible_depth(a, **thin),
            card.incompressible_force(a, **thin),
        ),
        (lambda *at: flowing(*at, False), card.incompressible_cylinder_depth(a, **thin), None),
    ):
        step = 1e-4 * a
        lift = abs(depth) + a**2 / R
        scale = abs(energy(depth + lift, a)) + W * a**2
        turn = (energy(depth, a + step) - energy(depth, a - step)) / (2 * step)
        assert abs(turn) < 1e-6 * scale / a
        rise = (energy(depth + 1e-3 * lift, a) - energy(depth - 1e-3 * lift, a)) / (2e-3 * lift)
        if force is not None:
            check(rise, force, 1e-9, scale / lift)


def test_layer_pull_off_published_forces():
    """Pull off is the most tensile state with its published force."""
    for found, force, factor in (
        (card.half_space_pull_off(**SOFT), lambda a: card.half_space_force(a, **SOFT), 1.5),
        (card.incompressible_pull_off(**THIN), lambda a: card.incompressible_force(a, **THIN), 3),
    ):
        a = float(found.half_width)
        least = minimize_scalar(force, bounds=(a / 3, 3 * a), options={"xatol": 1e-9 * a})
        check(least.x, a, 1e-6)
        check(force(a), found.force, 1e-13)
        check(found.force, -factor * np.pi * W * R, 1e-15)
    check(card.tension_pull_off_force(R=R, w=W), -np.pi * W * R, 1e-15)
    a = R * np.sqrt(W / (2 * 0.031))
    check(card.tension_force(a, R=R, gamma1=0.031, w=W), -np.pi * W * R, 1e-14)
    check(
        card.half_space_force(1e-3, **SOFT | {"w": 0.0}), 4 * E * 1e-9 / (1 - NU**2) / 3 / R, 1e-14
    )


def test_cylinders():
    found = card.incompressible_cylinder_pull_off(**THIN)
    a = float(found.half_width)
    step = 1e-6 * R
    check(card.incompressible_cylinder_depth(a, **THIN), 0.0, 1e-13, a**2 / R)
    pressed = [flowing(step, a, False), flowing(-step, a, False)]
    check((pressed[0] - pressed[1]) / (2 * step), found.force, 1e-9)


def test_eq_16_of_springs():
    springs = {"E": E, "h": H, "gamma1": 0.031, "w": W}
    k = cards.foundation.stiffness(E, 0.25, H)  # c₂ = 0
    found = card.depth(1.7e-5, 0.11, 71.0, ell=np.sqrt(0.031 / k), nu=0.25, **springs)
    check(found, cards.contact_line.depth(1.7e-5, 0.11, k=k, gamma1=0.031, w=W), 1e-13, 1e-3)
