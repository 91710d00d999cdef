"""Other models of the same curve, and how far the assumptions of the fitted one hold along it."""

import math
from dataclasses import dataclass, replace

import numpy as np

from discretization import NotCertifiedError, minimise
from energy import Assumption, Scene
from studies.scenes.fit.model import BASELINE, Model, scene_with
from studies.scenes.fit.search import BLUNT, ROUGH, Best, followed, hopeless, sought
from studies.shared import Array

STRONG = 6.0  # a difference of the information criterion that decides (Kass and Raftery 1995)
KNOWN = 0.3  # half-width of the interval of log w: adhesion that is known so well is needed
NONE = 1e-5  # of the work of adhesion stands for none
WITHIN = 0.1  # by which two models may differ in a parameter without a word
ROUGHLY = 3e-3  # how well a sum of squares is found
LOOKS = 5  # states along the curve whose assumptions are looked at
NEEDLESS = {"gamma1": "without surface tension", "w": "without adhesion"}


def criterion(best: Best) -> float:
    """Schwarz's criterion n log(Σr²/n) + m log n of a fit of m parameters to n residuals."""
    n, m = best.fun.size, best.x.size
    return float(n * math.log(2 * best.cost / n) + m * math.log(n))


@dataclass(frozen=True)
class Alternative:
    """Another model of the same curve.

    name: of the parameter left out, or the response of the layer; better: by how much its
    criterion is lower than that of the fit; values: what it finds; off: by how much the fit is
    off them, relatively; simpler: whether it lacks a parameter.
    """

    name: str
    better: float
    values: dict[str, float]
    off: dict[str, float]
    simpler: bool

    @property
    def preferred(self) -> bool:
        """Whether the data are better told by it."""
        return self.better > (0 if self.simpler else STRONG)

    @property
    def doubtful(self) -> bool:
        """Whether it casts a doubt on the fit."""
        differs = max(map(abs, self.off.values()), default=0.0) > WITHIN
        return self.preferred or (not self.simpler and self.better > -STRONG and differs)

    @property
    def told(self) -> str:
        """What the comparison says, in a sentence."""
        found = ", ".join(f"{name} = {value:.4g}" for name, value in self.values.items())
        size = (
            f"the criterion is {'lower' if self.better > 0 else 'higher'} by {abs(self.better):.3g}"
        )
        if self.simpler:
            verdict = "not needed" if self.preferred else "needed"
            with_it = f" and {found}" if self.preferred and found else ""
            text = f"{self.name} is {verdict} by these data: {NEEDLESS[self.name]}"
            return f"{text} {size}{with_it}"
        off = " and ".join(f"{value:+.0%} in {name}" for name, value in self.off.items())
        other = "springs" if self.name == "layer" else "the layer's own response"
        own = "the layer" if self.name == "layer" else "springs"
        verb = "explains" if self.name == "layer" else "explain"
        if self.preferred:
            text = f"{own} {verb} them better ({size}): {other} are off by {off}; with"
            return f'{text} response = "{self.name}" {found}'
        if self.doubtful:
            text = f"these data do not tell {other} from {own} ({size}), with which {found}"
            return f"{text}; the fit differs by {off}"
        return f"{other} tell these data better than {own} or as well ({size})"


def compared(model: Model, best: Best, reaches: Array) -> tuple[Alternative, ...]:
    """The models without tension, without adhesion and with the layer's own response.

    reaches: half-widths of the intervals; adhesion that is well known is needed, and not left out.
    """
    at = model.parameters(model.start if hopeless(model, best) else best.x)
    scene, names = scene_with(model.scene, at), _own(model)
    others: list[tuple[str, Scene, list[str]]] = []
    if "gamma1" in names and not scene.layer.exact:
        others.append(("gamma1", scene_with(scene, at | {"gamma1": 0.0}), _less(names, "gamma1")))
    if "w" in names and not reaches[names.index("w")] < KNOWN:
        none = scene_with(scene, at | {"w": NONE * at["w"], "opening": 0.0})
        others.append(("w", none, [n for n in names if n not in ("w", "opening")]))
    response = "springs" if scene.layer.exact else "layer"
    others.append((response, replace(scene, layer=replace(scene.layer, response=response)), names))
    found = []
    for name, other, free in others:
        if free:
            try:
                found.append(_alternative(model, best, name, other, free))
            except (ValueError, NotCertifiedError):
                continue  # this scene has no such model
    return tuple(found)


def _own(model: Model) -> list[str]:
    return [name for name in model.names if name not in BASELINE]


def _less(names: list[str], name: str) -> list[str]:
    return [one for one in names if one != name]


def _alternative(
    model: Model, best: Best, name: str, scene: Scene, names: list[str]
) -> Alternative:
    at = model.parameters(best.x)
    if hopeless(model, best):
        other = Model.of(scene, names, model.data)
        found = sought(other, other.start, ROUGHLY)
    else:
        other = Model.of(scene, names, model.data, at["offset"])
        x = followed(replace(other, blunt=BLUNT[-1] * other.blunt), other.start, ftol=ROUGH).x
        found = followed(other, x, ftol=ROUGHLY)
    own = other.parameters(found.x)
    energies = [name for name in names if name in ("w", "gamma1")]
    off = {n: at[n] / own[n] - 1 for n in energies}
    better = criterion(best) - criterion(found)
    return Alternative(name, better, {n: own[n] for n in energies}, off, name in NEEDLESS)


def strained(model: Model, best: Best) -> tuple[tuple[Assumption, float], ...]:
    """Each assumption that is violated along the fitted curve, at its worst, and its depth."""
    p, data = model.parameters(best.x), model.data
    scene = replace(scene_with(model.scene, p), opening=None)
    force, _ = model.forces(p)
    own = data.curve.drive - p["offset"] - force / data.curve.machine_stiffness
    shallow, deep = np.quantile(own[data.used], (0.02, 1.0)).tolist()
    depths = np.linspace(shallow, deep, LOOKS)
    worst: dict[str, tuple[Assumption, float]] = {}
    for depth in depths.tolist():
        try:
            state = minimise(scene, depth, rtol=1e-5)
        except (ValueError, NotCertifiedError):
            continue  # where the path has let go, or where it needs more than one contact
        for one in state.validity:
            if (
                not one.holds
                and one.value > worst.get(one.name, (one._replace(value=0.0),))[0].value
            ):
                worst[one.name] = one, depth
    return tuple(worst.values())
