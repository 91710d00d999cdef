"""The verdicts of `stress`: work done with warnings as errors, against 60-digit arithmetic."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Literal, NamedTuple

import numpy as np

from discretization import AccuracyWarning, Equilibrium, NotCertifiedError, minimise
from energy import Scene
from studies.benchmarks.stress import reference

EPS = float(np.finfo(float).eps)
SLACK, TOLERANCE = 1000.0, 1e-12
TIE = 16 * EPS  # relative distance from -δ₀ within which both verdicts are right
KEPT = 12.0  # digits
RTOL = 1e-13
BAD = ("lost", "wrong", "crash", "floating point")
NO_DIGITS = (math.nan,) * 3
Judgement = tuple[tuple[float, float, float], float, str, str]
Work = Callable[[], Judgement]


class Trial(NamedTuple):
    """One point of a grid: x, y decades; digits of a, P, U; largest e/(ε(1 + c)); verdict."""

    grid: str
    shape: str
    x: float
    y: float
    digits: tuple[float, float, float]
    excess: float
    verdict: str
    note: str


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
        word, excess, note = "crash", math.inf, f"{type(problem).__name__}: {problem}"[:300]
        if isinstance(problem, FloatingPointError):
            word, note = "floating point", str(problem)
        elif isinstance(problem, ValueError | NotCertifiedError):
            word, excess = "refused", math.nan
        return Trial(grid, shape, x, y, NO_DIGITS, excess, word, note)


def _strictly(work: Work, underflow: Literal["raise", "ignore"]) -> Judgement:
    with np.errstate(all="raise", under=underflow), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", AccuracyWarning)  # digits are judged here
        return work()


def against_reference(scene: Scene, depth: float) -> Judgement:
    """The default method against 60 digits."""
    given = reference.inputs(scene, depth)
    exact, state = reference.answer(given, scene.slopes), minimise(scene, depth, rtol=RTOL)
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
    a, force, energy = (-math.log10(max(e, EPS / 2)) for e in errors)
    note = f"errors {', '.join(f'{e:.1e}' for e in errors)}, "
    note += f"condition {', '.join(f'{c:.1e}' for c in condition)}"
    word = "wrong" if not certified else "lost" if lost else "ok"
    explained = not lost and min(a, force, energy) >= KEPT
    return (a, force, energy), excess, word, "" if explained else note
