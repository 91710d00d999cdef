"""The self-test of `fit`: simulated curves of many kinds, good and bad, fitted from a wrong start.

A sphere on a soft layer is varied at random (w, γ₁ and R by a factor up to 2 to either side), and
so are the noise, the number of points and, where the kind does not say it, the spring that holds
the sphere. "k_c = ..." and "rigid": nothing is wrong; "offset": the zero of the depth is off by up
to 5 µm; "baseline": the free line has a level up to 0.5 nN and a slope up to 3 pN/nm; "drift": the
zeros of depth and force move while it is measured; "no tension": γ₁ = 0, and the fit has it;
"half-space": a JKR contact on a body far thicker than the contact; "layer": the response of a
bonded layer with ν = 0.49; "sign": the force is reversed; "hysteresis": contact opens with 2 to 5
times w; "spike": one to three groups of one or two points are off by 10 to 200 times the
noise, and the loss is soft_l1;
"interference": the force has waves of 5 to 20 times the noise, with 1.5 to 4 periods in the free
part; "volts": the deflection of a cantilever in volts and the position of its piezo in nm stand in
a text file; "pairs": so do depth and force, with a pair of columns for each way; "hold": the
indenter rests at the deepest point, where the force relaxes by up to a half.

Called rightly: a good curve is accepted, and no other model preferred; tension is said not to be
needed; the others are doubted. A drift may be either, unless it spoils the answer. Wrong without a
word: the truth lies farther off than twice the interval, and neither the verdict, nor an
alternative, nor the thickness of the layer casts a doubt.

Conventions:

- A `Table` is the names of its columns, and its rows.
- `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other.
- `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to this
  depth, d positive into the layer.
- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀ =
  √(2w/k).
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `fit(scene, curve, names)` is a `Fit`: `quality.fits` whether the residual may be noise,
  `needless` the parameters that another model does without, `doubts` and `unsuited` what speaks
  against it.
- A `Curve` has depth, force and machine stiffness.
- `Branch(depth, force, smooth).read(drives, K)` are the forces at positions of a machine.
- `astray` is a scene whose parameters are off by a factor.
- `tell` shows the progress on stderr.
"""

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from energy.arrays import Array
from studies.scenes.curve_file import Reading, read_curve
from studies.scenes.fit.branches import Branch
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.model import astray
from studies.shared.batches import Progress, each, tell
from studies.shared.command import Output, answer
from studies.shared.table import Columns, Table

SPRINGS = {"rigid": math.inf, "k_c = 0.3": 0.3, "k_c = 0.08": 0.08, "k_c = 0.03": 0.03}  # N/m
DISTURBED = ("spike", "interference", "volts", "pairs", "hold")
GOOD = (*SPRINGS, "offset", "baseline", *DISTURBED)
KINDS = (
    *(*SPRINGS, "offset", "baseline"),
    *("drift", "no tension", "half-space", "layer", "sign", "hysteresis"),
    *DISTURBED,
)
SENSITIVITY = 50e-9  # m/V, of "volts"
# A colloidal probe on a soft film, around which w, γ₁ and R are drawn.
SCENE = Scene(
    ElasticLayer(E=30e3, nu=0.45, h=0.3e-6),  # Pa, 1, m
    SurfaceEnergies.from_work(gamma1=0.03, w=1e-4),  # N/m, J/m²
    Parabola(R=5e-6),  # m
    geometry="axisymmetric",
)
THICK = 20e-6  # thickness of "half-space" [m]
NU = 0.49  # of "layer"
NOISE = (5e-12, 40e-12)  # [N]
POINTS = (80, 200)  # inwards, and as many outwards
DEPTH = (1.0, 2.5)  # over δ₀
SPREAD = math.log(2.0)  # of the logarithms of w, γ₁ and R
WRONG = 1.5  # factor of the start
FAR_OFF = 2.0  # half-widths of the interval: a wrong result
NEEDED = 0.9  # share of each kind that is called rightly
COVERED = 0.91  # share of intervals of good curves that contain the truth
SILENT = 0.01  # share of wrong results without a warning


@dataclass(frozen=True)
class Parameters:
    """How many curves of which kinds.

    Attributes
    ----------
    curves : int
        Of each kind. In 200 a share of 95 % has a standard error of 1.5 %. One of each of the 17
        kinds takes 26 s of one core, so that 200 take an hour and a half.
    kinds : tuple of str
        Some of KINDS.
    seed : int
        Of the random numbers: any will do.
    """

    curves: int = 200
    kinds: tuple[str, ...] = KINDS
    seed: int = 28


