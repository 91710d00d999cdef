"""What the simulator says of a measured curve as a function of what is fitted.

Conventions:

- A scene has `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀ = √(2w/k).
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `Circle(R)` is the true arc.
- `NotCertifiedError` is raised where no state passes its own checks.
- `Data` is a curve with masks (n,) of its points: `used` are in contact, `free` out of it.
- Its `contacts` have `legs`, motions in one direction, inwards first: indices `points`, and the
  position `turn` of the machine where each begins; `ends` are the positions where contact begins or
  is lost, with an `error`.
- `sigma` is the noise of the force, `span` the range of positions in contact, `roots` are roots of
  weights and `lines` (m, q) the weighted columns of the force out of contact.
- A `Branch` is states along a leg: `read(drives, K, blunt)` are their forces at positions of a
  machine, and where the branch ends.
- `touching(scene)` is the depth of first touch, `leg_branches` the branches of all legs of a
  contact, `retraction` that of pulling alone.
- `scene.opened` is the scene of a contact that opens.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import optimize

from discretization import NotCertifiedError
from energy import Circle, Parabola, Scene, SurfaceEnergies
from energy.arrays import Array, Mask
from studies.scenes.fit.branches import Branch, leg_branches, retraction, touching
from studies.scenes.fit.force_curve import Data

NAMES = ("w", "gamma1", "stiffness", "E", "offset", "opening")
UNCERTAIN = ("R", "h")  # what may be known with an uncertainty
DEFAULT = ("w", "gamma1", "offset")
Round = Circle | Parabola  # indenters that have a radius
HUGE = 700.0  # logarithm above which a number overflows
STRIDE = 1e-3  # of a logarithm, for difference quotients
APART = 0.5  # of the logarithms of both works of adhesion, to start from where the scene has one
DEEPER = 1.5  # times the range of the drives in contact: how deep paths go
SHARP = 0.02  # of the distance between points in contact: how straight the end stays
CLEARLY = 0.01  # of the range of the drives in contact, below the detachment: no contact
STARTS = 100  # offsets that are tried, in each of the rounds
ROUNDS = 3  # in which they become closer


def parameters_of(scene: Scene) -> dict[str, float]:
    """What can be fitted or uncertain, as it is in a scene.

    opening: 0 where a contact opens with w, too. R: of the indenter, where it has one. ValueError
    for an incompressible layer.
    """
    if math.isinf(scene.stiffness):
        raise ValueError(
            f"nu = {scene.layer.nu!r}: a fit asks for the stiffness of the layer pressed evenly, "
            "which is infinite; give a smaller Poisson's ratio, such as 0.49"
        )
    energies = {"w": scene.work_of_adhesion, "gamma1": scene.gamma1}
    opening = scene.opening.work_of_adhesion if scene.opening else 0.0
    layer = {"stiffness": scene.stiffness, "E": scene.layer.E, "h": scene.layer.h}
    body = {"R": scene.indenter.R} if isinstance(scene.indenter, Round) else {}
    return energies | layer | body | {"offset": 0.0, "opening": opening}


def completed(scene: Scene, changes: Mapping[str, float]) -> dict[str, float]:
    """All parameters of a scene where some are changed: E follows the stiffness, or the reverse.

    Ẽ/h is in proportion to E/h at the Poisson's ratio of the scene.
    """
    found = {**parameters_of(scene), **changes}
    thinner = scene.layer.h / found["h"]
    if "stiffness" in changes and "E" not in changes:
        found["E"] = scene.layer.E * found["stiffness"] / (scene.stiffness * thinner)
    else:
        found["stiffness"] = scene.stiffness * thinner * found["E"] / scene.layer.E
    return found


def scene_with(scene: Scene, changes: Mapping[str, float]) -> Scene:
    """The scene with some parameters changed.

    A contact opens with the work of adhesion `opening` where that exceeds w, else with w.
    """
    p = completed(scene, changes)
    layer = scene.layer
    indenter = scene.indenter
    opening = None
    if (p["E"], p["h"]) != (layer.E, layer.h):
        layer = replace(layer, E=p["E"], h=p["h"])
    if isinstance(indenter, Round) and p["R"] != indenter.R:
        indenter = replace(indenter, R=p["R"])
    surfaces = SurfaceEnergies.from_work(p["gamma1"], p["w"])
    if p["opening"] > p["w"]:
        opening = SurfaceEnergies.from_work(p["gamma1"], p["opening"])
    return replace(scene, layer=layer, indenter=indenter, surfaces=surfaces, opening=opening)


def astray(scene: Scene, names: Sequence[str], factor: float) -> Scene:
    """The scene with some parameters off by a factor, γ₁ upwards and the others downwards."""
    off = {"w": 1 / factor, "gamma1": factor, "stiffness": 1 / factor, "E": 1 / factor}
    own = parameters_of(scene)
    return scene_with(scene, {name: own[name] * off.get(name, 1.0) for name in names})


def _usable(scene: Scene, names: tuple[str, ...]) -> Scene:
    """The scene to start from. ValueError for unknown names and a scene that cannot be fitted."""
    if not names or len(set(names)) < len(names) or not set(names) <= set(NAMES):
        raise ValueError(f"parameters = {names!r} must be among {', '.join(NAMES)}, each once")
    if {"stiffness", "E"} <= set(names):
        raise ValueError(f"parameters = {names!r}: E follows from the stiffness; leave one out")
    if "opening" in names and scene.opening is None:
        larger = scene.work_of_adhesion * math.exp(APART)
        scene = scene_with(scene, {"opening": larger})
    start = parameters_of(scene)
    for name in names:
        if name != "offset" and not start[name] > 0:
            raise ValueError(f"{name} = {start[name]!r} in the scene: start from a value > 0")
    return scene


class Coordinates(NamedTuple):
    """How far coordinates may go (m,): their largest size, their longest step in a search, and
    the step of difference quotients."""

    limit: Array
    step: Array
    difference: Array


@dataclass(frozen=True)
class Model:
    """A measured curve against the simulator, as a function of coordinates x (m,).

    Coordinates are logarithms of the parameters over those of the scene, and (offset - zero)/span.
    Forces are compared with the data less the nearest line out of contact: level, slope and drift
    follow from x.

    Attributes
    ----------
    scene : Scene
        Where the search begins.
    names : tuple of str
        Of the coordinates.
    data : Data
    zero : float
        Offset of the depth where its coordinate is 0 [m].
    touch : float
        Depth of first touch [m].
    blunt : float
        From so far before their ends on branches are straight [m].
    known : (ndarray (m,), list of Branch, ndarray (branches, 2, n, m)), optional
        Coordinates, the branches there, and how fast their depths and forces change with each
        coordinate: branches elsewhere follow from these.
    """

    scene: Scene
    names: tuple[str, ...]
    data: Data
    zero: float
    touch: float
    blunt: float
    known: tuple[Array, list[Branch], Array] | None = None

    @classmethod
    def of(cls, scene: Scene, names: Sequence[str], data: Data, zero: float | None = None) -> Model:
        """The model of some data, with what is known with an uncertainty among its coordinates.

        Parameters
        ----------
        scene : Scene
        names : sequence of str
            What is fitted.
        data : Data
        zero : float, optional
            Offset to start from; without, that at which the scene is nearest to the data.

        Raises
        ------
        ValueError
            For unknown names, a scene that cannot be fitted, and too few points.
        """
        scene = _usable(scene, tuple(names))
        count = int(data.used.sum())
        names = (*names, *(name for name, _ in data.known))
        if count <= len(names) + 1:
            raise ValueError(
                f"curve: {count} points with a force above the noise are too few for "
                f"{len(names)} parameters; measure more points in contact"
            )
        sharp = SHARP * 2 * data.span / count
        model = cls(scene, tuple(names), data, zero or 0.0, touching(scene), sharp)
        if "offset" not in names or zero is not None:
            return model
        return replace(model, zero=model.nearest(retraction(scene, model.touch, model.reach)[0]))

    @property
    def fitted(self) -> tuple[str, ...]:
        """What the data alone determine: the names without what is known with an uncertainty."""
        return self.names[: len(self.names) - len(self.data.known)]

    @property
    def reach(self) -> float:
        """How far below the touch paths go."""
        return DEEPER * self.data.span + 2 * self.scene.opened.critical_separation

    def branches(self, x: Array) -> list[Branch]:
        """The branch of each leg of all contacts."""
        if self.known is not None:
            at, here, rates = self.known
            moves = zip(here, rates @ (x - at), strict=True)
            moved = {b: replace(b, depth=b.depth + d, force=b.force + p) for b, (d, p) in moves}
            return [moved[branch] for branch in here]
        p = self.parameters(x)
        found = []
        scene = scene_with(self.scene, p)
        stiffness = self.data.curve.machine_stiffness
        for contact in self.data.contacts:
            drives = tuple(leg.turn - p["offset"] for leg in contact.legs[1:])
            found += leg_branches(scene, self.touch, self.reach, drives, stiffness)
        return found

    def near(self, x: Array) -> Model:
        """The model whose branches follow their rates at x.

        A branch as a function of the root of the distance from its end varies smoothly with the
        parameters, where the force at a depth may vary as a root.
        """

        def numbers(x: Array) -> Array:
            """Depths and forces of all branches at coordinates, in one row."""
            return np.array([[one.depth, one.force] for one in self.branches(x)]).ravel()

        here = self.branches(x)
        rates = optimize.approx_fprime(x, numbers, self.coordinates.difference)
        return replace(self, known=(x, here, rates.reshape(len(here), 2, -1, x.size)))

    def nearest(self, branch: Branch) -> float:
        """The offset, of all with a contact in it, at which a branch is nearest to the data."""
        data = self.data
        drive = self.data.curve.drive[self.data.used]
        measured = data.flat.force[data.used]

        def off(offset: float) -> float:
            """Sum of squares of the forces with this offset, times 1 + Σ (distance of ends/span)².

            The square of the largest force is added for each end of contact, so that the ends
            count also where all forces agree.
            """
            force, end = branch.read(drive - offset, data.curve.machine_stiffness, self.blunt)
            ends = {"touch": self.touch, "detachment": end}
            late = [ends[mark.kind] + offset - mark.depth for mark in data.ends]
            found = np.sum((force - measured) ** 2) + data.size**2 * len(late)
            return float(found) * (1 + sum((one / data.span) ** 2 for one in late))

        low = drive.min() - data.span - self.touch
        high = drive.max() - self.touch
        for _ in range(ROUNDS):
            offsets, step = np.linspace(low, high, STARTS, retstep=True)
            best = min(offsets.tolist(), key=off)
            low = best - step
            high = best + step
        return best

    @property
    def coordinates(self) -> Coordinates:
        """How far each coordinate may go."""
        is_offset = np.array([name == "offset" for name in self.names])
        return Coordinates(
            limit=np.where(is_offset, 1.0, math.log(1e4)),
            step=np.where(is_offset, math.inf, 0.8),
            difference=np.where(is_offset, 1e-5, STRIDE),
        )

    def on_bound(self, x: Array, i: int) -> bool:
        """Whether coordinate i is where the search ends: at its limit, or opening at w."""
        at = self.parameters(x)
        none = self.names[i] == "opening" and at["opening"] <= at["w"] * (1 + STRIDE)
        return none or bool(abs(x[i]) >= (1 - STRIDE) * self.coordinates.limit[i])

    def parameters(self, x: Array) -> dict[str, float]:
        """All parameters at these coordinates."""
        fitted = {name: self.value(name, at) for name, at in zip(self.names, x, strict=True)}
        return completed(self.scene, fitted)

    def value(self, name: str, coordinate: float) -> float:
        """A parameter at its coordinate."""
        if name == "offset":
            return self.zero + float(coordinate) * self.data.span
        factor = math.exp(coordinate) if coordinate < HUGE else math.inf
        return parameters_of(self.scene)[name] * factor

    def coordinate(self, name: str, value: float) -> float:
        """The coordinate at which a parameter has this value."""
        if name == "offset":
            return (value - self.zero) / self.data.span
        return math.log(value / parameters_of(self.scene)[name])

    def forces(self, x: Array) -> tuple[Array, dict[str, float]]:
        """P at every point of the curve (n,), 0 out of contact; drives at its begin and its end."""
        curve = self.data.curve
        offset = self.parameters(x)["offset"]
        force = np.zeros(curve.force.size)
        end = 0.0
        for leg, branch in zip(self.data.legs, self.branches(x), strict=True):
            at = curve.drive[leg.points] - offset
            force[leg.points], end = branch.read(at, curve.machine_stiffness, self.blunt)
        return force, {"touch": self.touch + offset, "detachment": end + offset}

    def off(self, x: Array) -> Array:
        """Force less measured in contact and out of it, then the ends of contact and what is known
        beside the curve in units of the noise, weighted (n,); nan: no state."""
        data = self.data
        try:
            force, ends = self.forces(x)
        except (ValueError, NotCertifiedError, OverflowError):
            return np.full(len(data.lines), math.nan)
        force = force - data.curve.force
        late = [data.sigma * (ends[mark.kind] - mark.depth) / mark.error for mark in data.ends]
        uncertain = [
            data.sigma * x[self.names.index(name)] / relative for name, relative in data.known
        ]
        return data.roots * np.concatenate([force[data.used], force[data.free], late, uncertain])

    def line(self, x: Array) -> Array:
        """Coefficients of the nearest line out of contact (q,)."""
        return -self.data.nearest @ self.off(x)

    def residuals(self, x: Array) -> Array:
        """What `off` leaves beside the nearest line out of contact (n,)."""
        off = self.off(x)
        return np.asarray(off - self.data.lines @ (self.data.nearest @ off))

    def jacobian(self, x: Array) -> Array:
        """∂off/∂x, and ∂off/∂line (n, m + q)."""
        own = optimize.approx_fprime(x, self.off, self.coordinates.difference)
        return np.concatenate([own, self.data.lines], axis=1)

    def without_contact(self, x: Array) -> Mask:
        """Which points (n,) can have no contact: before it, or below all of it."""
        data = self.data
        _, ends = self.forces(x)
        before = ~np.logical_or.accumulate(data.used) & (data.curve.drive < ends["touch"])
        return before | (data.curve.drive < ends["detachment"] - CLEARLY * data.span)
