"""How many digits survive extreme parameters, and can rtol and error_estimate be trusted?

| grid     | what is varied                                                                     |
| -------- | ---------------------------------------------------------------------------------- |
| fitted   | a/l 10⁻³..10⁶, w/γ₁ 10⁻¹²..10⁶, f = c|x|ⁿ (n = 1..4) and flat, ν to 0.4999, nm..km  |
| finite   | a/l 10⁻³..10⁶, w/γ₁ 10⁻¹²..2, parabola with true lengths                            |
| lattice  | l/Δx 10⁻³..10⁹, a/l 10⁻³..10⁶, from one link in contact up                          |
| edge     | depths 10⁻ʲ δ₀ above and below that at which the contact detaches, j = 1..15         |
| profiles | kinks, jumps, plateaus, noise; in units from nm to km                               |
| random   | scenes of every body over eight decades, small and finite slopes, at a random rtol  |
| nodes    | likewise on lattices with 2 to 400 nodes per l, from a fraction of a link in contact |

The layers are those of the model, beyond the limits of independent springs on purpose. Each state
must be certified, and is compared with 60-digit arithmetic (reference.py beside this file) where
that has an answer. With e the error of a relative to a, of P and U relative to the sums of their
terms' absolute values, and c = Σ |p ∂Q/∂p|/scale the problem's own condition,

    lost: e > 1000 ε (1 + c)   (and e > 10⁻¹² for the default method's own tolerance).

Where fewer than 12 digits are kept, the note of the CSV gives e and c, and the line of the grid
counts such points. On the lattice no error of a, P or U against the continuum may be more than ten
times `error_estimate`, which is infinite where it is withheld. At a distance of 16 ε from that
of detachment a depth counts as it: "neutral" passes on either side of it, and nowhere else.

Random scenes are compared with energy.cards; with e the largest error of a, P or U

    rtol is honoured: e <= max(rtol, 1e-12),    an estimate trusted: error_estimate >= e/10.

Lattices have no rtol, and withhold their estimate where they do not resolve the state.

The odd profiles have no closed form: their results must not depend on the units (10⁻⁹), and the
lattice must agree with the default method. Every floating-point warning is an error.

Output: a heat map of digits kept minus digits expected for each grid (0: the limit above), errors
over their estimates, a CSV, the list of
what was lost or failed. Exit status 1 if anything was.
"""

# Conventions:
# - Depths d are positive into the layer, l = √(γ₁/k), δ₀ = √(2w/k); at the depth -δ₀ a flat face
#   detaches.
# - a, P and U are half-width, force and energy, in this order wherever there are three numbers:
#   digits, errors, conditions.
# - A `Judgement` is (digits, excess, verdict, note), `Work` a function without arguments that
#   returns one, and `judged` makes a `Trial` of it: digits kept (NaN where nothing is compared:
#   NO_DIGITS), the verdict, which BAD lists if it fails, and `excess`, the largest error: over ε (1
#   + c), or in the grids SCATTERED, `random` and `nodes`, over its own estimate.
# - KEPT is 12 digits.
# - A random `Case` is a scene at a depth with its closed form; `in_turn(rng, i)` draws number i.
# - `show` and `command.say` take a line of text.
# - `against_reference(scene, depth)` judges the default method by 60 digits.
# - `reference.inputs` are k, γ₁, w, d and the shape in these digits.
# - `Lattice.of(scene, spacing)` has nodes at multiples of the spacing, `lattice.x(i)` is the place
#   of node i and `spring_stiffness` is kΔx.
# - `NodalEnergy(lattice, contact, first)` is the energy of nodes from number `first` on: `value(u)`
#   is it, and `pulls` are the stiffnesses of the surfaces beyond both ends.
# - `nodes` of a state are its outermost contact nodes (m, 2), `scales` the sums of the absolute
#   terms of its force and energy.

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from itertools import product

import numpy as np

