"""What `hysteresis` records: loops beside their closed forms, and maps of the loop area."""

from dataclasses import dataclass

import numpy as np

from discretization import History
from studies.shared import loops
from studies.shared.loops import LAYER, SIZE, WORK, Form
from studies.shared.types import Array

BAR, LEDGER = 1e-8, 1e-9


@dataclass(frozen=True)
class Parameters:
    """γ₁ and w [N/m], machine stiffnesses K/(kb), steps of a loop; grid of the map, frames."""

    tensions: tuple[float, ...] = (0.002, 0.02, 0.1, 0.4)
    works: tuple[float, ...] = (WORK / 2, WORK)
    machines: tuple[float, ...] = (0.3, 3.0)
    steps: int = 60
    across: tuple[float, ...] = tuple(np.geomspace(0.03, 3, 13).tolist())
    up: tuple[float, ...] = tuple(np.geomspace(0.1, 10, 9).tolist())
    frames: int = 60


FULL = Parameters()
QUICK = Parameters(
    tensions=(0.02, 0.4),
    works=(WORK,),
    machines=(0.3,),
    steps=36,
    across=(0.05, 0.15, 0.4, 1.0, 2.5),
    up=(0.1, 0.3, 1.0, 3.0, 10.0),
)


@dataclass(frozen=True)
class Loop:
    """One closed path beside its closed forms; work: ∫P dd from the forces."""

    shape: str
    history: History
    forms: tuple[Form, ...]
    work: float

    @property
    def imbalance(self) -> float:
        """How far the energy balance is off, relative."""
        return loops.imbalance(self.history, self.work)

    @property
    def control(self) -> str:
        """Depth, force, or the stiffness of the machine in units of kb."""
        K = self.history.machine_stiffness
        return f"K = {K / (LAYER.stiffness * SIZE):.3g} kb" if K else self.history.control

    @property
    def error(self) -> float:
        """The largest of all relative errors."""
        return max(form.error for form in self.forms)

    @property
    def passed(self) -> bool:
        """Whether all errors are within the limits; nan is not."""
        return self.error <= BAR and self.imbalance <= LEDGER


@dataclass(frozen=True)
class Map:
    """Loop area over 2wb for l/b (n,) and K/(kb) (m,): simulated (m, n), and its errors."""

    shape: str
    across: Array
    up: Array
    area: Array
    error: Array


@dataclass(frozen=True)
class Record:
    """All loops and maps."""

    parameters: Parameters
    loops: tuple[Loop, ...]
    maps: tuple[Map, ...]

    @property
    def error(self) -> float:
        """The largest relative error, maps included."""
        areas = [float(found.error.max()) for found in self.maps]
        return float(np.max([*(loop.error for loop in self.loops), *areas]))

    @property
    def imbalance(self) -> float:
        """The largest imbalance of the energy."""
        return float(np.max([loop.imbalance for loop in self.loops]))

    @property
    def passed(self) -> bool:
        """Whether everything is within the bars."""
        return self.error <= BAR and all(loop.passed for loop in self.loops)
