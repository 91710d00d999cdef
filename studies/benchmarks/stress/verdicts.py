"""The verdicts of `stress`: work done with warnings as errors, against 60-digit arithmetic.

Random scenes: whether rtol is honoured and error_estimate covers the error. Odd profiles, which
have no closed form: the same question in other units and on the lattice.
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
SLACK = 1000.0
TOLERANCE = 1e-12
TIE = 16 * EPS  # relative distance from -δ₀ within which both verdicts are right
NAMES = ("kink", "double kink", "plateau", "jump", "noise", "smooth noise", "tilted", "edge")
ALIKE = 1e-9
CLOSE = 2e-3
KEPT = 12.0  # digits
RTOL = 1e-13
BAD = ("lost", "wrong", "crash", "floating point")
NO_DIGITS = (math.nan,) * 3
NEAR = {"mesh": 1e-15, "nodes": 1e-13}  # rounding over the sums of the terms of P and U
Judgement = tuple[tuple[float, float, float], float, str, str]
Work = Callable[[], Judgement]


class Trial(NamedTuple):
    """One point of a grid: x, y decades; digits of a, P, U; excess; verdict.

    excess: largest e/(ε(1 + c)); of a random scene the largest error over its estimate.
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
    """Run with warnings as errors; `work` returns digits, excess, verdict and note.

    A number that underflows is noted, and the work repeated with zero in its place.
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
    with np.errstate(all="raise", under=underflow), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", AccuracyWarning)  # digits are judged here
        return work()


def against_reference(scene: Scene, depth: float) -> Judgement:
    """The default method against 60 digits."""
    given = reference.inputs(scene, depth)
    exact = reference.answer(given, scene.slopes)
    state = minimise(scene, depth, rtol=RTOL)
    if exact is None or not state.contacts.size:
        alike = exact is None and not state.contacts.size
        tied = state.label == "neutral" and reference.from_detachment(given) <= TIE
        at = f"d/δ₀ = {depth / scene.critical_separation!r}"
        note = "" if alike else f"contact or not differs from the reference at {at}"
        return NO_DIGITS, 0.0, "ok" if alike or tied else "wrong", note
    return verdict(*_errors(given, exact, state, float(exact.half_width)), state.certificate.ok)


def _errors(
    given: reference.Inputs, exact: reference.Exact, state: Equilibrium, width: float
) -> tuple[list[float], tuple[float, ...]]:
    """Errors of a, P and U, that of a relative to this width, and the condition of each."""
    found = state.half_width, state.force, state.energy
    scales = reference.Exact(*map(Decimal, (width, *state.scales.values())))
    pairs = zip(found, exact, scales, strict=True)
    errors = [float(abs(Decimal(value) - true) / (scale or 1)) for value, true, scale in pairs]
    return errors, reference.conditions(given, state.scene.slopes, scales)


def untrusted(scene: Scene, depth: float, state: Equilibrium) -> str:
    """Which errors of a state are more than ten times their estimates; "" where none is."""
    given = reference.inputs(scene, depth)
    exact = reference.answer(given, scene.slopes)
    if exact is None:
        return ""
    found = *_errors(given, exact, state, state.half_width), state.error_estimate.values()
    short = [
        f"{name} is off by {error:.1e}, estimated {estimate:.1e}"
        for name, error, c, estimate in zip("aPU", *found, strict=True)
        if error > 10 * estimate + SLACK * EPS * (1 + c)
    ]
    return "; ".join(short)


def verdict(errors: Sequence[float], condition: Sequence[float], certified: bool) -> Judgement:
    """Digits, excess, and whether more was lost than the problem's condition explains."""
    bounds = [max(SLACK * EPS * (1 + c), TOLERANCE) for c in condition]
    excess = max(e / (EPS * (1 + c)) for e, c in zip(errors, condition, strict=True))
    lost = [n for n, e, b in zip("aPU", errors, bounds, strict=True) if not e <= b]
    own = digits(errors)
    note = f"errors {', '.join(f'{e:.1e}' for e in errors)}, "
    note += f"condition {', '.join(f'{c:.1e}' for c in condition)}"
    word = "wrong" if not certified else "lost" if lost else "ok"
    explained = not lost and min(own) >= KEPT
    return own, excess, word, "" if explained else note


