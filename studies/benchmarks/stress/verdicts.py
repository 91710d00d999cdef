"""The verdicts of `stress`: work done with warnings as errors, against 60-digit arithmetic.

Random scenes: whether rtol is honoured and error_estimate covers the error. Odd profiles, which
have no closed form: the same question in other units and on the lattice.

Conventions:

- `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to this
  depth, d positive into the layer; with method="lattice" it is that on nodes of a spacing.
- A scene has `elastocapillary_length` l = √(γ₁/k) and `critical_separation` δ₀ = √(2w/k).
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `AccuracyWarning` says that the estimated error of a state exceeds its rtol.
- `NotCertifiedError` is raised where no state passes its own checks.
- `reference.inputs(scene, depth)` are k, γ₁, w, d and the shape in 60 digits; `reference.answer` is
  (a, P, U) of these, None without contact, `conditions` by how much each magnifies relative errors
  of the inputs, and `from_detachment` |d + δ₀|/δ₀.
- `scales` of a state are sums of the absolute terms of its force and energy, `error_estimate`
  relative errors by the names in QUANTITIES, infinite where withheld.
- `label` is "neutral" where contact and none are in balance.
- `on_lattice(scene, depth, spacing)` is a state on nodes, one of them at `origin`.
- A random `Case` has a closed form: `errors(state, half_width)` are relative errors of a, P and U.
"""

import functools
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from decimal import Decimal
from typing import Literal, NamedTuple

import numpy as np

import energy
from discretization import AccuracyWarning, Equilibrium, NotCertifiedError, minimise
from discretization.lattice.state import on_lattice
from energy import ElasticLayer, Indenter, Scene, SurfaceEnergies
from studies.benchmarks.stress import reference
from studies.shared import QUANTITIES
from studies.shared.random_cases import Case

EPS = float(np.finfo(float).eps)
SLACK = 1000.0  # errors may be so many times ε (1 + condition): sums of some hundred rounded terms
TOLERANCE = 1e-12  # what the default method may miss at the rtol asked of it here
TIE = 16 * EPS  # relative distance from -δ₀ within which both verdicts are right
NAMES = ("kink", "double kink", "plateau", "jump", "noise", "smooth noise", "tilted", "edge")
ALIKE = 1e-9  # relative difference of a state in another unit
CLOSE = 2e-3  # relative difference of nodes, of which 400 are in the unit, from the mesh
KEPT = 12.0  # digits that are expected
RTOL = 1e-13  # asked of states that are compared with 60 digits
TRUSTED = 10.0  # an error estimate is trusted if the error is at most so many times it
BAD = ("lost", "wrong", "crash", "floating point")
NO_DIGITS = (math.nan,) * 3  # of a, P and U, where none are counted
NEAR = {"mesh": 1e-15, "nodes": 1e-13}  # rounding over the sums of the terms of P and U
Judgement = tuple[tuple[float, float, float], float, str, str]
Work = Callable[[], Judgement]


class Trial(NamedTuple):
    """One point of a grid.

    Attributes
    ----------
    grid, shape : str
    x, y : float
        Decades of what is varied.
    digits : tuple of three floats
        Those kept of a, P and U; NaN where there is nothing to compare with.
    excess : float
        Largest e/(ε(1 + c)); of a random scene the largest error over its estimate.
    verdict, note : str
    """

    grid: str
    shape: str
    x: float
    y: float
    digits: tuple[float, float, float]
    excess: float
    verdict: str
    note: str

    @property
    def margin(self) -> float:
        """Digits kept minus digits expected, of what comes nearest to the limit; 0 is the limit.

        Expected are 12, or what the problem's own condition leaves: an error of 1000 ε (1 + c). Odd
        profiles, which have no closed form, are expected to agree to 9 digits in other units.
        """
        if math.isnan(self.digits[0]):
            return math.nan
        if self.grid == "profiles":
            return min(self.digits) + math.log10(ALIKE)
        beyond_condition = math.log10(SLACK / max(self.excess, EPS))
        return max(min(self.digits) - KEPT, beyond_condition)