FULL = Parameters()
# In some minutes: a share of 95 % has a standard error of 7 %, which shows a kind that fails.
QUICK = Parameters(curves=10)


class Outcome(NamedTuple):
    """What came of one simulated curve.

    Attributes
    ----------
    kind : str
    number : int
    rightly : bool
        Whether it was called rightly.
    silent : bool
        Whether the result is wrong without a warning.
    holds : tuple of bool or None
        Whether the profile intervals of w, γ₁ and the offset contain the truth; None: without one.
    times : float
        Residual over noise.
    """

    kind: str
    number: int
    rightly: bool
    silent: bool
    holds: tuple[bool | None, ...]
    times: float


@dataclass(frozen=True)
class Record:
    """The outcomes, `curves` of each kind."""

    parameters: Parameters
    outcomes: tuple[Outcome, ...]

    def shares(self, *kinds: str) -> list[float]:
        """Shares of the curves of these kinds that are called rightly and that are wrong without a
        word, and of their intervals of each parameter that contain the truth (nan: none)."""
        own = [one for one in self.outcomes if one.kind in kinds]
        found = [float(np.mean([o.rightly for o in own])), float(np.mean([o.silent for o in own]))]
        for held in zip(*(one.holds for one in own), strict=True):
            known = [one for one in held if one is not None]
            found.append(sum(known) / len(known) if known else math.nan)
        return found

    @property
    def passed(self) -> bool:
        """Whether all shares are as required."""
        kinds = self.parameters.kinds
        n = self.parameters.curves
        slack = 2 * math.sqrt(COVERED * (1 - COVERED) / n)  # of a share found in n curves
        called = all(self.shares(kind)[0] >= NEEDED for kind in kinds)
        held = [share for kind in kinds if kind in GOOD for share in self.shares(kind)[2:]]
        silent = self.shares(*kinds)[1]
        return called and silent <= SILENT and all(one >= COVERED - slack for one in held)


class Case(NamedTuple):
    """A curve, from where its fit starts, and the truth."""

    curve: Curve
    start: Scene
    truth: dict[str, float]


def run(p: Parameters, show: Callable[[Progress], object] = tell, jobs: int = 1) -> Record:
    """All curves, in `jobs` processes. ValueError for none."""
    if p.curves < 1:
        raise ValueError(f"trials = {p.curves!r} must be at least 1: give the number of curves")
    cases = [(kind, number) for number in range(1, p.curves + 1) for kind in p.kinds]
    return Record(p, tuple(each(partial(outcome, p), cases, jobs, show)))


def outcome(p: Parameters, which: tuple[str, int]) -> Outcome:
    """One curve, fitted and judged."""
    curve, start, truth = case(p, *which)
    kind, number = which
    try:
        loss = "soft_l1" if kind == "spike" else "linear"
        found = fit(start, curve, profiles=False, loss=loss)
    except ValueError:  # refused, which is a word
        return Outcome(kind, number, kind not in GOOD, False, (None,) * 3, math.nan)
    doubted = bool(found.doubts)
    holds = list[bool | None]()
    silent = False
    for i, (name, true) in enumerate(truth.items()):
        one = found[name]
        if one.interval is None or not one.identifiable:
            holds.append(None)
            continue
        low, high = one.interval
        holds.append((true > 0 or name == "offset") and found.inside_profile(i, true))
        reach = one.value - low if true < one.value else high - one.value
        silent |= not doubted and abs(true - one.value) > FAR_OFF * reach
    rightly = doubted
    if kind in GOOD:
        preferred = any(one.preferred for one in found.alternatives)
        rightly = found.quality.fits and not (found.unsuited or preferred)
    elif kind == "no tension":
        rightly = "gamma1" in found.needless
    elif kind == "drift":
        rightly = not silent
    return Outcome(kind, number, rightly, silent, tuple(holds), found.quality.times)


