"""Random scenes whose profiles are not convex, in several unit systems.

A shape is drawn in units of the elastocapillary length l along the surface and of α l upwards, with
α = √(2w/γ₁), in which the critical separation is 1. Each class of problem draws from all shapes.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from energy import ElasticLayer, FlatPunch, Profile, Sampled, Scene, SurfaceEnergies

HIGH = 6.0  # above its lowest point, a profile's ends must be out of reach


class Case(NamedTuple):
    """A scene, a depth, and the shortest length on which the profile varies."""

    kind: str
    shape: str
    scene: Scene
    depth: float
    feature: float
    scale: float  # of depths: δ₀, or what stands for it without adhesion
    above: float  # first touch, about


class Shape(NamedTuple):
    """A profile in units of l and α l: height, slope, half its extent, corners, feature."""

    height: Any
    slope: Any
    reach: float
    corners: tuple[float, ...]
    feature: float
    samples: Any = None


def _bowl(rng, low=-0.3, high=0.7):
    """R of the parabola under everything."""
    return 10 ** rng.uniform(low, high)


def _waves(R, waves, shift=0.0):
    """x²/(2R) and waves (height, wavelength, phase)."""
    amplitude, wavelength, phase = np.array(waves, float).T[:, :, None]
    q = 2 * np.pi / wavelength

    def height(x):
        x = np.asarray(x, float)
        each = amplitude * (1 - np.cos(q * x.ravel() + phase))
        return (x - shift) ** 2 / (2 * R) + np.sum(each, axis=0).reshape(x.shape)

    def slope(x):
        x = np.asarray(x, float)
        each = amplitude * q * np.sin(q * x.ravel() + phase)
        return (x - shift) / R + np.sum(each, axis=0).reshape(x.shape)

    highest = HIGH + 2 * float(np.sum(np.abs(amplitude)))
    reach = math.sqrt(2 * R * highest) + abs(shift)
    return Shape(height, slope, reach, (), float(wavelength.min()))


def ripples(rng, low=0.1, high=1.5):
    """Moderate ripples on a parabola, half of them mirror-symmetric about its lowest point."""
    m = 10 ** rng.uniform(-0.8, 0.5)
    phase = 0.0 if rng.random() < 0.5 else rng.uniform(0, 2 * np.pi)
    return _waves(_bowl(rng, 0.0, 1.0), [(rng.uniform(low, high) * m / (2 * np.pi), m, phase)])


def strong_ripples(rng):
    """Ripples several times steeper than the contact angle."""
    return ripples(rng, 1.5, 6.0)


def fine_ripples(rng):
    """Ripples shorter than l/16."""
    m = rng.uniform(0.02, 0.06)
    phase = rng.uniform(0, 2 * np.pi)
    return _waves(_bowl(rng, -1.0, -0.3), [(rng.uniform(0.1, 3.0) * m / (2 * np.pi), m, phase)])


def cosines(rng):
    """Sums of cosines of random lengths, heights and phases."""
    lengths = 10 ** rng.uniform(-0.6, 0.5, rng.integers(2, 6))
    rise = rng.uniform(0.1, 3.0)
    waves = [
        (rise * m / (2 * np.pi) * rng.uniform(0.2, 1), m, rng.uniform(0, 2 * np.pi))
        for m in lengths
    ]
    return _waves(_bowl(rng, 0.0, 1.0), waves, rng.uniform(-0.5, 0.5))


def bumps(rng):
    """Several bumps of different widths and heights."""
    R = _bowl(rng, 0.5, 1.3)
    n = rng.integers(2, 6)
    width = 10 ** rng.uniform(-1.2, 0.0, n)[:, None]
    at = rng.uniform(-2, 2, n)[:, None]
    deep = rng.uniform(1.0, 2.0, n)[:, None] * np.minimum(1.0, 2 * width)

    def height(x):
        x = np.asarray(x, float)
        t = (x.ravel() - at) / width
        return x**2 / (2 * R) - np.sum(deep * np.exp(-t * t / 2), axis=0).reshape(x.shape)

    def slope(x):
        x = np.asarray(x, float)
        t = (x.ravel() - at) / width
        down = np.sum(deep / width * t * np.exp(-t * t / 2), axis=0).reshape(x.shape)
        return x / R + down

    return Shape(height, slope, math.sqrt(2 * R * HIGH) + 2, (), 3 * float(width.min()))


def cup(rng):
    """Two lips with a hollow between them, tilted."""
    c = 10 ** rng.uniform(-0.7, 0.5)
    deep = rng.uniform(0.1, 3.0)
    tilt = rng.uniform(-0.3, 0.3)

    def height(x):
        t = (np.asarray(x, float) / c) ** 2
        return deep * (t - 1) ** 2 + tilt * np.asarray(x, float)

    def slope(x):
        x = np.asarray(x, float)
        return 4 * deep * (x / c**2) * ((x / c) ** 2 - 1) + tilt

    reach = c * math.sqrt(1 + math.sqrt((HIGH + 3 * c * abs(tilt)) / deep))
    return Shape(height, slope, reach, (), c / 2)


def tip(R, shift, reach, feature):
    """One parabola off the origin."""
    return Shape(
        lambda x: (np.asarray(x, float) - shift) ** 2 / (2 * R),
        lambda x: (np.asarray(x, float) - shift) / R,
        reach,
        (),
        feature,
    )


def tiny(rng):
    """A sharp or a blunt tip off the origin, in a long body: contacts from 1e-6 l on."""
    R = 10 ** rng.uniform(-6, 0)
    shift = rng.uniform(-1, 1)
    return tip(R, shift, abs(shift) + 10 ** rng.uniform(0, 1), 0.3)


def wedge(rng):
    """A wedge with ripples: a corner at its tip."""
    m = 10 ** rng.uniform(-0.5, 0.3)
    steep = rng.uniform(0.3, 2.0)
    rise = rng.uniform(0.1, 1.0) * steep
    a = rise * m / (2 * np.pi)
    q = 2 * np.pi / m
    return Shape(
        lambda x: steep * np.abs(x) + a * (1 - np.cos(q * np.asarray(x, float))),
        lambda x: steep * np.sign(x) + a * q * np.sin(q * np.asarray(x, float)),
        (HIGH + 2 * a) / steep,
        (0.0,),
        m,
    )


def rough(rng):
    """A measured rough profile through a spline."""
    R = _bowl(rng, -0.2, 0.5)
    n = int(rng.integers(24, 90))
    reach = math.sqrt(2 * R * (HIGH + 1))
    x = np.linspace(-reach, reach, n)
    frequency = np.fft.rfftfreq(n)
    highest = rng.uniform(0.1, 0.5)
    amplitude = np.maximum(frequency, 3 / n) ** -1.3
    amplitude = amplitude * ((frequency > 0) & (frequency < highest))
    phase = np.exp(2j * np.pi * rng.random(frequency.size))
    z = np.fft.irfft(amplitude * phase, n)
    z *= 10 ** rng.uniform(-1, 0) / (z.std() or 1)
    samples = (x, x**2 / (2 * R) + z)
    return Shape(None, None, reach, (), 4 * (x[1] - x[0]), samples)


SHAPES = (
    ripples, strong_ripples, fine_ripples, cosines, bumps, cup, tiny, wedge, rough,
)  # fmt: skip
KINDS = ("small", "finite", "no_adhesion", "no_tension", "global", "edges")  # of bodies that end


def built(shape, length, rise):
    """The indenter with this shape, length and height."""
    if shape.samples is not None:
        x, z = shape.samples
        return Sampled(x * length, z * rise, kind="smooth")
    return Profile(
        lambda x: rise * shape.height(np.asarray(x, float) / length),
        lambda x: rise / length * shape.slope(np.asarray(x, float) / length),
        extent=(-shape.reach * length, shape.reach * length),
        corners=[c * length for c in shape.corners],
    )


def ended(rng, shape):
    """Half the width of a body that ends where it may be in contact."""
    return float(min(10 ** rng.uniform(-0.7, 0.7), 0.9 * shape.reach))


def case_of(kind, seed):
    """The random scene of this class and seed."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    unit = 10 ** rng.choice([0.0, 0.0, 3.0, -3.0, -6.0])
    stress = 10 ** rng.choice([0.0, 6.0, -6.0])
    length = float(unit * rng.uniform(0.1, 3))
    layer = ElasticLayer(float(stress * rng.uniform(0.3, 3)), float(rng.choice([0.0, 0.3])), length)
    gamma1 = layer.stiffness * length**2
    alpha = float(10 ** rng.uniform(-2, -0.5))
    w = gamma1 * alpha**2 / 2
    if kind == "finite":
        w = 2 * gamma1 * math.sin(alpha / 2) ** 2
    if kind == "no_adhesion":
        w = 0.0
    draw = SHAPES[rng.integers(len(SHAPES))]
    shape = draw(rng)
    scale = alpha * length
    indenter = built(shape, length, scale)
    if kind == "edges":
        indenter += FlatPunch(ended(rng, shape) * length)
    tension = 0.0 if kind == "no_tension" else gamma1
    scene = Scene(
        layer,
        SurfaceEnergies.from_work(tension, w),
        indenter,
        slopes="finite" if kind == "finite" else "small",
    )
    x = np.linspace(*indenter.extent, 20001)
    lowest = float(np.min(indenter.height(x)))
    above = scale * float(_deep(rng, kind, draw))
    return Case(kind, draw.__name__, scene, lowest + above, shape.feature * length, scale, above)


def _deep(rng, kind, draw):
    """Depth above first touch, in δ₀."""
    above = rng.uniform(0, 4) if rng.random() < 0.75 else 10 ** rng.uniform(-6, 0)
    if kind == "finite" and draw is fine_ripples:
        above *= 0.3  # fewer contacts: their gaps take time
    if draw is tiny:
        above = 10 ** rng.uniform(-6, 0)
    if kind == "no_adhesion" or rng.random() < 0.8:
        return above
    return -rng.uniform(0, 1)