def judged(grid: str, shape: str, x: float, y: float, work: Work) -> Trial:
    """A trial with warnings as errors.

    A number that underflows is noted, and the work repeated with zero in its place.

    Parameters
    ----------
    grid, shape : str
    x, y : float
        The place of the trial on its grid.
    work : callable
        Does it, without arguments, and returns digits, excess, verdict and note.

    Returns
    -------
    Trial
        Of the verdict "refused", "floating point" or "crash" if the work raises.
    """
    try:
        try:
            return Trial(grid, shape, x, y, *_strictly(work, "raise"))
        except FloatingPointError as problem:
            digits, excess, word, note = _strictly(work, "ignore")
            return Trial(grid, shape, x, y, digits, excess, word, f"{problem} {note}")
    except Exception as problem:
        word = "crash"
        excess = math.inf
        note = f"{type(problem).__name__}: {problem}"[:300]
        if isinstance(problem, FloatingPointError):
            word = "floating point"
            note = str(problem)
        elif isinstance(problem, ValueError | NotCertifiedError):
            word = "refused"
            excess = math.nan
        return Trial(grid, shape, x, y, NO_DIGITS, excess, word, note)


def _strictly(work: Work, underflow: Literal["raise", "ignore"]) -> Judgement:
    """What the work returns, with warnings and floating-point problems as errors."""
    with np.errstate(all="raise", under=underflow), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", AccuracyWarning)  # digits are judged here
        return work()


def against_reference(scene: Scene, depth: float) -> Judgement:
    """The default method against 60 digits."""
    given = reference.inputs(scene, depth)
    exact = reference.answer(given, scene.slopes)
    state = minimise(scene, depth, rtol=RTOL)
    if exact is None and not state.contacts.size:
        return NO_DIGITS, 0.0, "ok", ""
    if exact is None or not state.contacts.size:
        tied = state.label == "neutral" and reference.from_detachment(given) <= TIE
        ratio = depth / scene.critical_separation
        note = f"contact or not differs from the reference at d/δ₀ = {ratio!r}"
        return NO_DIGITS, 0.0, "ok" if tied else "wrong", note
    errors, condition = _errors(given, exact, state, float(exact.half_width))
    return verdict(errors, condition, state.certificate.ok)


def _errors(
    given: reference.Inputs, exact: reference.Exact, state: Equilibrium, width: float
) -> tuple[list[float], tuple[float, ...]]:
    """Errors of a, P and U, that of a relative to this width, and the condition of each."""
    found = (state.half_width, state.force, state.energy)
    of_force, of_energy = state.scales.values()
    scales = reference.Exact(Decimal(width), Decimal(of_force), Decimal(of_energy))
    errors = []
    for value, true, scale in zip(found, exact, scales, strict=True):
        error = abs(Decimal(value) - true) / (scale or 1)
        errors.append(float(error))
    return errors, reference.conditions(given, state.scene.slopes, scales)


def untrusted(scene: Scene, depth: float, state: Equilibrium) -> str:
    """Which errors of a state are more than ten times their estimates; "" where none is.

    Parameters
    ----------
    scene : Scene
    depth : float
    state : Equilibrium

    Returns
    -------
    str
    """
    given = reference.inputs(scene, depth)
    exact = reference.answer(given, scene.slopes)
    if exact is None:
        return ""
    errors, conditions = _errors(given, exact, state, state.half_width)
    estimates = state.error_estimate.values()
    said = []
    for name, error, c, estimate in zip("aPU", errors, conditions, estimates, strict=True):
        rounding = SLACK * EPS * (1 + c)
        if error > TRUSTED * estimate + rounding:
            said.append(f"{name} is off by {error:.1e}, estimated {estimate:.1e}")
    return "; ".join(said)


