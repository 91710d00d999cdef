"""How many digits survive at the ends of the range of every parameter?

| grid     | what is varied                                                                     |
| -------- | ---------------------------------------------------------------------------------- |
| fitted   | a/l 10⁻³..10⁶, w/γ₁ 10⁻¹²..10⁶, f = c|x|ⁿ (n = 1..4) and flat, ν to 0.4999, nm..km  |
| finite   | a/l 10⁻³..10⁶, w/γ₁ 10⁻¹²..2, parabola with true lengths                            |
| lattice  | l/Δx 10⁻³..10⁹, a/l 10⁻³..10⁶, from one link in contact up                          |
| edge     | depths (1 - 10⁻ʲ) of the one at which the contact lets go, j = 1..15                |
| profiles | kinks, jumps, plateaus, noise; in units from nm to km                               |

Each state must be certified, and is compared with 60-digit arithmetic (stress_reference.py) where
that has an answer. With e the error of a relative to a, of P and U relative to the sums of their
terms' absolute values, and c = Σ |p ∂Q/∂p|/scale the problem's own condition,

    lost: e > 1000 ε (1 + c)   (and e > 10⁻¹² for the default method's own tolerance).

Where fewer than 12 digits are kept, the note of the CSV gives e and c, and the line of the grid
counts such points. At a distance of 16 ε from letting go a depth is that of letting go: "neutral"
passes on either side of it, and nowhere else.

The odd profiles have no closed form: their results must not depend on the units (10⁻⁹), and the
lattice must agree with the default method. Every floating-point warning is an error. Output: a heat
map of digits kept for each grid, a CSV, the list of what was lost or failed, why points were
refused. Exit status 1 if anything was lost or failed.
"""

from __future__ import annotations

import math
import re
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from discretization import AccuracyWarning, Equilibrium, NotCertifiedError, minimise
from discretization.certificate import measured
from discretization.lattice import fronts
from discretization.lattice.nodes import Lattice
from energy import ElasticLayer, FlatPunch, Indenter, Parabola, PowerLaw, Scene, SurfaceEnergies
from studies import command, stress_profiles, stress_reference
from studies.batches import each
from studies.stress_figure import plot

EPS = float(np.finfo(float).eps)
SLACK, TOLERANCE = 1000.0, 1e-12
TIE = 16 * EPS  # relative distance from -δ₀ within which both verdicts are right
KEPT, REASON = 12.0, 120  # digits, characters
GRIDS = ("fitted", "finite", "lattice", "edge", "profiles")
UNITS = (1.0, 1e9, 1e-3, 1e6, 1e3)  # per metre
POISSON = (0.0, 0.3, 0.49, 0.4999, -0.9)
RTOL = 1e-13
BAD = ("lost", "wrong", "crash", "floating point")


@dataclass(frozen=True)
class Parameters:
    """Decades between two points of a grid; most nodes in contact on the lattice."""

    stride: int = 1
    nodes: int = 2 * 10**6


QUICK = Parameters(stride=3, nodes=10**4)


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


NO_DIGITS = (math.nan,) * 3
Judgement = tuple[tuple[float, float, float], float, str, str]


def judged(grid: str, shape: str, x: float, y: float, work: Callable[[], Judgement]) -> Trial:
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
        return Trial(grid, shape, x, y, NO_DIGITS, math.nan, "refused", note[:200])
    except Exception as problem:
        note = f"{type(problem).__name__}: {problem}"
        return Trial(grid, shape, x, y, NO_DIGITS, math.inf, "crash", note[:200])


def _strictly(work: Callable[[], Judgement], underflow: Literal["raise", "ignore"]) -> Judgement:
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
            tied = state.label == "neutral" and stress_reference.from_letting_go(given) <= TIE
        word = "ok" if alike or tied else "wrong"
        return NO_DIGITS, 0.0, word, "" if alike else _letting_go(scene, depth)
    return compared(given, scene.slopes, exact, state)


def _letting_go(scene: Scene, depth: float) -> str:
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


