"""What the simulator says of a measured curve as a function of what is fitted."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from discretization import NotCertifiedError
from energy import Scene, SurfaceEnergies
from studies.scenes.fit.branches import Branch, moved, one_way, retraction, reversible, touching
from studies.scenes.fit.force_curve import Data
from studies.shared import Array

NAMES = ("w", "gamma1", "stiffness", "offset", "opening")
DEFAULT = ("w", "gamma1", "offset")
SCENE = ("w", "gamma1", "stiffness", "opening")  # parameters of the scene itself
BASELINE = ("level", "slope", "drift")  # of the force out of contact
SHIFTS = ("offset", *BASELINE)  # are added; the others are factors
Rates = list[list[tuple[Array, Array]]]  # of depth and force, of each branch by each coordinate
STRIDE = 1e-3  # of the difference quotients, in the coordinates
SHIFTED = 1e-5  # the same of the offset
FAR = math.log(1e4)  # from the start at most, in the logarithms
STEP = 0.8  # of a search at most, in the logarithms
APART = 0.5  # of the logarithms of both works of adhesion, to start from where the scene has one
DEEPER = 1.5  # times the range of the drives in contact: how deep paths go
SHARP = 0.02  # of the distance between points in contact: how straight the end stays
CLEARLY = 0.01  # of the range of the drives in contact
KEPT = 64  # paths that a model remembers
STARTS, ROUNDS = 100, 3  # offsets among which the best one is where the search begins, and beside


def parameters_of(scene: Scene) -> dict[str, float]:
    """What can be fitted, as it is in a scene; opening: 0 where a contact opens with w, too.

    ValueError for an incompressible layer.
    """
    if math.isinf(scene.stiffness):
        raise ValueError(
            f"nu = {scene.layer.nu!r}: a fit asks for the stiffness of the layer pressed evenly, "
            "which is infinite; give a smaller Poisson's ratio, such as 0.49"
        )
    energies = {"w": scene.work_of_adhesion, "gamma1": scene.gamma1}
    opening = scene.opening.work_of_adhesion if scene.opening else 0.0
    return energies | {"stiffness": scene.stiffness, "offset": 0.0, "opening": opening}


def scene_with(scene: Scene, p: dict[str, float]) -> Scene:
    """The scene with these parameters; the stiffness Ẽ/h through Young's modulus.

    A contact opens with the work of adhesion `opening` where that exceeds w, else with w.
    """
    layer = replace(scene.layer, E=scene.layer.E * p["stiffness"] / scene.layer.stiffness)
    surfaces, opening = SurfaceEnergies.from_work(p["gamma1"], p["w"]), None
    if p["opening"] > p["w"]:
        opening = SurfaceEnergies.from_work(p["gamma1"], p["opening"])
    return replace(scene, layer=layer, surfaces=surfaces, opening=opening)


def astray(scene: Scene, names: Sequence[str], factor: float) -> Scene:
    """The scene with some parameters off by a factor, γ₁ upwards and the others downwards."""
    off = {"w": 1 / factor, "gamma1": factor, "stiffness": 1 / factor}
    own = {n: v * off.get(n, 1) if n in names else v for n, v in parameters_of(scene).items()}
    return scene_with(scene, own)


def _usable(scene: Scene, names: tuple[str, ...]) -> Scene:
    """The scene to start from. ValueError for unknown names and a scene that cannot be fitted."""
    if not names or len(set(names)) < len(names) or not set(names) <= set(NAMES):
        raise ValueError(f"parameters = {names!r} must be among {', '.join(NAMES)}, each once")
    start = parameters_of(scene)
    if "opening" in names and scene.opening is None:
        apart = scene.work_of_adhesion * math.exp(APART)
        scene = scene_with(scene, start | {"opening": apart})
        start = parameters_of(scene)
    for name in names:
        if name != "offset" and not start[name] > 0:
            raise ValueError(f"{name} = {start[name]!r} in the scene: start from a value > 0")
    return scene


@dataclass(frozen=True)
class Model:
    """A measured curve against the simulator, as a function of coordinates x (m,).

    Coordinates: logarithms of the parameters over those of the scene; (offset - zero)/length;
    level, slope and drift of the force out of contact over `size`. names: parameters fitted, those
    of the baseline last. touch: depth of touching. branches: of the legs of all contacts as a
    function of the parameters. blunt: before their ends branches go on straight.
    """

    scene: Scene
    names: tuple[str, ...]
    data: Data
    size: float
    length: float
    zero: float
    touch: float
    branches: Callable[[dict[str, float]], list[Branch]]
    blunt: float = 0.0

    @classmethod
    def of(cls, scene: Scene, names: Sequence[str], data: Data, zero: float | None = None) -> Model:
        """zero: offset to start from; else that at which the scene is nearest to the data.

        ValueError for unknown names, a scene that cannot be fitted, too few points."""
        scene, used = _usable(scene, tuple(names)), data.used
        if used.sum() <= len(names) + 1:
            raise ValueError(
                f"curve: {used.sum()} points with a force above the noise are too few for "
                f"{len(names)} parameters; measure more points in contact"
            )
        size, length = float(np.abs(data.curve.force[used]).max()), data.span
        touch, reach = touching(scene), DEEPER * length + 2 * scene.opened.critical_separation

        @lru_cache(KEPT)
        def forward(*values: float) -> tuple[Branch, bool]:
            return retraction(_placed(scene, values), touch, reach)

        @lru_cache(KEPT)
        def turned(drives: tuple[float, ...], *values: float) -> list[Branch]:
            stiffness = data.curve.machine_stiffness
            return one_way(_placed(scene, values), touch, reach, drives, stiffness)

        def branches(p: dict[str, float]) -> list[Branch]:
            own, found = tuple(p[name] for name in SCENE), []
            same = reversible(_placed(scene, own))
            if same:
                both, same = forward(*own)
            for piece in data.pieces:
                drives = tuple(leg.turn - p["offset"] for leg in piece[1:])
                found += [both] * len(piece) if same else turned(drives, *own)
            return found

        fitted = (*names, *BASELINE[: data.columns.shape[1]])
        sharp = SHARP * 2 * length / int(used.sum())
        model = cls(scene, fitted, data, size, length, 0.0, touch, branches, sharp)
        if "offset" not in names:
            return model
        own = (parameters_of(scene)[name] for name in SCENE)
        return replace(model, zero=model.nearest(forward(*own)[0]) if zero is None else zero)

    def near(self, x: Array, rates: Rates | None = None) -> tuple[Model, Rates]:
        """The model whose branches follow these rates from x on, by default their own at x.

        A branch as a function of the root of the distance from its end varies smoothly with the
        parameters, where the force at a depth may vary as a root.
        """
        at = self.parameters(x)
        here, changing = self.branches(at), self.names[: self.count]
        if rates is None:
            rates = [self._rates(x, i, here) for i in range(len(changing))]

        def branches(p: dict[str, float]) -> list[Branch]:
            steps = [
                self.coordinate(name, p[name]) - self.coordinate(name, at[name])
                for name in changing
            ]
            found: dict[int, Branch] = {}
            for number, one in enumerate(here):
                if id(one) not in found:
                    found[id(one)] = moved(one, [rate[number] for rate in rates], steps)
            return [found[id(one)] for one in here]

        return replace(self, branches=branches), rates

    def _rates(self, x: Array, i: int, here: list[Branch]) -> list[tuple[Array, Array]]:
        """How depth and force of each branch change with coordinate i."""
        step = np.zeros(x.size)
        step[i] = SHIFTED if self.names[i] in SHIFTS else STRIDE
        beside = self.branches(self.parameters(x + step))
        return [
            ((b.depth - a.depth) / step[i], (b.force - a.force) / step[i])
            for a, b in zip(here, beside, strict=True)
        ]

    @property
    def count(self) -> int:
        """How many parameters are not of the baseline."""
        return len(self.names) - self.data.columns.shape[1]

    @property
    def start(self) -> Array:
        """Where the search begins (m,): the scene, and a line through the free points."""
        x, (columns, free) = np.zeros(len(self.names)), (self.data.columns, self.data.free)
        if columns.shape[1]:
            line = np.linalg.lstsq(columns[free], self.data.curve.force[free], rcond=None)[0]
            x[-columns.shape[1] :] = line / self.size
        return x

    def nearest(self, branch: Branch) -> float:
        """The offset, of all with a contact in it, at which a branch is nearest to the data."""
        data, drive = self.data, self.data.curve.drive[self.data.used]
        measured = (data.curve.force - self.line(self.start))[data.used]

        def off(offset: float) -> float:
            force, end = branch.read(drive - offset, data.curve.machine_stiffness, self.blunt)
            ends = {"touch": self.touch, "detachment": end}
            late = [ends[mark.kind] + offset - mark.depth for mark in data.ends]
            found = np.sum((force - measured) ** 2) + self.size**2 * len(late)
            return float(found) * (1 + sum((one / self.length) ** 2 for one in late))

        low, high = drive.min() - self.length - self.touch, drive.max() - self.touch
        for _ in range(ROUNDS):
            offsets = np.linspace(low, high, STARTS)
            best, step = min(offsets.tolist(), key=off), offsets[1] - offsets[0]
            low, high = best - step, best + step
        return best

    @property
    def limits(self) -> Array:
        """Largest size of each coordinate (m,): a factor exp FAR from the start, or the range."""
        reach = {"offset": 1.0} | dict.fromkeys(BASELINE, 1e6)
        return np.array([reach.get(name, FAR) for name in self.names])

    @property
    def strides(self) -> Array:
        """Longest step of each coordinate in a search (m,)."""
        return np.array([math.inf if name in SHIFTS else STEP for name in self.names])

    def on_bound(self, x: Array, i: int) -> bool:
        """Whether coordinate i is where the search ends: at its limit, or opening at w."""
        at = self.parameters(x)
        none = self.names[i] == "opening" and at["opening"] <= at["w"] * (1 + STRIDE)
        return none or bool(abs(x[i]) >= (1 - STRIDE) * self.limits[i])

    def parameters(self, x: Array) -> dict[str, float]:
        """All parameters at these coordinates."""
        known = (*NAMES, *BASELINE)
        at = dict.fromkeys(known, 0.0) | dict(zip(self.names, x.tolist(), strict=True))
        return {name: self.value(name, coordinate) for name, coordinate in at.items()}

    def value(self, name: str, coordinate: float) -> float:
        """A parameter at its coordinate; level, slope [force per length] and drift in SI."""
        if name == "offset":
            return self.zero + coordinate * self.length
        if name in BASELINE:
            per = float(np.ptp(self.data.curve.drive)) if name == "slope" else 1.0
            return coordinate * self.size / per
        return parameters_of(self.scene)[name] * math.exp(min(max(coordinate, -2 * FAR), 2 * FAR))

    def coordinate(self, name: str, value: float) -> float:
        """The coordinate at which a parameter has this value."""
        if name in SHIFTS:
            first = self.value(name, 0.0)
            return (value - first) / (self.value(name, 1.0) - first)
        return math.log(value / parameters_of(self.scene)[name])

    def line(self, x: Array) -> Array:
        """The force out of contact at every point of the curve (n,)."""
        columns = self.data.columns
        return np.asarray(columns @ x[x.size - columns.shape[1] :]) * self.size

    def residuals(self, x: Array) -> Array:
        """Force less measured in contact and out of it (n,), and the ends of contact in units of
        the noise (k,); nan: no state."""
        p, data = self.parameters(x), self.data
        try:
            force, ends = self.forces(p)
        except (ValueError, NotCertifiedError, OverflowError):
            count = data.used.sum() + data.free.sum() + len(data.ends)
            return np.full(count, math.nan)
        off = force + self.line(x) - data.curve.force
        late = [data.sigma * (ends[mark.kind] - mark.depth) / mark.error for mark in data.ends]
        return np.concatenate([off[data.used], off[data.free], late])

    def forces(self, p: dict[str, float]) -> tuple[Array, dict[str, float]]:
        """P at every point of the curve (n,), 0 out of contact; drives at its begin and its end."""
        curve, offset = self.data.curve, p["offset"]
        force, end = np.zeros(curve.force.size), 0.0
        legs = [leg for piece in self.data.pieces for leg in piece]
        for leg, branch in zip(legs, self.branches(p), strict=True):
            at = curve.drive[leg.points] - offset
            force[leg.points], end = branch.read(at, curve.machine_stiffness, self.blunt)
        return force, {"touch": self.touch + offset, "detachment": end + offset}

    def apart(self, x: Array) -> NDArray[np.bool_]:
        """Which points (n,) can have no contact: before it, or below all of it."""
        (_, ends), data = self.forces(self.parameters(x)), self.data
        before = ~np.logical_or.accumulate(data.used) & (data.curve.drive < ends["touch"])
        return before | (data.curve.drive < ends["detachment"] - CLEARLY * self.length)

    def jacobian(self, x: Array, free: Sequence[int]) -> Array:
        """∂residuals/∂x of some coordinates, a column for each."""
        columns, here, data = [], self.residuals(x), self.data
        for i in free:
            name = self.names[i]
            if name in BASELINE:
                line = self.size * data.columns[:, BASELINE.index(name)]
                ends = np.zeros(len(data.ends))
                columns.append(np.concatenate([line[data.used], line[data.free], ends]))
                continue
            step = np.zeros(x.size)
            step[i] = SHIFTED if name == "offset" else STRIDE
            columns.append((self.residuals(x + step) - here) / step[i])
        return np.stack(columns, axis=1)


def _placed(scene: Scene, values: Sequence[float]) -> Scene:
    return scene_with(scene, dict(zip(SCENE, values, strict=True)))
