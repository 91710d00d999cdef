"""What `contact_angle` measures: its parameters, and the record that the figure reads."""

from dataclasses import dataclass
from typing import NamedTuple

BAR = 1e-8  # of π - θ


@dataclass(frozen=True)
class Parameters:
    """ratios: w/γ₁; widths: a/l by Eq. (16); path: w/γ₁ of the loading paths, with `steps` depths
    each way."""

    ratios: tuple[float, ...] = (
        *(1e-4, 1e-3, 0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.95, 1.0, 1.2, 1.4, 1.6),
    )
    widths: tuple[float, ...] = (0.2, 1.1, 5.0)
    path: tuple[float, ...] = (0.01, 0.1, 0.5)
    steps: int = 24


FULL = Parameters()
QUICK = Parameters(
    ratios=(1e-4, 0.01, 0.1, 0.4, 1.2),
    widths=(0.3, 2.0),
    path=(0.1, 0.5),
    steps=6,
)


class Angle(NamedTuple):
    """One measured angle: kind is "finite" or "small", that of the slopes.

    deficit: π - θ; law: by (8) for "finite", (15) else; half_width: simulated a; indenter, layer:
    inclinations of both at the line [rad].
    """

    kind: str
    shape: str
    ratio: float
    depth: float
    half_width: float
    deficit: float
    law: float
    indenter: float
    layer: float

    @property
    def residual(self) -> float:
        """|deficit/law - 1|."""
        return abs(self.deficit / self.law - 1)


class Loop(NamedTuple):
    """Angles along touch -> press -> retract until just before the contact detaches."""

    shape: str
    ratio: float
    advance: tuple[Angle, ...]
    retract: tuple[Angle, ...]

    @property
    def angles(self) -> tuple[Angle, ...]:
        """The whole way."""
        return (*self.advance, *self.retract)


@dataclass(frozen=True)
class Record:
    """All measured angles."""

    parameters: Parameters
    states: tuple[Angle, ...]
    loops: tuple[Loop, ...]

    def of(self, kind: str) -> list[Angle]:
        """The single states of a kind."""
        return [angle for angle in self.states if angle.kind == kind]

    def worst(self, kind: str) -> float:
        """Largest relative difference between measured π - θ and its law, loops included."""
        angles = self.of(kind)
        if kind == "finite":
            angles += [angle for loop in self.loops for angle in loop.angles]
        return max(angle.residual for angle in angles)

    @property
    def passed(self) -> bool:
        """Whether every law is obeyed."""
        return max(self.worst("finite"), self.worst("small")) <= BAR