def case(p: Parameters, kind: str, number: int) -> Case:
    """A random curve of a kind; the same for the same number and seed."""
    rng = np.random.default_rng([p.seed, KINDS.index(kind), number])
    scene = _varied(SCENE, kind, rng)
    stiffness = SPRINGS.get(kind) or float(rng.choice(list(SPRINGS.values())))
    if kind == "volts":
        stiffness = float(rng.choice([0.3, 0.08, 0.03]))
    drive = _drives(scene, stiffness, rng)
    force = (_half_space if kind == "half-space" else simulated)(scene, drive, stiffness)
    noise = math.exp(rng.uniform(*np.log(NOISE)))
    force = force + noise * rng.standard_normal(force.size)
    drive, force = _disturbed(kind, drive, force, noise, rng)
    zero = float(rng.uniform(-5e-6, 5e-6)) if kind == "offset" else 0.1 * scene.critical_separation
    curve = Curve(drive + zero - force / stiffness, force, stiffness)
    if kind in ("volts", "pairs"):
        curve = _through_a_file(curve, kind)
    if kind == "sign":
        curve = curve._replace(force=-curve.force)
    truth = {"w": scene.work_of_adhesion, "gamma1": scene.gamma1, "offset": zero}
    plain = replace(scene, opening=None, layer=replace(scene.layer, response="springs"))
    if kind in ("no tension", "half-space"):
        truth["gamma1"] = 0.0
        plain = replace(plain, surfaces=SurfaceEnergies.from_work(0.02, truth["w"]))
    return Case(curve, astray(plain, ("w", "gamma1"), WRONG), truth)


