"""Where does Eq. (16), the contact line for small slopes, serve? Section 6 of the paper.

    f(a) = d + √(2w/k) - l f'(a),  l = √(γ₁/k)                                             (16)

is compared, at the same imposed depth d, with stationary states of the energy of true surface
lengths (slopes="finite"). With k = γ₁ = l = 1 a result depends
only on w/γ₁, on a/l and on the steepness, the slope f'(a) at the line of (16).

Map: a wedge and a parabola at the depth where (16) gives a = l, over w/γ₁ and steepness; a flat
punch about to detach, over w/γ₁ and a/l. Errors: of a relative to a; of the force (11) relative to
max(|P|, 2√(2wγ₁)), the tension term of (22); of π - θ relative to itself.
Around an axis: cone and sphere likewise, small against finite slopes at the depth where a line of
radius l is in balance, d = f - (δ₀ - l f') K₀/K₁.
Conjecture: w, k, the indenter and d = 0 are fixed, γ₁ alone varies: does (16) hold for all γ₁?
Its steepness is f'(a₀), the error of a relative to a₀, the half-width (18) without tension.

The paper's question: with small slopes (16) is ∂U/∂x = 0 itself, for every γ₁ > 0, which is also
compared with nodes, where energies alone decide; with true lengths its error is that of the map.
Range of validity, h against l and w against γ₁, with the example scenes: figures.py.

Output: applicability.png, conjecture.png, eq16.png, regimes.png, applicability.csv, and the answer
in applicability.md.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer; with branch="global" it is the lowest of all; with
#   method="lattice" it is that on nodes of a spacing.
# - A scene has `elastocapillary_length` l = √(γ₁/k) and `critical_separation` δ₀ = √(2w/k).
# - `FlatPunch(half_width)` has f = 0 up to its edges.
# - `small_slopes` compares (11), (15) and (16) with simulated states for k = 1:
#   `at_unit_width(shape, f'(a), w/γ₁)` gives their relative `Errors` where a = l,
#   `punch(half-width, w/γ₁)` those of a flat punch, `compare(scene, depth, a, size)` those of any
#   a.
# - `depth_by_16` and `detachment` are depths, the latter simulated.
# - `KINDS[shape]` says for δ₀ = 1 and d = 0 what a f'(a) is without tension, `width`, and what a
#   becomes with it, `at_touch(a₀, l)`.
# - QUANTITIES are the errors whose borders are searched, for the TOLERANCES; ROUND are shapes about
#   an axis.
# - With WORK, δ₀ = 1.
# - NODES are in the shorter of l and a.

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product

from scipy.optimize import brentq

from discretization import minimise
from energy import FlatPunch, Parabola
from studies.applicability.figures import (
    draw_conjecture,
    draw_maps,
    draw_question,
    draw_regimes,
)
from studies.applicability.record import (
    FULL,
    NODES,
    PUNCH,
    QUICK,
    TOLERANCES,
    WORK,
    Border,
    Parameters,
    Point,
    Record,
    Small,
)
from studies.applicability.report import answer, short, table
from studies.shared import command, small_slopes
from studies.shared.batches import Show, each, silent
from studies.shared.small_slopes import KINDS, SHAPES, at_unit_width, punch, scene


def border(error: Callable[[float], float], scan: Sequence[float], tolerance: float) -> float:
    """The w/γ₁ from which an error exceeds a tolerance.

    Parameters
    ----------
    error : callable
        Signed relative error at a w/γ₁.
    scan : sequence of float
        Growing w/γ₁, between two of which the border is bracketed.
    tolerance : float

    Returns
    -------
    float
        To a thousandth; 0 if the error is larger at the least w/γ₁, inf if it is nowhere.
    """

    def excess(log_ratio: float) -> float:
        """By how much the size of the error exceeds the tolerance, at the logarithm of w/γ₁."""
        return abs(error(math.exp(log_ratio))) - tolerance

    before = None
    for log_ratio in map(math.log, scan):
        if excess(log_ratio) > 0:
            if before is None:
                return 0.0
            return math.exp(brentq(excess, before, log_ratio, xtol=1e-3, rtol=1e-8))
        before = log_ratio
    return math.inf


def borders(p: Parameters, jobs: int = 1) -> Iterator[Border]:
    """Each shape, steepness line and quantity; and the angle, which depends on w/γ₁ alone."""
    # around an axis states share a family of free surfaces, which a process solves once
    for shapes, workers in ((SHAPES, jobs), (small_slopes.ROUND, 1)):
        lines = list(product(shapes, p.lines, small_slopes.QUANTITIES))
        for of_line in each(functools.partial(_borders, p.scan), lines, workers):
            yield from of_line

    def of_angle(ratio: float) -> float:
        """Relative error of π - θ at a w/γ₁; the wedge is any shape."""
        return at_unit_width("wedge", 1.0, ratio).angle

    for tolerance in TOLERANCES:
        found = border(of_angle, (*p.scan, 1.3), tolerance)
        yield Border("any", math.nan, "π - θ", tolerance, found)


def _borders(scan: Sequence[float], line: tuple[str, float, str]) -> list[Border]:
    """The borders of both tolerances for a shape, a steepness and a quantity."""
    shape, steepness, quantity = line
    error = functools.partial(small_slopes.QUANTITIES[quantity], shape, steepness)
    return [
        Border(shape, steepness, quantity, tolerance, border(error, scan, tolerance))
        for tolerance in TOLERANCES
    ]


def path_point(case: tuple[str, float, float]) -> Point | None:
    """Eq. (16) at d = 0, case: shape, steepness, γ₁/w; None without contact (too sharp a wedge)."""
    shape, steepness, tension = case
    a0 = KINDS[shape].width / steepness
    given = scene(small_slopes.blunt(shape, steepness, a0), tension * WORK, WORK)
    ell = given.elastocapillary_length
    a = KINDS[shape].at_touch(a0, ell)
    if a <= 0:
        return None
    return Point(shape, 1 / tension, steepness, a / ell, small_slopes.compare(given, 0.0, a, a0))


def small_slope_case(case: tuple[str, float, float]) -> Small:
    """Error of a by (16) in the paper's own energy, by (18) where the tension is 0.

    case: shape, steepness, γ₁/w.
    """
    shape, steepness, tension = case
    a0 = KINDS[shape].width / steepness
    body = small_slopes.blunt(shape, steepness, a0)
    given = scene(body, tension * WORK, WORK, "small")
    if not tension:
        state = minimise(given, 0.0, branch="global")
        return Small(*case, abs(state.half_width / a0 - 1), math.nan)
    depth = small_slopes.depth_by_16(given, a0)
    spacing = min(given.elastocapillary_length, a0) / NODES
    on_nodes = minimise(given, depth, method="lattice", spacing=spacing).half_width
    on_mesh = minimise(given, depth).half_width
    return Small(*case, abs(on_mesh / a0 - 1), abs(on_nodes / a0 - 1))


def within_small_slopes(p: Parameters, jobs: int = 1) -> tuple[Small, ...]:
    """Eq. (16) in the paper's own energy, for every shape, steepness and tension."""
    return tuple(each(small_slope_case, list(product(SHAPES, p.paths, (0.0, *p.tensions))), jobs))


