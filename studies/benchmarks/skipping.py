"""What does a scene that needs less than the general one save, and does that change a digit?

Measured in pairs: the call that skips, and the same question asked so that nothing can be skipped:
a profile of the same heights that does not say what it is, a vanishing slope, nodes instead of an
exact far field. The factor is the median of the ratios of their times, between its quartiles; next
to it the largest difference of a, P and U, relative to each, which must be rounding. The table in
discretization/README.md says where each thing is skipped.

The film is thicker than springs allow beside the contact, h > l: times and digits are those of the
model, in which only k, γ₁ and w of a film enter.

Output: a line per row, skipping.csv, a figure. Exit status 1 if a digit changed.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `command.answer` says the answer, in the last line of the screen.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer; with method="lattice" it is that on nodes of a spacing.
# - A scene has `elastocapillary_length` l = √(γ₁/k) and `critical_separation` δ₀ = √(2w/k).
# - `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
# - `FlatPunch(half_width)` has f = 0 up to its edges; `Profile(height, slope)` is a profile given
#   by two functions.
# - `state.displacement(x)` is u, positive into the layer.
# - `AccuracyWarning` says that the estimated error of a state exceeds its rtol.
# - `NodalEnergy(lattice, contact)` is the energy of nodes of which some are in contact:
#   `relaxed(g)` are the displacements of least energy with u = g in contact, `value(u)` is their
#   energy, `gradient(u)` the forces on the nodes.

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from discretization import AccuracyWarning, Lattice, NodalEnergy, load_path, minimise
from energy import ElasticLayer, FlatPunch, Indenter, Parabola, Profile, Scene, SurfaceEnergies
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, GREY, Figure, canvas
from studies.shared.table import Columns
from studies.shared.timing import seconds

ROUNDING = 1e-12  # relative difference that sums of 1e5 terms in another order may have
# A cylinder on a soft layer, with small slopes: √(2w/γ₁) = 0.09. Any other would do.
LAYER = ElasticLayer(E=3e3, nu=0.45, h=50e-6)  # Pa, 1, m
GAMMA1 = 0.07  # N/m
W = 3e-4  # J/m²
RADIUS = 0.1  # m
DEPTH = 2e-6  # m
_FACE = 6e-4  # half-width of the flat punch [m], less than that of the cylinder's contact
_RISE = 0.2  # slope beside a face: twice √(2w/γ₁), so that the line stays at its edge
_FIELD = 10_000  # places at which a field is read, as for a figure
_PER_L = 100  # nodes in l, of a contact with free nodes beside it
_FAR = 4000  # free nodes on each side, which are 40 l: exp(-40) is less than rounding
_SHALLOW = 40.0  # times less deep without adhesion, so that the contact is some l wide
# By which radius and depth differ where slopes are so small that true lengths are the same.
_GENTLE = 1e6
_NODES = 1e5  # in half the contact: the number of terms that ROUNDING is for
_FEWER = 10  # times fewer where the error is estimated, too
_STEPS = 50  # of a path that deepens by a tenth
Numbers = Sequence[float]
Route = Callable[[], Numbers]


def scene(indenter: Indenter | None = None, w: float = W) -> Scene:
    """A parabola if nothing else is given."""
    return Scene(LAYER, SurfaceEnergies.from_work(GAMMA1, w), indenter or Parabola(RADIUS))


def declared(indenter: Indenter, **attributes: Any) -> Indenter:
    """The same profile that says something else of itself.

    attributes: such as `apex`, the x of its lowest point, or `symmetric`, which routes rely on.
    """
    kind = type("Declared", (type(indenter),), attributes)
    found: Indenter = object.__new__(kind)
    vars(found).update(vars(indenter))
    return found


def blunt(a: float, rise: float = _RISE) -> Indenter:
    """A face that rises beyond its edges and does not say that it has corners there."""
    face = Profile(
        lambda x: rise * np.maximum(0.0, np.abs(x) - a),
        lambda x: rise * np.sign(x) * (np.abs(x) > a),
        convex=True,
    )
    return declared(face, apex=0.0, symmetric=True)


def solved(own: Scene, depth: float = DEPTH, asked: str = "", **options: Any) -> Numbers:
    """a, P and U; what else is `asked` of the state is worked out, too."""
    with warnings.catch_warnings():  # of a line at a kink the estimate knows no condition
        warnings.simplefilter("ignore", AccuracyWarning)
        state = minimise(own, depth, **options)
    if asked == "fields":
        x = np.linspace(-1e-3, 1e-3, _FIELD)  # m, beyond both lines
        state.displacement(x)
        state.pressure(x)
    if asked == "estimate":
        state.uncertainty  # noqa: B018  # found when it is asked for
    return state.half_width, state.force, state.energy


def pressed(beside: int) -> Numbers:
    """P and U of contact nodes over 10 l, 100 per l, and of so many free ones on each side."""
    own = scene(w=0.0)
    depth = DEPTH / _SHALLOW
    lattice = Lattice.of(own, own.elastocapillary_length / _PER_L)
    inside = int(minimise(own, depth).half_width / lattice.spacing)
    node = np.arange(-inside - beside, inside + beside + 1)
    energy = NodalEnergy(lattice, np.abs(node) <= inside)
    u = energy.relaxed(depth - own.indenter.height(lattice.x(node)))
    return float(np.maximum(energy.gradient(u), 0).sum()), energy.value(u)


def routes() -> dict[str, tuple[Route, Route]]:
    """The call that skips, and the one that does not; what both return must agree."""
    own = scene()
    body = Parabola(RADIUS)
    steps = np.linspace(DEPTH, 1.1 * DEPTH, _STEPS)
    flat = scene(FlatPunch(_FACE))
    pulled = -0.5 * own.critical_separation
    plain = declared(Profile(body.height, body.slope), apex=0.0, symmetric=True)
    gentle = scene(Parabola(_GENTLE * RADIUS), w=0.0)
    fine = minimise(own, DEPTH).half_width / _NODES
    nodes: dict[str, Any] = {"method": "lattice", "spacing": fine}
    coarse: dict[str, Any] = nodes | {"spacing": _FEWER * fine}
    return {
        "line of a punch": (
            partial(solved, flat, pulled),
            partial(solved, scene(blunt(_FACE)), pulled),
        ),
        "far field": (partial(pressed, 0), partial(pressed, _FAR)),
        "other contacts": (partial(solved, own), partial(solved, scene(plain))),
        "true lengths": (
            partial(solved, gentle, DEPTH / _GENTLE),
            partial(solved, replace(gentle, slopes="finite"), DEPTH / _GENTLE),
        ),
        "fields": (partial(solved, own), partial(solved, own, asked="fields")),
        "error estimate": (
            partial(solved, own, **coarse),
            partial(solved, own, asked="estimate", **coarse),
        ),
        "search for the line": (
            lambda: load_path(own, depths=steps).half_width.tolist(),
            lambda: [minimise(own, depth).half_width for depth in steps.tolist()],
        ),
    }


@dataclass(frozen=True)
class Parameters:
    """How long is measured.

    Attributes
    ----------
    pairs : int
        Of calls; with 41, an odd number, a quartile has ten of them below it.
    patience : float
        Seconds after which a row has enough of them: the seven take half a minute at most.
    """

    pairs: int = 41
    patience: float = 4.0


QUICK = Parameters(pairs=5, patience=0.3)  # what agrees is seen; times mean little


class Row(NamedTuple):
    """One thing that is left out, and what that saves and changes.

    Attributes
    ----------
    name : str
    seconds, general : float
        Median times [s] of the call that skips, and by the general route.
    factor, low, high : float
        Median of the ratios of both in pairs, and its quartiles.
    difference : float
        Largest difference of a, P and U, relative to each.
    """

    name: str
    seconds: float
    general: float
    factor: float
    low: float
    high: float
    difference: float

    @property
    def same(self) -> bool:
        """Whether no digit changed but by rounding."""
        return not self.difference > ROUNDING


def difference(found: Numbers, general: Numbers) -> float:
    """Largest relative difference of numbers that correspond."""
    one = np.asarray(found, float)
    other = np.asarray(general, float)
    size = np.abs(other)
    return float(np.max(np.abs(one - other) / np.where(size > 0, size, 1.0)))


def measure(parameters: Parameters, case: tuple[str, tuple[Route, Route]]) -> Row:
    """One row: calls of both routes in turn, the first not timed."""
    name, (skips, general) = case
    changed = difference(skips(), general())
    of_skip: list[float] = []
    of_general: list[float] = []
    while len(of_skip) < parameters.pairs:
        if sum(of_skip) + sum(of_general) > parameters.patience:
            break
        of_skip.append(seconds(skips))
        of_general.append(seconds(general))
    factors = np.divide(of_general, of_skip)
    low, middle, high = np.percentile(factors, [25, 50, 75]).tolist()
    return Row(
        name=name,
        seconds=float(np.median(of_skip)),
        general=float(np.median(of_general)),
        factor=middle,
        low=low,
        high=high,
        difference=changed,
    )


def run(parameters: Parameters = Parameters(), show: Show = silent) -> list[Row]:
    """All rows; `show` gets a line for each."""
    show(COLUMNS.head)
    cases = list(routes().items())
    return list(each(partial(measure, parameters), cases, 1, say=lambda row: show(line(row))))


COLUMNS = Columns(
    "not needed -21|skipped ms 11.3g|general ms 11.3g|factor 8.3g|quartiles 13|difference 11.0e"
)


def line(row: Row) -> str:
    """One row on the screen."""
    times = (1e3 * row.seconds, 1e3 * row.general)
    spread = f"{row.low:.3g}..{row.high:.3g}"
    return COLUMNS.line(row.name, *times, row.factor, spread, row.difference)


def plot(rows: Sequence[Row]) -> Figure:
    """Factors as bars on a logarithmic axis, with their quartiles."""
    rows = sorted(rows, key=lambda row: row.factor)
    figure, axes = canvas(9, 1.4 + 0.32 * len(rows))
    at = np.arange(len(rows))
    factor = np.array([row.factor for row in rows])
    low = np.array([row.low for row in rows])
    high = np.array([row.high for row in rows])
    spread = np.array([factor - low, high - factor])
    axes.barh(at, factor - 1, left=1, color=BLUE, xerr=spread, ecolor=GREY, capsize=3)
    axes.set(xscale="log", yticks=at, yticklabels=[row.name for row in rows])
    axes.set_ylabel("not needed")
    axes.set(xlabel="time of the general route / time of the call that skips it")
    axes.set_xlim(min(0.9, low.min()), 3 * high.max())  # room for the texts
    for height, row in enumerate(rows):
        change = f"Δ {row.difference:.0e}" if row.difference else "identical"
        text = f"  × {row.factor:.3g}  ({change})"
        axes.text(max(row.high, row.factor), height, text, va="center", fontsize=9)
    axes.axvline(1, color="black", lw=0.8)
    axes.grid(alpha=0.25, axis="x")
    axes.set_axisbelow(True)
    axes.set_title("Leaving out what a scene does not need changes a, P and U by rounding only (Δ)")
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if a digit changed."""
    parameters, _, out = command.start(
        "skipping", __doc__, argv, "few pairs, under 10 s", Parameters(), QUICK
    )
    rows = run(parameters, command.say)
    out.table("skipping.csv", parameters, Row._fields, rows)
    out.figure("skipping.png", plot(rows))
    changed = [row.name for row in rows if not row.same]
    told = f"these change a digit: {', '.join(changed)}" if changed else "none changes a digit"
    factors = [row.factor for row in rows]
    command.answer(
        f"Speed-ups of {min(factors):.3g} to {max(factors):.3g} by leaving out {len(rows)} things; "
        f"{told}."
    )
    return 1 if changed else 0
