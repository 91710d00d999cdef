"""What the study of the layer measures, one case at a time: functions that processes can call.

Units: h = E = 1; w/γ₁ only sets the scale of displacements.
"""

import math
import statistics
import time
from dataclasses import replace
from typing import NamedTuple

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards

GENTLE = 1e-6  # w/γ₁
SLOPE = math.sqrt(2 * GENTLE)  # at the line
RTOL, FINE, EXACT = 1e-4, 1e-7, 1e-10
WIDE = 15.0  # half-width in h from which Eq. (16) is read
WEAK, STRONG = 1e-3, 1e2  # γ₁ over the least and the most that can withstand it
BEYOND = 3.3  # of πwR: no sphere bears as much


def scene_of(nu: float, gamma1: float, R: float, geometry: str = "axisymmetric") -> Scene:
    """A parabola, or the sphere it is about an axis, on the layer."""
    layer = ElasticLayer(1.0, nu, 1.0, response="layer")
    surfaces = SurfaceEnergies.from_work(gamma1, GENTLE * gamma1)
    return Scene(layer, surfaces, Parabola(R), geometry=geometry)


class Angle(NamedTuple):
    """π - θ over √(2w/γ₁) on nodes, for this h over √(γ₁h/G); error: of the extrapolation."""

    nu: float
    thickness: float
    measured: float
    error: float


def angle(case: tuple[float, float, int]) -> Angle:
    """ν, thickness, and nodes on each side of a cylinder that is about as wide as h."""
    nu, thickness, nodes = case
    scene = scene_of(nu, 1 / (2 * (1 + nu) * thickness**2), 1 / SLOPE, "line")
    a = minimise(scene, SLOPE, rtol=RTOL).half_width
    spacings = (a * part / nodes for part in (4, 2, 1))
    states = (minimise(scene, SLOPE, method="lattice", spacing=s) for s in spacings)
    first, second, third = (state.angle_deficit / SLOPE for state in states)
    before, last = 2 * second - first, 2 * third - second
    return Angle(nu, thickness, last, abs(last - before))


class Length(NamedTuple):
    """The length in Eq. (16), over h: measured and ℓ, for this l/h."""

    nu: float
    ratio: float
    measured: float
    effective: float


def length(case: tuple[float, float]) -> Length:
    """ν and l/h: a cylinder moved between two depths, L = R Δd/Δa - a."""
    nu, ratio = case
    R = WIDE**2 / SLOPE
    scene = scene_of(nu, ElasticLayer(1.0, nu, 1.0).stiffness * ratio**2, R, "line")
    d = WIDE**2 / (2 * R)
    narrow, wide = (minimise(scene, depth, rtol=FINE).half_width for depth in (d, 2 * d))
    measured = R * d / (wide - narrow) - (wide + narrow) / 2
    return Length(nu, ratio, measured, scene.effective_length)


class Pull(NamedTuple):
    """Where a dead load pulls a sphere off: a/h, force over πwR; tension: "weak" or "strong"."""

    nu: float
    tension: str
    radius: float
    force: float


def pull(case: tuple[float, str, float]) -> Pull:
    """ν, tension, and about which a/h."""
    nu, tension, about = case
    if tension == "strong":  # a = R √(w/2γ₁)
        gamma1 = STRONG * about * max(about, 1.0)
        return Pull(nu, tension, *pulled(scene_of(nu, gamma1, 2 * about / SLOPE)))
    thin = about**6 / 288
    if nu < 0.5:
        thin = min(thin, about**4 * ElasticLayer(1.0, nu, 1.0).modulus / 8)
    gamma1 = WEAK * min(about, 1.0)
    R = math.sqrt((about**3 / 3 + thin) / (GENTLE * gamma1))  # wR²/(Eh³) of half-space and thin
    return Pull(nu, tension, *pulled(scene_of(nu, gamma1, R)))


def pulled(scene: Scene) -> tuple[float, float]:
    """Radius and force over πwR of the largest pull that a sphere bears."""
    unit = math.pi * scene.work_of_adhesion * float(scene.indenter.R)  # type: ignore[attr-defined]
    found = load_path(scene, forces=[0.0, -BEYOND * unit], rtol=RTOL).pull_off
    return found.half_width, -found.force / unit


class Springs(NamedTuple):
    """What springs put too high, relatively, in force and radius at pull-off of a sphere."""

    nu: float
    ratio: float
    Lambda: float
    force: float
    radius: float


def springs(case: tuple[float, float, float]) -> Springs:
    """ν, l/h and Λ = l/√(Rδ₀)."""
    nu, ratio, Lambda = case
    k, R = ElasticLayer(1.0, nu, 1.0).stiffness, ratio / (SLOPE * Lambda**2)
    scene = scene_of(nu, k * ratio**2, R)
    radius, force = pulled(scene)
    w = scene.work_of_adhesion
    card = cards.axisymmetric.sphere.pull_off(R=R, k=k, gamma1=scene.gamma1, w=w)
    off = -card.force / (math.pi * w * R) / force - 1, card.half_width / radius - 1
    return Springs(nu, ratio, Lambda, *map(float, off))


class Accuracy(NamedTuple):
    """Largest errors of a and of P, over its terms; processor time, and over that of springs."""

    geometry: str
    rtol: float
    half_width: float
    force: float
    milliseconds: float
    over_springs: float


def accuracy(case: tuple[str, float]) -> Accuracy:
    """Geometry and rtol: a cylinder or sphere at a few depths, medians of their times."""
    geometry, rtol = case
    scene = scene_of(0.45, 0.3, 1 / SLOPE, geometry)
    springs = replace(scene, layer=replace(scene.layer, response="springs"))
    off, times = [], []
    for depth in (SLOPE * part / 10 for part in range(-1, 10)):
        exact, state = minimise(scene, depth, rtol=EXACT), minimise(scene, depth, rtol=rtol)
        moved, pushed = state.half_width - exact.half_width, state.force - exact.force
        off.append((abs(moved) / exact.half_width, abs(pushed) / exact.scales["force"]))
        times.append([timed(one, depth, rtol) for one in (scene, springs)])
    own, other = (statistics.median(each) for each in zip(*times, strict=True))
    width, force = (max(each) for each in zip(*off, strict=True))
    return Accuracy(geometry, rtol, width, force, 1e3 * own, own / other)


def timed(scene: Scene, depth: float, rtol: float) -> float:
    """Processor time of a state with its error estimate [s], the least of three."""
    times = []
    for _ in range(3):
        start = time.process_time()
        _ = minimise(scene, depth, rtol=rtol).error_estimate
        times.append(time.process_time() - start)
    return min(times)
