"""What the self-test of `fit` records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies.scenes.fit.model import DEFAULT

NEEDED = 0.9  # of the intervals hold the truth


SCENE = Scene(  # a very soft film, whose tension is felt: l = 43 µm, a(0) = 140 µm, δ₀ = 0.32 µm
    ElasticLayer(E=50.0, nu=0.45, h=5e-6),
    SurfaceEnergies.from_work(gamma1=0.07, w=2e-6),
    Parabola(R=0.05),
)


@dataclass(frozen=True)
class Parameters:
    """Scene with the true parameters, what is fitted, trials, steps per branch, noise, start.

    noise: standard deviation over the largest force; wrong: how far off the search starts, as a
    factor; reach: the curve goes from -reach to reach times δ₀; offset: true, in units of δ₀.
    """

    scene: Scene = SCENE
    names: tuple[str, ...] = DEFAULT
    trials: int = 100
    steps: int = 40
    noise: float = 0.01
    wrong: float = 1.5
    reach: float = 1.1
    offset: float = 0.05
    profile: bool = True
    seed: int = 11


class Trial(NamedTuple):
    """One estimate, its linearised interval, and whether that and the profile hold the truth."""

    value: float
    interval: tuple[float, float] | None
    holds: bool
    profile_holds: bool


@dataclass(frozen=True)
class Record:
    """Trials, each a tuple over the parameters fitted, and the truth by name."""

    parameters: Parameters
    truth: dict[str, float]
    trials: tuple[tuple[Trial, ...], ...]

    def share(self, i: int) -> tuple[float, float]:
        """Of trials whose interval of parameter i holds the truth: linearised, profile."""
        held = [(trial[i].holds, trial[i].profile_holds) for trial in self.trials]
        linear, profile = np.mean(held, axis=0).tolist()
        return linear, profile

    @property
    def passed(self) -> bool:
        """Whether every share is enough, of linearised and of profile intervals."""
        return all(min(self.share(i)) >= NEEDED for i in range(len(self.parameters.names)))
