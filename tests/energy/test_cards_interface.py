"""Every function of the cards: units, arrays, what is refused in words; digits of Bessel's."""

import inspect

import mpmath as mp
import numpy as np
import pytest
from support.comparison import check

from energy import cards
from energy.cards.axisymmetric import _bessel

MODULES = {
    f"{below}{module}": getattr(package, module)
    for below, package in (("", cards), ("axisymmetric.", cards.axisymmetric))
    for module in set(package.__all__) - {"Jump", "PullOff", "axisymmetric"}
}
FUNCTIONS = {
    f"{module}.{name}": function
    for module, package in MODULES.items()
    for name, function in inspect.getmembers(package, inspect.isfunction)
    if function.__module__ == f"energy.cards.{module}" and name[0] != "_"
}
VALUES = {  # arguments in SI, none of them 1, by the powers of force and length in their units
    (1, -3): {"k": 1.1e7},
    (1, -2): {"E": 8.3e3, "K": 1.1e3},
    (1, -1): {"gamma1": 0.031, "gamma2": 0.021, "gamma12": 0.047}
    | {"w": 4.3e-3, "w_closing": 1.7e-3},
    (0, -1): {"bend_a": 71.0},
    (0, -0.5): {"c": 3.3},
    (0, 0): {"n": 1.5, "nu": 0.4, "delta": 0.2, "beta": 0.05, "theta": 2.9, "phi": 0.4}
    | {"slope_a": 0.11, "slope_b": -0.06, "slope_f": 0.07, "slope_u": 0.23},
    (0, 1): {"R": 0.013, "a": 2.1e-3, "d": 3.4e-5, "x": 2.2e-3, "h": 1.3e-3}
    | {"f_a": 1.7e-5, "u_a": -2.3e-5, "u": -1.1e-5, "d_min": -7e-6, "d_max": 5.2e-5}
    | {"ell": 1.7e-3, "b": 2.4e-3, "f_b": 1.2e-5, "u_b": -1.9e-5},
}


def call(function, F=1.0, L=1.0, **overrides):
    """The function at VALUES, or the overrides, in units of force and length 1/F and 1/L."""
    values = {s: v * F**p * L**q for (p, q), group in VALUES.items() for s, v in group.items()}
    values = {"f": lambda x: x**2 / (0.026 * L), **values, **overrides}
    used = inspect.signature(function).parameters
    first = [values[s] for s, p in used.items() if p.kind != p.KEYWORD_ONLY]
    keywords = {s: values[s] for s, p in used.items() if p.kind == p.KEYWORD_ONLY and s in values}
    return function(*first, **keywords)


def inherent(function):
    """Σ |p ∂f/∂p| over the arguments p: by so many ε do rounded arguments change the values."""
    plain = np.ravel(call(function))
    total = 0.0
    for s, value in [item for group in VALUES.values() for item in group.items()]:
        if s in inspect.signature(function).parameters:
            total += np.abs(np.ravel(call(function, **{s: value * (1 + 1e-7)})) - plain) * 1e7
    return total


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_units_and_arrays(name):
    function = FUNCTIONS[name]
    plain = np.ravel(call(function))
    for units in ({"F": 1e6}, {"L": 1e3}):
        scaled = np.ravel(call(function, **units))
        assert ((scaled == 0) == (plain == 0)).all()
        powers = np.log(scaled[plain != 0] / plain[plain != 0]) / np.log(*units.values())
        check(powers, np.round(powers), 1e-13, 1)
    own = np.reshape(inherent(function), (-1, 1))
    for s, value in [item for group in VALUES.values() for item in group.items()]:
        if s in inspect.signature(function).parameters and s != "n":
            pair = value * np.array([1, 1.001])
            scalars = np.array([plain, np.ravel(call(function, **{s: pair[1]}))])
            arrays = np.atleast_2d(call(function, **{s: pair}))
            scale = np.abs(scalars.T) + own
            assert (np.abs(arrays - scalars.T) <= 1e-15 * scale).all()


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_refusals_of_every_card(name):
    function = FUNCTIONS[name]
    residual = name.split("_")[-1] == "residual"
    for s in set(inspect.signature(function).parameters) - {"order"}:
        with pytest.raises(ValueError, match=rf"\b{s}\b.* is not finite: pass finite numbers"):
            call(function, **{s: (lambda x: np.nan * x) if s == "f" else np.nan})
        if s in ("E", "K", "R", "a", "b", "c", "delta", "gamma1", "h", "k", "n", "w", "w_closing"):
            with pytest.raises(ValueError, match=rf"^{s} = -0.7 must .*: \w+"):
                call(function, **{s: -0.7})
        if s == "d" and not residual and ".force." not in f".{name}":
            with pytest.raises(ValueError, match=r"^d = -0.001 is below -?[\d.e-]+: .* pass d >= "):
                call(function, d=np.array([3.4e-5, -1e-3]))