def _disturbed(
    kind: str, drive: Array, force: Array, noise: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Positions and forces with the disturbance of a kind."""
    depth_side, force_side = rng.choice([-1.0, 1.0], 2)
    if kind == "baseline":
        level = rng.uniform(-0.5e-9, 0.5e-9)
        return drive, force + level + rng.uniform(-3e-3, 3e-3) * drive
    if kind == "drift":
        passed = np.linspace(0.0, 1.0, force.size)
        moved = drive + depth_side * rng.uniform(1e-9, 10e-9) * passed
        return moved, force + force_side * rng.uniform(0.0, 0.3e-9) * passed
    if kind == "spike":
        return drive, _spiked(force, noise, rng)
    if kind == "interference":
        return drive, force + _interference(drive, noise, rng)
    if kind == "hold":
        return _held(drive, force, noise, rng)
    return drive, force


def _spiked(force: Array, noise: float, rng: np.random.Generator) -> Array:
    """The forces with one to three spikes of one or two points."""
    spiked = force.copy()
    for place in rng.integers(3, force.size - 5, int(rng.integers(1, 4))):
        size = noise * math.exp(rng.uniform(math.log(10), math.log(200)))
        spiked[place : place + int(rng.integers(1, 3))] += size * rng.choice([-1.0, 1.0])
    return spiked


def _interference(drive: Array, noise: float, rng: np.random.Generator) -> Array:
    """Waves over the position, which a laser that interferes adds to the force."""
    free = -float(drive[0])
    periods = float(rng.uniform(1.5, 4))
    phase = float(rng.uniform(0, 2 * math.pi))
    amplitude = noise * float(rng.uniform(5, 20))
    return np.asarray(amplitude * np.sin(2 * math.pi * periods * drive / free + phase))


def _held(
    drive: Array, force: Array, noise: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Positions and forces with a hold at the deepest point, where the force relaxes."""
    top = drive.size // 2
    points = int(rng.integers(40, 120))
    share = float(rng.uniform(0.1, 0.5))
    relaxed = force[top] * (1 - share * (1 - np.exp(-np.arange(points) / 20)))
    relaxed += noise * rng.standard_normal(points)
    rest = np.full(points, drive[top])
    return np.insert(drive, top, rest), np.insert(force, top, relaxed)


def _through_a_file(curve: Curve, kind: str) -> Curve:
    """The curve as it is read from a text file of an instrument."""
    k = curve.machine_stiffness
    cantilever = None if math.isinf(k) else k
    reading = Reading(width=1.0, spring_constant=cantilever, sensitivity=SENSITIVITY)
    header = "Piezo [nm]\tDeflection [V]"
    columns = [1e9 * curve.drive, curve.force / (k * SENSITIVITY)]
    if kind == "pairs":
        half = curve.force.size // 2
        legs = slice(0, half), slice(half, None)
        header = "\t".join(["Depth (nm)\tForce (nN)"] * 2)
        columns = [1e9 * one[leg] for leg in legs for one in (curve.depth, curve.force)]
    rows = ["\t".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "curve.txt")
        path.write_text("\n".join([header, *rows]), "utf-8")
        return read_curve(path, reading)


def _varied(scene: Scene, kind: str, rng: np.random.Generator) -> Scene:
    """The scene with random w, γ₁ and R around its own, and with what its kind of trial changes."""
    w, gamma1, size = (float(x) for x in np.exp(rng.uniform(-SPREAD, SPREAD, 3)))
    w = w * scene.work_of_adhesion
    gamma1 = gamma1 * scene.gamma1
    opening = None
    layer = scene.layer
    if kind == "hysteresis":
        opening = SurfaceEnergies.from_work(gamma1, w * float(rng.uniform(2, 5)))
    if kind == "half-space":
        layer = replace(layer, h=THICK)
    if kind == "layer":
        layer = replace(layer, nu=NU, response="layer")
    surfaces = SurfaceEnergies.from_work(0.0 if kind == "no tension" else gamma1, w)
    body = Parabola(R=5e-6 * size)
    return replace(scene, layer=layer, surfaces=surfaces, indenter=body, opening=opening)


def _drives(scene: Scene, stiffness: float, rng: np.random.Generator) -> Array:
    """In from out of contact, and out again, with free parts on both sides."""
    unit = math.sqrt(2 * scene.work_of_adhesion / SCENE.stiffness)
    R = cast(Parabola, scene.indenter).R
    pull = 2 * math.pi * R * scene.opened.work_of_adhesion / stiffness
    reach = pull + 2 * scene.opened.critical_separation
    deep = float(rng.uniform(*DEPTH)) * unit
    if scene.layer.h == THICK:
        deep = 4 * deep + pull
        reach = pull + 4 * unit
    else:
        deep += max(minimise(replace(scene, opening=None), deep).force, 0.0) / stiffness
    n = int(rng.integers(*POINTS))
    way = np.linspace(-float(rng.uniform(1.5, 2.5)) * reach, deep, n)
    return np.concatenate([way, way[::-1]])


def simulated(scene: Scene, drive: Array, stiffness: float) -> Array:
    """The forces of load_path under the machine's own control."""
    if math.isinf(stiffness):
        return load_path(scene, depths=drive, rtol=1e-5).force
    return load_path(scene, drives=drive, machine_stiffness=stiffness, rtol=1e-5).force


def _half_space(scene: Scene, drive: Array, stiffness: float) -> Array:
    """Without tension on a body far thicker than the contact (energy.cards.layer)."""
    R = cast(Parabola, scene.indenter).R
    w = scene.work_of_adhesion
    E = scene.layer.E
    nu = scene.layer.nu
    modulus = cards.layer.half_space_modulus(E, nu)
    least = np.cbrt(math.pi * w * R**2 / (8 * modulus))  # dd/da = 0
    a = least * np.linspace(12.0, 1.0, 2000)
    depth = np.asarray(cards.layer.half_space_depth(a, R=R, E=E, nu=nu, w=w))
    force = np.asarray(cards.layer.half_space_force(a, R=R, E=E, nu=nu, w=w))
    found, end = Branch(depth, force, True).read(drive, stiffness)
    inwards = np.arange(drive.size) < drive.size // 2
    return np.where(drive < np.where(inwards, 0.0, end), 0.0, found)


def summary(record: Record) -> str:
    """A line per kind."""
    p = record.parameters
    shown = Columns("kind -12|called rightly 14.1%|wrong, no word 14.1%|w 7.1%|γ₁ 7.1%|offset 7.1%")
    lines = [f"{p.curves} random curves of each kind; intervals that hold:", shown.head]
    lines += [shown.line(kind, *record.shares(kind)) for kind in p.kinds]
    lines.append(shown.line("all", None, record.shares(*p.kinds)[1], *[None] * 3))
    needed = f"needed: {NEEDED:.0%}, {SILENT:.0%} in the mean, {COVERED:.0%} of good curves"
    return "\n".join([*lines, needed])


def table(record: Record) -> Table:
    """Columns and a row per curve."""
    rows = [[*o[:4], *("" if h is None else h for h in o.holds), o.times] for o in record.outcomes]
    columns = ["kind", "curve", "called_rightly", "wrong_without_a_word"]
    return [*columns, "holds_w", "holds_gamma1", "holds_offset", "residual_over_noise"], rows


def report(count: int, jobs: int, out: Output) -> int:
    """Run so many curves of each kind, print and write the shares; 1 if they are too low."""
    params = Parameters(count)
    record = run(params, jobs=jobs)
    written = out.table("fit_self_test.csv", params, *table(record))
    print(summary(record))
    print(f"written: {written}")
    answer(f"the self-test {'passed' if record.passed else 'failed'}")
    return 0 if record.passed else 1