from discretization import Lattice, NodalEnergy, minimise
from energy import ElasticLayer, FlatPunch, Indenter, Parabola, PowerLaw, Scene, SurfaceEnergies
from studies.benchmarks.stress import reference, verdicts
from studies.benchmarks.stress.figure import SCATTERED, plot
from studies.benchmarks.stress.verdicts import (
    BAD,
    KEPT,
    NO_DIGITS,
    Judgement,
    Trial,
    Work,
    against_reference,
    judged,
    untrusted,
    verdict,
)
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.random_cases import Case, in_turn
from studies.shared.table import Table

UNITS = (1.0, 1e9, 1e-3, 1e6, 1e3)  # of length, so many in a metre
POISSON = (0.0, 0.3, 0.49, 0.4999, -0.9)  # from auxetic to nearly incompressible
SHAPES = ("parabola", "x1", "x3", "x4", "flat")
# The scenes of the grids. Results depend on ratios alone, so that these three may have any values;
# they are those of a soft layer.
_E = 2e4  # Young's modulus [Pa]
_ELL = 1e-6  # l [m]
_THICKNESS = 3e-6  # h [m]
# Slope of the profile at the line over α = √(2w/γ₁), where the surface is at u(a) = l (f'(a) - α):
# pulled up by 0.4 δ₀, and level.
_RISES = (0.6, 1.0)
_STEEPEST = 0.7  # 35°, in place of α where that is no slope any more, with w near γ₁
_PULLED = -0.7  # of δ₀: the depth of a flat face, between touch at 0 and detachment at -1
# Of grids in which these do not vary: both springs and tension matter, and slopes are some degrees,
# so that nothing here costs digits.
_WIDTH = 3.0  # a/l
_WORK = 1e-2  # w/γ₁
# Of P and U of a given set of nodes: the sum of the powers, at most 8, by which k, γ₁, w, d and 1/R
# enter a term of U, and two more.
_CONDITION_ON_NODES = 10.0
_DEPTHS_OF_PROFILES = (0.5, -0.05)  # pressed, and pulled by a quarter of δ₀ = 0.2
_NODES_PER_L = (2, 400)  # coarser, hardly an estimate is given; finer is what `profiles` has
Point = tuple[str, float, float, Work]  # shape, x, y, and what is judged there


@dataclass(frozen=True)
class Parameters:
    """How much is tried.

    Attributes
    ----------
    stride : int
        Decades between two points of a grid.
    nodes : int
        The most in contact on the lattice: with 2e6 no state takes more than 2 s, and the whole
        grid 8 s.
    scenes : int
        Random ones on the mesh, at rtol from 1e-2 to 1e-12: 500 take 8 s.
    lattices : int
        Random ones on nodes: 2000, the most work of all, take one to some minutes.
    seed : int
        Of both; any.
    """

    stride: int = 1
    nodes: int = 2 * 10**6
    scenes: int = 500
    lattices: int = 2000
    seed: int = 3


# About a ninth of each grid, and random scenes as many as are done in the same few seconds.
QUICK = Parameters(stride=3, nodes=10**4, scenes=100, lattices=20)


