"""What the simulator says of a measured curve as a function of what is fitted; least squares."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from discretization import NotCertifiedError, load_path
from energy import Scene, SurfaceEnergies
from studies.scenes.fit.force_curve import Curve, Mark, contacts, in_contact, marks, noise
from studies.shared import Array

NAMES = ("w", "gamma1", "stiffness", "offset", "opening")
DEFAULT = ("w", "gamma1", "offset")
STRIDE = 1e-4  # of the difference quotients, relative to the parameters' scales
TANGENT = 1e-3  # of the difference quotient at the detachment, over δ₀
BEYOND = 1.01  # times δ₀ below touching nothing holds
ROUNDING = 1e-10  # of a force, relative to the largest
FAR = math.log(1e4)  # from the start at most, in the logarithms
APART = 0.5  # of the logarithms of both works of adhesion, to start from where the scene has one


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


@dataclass(frozen=True)
class Model:
    """A measured curve against the simulator, as a function of coordinates x (m,).

    Coordinates: logarithms of the parameters over those of the scene; offset over `length`.
    depths, measured (n,): in contact, each of `pieces` from a touch on; ends: where contact begins
    and is lost, k of them; sigma: noise of the force, or rounding [N/m]; touch: depth of touching.
    """

    scene: Scene
    names: tuple[str, ...]
    depths: Array
    measured: Array
    pieces: tuple[slice, ...]
    ends: tuple[Mark, ...]
    sigma: float
    length: float
    touch: float

    @classmethod
    def of(cls, scene: Scene, names: Sequence[str], curve: Curve) -> Model:
        """ValueError for unknown names, a scene that cannot be fitted, too few points."""
        names, start = tuple(names), parameters_of(scene)
        if not names or len(set(names)) < len(names) or not set(names) <= set(NAMES):
            raise ValueError(f"parameters = {names!r} must be among {', '.join(NAMES)}, each once")
        if "opening" in names and scene.opening is None:
            apart = scene.work_of_adhesion * math.exp(APART)
            scene = scene_with(scene, start | {"opening": apart})
            start = parameters_of(scene)
        for name in names:
            if name != "offset" and not start[name] > 0:
                raise ValueError(f"{name} = {start[name]!r} in the scene: start from a value > 0")
        used = in_contact(curve)
        if used.sum() <= len(names) + 1:
            raise ValueError(
                f"curve: {used.sum()} points with a force above the noise are too few for "
                f"{len(names)} parameters; measure more points in contact"
            )
        ends = np.cumsum([0, *(int(used[piece].sum()) for piece in contacts(curve))]).tolist()
        pieces = tuple(slice(a, b) for a, b in pairwise(ends) if b > a)
        depths, measured, length = *(column[used] for column in curve), float(np.ptp(curve.depth))
        sigma = max(noise(curve.force), ROUNDING * float(np.abs(measured).max()))
        touch = load_path(scene, forces=[0.0]).events[0].depth  # where a path under a load begins
        return cls(scene, names, depths, measured, pieces, marks(curve), sigma, length, touch)

    @property
    def limits(self) -> Array:
        """Largest size of each coordinate (m,): a factor exp FAR from the start, or the range."""
        return np.array([1.0 if name == "offset" else FAR for name in self.names])

    def on_bound(self, x: Array, i: int) -> bool:
        """Whether coordinate i is where the search ends: at its limit, or opening at w."""
        at = self.parameters(x)
        none = self.names[i] == "opening" and at["opening"] <= at["w"] * (1 + STRIDE)
        return none or bool(abs(x[i]) >= (1 - STRIDE) * self.limits[i])

    def detached(self, curve: Curve, x: Array) -> NDArray[np.bool_]:
        """Which points of the curve (n,) can have no contact: before it, or below all of it."""
        p = self.parameters(x)
        depth, reach = curve.depth - p["offset"], scene_with(self.scene, p).opened
        before = ~np.logical_or.accumulate(in_contact(curve)) & (depth < self.touch)
        return before | (depth < self.touch - BEYOND * reach.critical_separation)

    def parameters(self, x: Array) -> dict[str, float]:
        """All parameters at these coordinates."""
        at = dict.fromkeys(NAMES, 0.0) | dict(zip(self.names, x.tolist(), strict=True))
        return {name: self.value(name, coordinate) for name, coordinate in at.items()}

    def value(self, name: str, coordinate: float) -> float:
        """A parameter at its coordinate."""
        if name == "offset":
            return coordinate * self.length
        return parameters_of(self.scene)[name] * math.exp(min(max(coordinate, -2 * FAR), 2 * FAR))

    def coordinate(self, name: str, value: float) -> float:
        """The coordinate at which a parameter has this value."""
        if name == "offset":
            return value / self.length
        return math.log(value / parameters_of(self.scene)[name])

    def residuals(self, x: Array) -> Array:
        """P - measured (n,), and the ends of contact in units of the noise (k,); nan: no state."""
        p = self.parameters(x)
        try:
            scene, depths = scene_with(self.scene, p), self.depths - p["offset"]
            found = [self._response(scene, depths[piece]) for piece in self.pieces]
        except (ValueError, NotCertifiedError, OverflowError):
            return np.full(self.depths.size + len(self.ends), math.nan)
        forces, (*_, lost) = np.concatenate([f for f, _ in found]), (end for _, end in found)
        at = {"touch": self.touch + p["offset"], "detachment": lost + p["offset"]}
        ends = [self.sigma * (at[mark.kind] - mark.depth) / mark.error for mark in self.ends]
        return np.concatenate([forces - self.measured, ends])

    def _response(self, scene: Scene, depths: Array) -> tuple[Array, float]:
        """P (n,), past the detachment continued along its tangent there, and where that is."""
        reach = scene.opened.critical_separation
        history = load_path(scene, depths=[self.touch, *depths, self.touch - BEYOND * reach])
        forces, held = history.force[1:-1], ~np.isnan(history.contacts[1:-1, 0])
        end = [event for event in history.events if event.kind == "detachment"][-1].before
        if held.all():
            return forces, end.depth
        beside = load_path(scene, depths=[self.touch, end.depth + TANGENT * reach]).force[-1]
        slope = (float(beside) - end.force) / (TANGENT * reach)
        return np.where(held, forces, end.force + slope * (depths - end.depth)), end.depth

    def jacobian(self, x: Array, free: Sequence[int]) -> Array:
        """∂residuals/∂x of some coordinates by central differences, a column for each."""
        columns = []
        for i in free:
            step = np.zeros(x.size)
            step[i] = STRIDE
            rise = self.residuals(x + step) - self.residuals(x - step)
            columns.append(rise / (2 * STRIDE))
        return np.stack(columns, axis=1)


def minimum(
    model: Model, start: Array, fixed: int | None = None, ftol: float = 1e-9
) -> OptimizeResult:
    """Least squares from `start`; coordinate `fixed` stays. cost: half the sum of squares."""
    free = [i for i in range(start.size) if i != fixed]

    def whole(y: Array) -> Array:
        x = start.copy()
        x[free] = y
        return x

    if not np.isfinite(model.residuals(start)).all():
        raise ValueError(
            f"scene = {model.scene!r} has no equilibria along the measured depths to start from; "
            "start from other parameters"
        )
    scale = max(float(np.abs(model.measured).max()), sys.float_info.min)
    reach = model.limits[free]
    found = least_squares(
        lambda y: model.residuals(whole(y)) / scale,
        start[free],
        lambda y: model.jacobian(whole(y), free) / scale,
        bounds=(-reach, reach),
        x_scale="jac",
        xtol=1e-8,
        ftol=ftol,
        max_nfev=100,
    )
    found.x, found.fun, found.jac = whole(found.x), found.fun * scale, found.jac * scale
    found.cost = (found.cost + ROUNDING**2 * found.fun.size) * scale**2
    return found


def conditioning(jacobian: Array) -> tuple[float, Array, Array]:
    """Condition with unit columns, the weakest direction, √((JᵀJ)⁻¹)ᵢᵢ; inf for a zero column."""
    sizes = np.linalg.norm(jacobian, axis=0)
    dead = sizes <= 1e-9 * sizes.max()
    unit = jacobian / np.where(dead, 1.0, sizes)
    _, singular, right = np.linalg.svd(unit[:, ~dead], full_matrices=False)
    spread = np.full(sizes.size, math.inf)
    spread[~dead] = np.linalg.norm(right.T / singular, axis=1) / sizes[~dead]
    weakest = np.zeros(sizes.size)
    weakest[~dead] = right[-1] / sizes[~dead]
    if dead.any():
        weakest = dead.astype(float)
    condition = math.inf if dead.any() else float(singular[0] / singular[-1])
    return condition, weakest / np.linalg.norm(weakest), spread
