"""What does a real layer change: the angle, Eq. (16), a sphere's pull-off? Where do springs serve?

The stiffness k(q) of a bonded elastic layer depends on the wave number q; springs, k = Ẽ/h, are its
limit q → 0 for ν < ½. Four questions:

- Is the contact angle π - θ = √(2w/γ₁) whatever ν and h? It is measured on nodes, which know
  nothing of it, and extrapolated to vanishing distance.
- Which length stands in Eq. (16), f(a) + ℓ f'(a) + ... = d + δ₀, of a wide contact? Measured from
  two states of the fitted side, next to ℓ = (1/π) ∫ ln[(k(q) + γ₁q²)/k] dq/q².
- With which force F does a dead load pull a sphere off: F = 3/2 πwR (half-space), 2 (thin and
  compressible), 3 (thin and incompressible), 1 (tension rules)?
- How far off are springs in force and radius at pull-off of a sphere, at the worst Λ = l/√(Rδ₀)?
  The last table, springs_worst.csv, is what `energy/validity.py` reads from.

Output: four figures and tables. Exit status 1 if an angle is off by more than 1 % and twice its
error, or a length by more than 1e-4 h.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from studies.layer import figures
from studies.layer.cases import Angle, Length, Pull, Springs, angle, length, pull, springs
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import Figure
from studies.shared.table import Table

LARGEST_ANGLE, LARGEST_LENGTH = 1e-2, 1e-4


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
    Lambdas: tuple[float, ...] = (0.05, 0.15, 0.4, 1.0, 2.5)


FULL = Parameters()
QUICK = Parameters(
    (0.3, 0.5), (0.3, 1.0), 24, (0.3, 0.45), (0.3, 1.0), (0.3, 0.5), (0.03, 1.0, 30.0),
    (0.1,), (0.3, 0.45), (0.5, 2.0), (0.15, 1.0),
)  # fmt: skip


class Record(NamedTuple):
    """What was measured."""

    angles: tuple[Angle, ...]
    lengths: tuple[Length, ...]
    pulls: tuple[Pull, ...]
    springs: tuple[Springs, ...]

    @property
    def passed(self) -> bool:
        """Whether angles and lengths are what they should be."""
        off = [abs(a.measured - 1) - max(LARGEST_ANGLE, 2 * a.error) for a in self.angles]
        return max(off) <= 0 and self.length_error <= LARGEST_LENGTH

    @property
    def angle_error(self) -> float:
        """The largest, relative."""
        return max(abs(a.measured - 1) for a in self.angles)

    @property
    def length_error(self) -> float:
        """The largest, over h."""
        return max(abs(one.measured - one.effective) for one in self.lengths)

    def worst(self) -> list[Springs]:
        """Over Λ, signed, of each ν and l/h; Λ is that of the radius."""
        found = []
        for nu, ratio in dict.fromkeys((s.nu, s.ratio) for s in self.springs):
            own = [s for s in self.springs if (s.nu, s.ratio) == (nu, ratio)]
            radius = max(own, key=lambda s: abs(s.radius))
            force = max(own, key=lambda s: abs(s.force))
            found.append(radius._replace(force=force.force))
        return found


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Every case, in `jobs` processes; `show` gets a line for each."""
    p = parameters
    angles = [(nu, h, p.nodes) for nu, h in product(p.angle_nus, p.thicknesses)]
    pulls = [(nu, "weak", a) for nu, a in product(p.pull_nus, p.radii)]
    pulls += [(p.pull_nus[0], "strong", a) for a in p.strong]
    asked: list[tuple[Callable[..., Any], Sequence[Any]]] = [
        (angle, angles),
        (length, list(product(p.length_nus, p.lengths))),
        (pull, pulls),
        (springs, list(product(p.springs_nus, p.ratios, p.Lambdas))),
    ]
    found = []
    for work, cases in asked:
        found.append(tuple(each(work, cases, jobs, say=lambda row: show(line(row)))))
    return Record(*found)


def line(row: Any) -> str:
    """One line on the screen: what it is and its numbers."""
    told = (
        f"{name} = {value}" if isinstance(value, str) else f"{name} = {value:.5g}"
        for name, value in zip(row._fields, row, strict=True)
    )
    return f"{type(row).__name__.lower():8s} {', '.join(told)}"


def plot(record: Record) -> dict[str, Figure]:
    """The four figures by file name."""
    return {
        "layer_angle.png": figures.angles(record.angles, record.angle_error),
        "layer_length.png": figures.lengths(record.lengths, record.length_error),
        "layer_pull.png": figures.pulls(record.pulls),
        "layer_springs.png": figures.springs(record.worst(), serve(record)),
    }


def serve(record: Record, within: float = 0.05) -> dict[float, float]:
    """Least l/h of those computed from which on springs err by no more, of each ν; nan: none."""
    found = {}
    for nu in dict.fromkeys(s.nu for s in record.springs):
        own = sorted((s for s in record.worst() if s.nu == nu), key=lambda s: -s.ratio)
        least = float("nan")
        for one in own:
            if max(abs(one.force), abs(one.radius)) > within:
                break
            least = one.ratio
        found[nu] = least
    return found


def answer(record: Record) -> str:
    """In a few sentences."""
    weak = [p for p in record.pulls if p.tension == "weak"]
    narrow, wide = min(weak, key=lambda p: p.radius), max(weak, key=lambda p: p.force)
    strong = next(p for p in record.pulls if p.tension == "strong")
    least = serve(record)
    told = ", ".join(f"{least[nu]:g} (ν = {nu:g})" for nu in least if np.isfinite(least[nu]))
    return (
        f"The angle stays √(2w/γ₁) whatever ν and h, within {100 * record.angle_error:.1g} % on "
        f"nodes; Eq. (16) holds with ℓ in place of l, within {record.length_error:.0e} h; a sphere "
        f"sticks with {narrow.force:.3g} πwR at a = {narrow.radius:.2g} h, up to {wide.force:.3g} "
        f"at ν = {wide.nu:g}, a = {wide.radius:.2g} h, and {strong.force:.3g} where tension rules; "
        f"springs serve within 5 % from l/h = {told} on."
    )


def tables(record: Record) -> dict[str, Table]:
    """Columns and rows of each kind of case, and the worst of springs."""
    named = {**record._asdict(), "springs_worst": record.worst()}
    return {name: (rows[0]._fields, rows) for name, rows in named.items()}


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if an angle or a length is not what it should be."""
    preset, jobs, out = command.start("layer", __doc__, argv, "a few of each", FULL, QUICK)
    record = run(preset, command.say, jobs)
    for name, (columns, rows) in tables(record).items():
        out.table(f"layer_{name}.csv", preset, columns, rows)
    out.figures(plot(record))
    command.answer(answer(record))
    return int(not record.passed)
