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
    places = np.cumsum(rng.uniform(2, 12, int(rng.integers(1, 6))))
    offsets = heights(rng, places.size, 0.3)
    return parabolas(places, offsets, 10 ** rng.uniform(0, 1.5)), float(offsets.min()), 0.5


def polygon(rng):
    """Straight pieces between random heights in a bowl; some of them equal."""
    x = np.unique(np.round(np.sort(rng.uniform(-15, 15, int(rng.integers(5, 40)))), 1))
    z = x**2 / (2 * 10 ** rng.uniform(1, 2)) + rng.uniform(0.01, 0.5) * rng.normal(size=x.size)
    z = np.round(z, 1) if rng.random() < 0.4 else z
    return Sampled(x, z), float(z.min()), float(2 * np.diff(x).min())


def plateau(rng):
    """Steps of several nodes of equal height each, or nearly equal."""
    x = np.linspace(-15, 15, int(rng.integers(5, 40)))
    z = np.floor(x**2 / (2 * 10 ** rng.uniform(1, 2)) / 0.2) * 0.2
    z = z + rng.choice([0.0, 0.1]) * rng.uniform(0, 1, x.size) * (rng.random(x.size) < 0.3)
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


def case(kind, seed):
    """A scene, its feature and its least height, and a programme that loads and unloads."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    indenter, low, feature = globals()[kind](rng)
    scene = bare(indenter, 10 ** rng.uniform(-0.6, 0.6))
    top = rng.uniform(0.05, 0.5)
    up = low + top * np.sort(rng.uniform(0, 1, int(rng.integers(1, 4))))
    near = low + top * 10.0 ** rng.choice([-12, -9, -6, -3])
    return scene, feature, low, np.array([low, *up, low + top, near, *up[::-1], low - 0.1 * top])
