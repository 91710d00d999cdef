"""What the study of the layer measures, one case at a time: functions that processes can call.

Units: h = E = 1; w/γ₁ only sets the scale of displacements.
"""

import math
from typing import NamedTuple

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards

GENTLE = 1e-6  # w/γ₁
RTOL, LENGTH_RTOL = 1e-4, 1e-7
WIDE = 15.0  # half-width in h from which Eq. (16) is read
WEAK, STRONG = 1e-3, 1e2  # γ₁ least and most, over E a and what h changes
BEYOND = 3.3  # of πwR: no sphere bears as much


def scene_of(
    nu: float, gamma1: float, w: float, R: float, geometry: str = "axisymmetric", E: float = 1.0
) -> Scene:
    """A parabola, or the sphere it is about an axis, on the layer."""
    layer = ElasticLayer(E, nu, 1.0, response="layer")
    return Scene(layer, SurfaceEnergies.from_work(gamma1, w), Parabola(R), geometry=geometry)


class Angle(NamedTuple):
    """π - θ over √(2w/γ₁), measured on nodes, for this h over √(γ₁h/G).

    Extrapolated from two distances of nodes; error: what that changes from the two before.
    """

    nu: float
    thickness: float
    measured: float
    error: float


def angle(case: tuple[float, float, int]) -> Angle:
    """ν, thickness, and nodes on each side of a cylinder that is about as wide as h."""
    nu, thickness, nodes = case
    gamma1 = 1 / (2 * (1 + nu) * thickness**2)
    unit = math.sqrt(2 * GENTLE)
    scene = scene_of(nu, gamma1, GENTLE * gamma1, 1 / unit, "line")
    a = minimise(scene, unit, rtol=RTOL).half_width
    found = [
        minimise(scene, unit, method="lattice", spacing=a / n).angle_deficit / unit
        for n in (nodes / 4, nodes / 2, nodes)
    ]
    before, last = 2 * found[1] - found[0], 2 * found[2] - found[1]
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
    gamma1 = ElasticLayer(1.0, nu, 1.0).stiffness * ratio**2
    R = WIDE**2 / math.sqrt(2 * GENTLE)
    scene = scene_of(nu, gamma1, GENTLE * gamma1, R, "line")
    depths = [part * WIDE**2 / (2 * R) for part in (1.0, 2.0)]
    narrow, wide = (minimise(scene, d, rtol=LENGTH_RTOL).half_width for d in depths)
    measured = R * (depths[1] - depths[0]) / (wide - narrow) - (wide + narrow) / 2
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
    thin = about**6 / 288
    if nu < 0.5:
        thin = min(thin, about**4 * ElasticLayer(1.0, nu, 1.0).modulus / 8)
    stuck = about**3 / 3 + thin  # wR²/(Eh³)
    gamma1 = WEAK * min(about, 1.0)
    if tension == "strong":
        gamma1 = STRONG * about * max(about, 1.0)
        stuck = 2 * gamma1 * about**2  # a = R √(w/2γ₁)
    w = GENTLE * gamma1
    return Pull(nu, tension, *_pulled(scene_of(nu, gamma1, w, math.sqrt(stuck / w))))


def _pulled(scene: Scene) -> tuple[float, float]:
    R, w = float(scene.indenter.R), scene.work_of_adhesion  # type: ignore[attr-defined]
    unit = math.pi * w * R
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
    k = ElasticLayer(1.0, nu, 1.0).stiffness
    gamma1 = k * ratio**2
    R = ratio / (math.sqrt(2 * GENTLE) * Lambda**2)
    scene = scene_of(nu, gamma1, GENTLE * gamma1, R)
    radius, force = _pulled(scene)
    given = {"R": R, "k": k, "gamma1": gamma1, "w": scene.work_of_adhesion}
    card = cards.axisymmetric.sphere.pull_off(**given)
    unit = math.pi * R * scene.work_of_adhesion
    off = float(-card.force / unit / force - 1), float(card.half_width / radius - 1)
    return Springs(nu, ratio, Lambda, *off)
