"""How much narrower is the contact of a parabola where the surface tension is larger?

    a = -l + √(l² + 2R(d + δ₀))                                                                (33)

at d = 0 is set against the simulation, for several elastocapillary lengths l = √(γ₁/k) over √(Rδ₀).
Output: half_width.csv, half_width.png. Exit status 1 if a relative error exceeds 1e-8.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from discretization import minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies.shared import command
from studies.shared.batches import each
from studies.shared.figures import BLUE, canvas

LAYER = ElasticLayer(E=2.5e3, nu=0.3, h=5e-6)  # Pa, 1, m
WORK = 1e-6  # J/m²
RADIUS = 1e-3  # m
LARGEST = 1e-8  # relative error, that of `minimise` unless another rtol is given


@dataclass(frozen=True)
class Parameters:
    """l over √(Rδ₀)."""

    ratios: tuple[float, ...] = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0)


class Row(NamedTuple):
    """One scene.

    Attributes
    ----------
    ratio : float
        l/√(Rδ₀).
    gamma1 : float
        [N/m].
    half_width, closed_form : float
        Simulated, and by (33) [m].
    error : float
        Relative.
    """

    ratio: float
    gamma1: float
    half_width: float
    closed_form: float
    error: float


def solved(ratio: float) -> Row:
    """One scene; a function of module level, so that other processes can call it."""
    delta0 = (2 * WORK / LAYER.stiffness) ** 0.5
    gamma1 = LAYER.stiffness * ratio**2 * RADIUS * delta0
    scene = Scene(LAYER, SurfaceEnergies.from_work(gamma1, WORK), Parabola(RADIUS))
    a = minimise(scene, 0.0).half_width
    card = cards.parabola.half_width(0.0, R=RADIUS, k=LAYER.stiffness, gamma1=gamma1, w=WORK)
    return Row(ratio, gamma1, a, float(card), abs(a / float(card) - 1))


def run(parameters: Parameters, jobs: int = 1) -> list[Row]:
    """Every scene, in `jobs` processes."""
    return list(each(solved, parameters.ratios, jobs))


def plot(rows: Sequence[Row]) -> Any:
    """Half-width over the tension."""
    figure, axes = canvas(7, 4.5)
    ratios = [row.ratio for row in rows]
    axes.plot(ratios, [1e6 * row.closed_form for row in rows], color="black", label="Eq. (33)")
    axes.plot(ratios, [1e6 * row.half_width for row in rows], "o", color=BLUE, label="simulated")
    axes.set(xlabel="tension  l/√(Rδ₀)", ylabel="half-width a in µm")
    axes.set_title("Surface tension narrows the contact")
    axes.legend()
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    full = Parameters()
    quick = Parameters(ratios=(0.1, 1.0))
    preset, jobs, out = command.start(__file__, __doc__, argv, "two tensions", full, quick)
    rows = run(preset, jobs)
    out.table("half_width.csv", preset, Row._fields, rows)
    out.figure("half_width.png", plot(rows))
    worst = max(row.error for row in rows)
    scenes = f"{len(rows)} scenes"
    command.answer(f"{scenes}, largest relative error {worst:.0e} (at most {LARGEST:.0e})")
    return int(worst > LARGEST)