def verdict(errors: Sequence[float], condition: Sequence[float], certified: bool) -> Judgement:
    """Digits, excess, and whether more was lost than the problem's condition explains.

    Parameters
    ----------
    errors : sequence of float
        Relative, of a, P and U.
    condition : sequence of float
        By how much each amplifies a relative error of what is given.
    certified : bool
        Whether the state says that it is an equilibrium.

    Returns
    -------
    Judgement
        "wrong" without a certificate, "lost" if digits are lost, else "ok".
    """
    excess = 0.0
    lost = False
    for error, c in zip(errors, condition, strict=True):
        rounding = EPS * (1 + c)
        excess = max(excess, error / rounding)
        lost = lost or not error <= max(SLACK * rounding, TOLERANCE)
    kept = digits(errors)
    word = "lost" if lost else "ok"
    if not certified:
        word = "wrong"
    if not lost and min(kept) >= KEPT:
        return kept, excess, word, ""
    note = f"errors {_listed(errors)}, condition {_listed(condition)}"
    return kept, excess, word, note


def _listed(values: Sequence[float]) -> str:
    """Numbers with two digits."""
    return ", ".join(f"{value:.1e}" for value in values)


def random_mesh(case: Case, rtol: float) -> Judgement:
    """A scene solved at its rtol, against its closed forms."""
    state = minimise(case.scene, case.depth, rtol=rtol)
    estimates = [float(state.error_estimate[name]) for name in QUANTITIES]
    return estimated(case.errors(state, case.half_width), estimates, "mesh", rtol)


def random_nodes(case: Case, nodes: float, offset: float) -> Judgement:
    """A scene solved on nodes, against its closed forms.

    Parameters
    ----------
    case : Case
    nodes : float
        In l.
    offset : float
        Of the profile, in links.

    Returns
    -------
    Judgement
    """
    dx = case.scene.elastocapillary_length / nodes
    scene = replace(case.scene, indenter=case.scene.indenter.shifted(offset * dx))
    state = on_lattice(scene, case.depth, dx, origin=None if not offset else 0.0)
    estimates = [float(state.error_estimate[name]) for name in QUANTITIES]
    if not max(estimates) < math.inf:
        links = float(np.diff(state.nodes).sum()) / dx
        return NO_DIGITS, 0.0, "withheld", f"{links:.3g} links in contact"
    if not state.contacts.size:
        return NO_DIGITS, math.inf, "wrong", "no contact"
    return estimated(case.errors(state, state.half_width or dx), estimates, "nodes")


def estimated(
    errors: Sequence[float], estimates: Sequence[float], where: str, rtol: float = math.inf
) -> Judgement:
    """Digits, the largest error over its estimate, and whether rtol and estimates were kept.

    Parameters
    ----------
    errors, estimates : sequence of float
        Of a, P and U.
    where : {"mesh", "nodes"}
    rtol : float
        What was asked for; inf: nothing.

    Returns
    -------
    Judgement
        "wrong" if an estimate is too small, "lost" if rtol is missed, else "ok".
    """
    least = NEAR[where] / TRUSTED
    worst = max(
        error / max(estimate, least) for error, estimate in zip(errors, estimates, strict=True)
    )
    honoured = max(errors) <= max(rtol, TOLERANCE)
    if not worst <= TRUSTED:
        word = "wrong"
    elif not honoured:
        word = "lost"
    else:
        return digits(errors), worst, "ok", ""
    note = f"errors {_listed(errors)} for rtol = {rtol:.1e}, estimated {_listed(estimates)}"
    return digits(errors), worst, word, note


def digits(errors: Sequence[float]) -> tuple[float, float, float]:
    """What relative errors of a, P and U leave."""
    a, force, energy = (-math.log10(max(e, EPS / 2)) for e in errors)
    return a, force, energy


