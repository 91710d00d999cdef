"""Random load paths under a dead load or a machine, over profiles with one and several contacts.

A class is a control and what adheres: load_small, machine_opening, ... Lengths, heights and units
are drawn as in random_states.py; a programme goes up, down, up again and down until the contact is
lost.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from energy import ElasticLayer, FlatPunch, Patches, Scene, SurfaceEnergies

from .. import random_states
from ..random_states import HIGH, Shape, built

FORCES = ("small", "opening", "pattern", "no_adhesion", "no_tension")
PATH_KINDS = tuple(f"{hold}_{what}" for hold in ("load", "machine") for what in FORCES)
PATH_KINDS += ("load_edges", "machine_edges")  # of bodies that end
STEPS = (6, 4, 4, 7)  # values on each way


class PathCase(NamedTuple):
    """A scene, what holds the indenter, and how far the programme goes.

    stiffness: K, 0 for a dead load. deep: of the first way above first touch, in depth scales;
    back, again: shares of the second and third way of those before.
    """

    kind: str
    shape: str
    scene: Scene
    feature: float
    scale: float
    length: float
    stiffness: float
    deep: float
    back: float
    again: float


def parabola(rng):
    """One tip, off the origin."""
    R = 10 ** rng.uniform(-0.5, 1.3)
    shift = rng.uniform(-1, 1)
    return random_states.tip(R, shift, abs(shift) + math.sqrt(2 * R * HIGH), 1.0)


def tips(rng):
    """The lower of two or three parabolas, with corners between them."""
    n = int(rng.integers(2, 4))
    R = 10 ** rng.uniform(-0.5, 0.7, n)
    at = np.cumsum(rng.uniform(1.0, 5.0, n))
    at -= at.mean()
    top = rng.uniform(0, 1.5, n)
    reach = float((np.abs(at) + np.sqrt(2 * R * (HIGH + 2))).max())
    height, slope, corners = envelope(R, at, top)
    return Shape(height, slope, reach, corners, 1.0)


def envelope(R, at, top):
    """Height, slope and corners of the lowest of parabolas of these radii, places and heights."""
    R, at, top = np.broadcast_arrays(R, np.asarray(at, float), top)

    def every(x):
        return (np.asarray(x, float)[..., None] - at) ** 2 / (2 * R) + top

    def slope(x):
        own = every(x).argmin(axis=-1)
        return (np.asarray(x, float) - at[own]) / R[own]

    return lambda x: every(x).min(axis=-1), slope, _corners(R, at, top)


def _corners(R, at, top):
    """Where two of the parabolas meet and no other is lower."""
    found = []
    for i in range(R.size):
        for j in range(i):
            a = 1 / (2 * R[i]) - 1 / (2 * R[j])
            b = at[j] / R[j] - at[i] / R[i]
            c = at[i] ** 2 / (2 * R[i]) + top[i] - at[j] ** 2 / (2 * R[j]) - top[j]
            for x in np.roots([a, b, c]) if a else [-c / b]:
                heights = (np.real(x) - at) ** 2 / (2 * R) + top
                if np.isreal(x) and heights[i] <= heights.min() + 1e-12:
                    found.append(float(np.real(x)))
    return tuple(sorted(found))


def polygon(rng):
    """A measured profile of straight pieces."""
    R = 10 ** rng.uniform(0.0, 0.7)
    n = int(rng.integers(8, 30))
    reach = math.sqrt(2 * R * (HIGH + 1))
    x = np.linspace(-reach, reach, n)
    x[1:-1] += rng.uniform(-0.3, 0.3, n - 2) * (x[1] - x[0])
    highest = 10 ** rng.uniform(-1.5, 0)
    z = x**2 / (2 * R) + rng.uniform(0, highest, n)
    feature = min(1.0, float(np.diff(x).min()))
    return Shape(None, None, reach, (), feature, (x, z))


def waves(rng):
    """A parabola with one or two waves of about the elastocapillary length."""
    lengths = 10 ** rng.uniform(-0.2, 0.7, rng.integers(1, 3))
    rise = 10 ** rng.uniform(-1.0, 0.5)
    return random_states._waves(
        10 ** rng.uniform(-0.3, 0.7),
        [(rise * m / (2 * np.pi), m, rng.uniform(0, 2 * np.pi)) for m in lengths],
        rng.uniform(-0.5, 0.5),
    )


SHAPES = (
    parabola,
    tips,
    polygon,
    waves,
    waves,
    random_states.cup,
    random_states.wedge,
    random_states.rough,
)


def path_case(kind, seed):
    """The random load path of this class and seed."""
    rng = np.random.default_rng([100 + PATH_KINDS.index(kind), seed])
    hold, what = kind.split("_", 1)
    unit = 10 ** rng.choice([0.0, 0.0, 3.0, -3.0])
    stress = 10 ** rng.choice([0.0, 6.0, -6.0])
    length = float(unit * rng.uniform(0.1, 3))
    layer = ElasticLayer(float(stress * rng.uniform(0.3, 3)), float(rng.choice([0.0, 0.3])), length)
    k = layer.stiffness
    alpha = float(10 ** rng.uniform(-2, -0.5))
    gamma1 = k * length**2
    scale = alpha * length
    w = gamma1 * alpha**2 / 2
    draw = SHAPES[rng.integers(len(SHAPES))]
    shape = draw(rng)
    indenter = built(shape, length, scale)
    if draw is polygon:
        indenter = replace(indenter, kind="linear")
    if what == "edges":
        indenter += FlatPunch(random_states.ended(rng, shape) * length)
    surfaces = SurfaceEnergies.from_work
    tension = gamma1 * (what != "no_tension")
    held = w * (what != "no_adhesion")
    scene = Scene(layer, surfaces(tension, held), indenter)
    if what == "opening" or (what == "edges" and rng.random() < 0.3):
        scene = replace(scene, opening=surfaces(gamma1, w * 10 ** rng.uniform(0.02, 0.7)))
    if what == "pattern":
        scene = replace(scene, pattern=_patches(rng, length))
    K = k * length * 10 ** (rng.uniform(-1.5, 2) if rng.random() < 0.75 else rng.uniform(2, 8))
    return PathCase(
        kind, draw.__name__, scene, shape.feature * length, scale, length,
        float(K) if hold == "machine" else 0.0, float(rng.uniform(0.1, 2.5)),
        float(rng.uniform(0.1, 0.9)), float(rng.uniform(0.1, 1.2)),
    )  # fmt: skip


def _patches(rng, length):
    """Patches of different widths about the origin."""
    n = int(rng.integers(1, 6))
    edges = np.cumsum(rng.uniform(0.2, 2.0, n)) * length
    edges -= rng.uniform(edges[0], edges[-1]) if n > 1 else edges[0] * rng.uniform(0, 2)
    return Patches(edges.tolist(), (10 ** rng.uniform(-0.7, 0.3, n + 1)).tolist())


def programme(case, reading):
    """Values of the control: up, down, up again, and down until the contact is lost.

    reading: of the case, before its path has begun.
    """
    path = reading.path
    free = reading.control.value(reading.path.touch, 0.0)
    deepest = path.moved(reading.place, path.touch + case.deep * case.scale)
    least = reading.control.value(0.1 * case.scale, 0.2 * case.scale * case.scene.stiffness
                                  * case.length)  # fmt: skip
    top = max(reading.reached(deepest), free + least)
    low = free
    place = deepest
    while place.lines and place.depth > path.touch - 3 * case.scale:
        low = min(low, reading.reached(place))
        place = path.moved(place, place.depth - case.scale / 10)
    back = top - case.back * (top - low)
    again = back + case.again * (top - back)
    ends = (top, back, again, low - 0.15 * (top - low))
    values = [free + 0.02 * (top - free)]
    for end, count in zip(ends, STEPS, strict=True):
        values += np.linspace(values[-1], end, count + 1)[1:].tolist()
    return np.array(values)
