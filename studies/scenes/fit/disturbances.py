"""What disturbs a measured force: noise, digits that are missing, spikes, interference."""

import math
from typing import NamedTuple

import numpy as np
from scipy import optimize
from scipy.special import chdtri

from energy.arrays import Array, Mask

LOOSE = 1.5  # standard deviation of residuals over the noise that may still be noise
RARE = 1e-4  # chance of larger residuals that are noise
WHOLE = 0.01  # by which multiples of a step may be off a whole number
STICKS_OUT = 8.0  # times the noise: a spike
APART = 3.0  # times what a line leaves of its four neighbours: a spike, and no jump or kink
WIDEST_SPIKE = 3  # points
OUTLYING = 6.0  # times the noise from a fit: by chance once in 5e8 points
NORMAL_MEDIAN = 0.6745  # of the absolute value of a normal variable
FEWEST = 24  # points in which waves are looked for
GROWTH = 1.2  # of the number of these points from one trial to the next
PERIODS = 1.25  # waves at least within them
MOST_WAVES = 30  # and at most
POINTS_PER_WAVE = 6  # at least
FINELY = 4  # numbers of waves that are tried, between n and n + 1 waves
LARGEST_WAVE = 0.2  # amplitude of waves over the range of all forces


def noise(force: Array) -> float:
    """Standard deviation of the noise on a smooth curve with few jumps, from third differences.

    0 for fewer than 8 points, which are too few.
    """
    if force.size < 8:
        return 0.0
    return float(np.median(np.abs(np.diff(force, 3)))) / (NORMAL_MEDIAN * math.sqrt(20))


def resolution(force: Array) -> float:
    """The step of which all forces are multiples, as digits were rounded; 0 if there is none.

    It is the least difference of unequal forces, if all other differences are multiples of it.
    """
    steps = np.diff(np.unique(force))
    if not steps.size:
        return 0.0
    multiples = steps / steps.min()
    whole = np.abs(multiples - np.round(multiples)) <= WHOLE
    return float(steps.min()) if whole.all() else 0.0


def may_be_noise(residuals: Array, fitted: int, sigma: float) -> bool:
    """Whether the residuals (n,) of so many fitted coefficients may be noise of this size.

    Their sum of squares is at most LOOSE² times its mean, or what noise exceeds as rarely as RARE.
    """
    spare = residuals.size - fitted
    limit = max(LOOSE**2 * spare, chdtri(spare, RARE)) * sigma**2
    return float(residuals @ residuals) <= limit


def without_spikes(force: Array) -> tuple[Mask, Array]:
    """Which points are spikes of up to three points, and the forces with these replaced (n,).

    A line is fitted to two neighbours on either side. A spike is farther from it than STICKS_OUT
    times the noise, and than APART times the range of the residuals of these four, which is large
    beside a jump or a kink. Its forces are replaced by those of the line.
    """
    spikes = np.zeros(force.size, bool)
    smooth = force.copy()
    clear = STICKS_OUT * noise(force)
    for width in range(1, WIDEST_SPIKE + 1):
        count = force.size - width - 3  # of places where four neighbours are known
        if count < 1 or not clear > 0:
            break
        places = np.array([0, 1, width + 2, width + 3])
        neighbours = np.stack([force[place : place + count] for place in places])
        offsets = places - places.mean()
        middle = neighbours.mean(axis=0)
        slope = offsets @ neighbours / (offsets @ offsets)
        left = neighbours - middle - np.outer(offsets, slope)
        least = np.maximum(clear, APART * np.ptp(left, axis=0))
        inner = np.arange(2, width + 2)
        line = middle + np.outer(inner - places.mean(), slope)
        off = np.stack([force[place : place + count] for place in inner]) - line
        for at in np.flatnonzero(np.all(np.abs(off) > least, axis=0)):
            spikes[at + inner] = True
            smooth[at + inner] = line[:, at]
    return spikes, smooth


def wave_columns(depth: Array, number: float) -> Array:
    """Cosine and sine with so many waves per length (n, 2)."""
    phase = 2 * math.pi * number * depth
    return np.stack([np.cos(phase), np.sin(phase)], axis=1)


class Waves(NamedTuple):
    """Interference in a force.

    Attributes
    ----------
    number : float
        Waves per length; 0 if there are none.
    points : int
        How many points show them.
    coefficients : ndarray (2,)
        Of `wave_columns`.
    """

    number: float
    points: int
    coefficients: Array


NO_WAVES = Waves(0.0, 0, np.zeros(2))


def first_waves(depth: Array, force: Array, least: int) -> Waves:
    """The waves in the force at the first points.

    A line with a cosine and a sine is fitted to `least` points and more, as long as the residuals
    may be noise.
    """
    sigma = noise(force)
    n = max(least, FEWEST)
    found = NO_WAVES
    while n <= force.size - 2:
        extent = abs(float(depth[n - 1] - depth[0]))
        most = min(MOST_WAVES, n // POINTS_PER_WAVE)
        if not extent > 0 or most < 1:
            break
        number = _nearest_number(depth[:n], force[:n], extent, most)
        _, off, coefficients = _leaves(depth[:n], force[:n], number)
        if not may_be_noise(off, 5, sigma):
            break
        found = Waves(number, n, coefficients)
        n = int(GROWTH * n)
    if not found.points:
        return NO_WAVES
    enough = found.number * abs(float(depth[found.points - 1] - depth[0])) >= PERIODS
    small = float(np.hypot(*found.coefficients)) <= LARGEST_WAVE * float(np.ptp(force))
    return found if enough and small else NO_WAVES


def _nearest_number(depth: Array, force: Array, extent: float, most: int) -> float:
    """Waves per length that leave least of a force (n,), 1 to `most` of them over its extent."""
    tried = np.arange(FINELY, FINELY * most + 1) / FINELY
    left = [_leaves(depth, force, waves / extent)[0] for waves in tried]
    near = tried[int(np.argmin(left))] / extent
    step = 1 / (FINELY * extent)
    found = optimize.minimize_scalar(
        lambda number: _leaves(depth, force, number)[0],
        bounds=(near - step, near + step),
        method="bounded",
        options={"xatol": 1e-4 * step},
    )
    return float(found.x)


def _leaves(depth: Array, force: Array, number: float) -> tuple[float, Array, Array]:
    """Sum of squares that a line with waves leaves, its residuals, and cosine and sine (2,)."""
    x = depth - depth[0]
    columns = np.column_stack([np.ones(x.size), x / np.ptp(x), wave_columns(depth, number)])
    line = np.linalg.lstsq(columns, force, rcond=None)[0]
    off = force - columns @ line
    return float(off @ off), off, line[2:]
