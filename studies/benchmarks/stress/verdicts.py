"""The verdicts of `stress`: work done with warnings as errors, against 60-digit arithmetic."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from typing import Any, Literal, NamedTuple

import numpy as np

from discretization import AccuracyWarning, Equilibrium, NotCertifiedError, minimise
from energy import Scene
from studies.benchmarks.stress import reference as stress_reference

EPS = float(np.finfo(float).eps)
SLACK, TOLERANCE = 1000.0, 1e-12
TIE = 16 * EPS  # relative distance from -δ₀ within which both verdicts are right
KEPT = 12.0  # digits
RTOL = 1e-13
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
    except FloatingPointError as problem:
        return Trial(grid, shape, x, y, NO_DIGITS, math.inf, "floating point", str(problem))
    except (ValueError, NotCertifiedError) as refusal:
        note = f"{type(refusal).__name__}: {refusal}"
        return Trial(grid, shape, x, y, NO_DIGITS, math.nan, "refused", note[:300])
    except Exception as problem:
        note = f"{type(problem).__name__}: {problem}"
        return Trial(grid, shape, x, y, NO_DIGITS, math.inf, "crash", note[:300])


def _strictly(work: Work, underflow: Literal["raise", "ignore"]) -> Judgement:
    with np.errstate(all="raise", under=underflow), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", AccuracyWarning)  # digits are judged here
        return work()


def against_reference(scene: Scene, depth: float) -> Judgement:
    """The default method against 60 digits."""
    with localcontext(prec=stress_reference.DIGITS):
        given = stress_reference.inputs(scene, depth)
        exact = stress_reference.answer(given, scene.slopes)
    state = minimise(scene, depth, rtol=RTOL)
    if exact is None or not state.contacts.size:
        alike = exact is None and not state.contacts.size
        with localcontext(prec=stress_reference.DIGITS):
            tied = state.label == "neutral" and stress_reference.from_detachment(given) <= TIE
        word = "ok" if alike or tied else "wrong"
        return NO_DIGITS, 0.0, word, "" if alike else _detachment(scene, depth)
    return compared(given, scene.slopes, exact, state)


def _detachment(scene: Scene, depth: float) -> str:
    return (
        f"contact or not differs from the reference at d/δ₀ = {depth / scene.critical_separation!r}"
    )


def compared(given: Any, slopes: str, exact: Any, state: Equilibrium) -> Judgement:
    """Errors of a state whose certificate is known to hold."""
    found = (state.half_width, state.force, state.energy)
    scales = (float(exact[0]), state.scales["force"], state.scales["energy"])
    with localcontext(prec=stress_reference.DIGITS):
        errors = [
            float(abs(Decimal(value) - true) / Decimal(scale or 1))
            for value, true, scale in zip(found, exact, scales, strict=True)
        ]
        sizes = stress_reference.Exact(*map(Decimal, scales))
        condition = stress_reference.conditions(given, slopes, sizes)
    return verdict(errors, condition, state.certificate.ok)


def untrusted(scene: Scene, depth: float, state: Equilibrium) -> str:
    """Which errors of a state are more than ten times their estimates; "" where none is."""
    with localcontext(prec=stress_reference.DIGITS):
        given = stress_reference.inputs(scene, depth)
        exact = stress_reference.answer(given, scene.slopes)
        found = zip((state.half_width, state.force, state.energy), exact or (), strict=False)
        errors = [float(abs(Decimal(value) - true)) for value, true in found]
        scales = (state.half_width, *state.scales.values())
        sizes = stress_reference.Exact(*map(Decimal, scales))
        condition = stress_reference.conditions(given, scene.slopes, sizes) if exact else ()
    rows = zip("aPU", errors, scales, condition, state.error_estimate.values(), strict=False)
    short = [
        f"{name} is off by {error / scale:.1e}, estimated {estimate:.1e}"
        for name, error, scale, c, estimate in rows
        if error > scale * (10 * estimate + SLACK * EPS * (1 + c))
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
