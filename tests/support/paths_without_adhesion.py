"""Random bodies without adhesion with programmes of depths: a hull gives their load paths."""

import numpy as np
from truth.paths.random_paths import envelope

from energy import Profile, Sampled

from .example_scenes import plain

KINDS = ("tips", "polygon", "plateau", "punches")


def bare(indenter, length=1.0):
    """A scene without adhesion, k = 1."""
    return plain(indenter, w=0.0, gamma1=length**2)


def heights(rng, count, scale):
    """Least heights of several tips: equal, apart by rounding and more, and different."""
    kind = rng.integers(4)
    if kind == 0:
        return np.zeros(count)
    if kind == 1:
        return 1e-9 * scale * rng.integers(0, 3, count)
    if kind == 2:
        return scale * 10 ** rng.uniform(-14, -1, count) * rng.integers(0, 2, count)
    return scale * rng.uniform(0, 1, count)


def parabolas(places, offsets, R=10.0, reach=40.0):
    """The lower envelope of equal parabolas."""
    height, slope, corners = envelope(R, places, offsets)
    return Profile(height, slope, (places[0] - reach, places[-1] + reach), corners)


def tips(rng):
    """Round tips."""
    count = int(rng.integers(1, 6))
    places = np.cumsum(rng.uniform(2, 12, count))
    offsets = heights(rng, count, 0.3)
    radius = 10 ** rng.uniform(0, 1.5)
    return parabolas(places, offsets, radius), float(offsets.min()), 0.5


def polygon(rng):
    """Straight pieces between random heights in a bowl; some of them equal."""
    count = int(rng.integers(5, 40))
    x = np.unique(np.round(np.sort(rng.uniform(-15, 15, count)), 1))
    bowl = x**2 / (2 * 10 ** rng.uniform(1, 2))
    roughness = rng.uniform(0.01, 0.5) * rng.normal(size=x.size)
    z = bowl + roughness
    if rng.random() < 0.4:
        z = np.round(z, 1)  # some heights are equal
    return Sampled(x, z), float(z.min()), float(2 * np.diff(x).min())


def plateau(rng):
    """Steps of several nodes of equal height each, or nearly equal."""
    x = np.linspace(-15, 15, int(rng.integers(5, 40)))
    bowl = x**2 / (2 * 10 ** rng.uniform(1, 2))
    steps = np.floor(bowl / 0.2) * 0.2
    size = rng.choice([0.0, 0.1])
    noise = rng.uniform(0, 1, x.size)
    noisy = rng.random(x.size) < 0.3
    z = steps + size * noise * noisy
    return Sampled(x, z), float(z.min()), 0.25


def punches(rng):
    """Flat faces with steep sides."""
    offsets = heights(rng, int(rng.integers(1, 6)), 0.3)
    x = []
    z = []
    at = 0.0
    for offset in offsets.tolist():
        side = rng.uniform(0.1, 2)
        wide = rng.uniform(0.2, 6)
        x += [at, at + side, at + side + wide, at + 2 * side + wide]
        z += [2.0, offset, offset, 2.0]
        at = x[-1] + rng.uniform(1, 8)
    x = np.array([x[0] - 30, *x, x[-1] + 30])
    z = np.array([32.0, *z, 32.0])
    return Sampled(x, z), float(z.min()), 0.5


BODIES = {"tips": tips, "polygon": polygon, "plateau": plateau, "punches": punches}


def case(kind, seed):
    """A scene, its feature and its least height, and a programme that loads and unloads."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    indenter, low, feature = BODIES[kind](rng)
    scene = bare(indenter, 10 ** rng.uniform(-0.6, 0.6))
    top = rng.uniform(0.05, 0.5)
    count = int(rng.integers(1, 4))
    loading = low + top * np.sort(rng.uniform(0, 1, count))
    just_in_contact = low + top * 10.0 ** rng.choice([-12, -9, -6, -3])
    out_of_contact = low - 0.1 * top
    depths = [low, *loading, low + top, just_in_contact, *loading[::-1], out_of_contact]
    return scene, feature, low, np.array(depths)
