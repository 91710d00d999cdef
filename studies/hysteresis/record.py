"""What `hysteresis` records: loops beside their closed forms."""

from dataclasses import dataclass

import numpy as np

from discretization import History
from studies.shared import loops
from studies.shared.loops import LAYER, SIZE, WORK, Form

BAR, LEDGER = 1e-8, 1e-9


@dataclass(frozen=True)
class Parameters:
    """γ₁ and w [N/m], machine stiffnesses K/(kb), steps of a loop."""

    tensions: tuple[float, ...] = (0.002, 0.02, 0.1, 0.4)
    works: tuple[float, ...] = (WORK / 2, WORK)
    machines: tuple[float, ...] = (0.3, 3.0)
    steps: int = 60


FULL = Parameters()
QUICK = Parameters(tensions=(0.02, 0.4), works=(WORK,), machines=(0.3,), steps=36)


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
class Record:
    """All loops."""

    parameters: Parameters
    loops: tuple[Loop, ...]

    @property
    def error(self) -> float:
        """The largest relative error."""
        return float(np.max([loop.error for loop in self.loops]))

    @property
    def imbalance(self) -> float:
        """The largest imbalance of the energy."""
        return float(np.max([loop.imbalance for loop in self.loops]))

    @property
    def passed(self) -> bool:
        """Whether everything is within the bars."""
        return all(loop.passed for loop in self.loops)