@pytest.mark.parametrize(
    ("name", "overrides", "message"),
    [
        ("tail.displacement", {"x": 2e-3}, r"abs\(x\) = 0.002 is below 0.0021: .* \|x\| >= a"),
        ("tail.slope_at_line", {"gamma1": 0.0}, "gamma1 = 0.0 must be > 0: pass the surface"),
        ("tail.amplitude", {"a": 0.04}, "a/l = .* overflow: use displacement"),
        ("contact_line.angle", {"gamma12": 0.1}, "w = .* must be >= 0: lower gamma12"),
        ("contact_line.angle", {"gamma2": 0.2}, "w = .* exceeds 2 gamma1: .* lower gamma2"),
        ("contact_line.angle_deficit", {"w": 0.07}, "w = 0.07 exceeds .* pass w <= 2 gamma1"),
        ("wedge.energy", {"d": -1e-9, "delta": 0.7}, "d = -1e-09 is below 0.0: .*pass d >= "),
        ("wedge.force", {"delta": np.pi / 2}, r"delta = 1.57.*\(0, π/2\): .* in rad"),
        ("wedge.adhesion_force", {"delta": 0.7}, "delta = 0.7.*pass a blunter wedge"),
        ("power_law.energy", {"n": 1.0, "c": 9.0, "d": -1e-9}, "d = -1e-09 is below 0.0.*pass d"),
        ("displacement_control.wedge_jump_in", {"gamma1": 0.0}, "gamma1 = 0.0 must .* two_works"),
        ("load_control.parabola_jump_in", {"gamma1": 0.0}, "gamma1 = 0.0 must .* two_works"),
        ("machine_control.wedge_detachment", {"K": 0.0}, "K = 0.0 must .* load_control"),
        ("two_works.half_widths", {"w_closing": 5e-3}, "w_closing = 0.005 exceeds w: .* pass"),
        ("two_works.loop_area", {"gamma1": 0.0}, "w_closing = 0.0017 needs gamma1 > 0: .* pass"),
        ("two_works.loop_area", {"d_max": -1e-6}, "d_max = -1e-06 is below 0.0: .* pass d_max"),
        ("two_works.cycle_area", {"d_max": -8e-6}, "d_max = -8e-06 is below -7e-06: .* pass"),
        ("two_works.cycle_area", {"d_min": -1e-3}, "d_min = -0.001 is below .* larger d_min"),
        ("power_law.depth", {"n": [2.0, 3.0]}, "n = .* must be one number: loop over exponents"),
        ("power_law.force", {"n": np.array([[1.5]])}, "n = .* must be one number: loop"),
        ("axisymmetric.power_law.depth", {"n": [2.0, 3.0]}, "n = .* must be one number: loop"),
        ("axisymmetric.power_law.force", {"n": np.array([2.0, 3.0])}, "must be one number: loop"),
        ("foundation.stiffness", {"nu": 0.5}, r"nu = 0.5 must lie in \(-1, 1/2\): "),
        ("force.elastic", {"a": "wide"}, "a = 'wide' is not real: pass a number"),
    ],
)
def test_refusals_of_one_card(name, overrides, message):
    with pytest.raises(ValueError, match=message):
        call(FUNCTIONS[name], **overrides)


@pytest.mark.slow
def test_bessel_functions_keep_their_digits():
    for s in [*np.geomspace(1e-8, 1e8, 200).tolist(), 24.9999999, 25.0, 25.0000001]:
        with mp.workdps(60):
            q = mp.besselk(0, s) / mp.besselk(1, s)
            steeper = mp.mpf(s) ** 2 * (q**2 - 1) + s * q
            p = mp.besseli(1, s) / mp.besseli(0, s)
            exact = [float(v) for v in (q, steeper, p)]
        check(_bessel.decay(s), exact[0], 3e-15)
        check(_bessel.growth(s), exact[1], 1e-12)
        check(_bessel.disc(s), exact[2], 3e-15)
    ends = np.array([0.0, 1e-300, 1e300, np.inf])
    check(_bessel.growth(ends), np.array([0.0, 0.0, 0.5, 0.5]), 1e-15, 1e-300)
    check(_bessel.decay(ends)[[0, 2, 3]], np.array([0.0, 1.0, 1.0]), 1e-15)
