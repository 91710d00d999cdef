"""What does a real layer change: the angle, Eq. (16), a sphere's pull-off? Where do springs serve?

Springs are the limit q → 0 of the stiffness k(q) of a bonded elastic layer with ν < ½. It is asked:

- Is the contact angle π - θ = √(2w/γ₁) whatever ν and h? It is measured on nodes, which know
  nothing of it, and extrapolated to vanishing distance.
- Which length stands in Eq. (16), f(a) + ℓ f'(a) + ... = d + δ₀, of a wide contact? Measured from
  two states of the fitted side, next to ℓ = (1/π) ∫ ln[(k(q) + γ₁q²)/k] dq/q².
- Does a dead load pull a sphere off with F = 3/2 πwR (half-space), 2 (thin, compressible), 3 (thin,
  incompressible), 1 (tension rules)?
- How far off are springs in force and radius at pull-off of a sphere, at the worst Λ = l/√(Rδ₀)?
  `energy/validity.py` has the numbers of layer_springs_worst.csv.
- What does a state cost? layer_accuracy.csv: errors and times for three rtol, and over springs.

Output: four figures and tables. Exit status 1 if an angle is off by more than 1 %, or a length by
more than 1e-4 h.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product, takewhile
from typing import Any, NamedTuple

from studies.layer import cases, figures
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import Figure

LARGEST = (1e-2, 1e-4)  # errors of angles, relative, and of lengths, over h


@dataclass(frozen=True)
class Parameters:
    """Poisson's ratios and sizes of the four questions; nodes: on each side of a contact."""

    angle_nus: tuple[float, ...] = (0.0, 0.3, 0.45, 0.5)
    thicknesses: tuple[float, ...] = (0.3, 0.55, 1.0, 1.7, 3.0)
    nodes: int = 40
    length_nus: tuple[float, ...] = (0.0, 0.3, 0.4, 0.45)
    lengths: tuple[float, ...] = (0.05, 0.15, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0)
    pull_nus: tuple[float, ...] = (0.3, 0.45, 0.49, 0.5)
    radii: tuple[float, ...] = (0.03, 0.1, 0.3, 0.6, 1.0, 1.7, 3.0, 6.0, 12.0, 30.0, 100.0)
    strong: tuple[float, ...] = (0.03, 0.3, 3.0, 30.0, 100.0)
    springs_nus: tuple[float, ...] = (0.0, 0.3, 0.4, 0.45, 0.48, 0.49)
    ratios: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
    Lambdas: tuple[float, ...] = (0.05, 0.1, 0.15, 0.25, 0.4, 0.6, 1.0, 2.5)
    rtols: tuple[float, ...] = (1e-4, 1e-6, 1e-8)


FULL = Parameters()
QUICK = Parameters(
    (0.3, 0.5), (0.3, 1.0), 24, (0.3, 0.45), (0.3, 1.0), (0.3, 0.5), (0.03, 1.0, 30.0),
    (0.1,), (0.45,), (0.5, 2.0), (0.15, 1.0),
)  # fmt: skip


class Record(NamedTuple):
    """What was measured."""

    angle: tuple[cases.Angle, ...]
    length: tuple[cases.Length, ...]
    pull: tuple[cases.Pull, ...]
    springs: tuple[cases.Springs, ...]
    accuracy: tuple[cases.Accuracy, ...]

    @property
    def errors(self) -> tuple[float, float]:
        """The largest of angles, relative, and of lengths, over h."""
        angles = (abs(one.measured - 1) for one in self.angle)
        return max(angles), max(abs(one.measured - one.effective) for one in self.length)

    def worst(self) -> list[cases.Springs]:
        """Over Λ, without sign, of each ν and l/h; Λ is that of the radius."""
        found = []
        for key in dict.fromkeys(s[:2] for s in self.springs):
            own = [s for s in self.springs if s[:2] == key]
            most = max(own, key=lambda s: abs(s.radius))
            force = max(abs(s.force) for s in own)
            found.append(most._replace(force=force, radius=abs(most.radius)))
        return found


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Every case, in `jobs` processes; `show` gets a line for each."""
    p = parameters
    weak, strong = product(p.pull_nus, ["weak"], p.radii), product([0.3], ["strong"], p.strong)
    asked: dict[Callable[..., Any], Sequence[Any]] = {
        cases.angle: list(product(p.angle_nus, p.thicknesses, [p.nodes])),
        cases.length: list(product(p.length_nus, p.lengths)),
        cases.pull: [*weak, *strong],
        cases.springs: list(product(p.springs_nus, p.ratios, p.Lambdas)),
        cases.accuracy: list(product(("line", "axisymmetric"), p.rtols)),
    }
    found = (each(*one, jobs, say=lambda row: show(line(row))) for one in asked.items())
    return Record(*map(tuple, found))


def line(row: Any) -> str:
    """One line on the screen: what it is and its numbers."""
    values = (f"{value}" if isinstance(value, str) else f"{value:.5g}" for value in row)
    told = (f"{name} = {value}" for name, value in zip(row._fields, values, strict=True))
    return f"{type(row).__name__.lower():8s} {', '.join(told)}"


def plot(record: Record) -> dict[str, Figure]:
    """The four figures by file name."""
    return {
        "layer_angle.png": figures.angles(record.angle, record.errors[0]),
        "layer_length.png": figures.lengths(record.length, record.errors[1]),
        "layer_pull.png": figures.pulls(record.pull),
        "layer_springs.png": figures.springs(record.worst(), serve(record)),
    }


def serve(record: Record) -> str:
    """From which l/h on, of those computed, springs err by 5 % at most, for each ν."""
    told = []
    for nu in sorted({s.nu for s in record.springs}):
        own = sorted((s for s in record.worst() if s.nu == nu), key=lambda s: -s.ratio)
        served = list(takewhile(lambda s: max(s.force, s.radius) <= 0.05, own))
        told += [f"{served[-1].ratio:g} (ν = {nu:g})"] if served else []
    return ", ".join(told)


def answer(record: Record) -> str:
    """In a sentence."""
    weak, strong = ([p for p in record.pull if p.tension == name] for name in ("weak", "strong"))
    narrow, most = min(weak, key=lambda p: p.radius), max(weak, key=lambda p: p.force)
    return (
        f"The angle stays √(2w/γ₁) whatever ν and h, within {100 * record.errors[0]:.1g} % on "
        f"nodes; Eq. (16) holds with ℓ in place of l, within {record.errors[1]:.0e} h; a sphere "
        f"sticks with {narrow.force:.3g} πwR at a = {narrow.radius:.2g} h, up to {most.force:.3g} "
        f"at ν = {most.nu:g}, a = {most.radius:.2g} h, and {strong[0].force:.3g} where tension "
        f"rules; springs serve within 5 % from l/h = {serve(record)} on."
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if an angle or a length is not what it should be."""
    preset, jobs, out = command.start("layer", __doc__, argv, "a few of each", FULL, QUICK)
    record = run(preset, command.say, jobs)
    for name, rows in {**record._asdict(), "springs_worst": record.worst()}.items():
        out.table(f"layer_{name}.csv", preset, rows[0]._fields, rows)
    out.figures(plot(record))
    command.answer(answer(record))
    return int(any(error > most for error, most in zip(record.errors, LARGEST, strict=True)))
