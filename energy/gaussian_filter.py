"""The Gaussian profile filter of surface metrology (ISO 16610-21).

The filtered height is the mean of the heights with the weight

    s(x) = exp(-π (x / (α λ))²) / (α λ),    α = √(ln 2 / π) = 0.4697,

of a sample at the distance x, which passes half of a wave of length λ, the cut-off. Waves much
shorter than λ are removed, much longer ones stay: with this filter λ is the cut-off λs of a
profilometer. The weights end at |x| = λ, beyond which are 1e-7 of them. Nearer than that to an end
of the profile samples are missing: this end-effect region is left out.
"""

import math

import numpy as np

from energy.arrays import Array

ALPHA = math.sqrt(math.log(2) / math.pi)
REACH = 1.0  # of the cut-off: the standard's L_c for a reference filter
# Samples whose distances differ by less than this share of the median count as evenly spaced.
# Taking them so moves a height by the slope times a millionth of the cut-off at most: over that
# many samples their distances add up.
_EVEN = 1e-6
_LEAST_WIDTH = 2.0  # spacings: a shorter cut-off passes all waves that the samples can hold


def filtered(x: Array, z: Array, cutoff: float) -> tuple[Array, Array]:
    """Positions and heights of a profile without its short waves.

    Parameters
    ----------
    x, z : ndarray (n,)
        Increasing positions and heights [length]. Samples that are not evenly spaced are first
        interpolated on straight lines, at the median of their distances.
    cutoff : float
        Length of the waves λ of which half the amplitude passes [length].

    Returns
    -------
    x, z : ndarray (m,)
        Evenly spaced, without the end-effect region of length λ on either side.

    Raises
    ------
    ValueError
        If the cut-off is shorter than two spacings, or leaves fewer than three samples.
    """
    spacings = np.diff(x)
    typical = float(np.median(spacings))
    if np.ptp(spacings) > _EVEN * typical:
        count = math.ceil((x[-1] - x[0]) / typical)
        even = np.linspace(x[0], x[-1], count + 1)
        z = np.interp(even, x, z)
        x = even
    spacing = float(x[-1] - x[0]) / (x.size - 1)
    if cutoff < _LEAST_WIDTH * spacing:
        raise ValueError(
            f"cutoff = {cutoff!r} is shorter than two spacings of the samples, {2 * spacing!r}: it "
            "filters nothing; give a longer one, or none"
        )
    edge = math.ceil(REACH * cutoff / spacing)
    if x.size < 2 * edge + 3:
        raise ValueError(
            f"cutoff = {cutoff!r}: the profile is {float(x[-1] - x[0])!r} long, and a cut-off at "
            "each end is lost; give a shorter one"
        )
    distance = spacing * np.arange(-edge, edge + 1)
    weights = np.exp(-np.pi * (distance / (ALPHA * cutoff)) ** 2)
    weights /= weights.sum()
    smooth = np.convolve(z, weights, mode="valid")
    return x[edge:-edge], smooth