def scene_at(
    number: int, width: float, work: float, shape: str, slopes: str = "small"
) -> tuple[Scene, float]:
    """A scene of a given width of contact and work of adhesion.

    Parameters
    ----------
    number : int
        Chooses units, ν and the slope at the line, so that they change from scene to scene.
    width, work : float
        a/l and w/γ₁.
    shape : str
        One of SHAPES; "xn" is f = c|x|ⁿ.
    slopes : {"small", "finite"}

    Returns
    -------
    scene : Scene
    depth : float
        Where the contact is this wide, d = f(a) + l (f'(a) - α) (16); with finite slopes nearly.
    """
    turn = number // len(SHAPES)  # so that each shape, which changes fastest, has all of them
    unit = UNITS[turn % len(UNITS)]
    nu = POISSON[(turn + turn // len(UNITS)) % len(POISSON)]
    ell = _ELL * unit
    layer = ElasticLayer(_E, nu, _THICKNESS * unit)
    gamma1 = layer.stiffness * ell * ell
    alpha = math.sqrt(2 * work)
    a = width * ell
    surfaces = SurfaceEnergies.from_work(gamma1, work * gamma1)
    rise = _RISES[number % 2] * (min(alpha, _STEEPEST) if slopes == "finite" else alpha)
    body: Indenter
    if shape == "flat":
        body = FlatPunch(a)
        depth = _PULLED * alpha * ell  # δ₀ = α l
    elif shape == "parabola":
        body = Parabola(a / rise)
        depth = rise * (a / 2 + ell) - alpha * ell
    else:
        n = int(shape[1:])
        body = PowerLaw(rise / n * a ** (1 - n), n)
        depth = rise * (a / n + ell) - alpha * ell
    return Scene(layer, surfaces, body, slopes=slopes), depth


def fitted(params: Parameters) -> Iterator[Point]:
    """a/l against w/γ₁, small slopes: surface alone and springs alone by a factor 10³ and more."""
    decades = range(-3, 7, params.stride), range(-12, 7, params.stride)
    for number, (x, y, shape) in enumerate(product(*decades, SHAPES)):
        scene, depth = scene_at(number, 10.0**x, 10.0**y, shape)
        yield shape, x, y, partial(against_reference, scene, depth)


def finite(params: Parameters) -> Iterator[Point]:
    """a/l against w/γ₁ up to 2, finite slopes."""
    # up to 2, beyond which no contact angle exists
    works = (*range(-12, 0, params.stride), math.log10(0.5), 0.0, math.log10(1.99))
    for number, (x, y) in enumerate(product(range(-3, 7, params.stride), works)):
        scene, depth = scene_at(number, 10.0**x, 10.0**y, "parabola", "finite")
        yield "parabola", x, y, partial(against_reference, scene, depth)


def lattice(params: Parameters) -> Iterator[Point]:
    """l/Δx against a/l: energy, force and place of the line on the same lattice."""
    decades = product(range(-3, 10, params.stride), range(-3, 7, params.stride))
    # from one link in contact, 2a = Δx, up to as many nodes as are wanted
    held = ((x, y) for x, y in decades if 0.5 <= 10.0 ** (x + y) <= params.nodes / 2)
    for number, (x, y) in enumerate(held):
        scene, depth = scene_at(number, 10.0**y, _WORK, "parabola")
        spacing = scene.elastocapillary_length / 10.0**x
        yield "parabola", x, y, partial(on_nodes, scene, depth, spacing)


def on_nodes(scene: Scene, depth: float, spacing: float) -> Judgement:
    """Energy, force and place of the line on a lattice, against 60 digits.

    The state must have passed the last link of its contact and not the next: `reference.resistance`
    of a link is the gap there over that which adhesion closes, less 1, at most 0 where the line
    advances. By how much either is missed is the error of the line. Force and energy are computed
    in floats of the same contact nodes as in 60 digits.

    Parameters
    ----------
    scene : Scene
        With a parabola.
    depth, spacing : float

    Returns
    -------
    Judgement
        "wrong" also where `untrusted` names an error of more than ten times its estimate.
    """
    state = minimise(scene, depth, method="lattice", spacing=spacing)
    if not state.contacts.size:
        return NO_DIGITS, 0.0, "refused", "no contact node"
    last = round(
        float(state.nodes[0, 1]) / spacing
    )  # of the contact nodes -last..last, placed at x
    lattice = Lattice.of(scene, spacing)
    node = np.arange(-last, last + 1)
    nodal = NodalEnergy(lattice, np.ones(node.size, bool), -last)
    g = depth - scene.indenter.height(lattice.x(node))
    tails = float(nodal.pulls @ g[[0, -1]])  # forces of both tails: stiffness times u at the line
    given = reference.inputs(scene, depth)
    force, energy = reference.on_nodes(given, spacing, last)
    passed = reference.resistance(given, spacing, last - 1)
    not_passed = reference.resistance(given, spacing, last)
    own_force = float(lattice.spring_stiffness * g.sum() + tails)
    of_force = abs(Decimal(own_force) - force) / Decimal(state.scales["force"])
    of_energy = abs(Decimal(nodal.value(g)) - energy) / Decimal(state.scales["energy"])
    errors = [max(0.0, passed, -not_passed), float(of_force), float(of_energy)]
    # A link's gap is a difference of heights that are `last` times as large. `minimise` returns
    # no state without a certificate.
    conditions = max(1.0, last), _CONDITION_ON_NODES, _CONDITION_ON_NODES
    found = verdict(errors, conditions, certified=True)
    doubted = untrusted(scene, depth, state)
    return (*found[:2], "wrong", doubted) if doubted else found


def edge(params: Parameters) -> Iterator[Point]:
    """Depths ever closer to detachment, from both sides: side 1 still has the contact.

    It detaches at -δ₀, where the tip of a profile would be the line: u = -δ₀ there. A wedge, whose
    slope at the tip is that of its flank, detaches already at -δ₀ + l f' (16).
    """
    steps = range(1, 16, max(1, params.stride - 1))  # the quick preset has every second one of 15
    for number, (shape, j) in enumerate(product(SHAPES, steps)):
        scene, _ = scene_at(number, _WIDTH, _WORK, shape)
        delta0 = scene.critical_separation
        last = -delta0
        if shape == "x1":
            last += scene.elastocapillary_length * float(scene.indenter.slope(1.0))
        for side in (1, -1):
            depth = last + side * 10.0**-j * delta0
            yield shape, j, side, partial(against_reference, scene, depth)


def profiles(params: Parameters) -> Iterator[Point]:
    """Odd profiles in all units, and lattice against the default method.

    `verdicts.compare` solves each at a depth in the unit 1, of l, on the mesh and on nodes, and on
    the mesh again in another unit, and compares contacts, force and energy.
    """
    units = range(-9, 10, 3 * params.stride)
    names = enumerate(verdicts.NAMES)
    for (number, name), unit, depth in product(names, units, _DEPTHS_OF_PROFILES):
        work = partial(verdicts.compare, name, depth, 10.0**unit)
        yield name, unit, number + depth / 2, work


def random(params: Parameters) -> Iterator[Point]:
    """rtol against a/l, small and finite slopes in turn."""
    rng = np.random.default_rng(params.seed)
    for i in range(params.scenes):
        case = in_turn(rng, i)
        x = -rng.uniform(2, 12)  # log₁₀ rtol, down to what the default method promises
        yield *_named(case, x), partial(verdicts.random_mesh, case, 10**x)


def nodes(params: Parameters) -> Iterator[Point]:
    """l/Δx against a/l, half of the lattices shifted."""
    rng = np.random.default_rng(params.seed)
    for i in range(params.lattices):
        case = in_turn(rng, i)
        x = rng.uniform(*np.log10(_NODES_PER_L))
        offset = float(rng.choice([0.0, rng.uniform(-0.5, 0.5)]))  # of the profile, in spacings
        yield *_named(case, x), partial(verdicts.random_nodes, case, 10**x, offset)


def _named(case: Case, x: float) -> tuple[str, float, float]:
    """Name, x and y of a random case in its figure: y is log₁₀ a/l."""
    width = case.half_width / case.scene.elastocapillary_length
    return f"{case.shape}, {case.scene.slopes} slopes", float(x), math.log10(width)


RUNS = {grid.__name__: grid for grid in (fitted, finite, lattice, edge, profiles, random, nodes)}
GRIDS = tuple(RUNS)


def run(
    params: Parameters = Parameters(),
    grids: Sequence[str] = GRIDS,
    show: Show = silent,
    jobs: int = 1,
) -> list[Trial]:
    """All trials, in `jobs` processes; `show` gets a line for each grid.

    Parameters
    ----------
    params : Parameters
    grids : sequence of str
        Names of RUNS.
    show : callable, optional
        Gets a line of text for each grid.
    jobs : int
        Number of processes.

    Returns
    -------
    list of Trial
    """
    cases = [(name, *point) for name in grids for point in RUNS[name](params)]
    trials = list(each(_judged, cases, jobs))
    for name in grids:
        show(summary(name, [t for t in trials if t.grid == name]))
    return trials


def _judged(case: tuple[str, str, float, float, Work]) -> Trial:
    """`verdicts.judged` of one argument: grid, shape, x, y, and what is judged there."""
    return judged(*case)


def exact(trials: Sequence[Trial]) -> list[Trial]:
    """Those that have a reference to the last digit, and passed: of no random scene."""
    own = (t for t in trials if t.grid not in SCATTERED)
    return [t for t in own if t.verdict == "ok" and not math.isnan(t.digits[0])]


def summary(name: str, trials: Sequence[Trial]) -> str:
    """Counts of verdicts, the fewest digits of a grid, and why some points keep fewer than 12."""
    words = [t.verdict for t in trials]
    counts = ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(sorted(words)))
    if name in SCATTERED:
        worst = max((t.excess for t in trials if t.verdict == "ok"), default=math.nan)
        return f"{name:9s} {counts}; error at most {worst:.2g} times its estimate"
    known = exact(trials)
    if not known:
        return f"{name:9s} {counts}"
    fewest = [min(column) for column in zip(*(t.digits for t in known), strict=True)]
    fewest_text = ", ".join(f"{q} {d:.1f}" for q, d in zip("aPU", fewest, strict=True))
    few = [t for t in known if min(t.digits) < KEPT]
    allowed = f"{len(known) - len(few)} of {len(known)} keep 12"
    if few:
        worst = max(t.excess for t in few)
        allowed += f", the other {len(few)} lose at most {worst:.1g} ε (1 + condition)"
    return f"{name:9s} {counts}; fewest digits of {fewest_text}; {allowed}"


def table(trials: Sequence[Trial]) -> Table:
    """Columns and a row per trial."""
    names = ["digits_half_width", "digits_force", "digits_energy", "excess", "verdict", "note"]
    return ["grid", "shape", "x", "y", *names], [[*t[:4], *t.digits, *t[5:]] for t in trials]


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study; 1 if anything was lost or failed."""
    parser = command.parser("stress", __doc__, "every third decade")
    command.some_of(parser, "--grids", GRIDS)
    options, out = command.parse(parser, argv)
    params = QUICK if options.preset == "quick" else Parameters()
    trials = run(params, options.grids, command.say, options.jobs)
    out.table("stress.csv", params, *table(trials))
    out.figure("stress.png", plot(trials, options.grids))
    bad = [t for t in trials if t.verdict in BAD]
    for t in sorted(bad, key=lambda t: (t.grid, t.shape, -t.excess)):
        print(f"{t.verdict:14s} {t.grid:8s} {t.shape:8s} x = {t.x:5.3g}, y = {t.y:5.3g}: {t.note}")
    command.answer(answer(trials, len(bad)))
    return 1 if bad else 0


def answer(trials: Sequence[Trial], bad: int) -> str:
    """How many points keep their digits, rtol and estimates."""
    known = exact(trials)
    drawn = [t for t in trials if t.grid in SCATTERED]
    kept = sum(min(t.digits) >= KEPT for t in known)
    text = (
        f"{KEPT:g} or more at {kept} of {len(known)} points with an answer, fewer where the "
        f"problem itself loses them; of all {len(trials)} points {bad} are lost or failed"
    )
    if drawn:
        good = sum(t.verdict not in BAD for t in drawn)
        text += f". rtol and error_estimate can be trusted in {good} of {len(drawn)} random scenes"
    return f"{text}."