def flat_faces(p: Parameters) -> Iterator[tuple[str, float, float]]:
    """d = -δ₀, where a face that is flat at the line detaches, against the simulation."""
    for shape, body in ((PUNCH, FlatPunch(1.0)), ("parabola", Parabola(5.0))):
        for ratio in p.scan[::2]:
            given = scene(body, 1.0, ratio)
            depth = small_slopes.detachment(given, 1e-12)
            yield shape, ratio, depth / given.critical_separation + 1


def map_point(case: tuple[str, float, float]) -> Point:
    """A state of the map; case: shape, steepness (width of the punch), w/γ₁."""
    shape, other, ratio = case
    if shape == PUNCH:
        return Point(PUNCH, ratio, 0.0, other, punch(other, ratio))
    return Point(shape, ratio, other, 1.0, at_unit_width(shape, other, ratio))


def run(p: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """All comparisons, in `jobs` processes; `show` gets a line as each part begins.

    Parameters
    ----------
    p : Parameters
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    Record
    """
    cases = [*product(SHAPES, p.steepness, p.ratios), *product((PUNCH,), p.widths, p.ratios)]
    show("the paper's own energy, and flat faces ...")
    small = within_small_slopes(p, jobs)
    flat = tuple(flat_faces(p))
    show(f"map, {len(cases)} states ...")
    points = tuple(each(map_point, cases, jobs))
    show(f"borders of 1 % and 10 % on {len(p.lines)} lines ...")
    found = tuple(borders(p, jobs))
    varied = list(product(SHAPES, p.paths, p.tensions))
    show(f"γ₁ alone varied, {len(varied)} states ...")
    on_path = [point for point in each(path_point, varied, jobs) if point is not None]
    maps = {shape: tuple(x for x in points if x.shape == shape) for shape in (*SHAPES, PUNCH)}
    paths = {shape: tuple(x for x in on_path if x.shape == shape) for shape in SHAPES}
    return Record(p, maps, paths, found, flat, small)


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write, answer."""
    quick = "coarser grids"
    preset, jobs, out = command.start("applicability", __doc__, argv, quick, FULL, QUICK)
    record = run(preset, command.say, jobs)
    drawn = {"applicability.png": draw_maps(record), "conjecture.png": draw_conjecture(record)}
    drawn |= {"eq16.png": draw_question(record), "regimes.png": draw_regimes()}
    out.figures(drawn)
    out.table("applicability.csv", preset, *table(record))
    text = answer(record)
    out.text("applicability.md", "\n".join([text, *(f"\n![{name}]({name})" for name in drawn), ""]))
    print(text)
    command.answer(short(record))
    return 0