def random_mesh(case: Case, rtol: float) -> Judgement:
    """A scene solved at its rtol, against its closed forms."""
    state = minimise(case.scene, case.depth, rtol=rtol)
    estimates = [float(state.error_estimate[name]) for name in QUANTITIES]
    return estimated(case.errors(state, case.half_width), estimates, "mesh", rtol)


def random_nodes(case: Case, nodes: float, offset: float) -> Judgement:
    """A scene solved on so many nodes per l, at this offset in links, likewise."""
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
    """Digits, the largest error over its estimate, and whether rtol and estimates were kept."""
    least = NEAR[where] / 10
    worst = max(e / max(own, least) for e, own in zip(errors, estimates, strict=True))
    trusted = worst <= 10
    honoured = max(errors) <= max(rtol, TOLERANCE)
    word = "ok" if trusted and honoured else "lost" if trusted else "wrong"
    told = f"errors {', '.join(f'{e:.1e}' for e in errors)} for rtol = {rtol:.1e}"
    told += f", estimated {', '.join(f'{e:.1e}' for e in estimates)}"
    return digits(errors), worst, word, "" if word == "ok" else told


def digits(errors: Sequence[float]) -> tuple[float, float, float]:
    """What relative errors of a, P and U leave."""
    a, force, energy = (-math.log10(max(e, EPS / 2)) for e in errors)
    return a, force, energy


def profile(name: str, unit: float) -> Indenter:
    """A profile of some micrometres, in another unit of length."""
    x = np.linspace(-12, 12, 481)
    rng = np.random.default_rng(7)
    slopes = {
        "double kink": np.maximum(0.1 * abs(x), 0.4 * abs(x) - 0.9),
        "plateau": np.maximum(0.0, 0.15 * (abs(x) - 1)),
        "jump": x * x / 20 + 0.3 * (abs(x) > 2),
        "noise": x * x / 20 + 1e-5 * rng.normal(size=x.size),
        "smooth noise": x * x / 20 + 1e-5 * rng.normal(size=x.size),
    }
    if name in slopes:
        kind = "smooth" if name == "smooth noise" else "linear"
        return energy.Sampled(x * unit, slopes[name] * unit, kind=kind)
    if name == "kink":
        return energy.Parabola(10 * unit) + energy.Wedge(0.1)
    if name == "tilted":
        return energy.Parabola(10 * unit).shifted(0.3 * unit).tilted(0.03)
    return energy.FlatPunch(1.5 * unit) + energy.Parabola(10 * unit)


def scene(name: str, unit: float) -> Scene:
    """k = γ₁ = 1, w = 0.02 in the unit 1."""
    surfaces = SurfaceEnergies.from_work(1.0 * unit**2, 0.02 * unit**2)
    return Scene(ElasticLayer(1.0 * unit, 0.0, unit), surfaces, profile(name, unit))


def _numbers(state: Equilibrium, unit: float) -> np.ndarray:
    ends = (state.contacts / unit).ravel() if state.contacts.size else np.full(2, math.nan)
    return np.array([*ends, state.force / unit**2, state.energy / unit**3])


@functools.lru_cache(maxsize=64)
def _plain(name: str, depth: float) -> tuple[Equilibrium, Equilibrium]:
    own = scene(name, 1.0)
    return minimise(own, depth), minimise(own, depth, method="lattice", spacing=1 / 400)


def compare(name: str, depth: float, unit: float) -> Judgement:
    """Digits on which two units agree; the lattice close to the default method."""
    here, nodes = _plain(name, depth)
    there = minimise(scene(name, unit), depth * unit)
    size = max(1.0, np.abs(np.nan_to_num(_numbers(here, 1.0))).max())
    apart = np.abs(np.nan_to_num(_numbers(there, unit) - _numbers(here, 1.0))) / size
    if here.contacts.shape != there.contacts.shape:
        apart[:] = 1.0
    off = float(np.nan_to_num(np.abs(_numbers(nodes, 1.0) - _numbers(here, 1.0))).max() / size)
    certified = here.certificate.ok and there.certificate.ok and nodes.certificate.ok
    a, force, energy = (-math.log10(max(e, 1e-16)) for e in (apart[:2].max(), *apart[2:]))
    word = "ok" if apart.max() <= ALIKE and off <= CLOSE and certified else "lost"
    note = "" if word == "ok" else f"units differ by {apart.max():.1e}, lattice by {off:.1e}"
    return (a, force, energy), float(apart.max()), word, note