def scene_at(
    number: int, width: float, work: float, shape: str, slopes: str = "small"
) -> tuple[Scene, float]:
    """a/l and w/γ₁ given; the slope at the line in π - θ (1: no tail), units and ν change."""
    unit, nu = UNITS[number % len(UNITS)], POISSON[number // 2 % len(POISSON)]
    ell, h = 1e-6 * unit, 3e-6 * unit
    layer = ElasticLayer(2e4, nu, h)
    gamma1 = layer.stiffness * ell * ell
    alpha, a = math.sqrt(2 * work), width * ell
    surfaces = SurfaceEnergies.from_work(gamma1, work * gamma1)
    rise = (0.6, 1.0)[number % 2] * (min(alpha, 0.7) if slopes == "finite" else alpha)
    body: Indenter
    if shape == "flat":
        body, depth = FlatPunch(a), -0.7 * alpha * ell
    elif shape == "parabola":
        body, depth = Parabola(a / rise), rise * (a / 2 + ell) - alpha * ell
    else:
        n = int(shape[1:])
        body = PowerLaw(rise / n * a ** (1 - n), n)
        depth = rise * (a / n + ell) - alpha * ell
    return Scene(layer, surfaces, body, slopes=slopes), depth


def fitted(params: Parameters) -> list[Trial]:
    """a/l against w/γ₁, small slopes."""
    trials: list[Trial] = []
    for x in range(-3, 7, params.stride):
        for y in range(-12, 7, params.stride):
            for shape in ("parabola", "x1", "x3", "x4", "flat"):
                scene, depth = scene_at(len(trials), 10.0**x, 10.0**y, shape)
                work = _reference(scene, depth)
                trials.append(judged("fitted", shape, x, y, work))
    return trials


def _reference(scene: Scene, depth: float) -> Callable[[], Judgement]:
    return lambda: against_reference(scene, depth)


def finite(params: Parameters) -> list[Trial]:
    """a/l against w/γ₁ up to 2, finite slopes."""
    trials: list[Trial] = []
    for x in range(-3, 7, params.stride):
        for y in (*range(-12, 0, params.stride), math.log10(0.5), 0.0, math.log10(1.99)):
            for shape in ("parabola", "flat"):
                scene, depth = scene_at(len(trials), 10.0**x, 10.0**y, shape, "finite")
                if shape == "flat":  # no closed form here
                    continue
                trials.append(judged("finite", shape, x, y, _reference(scene, depth)))
    return trials


def lattice(params: Parameters) -> list[Trial]:
    """l/Δx against a/l: energy, force and place of the line on the same lattice."""
    trials: list[Trial] = []
    for x in range(-3, 10, params.stride):
        for y in range(-3, 7, params.stride):
            if not 0.5 <= 10.0 ** (x + y) <= params.nodes / 2:
                continue
            scene, depth = scene_at(len(trials), 10.0**y, 1e-2, "parabola")
            spacing = scene.elastocapillary_length / 10.0**x
            trials.append(judged("lattice", "parabola", x, y, _nodes(scene, depth, spacing)))
    return trials


def _nodes(scene: Scene, depth: float, spacing: float) -> Callable[[], Judgement]:
    def work() -> Judgement:
        body, lat = scene.indenter, Lattice.of(scene, spacing)
        where = fronts.region(lat, body, depth)
        contact = fronts.adhered(lat, body, depth, where)
        if contact is None:
            return NO_DIGITS, 0.0, "refused", "no contact node"
        sums = measured(lat, body, depth, contact)
        with localcontext(prec=stress_reference.DIGITS):
            given = stress_reference.inputs(scene, depth)
            exact = stress_reference.on_nodes(given, spacing, contact.last)
            misplaced = max(
                0.0,
                stress_reference.resistance(given, spacing, contact.last - 1),
                -stress_reference.resistance(given, spacing, contact.last),
            )
            errors = [
                misplaced,
                float(abs(Decimal(sums.force) - exact.force) / Decimal(sums.force_scale)),
                float(abs(Decimal(sums.energy) - exact.energy) / Decimal(sums.energy_scale)),
            ]
        found = verdict(errors, (max(1.0, contact.last), 10.0, 10.0), True)
        try:
            minimise(scene, depth, method="lattice", spacing=spacing)
        except NotCertifiedError as refusal:
            return (*found[:2], "refused" if found[2] == "ok" else found[2], str(refusal)[:200])
        return found

    return work


def edge(params: Parameters) -> list[Trial]:
    """Depths ever closer to letting go, from both sides."""
    trials: list[Trial] = []
    for shape in ("parabola", "x1", "x3", "x4", "flat"):
        for j in range(1, 16, max(1, params.stride - 1)):
            for side in (1, -1):
                scene, _ = scene_at(len(trials), 3.0, 1e-2, shape)
                last = -scene.critical_separation
                if shape == "x1":
                    last += scene.elastocapillary_length * float(scene.indenter.slope(1.0))
                depth = last * (1 - side * 10.0**-j)
                trials.append(judged("edge", shape, j, side, _reference(scene, depth)))
    return trials


def profiles(params: Parameters) -> list[Trial]:
    """Odd profiles in all units, and lattice against the default method."""
    trials = []
    for number, name in enumerate(stress_profiles.NAMES):
        for unit in range(-9, 10, 3 * params.stride):
            for depth in (0.5, -0.3):
                work = stress_profiles.compare(name, depth, 10.0**unit)
                trials.append(judged("profiles", name, unit, number + depth / 2, work))
    return trials


RUNS = {
    "fitted": fitted,
    "finite": finite,
    "lattice": lattice,
    "edge": edge,
    "profiles": profiles,
}


def run(
    params: Parameters = Parameters(),
    grids: Sequence[str] = GRIDS,
    show: Callable[[str], object] = lambda line: None,
    jobs: int = 1,
) -> list[Trial]:
    """All trials, grids in `jobs` processes; `show` gets a line for each grid."""
    trials: list[Trial] = []
    work = [RUNS[name] for name in grids]
    for name, own in zip(grids, each(partial(_called, params), work, jobs), strict=True):
        show(summary(name, own))
        trials += own
    return trials


def _called(params: Parameters, grid: Callable[[Parameters], list[Trial]]) -> list[Trial]:
    return grid(params)


def summary(name: str, trials: Sequence[Trial]) -> str:
    """Counts of verdicts, the fewest digits of a grid, and why some points keep fewer than 12."""
    words = [t.verdict for t in trials]
    counts = ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(sorted(words)))
    known = [t for t in trials if t.verdict == "ok" and not math.isnan(t.digits[0])]
    if not known:
        return f"{name:9s} {counts}"
    fewest = [min(column) for column in zip(*(t.digits for t in known), strict=True)]
    told = ", ".join(f"{q} {d:.1f}" for q, d in zip("aPU", fewest, strict=True))
    few = [t for t in known if min(t.digits) < KEPT]
    allowed = f"{len(known) - len(few)} of {len(known)} keep 12"
    if few:
        worst = max(t.excess for t in few)
        allowed += f", the other {len(few)} lose at most {worst:.1g} ε (1 + condition)"
    return f"{name:9s} {counts}; fewest digits of {told}; {allowed}"