def profile(name: str, unit: float) -> Indenter:
    """A profile of which some l are touched, l = 1, in another unit of length.

    Samples are 0.05 l apart, and reach farther than any contact here; their noise has slopes of
    3e-4, small against √(2w/γ₁) = 0.2 and far above rounding. Any seed would do.
    """
    x = np.linspace(-12, 12, 481)
    rng = np.random.default_rng(7)
    heights = {
        "double kink": np.maximum(0.1 * abs(x), 0.4 * abs(x) - 0.9),
        "plateau": np.maximum(0.0, 0.15 * (abs(x) - 1)),
        "jump": x * x / 20 + 0.3 * (abs(x) > 2),
        "noise": x * x / 20 + 1e-5 * rng.normal(size=x.size),
        "smooth noise": x * x / 20 + 1e-5 * rng.normal(size=x.size),
    }
    if name in heights:
        kind = "smooth" if name == "smooth noise" else "linear"
        return energy.Sampled(x * unit, heights[name] * unit, kind=kind)
    if name == "kink":
        return energy.Parabola(10 * unit) + energy.Wedge(0.1)
    if name == "tilted":
        return energy.Parabola(10 * unit).shifted(0.3 * unit).tilted(0.03)
    return energy.FlatPunch(1.5 * unit) + energy.Parabola(10 * unit)


def scene(name: str, unit: float) -> Scene:
    """k = γ₁ = 1, w = 0.02 in the unit 1, so that l = 1 and δ₀ = 0.2."""
    surfaces = SurfaceEnergies.from_work(1.0 * unit**2, 0.02 * unit**2)
    return Scene(ElasticLayer(1.0 * unit, 0.0, unit), surfaces, profile(name, unit))


def _numbers(state: Equilibrium, unit: float) -> np.ndarray:
    """Ends of the contacts, force and energy, as they are in the unit 1; NaN without contact."""
    ends = (state.contacts / unit).ravel() if state.contacts.size else np.full(2, math.nan)
    return np.array([*ends, state.force / unit**2, state.energy / unit**3])


@functools.lru_cache(maxsize=64)
def _in_unit_1(name: str, depth: float) -> tuple[Equilibrium, Equilibrium]:
    """The state on the mesh and on nodes, of which 400 are in l: their error is below CLOSE."""
    own = scene(name, 1.0)
    on_mesh = minimise(own, depth)
    on_nodes = minimise(own, depth, method="lattice", spacing=1 / 400)
    return on_mesh, on_nodes


def compare(name: str, depth: float, unit: float) -> Judgement:
    """Digits on which two units agree; the lattice close to the default method.

    Parameters
    ----------
    name : str
        Of a profile.
    depth : float
        In the unit 1.
    unit : float
        Of length, in place of 1.

    Returns
    -------
    Judgement
    """
    on_mesh, on_nodes = _in_unit_1(name, depth)
    scaled = minimise(scene(name, unit), depth * unit)
    expected = _numbers(on_mesh, 1.0)
    size = max(1.0, np.abs(np.nan_to_num(expected)).max())
    apart = np.abs(np.nan_to_num(_numbers(scaled, unit) - expected)) / size
    if on_mesh.contacts.shape != scaled.contacts.shape:
        apart[:] = 1.0
    of_nodes = np.nan_to_num(np.abs(_numbers(on_nodes, 1.0) - expected))
    off = float(of_nodes.max() / size)
    certified = all(state.certificate.ok for state in (on_mesh, scaled, on_nodes))

    def kept(error: float) -> float:
        """Digits that an error leaves, at most the sixteen of a float."""
        return -math.log10(max(error, 1e-16))  # less than a float can show

    found = (kept(apart[:-2].max()), kept(apart[-2]), kept(apart[-1]))
    largest = float(apart.max())
    if largest <= ALIKE and off <= CLOSE and certified:
        return found, largest, "ok", ""
    return found, largest, "lost", f"units differ by {largest:.1e}, lattice by {off:.1e}"
