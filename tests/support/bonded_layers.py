"""Scenes of a bonded layer with its exact response, fixed and random, in any units."""

import math

import numpy as np

from energy import ElasticLayer, FlatPunch, Parabola, PowerLaw, Scene, SurfaceEnergies, Wedge
from energy.indenter import Indenter

GEOMETRIES = ("line", "axisymmetric")
BODIES = ("parabola", "power law", "wedge", "punch")


class FlatTo(Indenter):
    """Flat up to a corner at c, rising with a slope beyond."""

    apex = 0.0
    symmetric = True
    convex = True
    complete = True

    def __init__(self, c, rise):
        self.c = c
        self.rise = rise
        self.corners = (-c, c)

    def height(self, x):
        return self.rise * np.maximum(np.abs(x) - self.c, 0.0)

    def slope(self, x):
        return self.rise * np.sign(x) * (np.abs(x) > self.c)


def layer(nu, *, unit=1.0, stress=1.0, response="layer"):
    """A layer of thickness and shear modulus 1, in these units."""
    return ElasticLayer(2 * (1 + nu) * stress, nu, unit, response=response)


def scene_of(body, nu=0.45, gamma=0.7, w=0.01, geometry="line", *, opening=None, **given):
    """γ₁ and works of adhesion over Gh; the body in units of the layer's thickness."""
    tension = given.get("unit", 1.0) * given.get("stress", 1.0)
    surfaces = SurfaceEnergies.from_work(gamma * tension, w * tension)
    opened = None
    if opening is not None:
        opened = SurfaceEnergies.from_work(gamma * tension, opening * tension)
    return Scene(layer(nu, **given), surfaces, body, geometry=geometry, opening=opened)


QUANTITIES = ("half_width", "force", "energy")


def off(one, other):
    """Differences of half-width, force and energy, over the scales of the other's estimates."""
    scales = [other.half_width, other.scales["force"], other.scales["energy"]]
    return np.abs([getattr(one, q) - getattr(other, q) for q in QUANTITIES]) / scales


def body_of(kind, a, rise, n=3.0):
    """A body whose slope is `rise` at a, or that ends there."""
    return {
        "parabola": lambda: Parabola(a / rise),
        "power law": lambda: PowerLaw(rise / n * a ** (1 - n), n),
        "wedge": lambda: Wedge(math.atan(rise)),
        "punch": lambda: FlatPunch(a),
    }[kind]()


def random_scene(rng, kind, geometry, *, widest=1.5, nu=None):
    """A scene, a depth at which it is in contact for most choices, and about how wide."""
    if nu is None:
        incompressible = 0.5
        any_ratio = rng.uniform(-0.9, 0.5)
        soft = rng.uniform(0.3, 0.5)
        nu = float(rng.choice([incompressible, any_ratio, soft]))
    gamma = 10 ** rng.uniform(-2, 2)
    a = 10 ** rng.uniform(-1, widest)
    rise = 0.1 * 10 ** rng.uniform(-0.5, 0.5)
    exponent = float(rng.uniform(1.5, 4))
    body = body_of(kind, a, rise, exponent)
    deepest = 0.5 if kind == "punch" else 0.7
    depth = rise * a * rng.uniform(-0.02, deepest)
    return scene_of(body, nu, gamma, gamma * 0.005, geometry), depth, a