def refusals(trials: Sequence[Trial]) -> Counter[str]:
    """How often a point was refused for which reason, numbers left out."""
    notes = (t.note for t in trials if t.verdict == "refused")
    told = (re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "…", note) for note in notes)
    return Counter(f"{note[:REASON]} …" for note in told)


def table(trials: Sequence[Trial]) -> tuple[list[str], list[list[object]]]:
    """Columns and a row per trial."""
    names = ["digits_half_width", "digits_force", "digits_energy", "excess", "verdict", "note"]
    return ["grid", "shape", "x", "y", *names], [[*t[:4], *t.digits, *t[5:]] for t in trials]


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study; 1 if anything was lost or failed."""
    parser = command.parser("stress", __doc__, "every third decade")
    parser.add_argument("--grids", nargs="+", default=list(GRIDS), choices=GRIDS)
    options, out = command.parse(parser, argv)
    params = QUICK if options.preset == "quick" else Parameters()
    trials = run(params, options.grids, command.say, options.jobs)
    out.table("stress.csv", params, *table(trials))
    out.figure("stress.png", plot(trials, options.grids))
    bad = [t for t in trials if t.verdict in BAD]
    for t in sorted(bad, key=lambda t: (t.grid, t.shape, -t.excess)):
        print(f"{t.verdict:14s} {t.grid:8s} {t.shape:8s} x = {t.x:5.3g}, y = {t.y:5.3g}: {t.note}")
    for reason, times in refusals(trials).items():
        print(f"refused {times} times: {reason}")
    print(f"{len(trials)} points, {len(bad)} lost or failed")
    return 1 if bad else 0
