"""Random scenes with rotational symmetry and their answers, over eight decades of length, stress.

The contact is one disc around the axis, of a radius that is drawn; depth, force and energy follow
from closed forms of the free surface and integrals over the profile. Small slopes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)
from studies.shared.random_cases import Case

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(40)
_T, _DT = (1 + _POINTS) / 2, _WEIGHTS / 2


def _sampled(a: float, rise: float, n: float) -> Indenter:
    r = np.linspace(0, 2.5 * a, 40)
    return Sampled(r, rise * a * ((r / a) ** 2 / 2 + n / 40 * (r / a) ** 4), kind="smooth")


def _cosh(a: float, rise: float, n: float) -> Indenter:
    steep = rise / math.sinh(1)
    return Profile(
        lambda x: a * steep * (np.cosh(np.asarray(x) / a) - 1),
        lambda x: steep * np.sinh(np.asarray(x) / a),
        extent=(0.0, 4 * a),
        convex=True,
    )


def _arc(a: float, rise: float, n: float) -> Indenter:
    return Circle(a * math.hypot(1, 1 / rise))


DRAWN: dict[str, Callable[[float, float, float], Indenter]] = {
    "flat": lambda a, rise, n: FlatPunch(a),
    "cone": lambda a, rise, n: Wedge(math.atan(rise)),
    "parabola": lambda a, rise, n: Parabola(a / rise),
    "power": lambda a, rise, n: PowerLaw(rise / (n * a ** (n - 1)), n),
    "circle": _arc,
    "sampled": _sampled,
    "function": _cosh,
    "sum": lambda a, rise, n: Parabola(2 * a / rise) + Wedge(math.atan(rise / 2)),
}
SHAPES = tuple(DRAWN)


def random_round_case(rng: np.random.Generator, shape: str) -> Case:
    """A state of the adhered branch with a/l in 10⁻³..10³ and δ₀/l in 0.01..1 in random units."""
    length, stress = 10.0 ** rng.uniform(-4, 4, 2)
    nu, thickness = rng.uniform(-0.5, 0.45), length * rng.uniform(0.1, 10)
    k = stress / length
    layer = ElasticLayer(k / ElasticLayer(1.0, nu, thickness).stiffness, nu, thickness)
    while True:
        a, alpha = length * 10 ** rng.uniform(-3, 3), 10 ** rng.uniform(-2, 0)
        indenter = DRAWN[shape](a, alpha * 10 ** rng.uniform(-1, 1), rng.uniform(1.5, 5))
        surfaces = SurfaceEnergies.from_work(k * length**2, k * (alpha * length) ** 2 / 2)
        scene = Scene(layer, surfaces, indenter, geometry="axisymmetric")
        least = resting_depth(scene, a)
        if shape == "flat":
            least *= -rng.uniform(-0.99, 2)
            break
        if resting_depth(scene, 0.9 * a) < resting_depth(scene, 0.95 * a) < least:
            break
    return Case(scene, least, a, *totals(scene, least, a), shape)


def resting_depth(scene: Scene, a: float) -> float:
    """The depth at which a line rests at this radius."""
    f, slope = (float(v(a)) for v in (scene.indenter.height, scene.indenter.slope))
    layer = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    return float(cards.axisymmetric.contact_line.depth(f, slope, a, **layer))


def totals(scene: Scene, d: float, a: float) -> tuple[float, float]:
    """Force and energy of a contact of radius a at a depth, small slopes."""
    k, gamma1, f = scene.stiffness, scene.gamma1, scene.indenter
    r, dr = _quadrature(f, a)
    displaced, slope = d - f.height(r), f.slope(r)
    edge = {"a": a, "k": k, "gamma1": gamma1}
    u_a, surface = d - float(f.height(a)), cards.axisymmetric.surface
    force = 2 * math.pi * k * float(displaced @ (r * dr)) + surface.force(u_a, **edge)
    density = k * displaced**2 + gamma1 * slope**2 - 2 * scene.work_of_adhesion
    energy = math.pi * float(density @ (r * dr)) + surface.energy(u_a, **edge)
    return float(force), float(energy)


def _quadrature(f: Indenter, a: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gauss points on [0, a], graded towards both ends, with weights; between corners and knots."""
    known = np.concatenate([np.asarray(f.corners, float), np.asarray(f.knots, float)])
    steep = a * (1 - 0.5 ** np.arange(1.0, 10.0))  # an arc is steep next to the line
    cuts = np.unique(np.concatenate([[0.0, a], known[(known > 0) & (known < a)], steep]))
    first = cuts[1]
    points = [first * _T**4] + [lo + (hi - lo) * _T for lo, hi in itertools.pairwise(cuts[1:])]
    weights = [4 * first * _T**3 * _DT] + [width * _DT for width in np.diff(cuts[1:])]
    return np.concatenate(points), np.concatenate(weights)
