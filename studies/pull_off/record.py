"""What `pull_off` records: the pull-off of each scene, simulated and in closed form."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from energy import Scene
from studies.shared import Array, loops


class State(NamedTuple):
    """A pull: force F_A > 0 [N/m], depth and half-width [m]."""

    force: float
    depth: float
    half_width: float


class Pull(NamedTuple):
    """Pull-off of one scene, simulated and in closed form; for the flat punch the global one."""

    scene: Scene
    ratio: float
    simulated: State
    closed_form: State
    balanced: State | None
    balanced_card: State | None

    @property
    def error(self) -> float:
        """Largest relative error, where the closed form is 0 of kδ₀(b + l), δ₀ or b."""
        scene = self.scene
        scales = (loops.force_scale(scene), scene.critical_separation, loops.size(scene))
        pairs = [(self.simulated, self.closed_form)]
        if self.balanced is not None and self.balanced_card is not None:
            pairs.append((self.balanced, self.balanced_card))
        return max(
            loops.Form("", own, card, scale).error
            for pair in pairs
            for own, card, scale in zip(*pair, scales, strict=True)
        )


@dataclass(frozen=True)
class Curve:
    """All pulls of one indenter, over growing tension; the first without."""

    shape: str
    pulls: tuple[Pull, ...]

    @property
    def ratios(self) -> Array:
        """l/b (n,)."""
        return np.array([pull.ratio for pull in self.pulls])

    @property
    def forces(self) -> Array:
        """F_A (n,), simulated."""
        return np.array([pull.simulated.force for pull in self.pulls])

    @property
    def gain(self) -> Array:
        """F_A over that without tension."""
        return self.forces / self.forces[0]

    @property
    def error(self) -> float:
        """The largest of all errors."""
        return float(np.max([pull.error for pull in self.pulls]))
