"""The size of the noise of measured heights, from the profile that they measure.

Neighbouring samples of a profile that they resolve follow from each other: the residual of sample i
in the polynomial through m of its neighbours, with the weights c_j of the divided difference

    r_i = Σ_j c_j z_{i+jp} / √(Σ_j c_j²),    c_j = 1/Π_{k≠j} (x_{i+jp} - x_{i+kp}),   j = 0 … m,

is small where the profile is smooth (m = 8: a thousandth of the height of a wave with 8 samples),
0 between the corners of straight pieces (m = 2), on level pieces (m = 1) and where the profile
repeats itself every p samples. Of white noise of rms σ its rms is σ for all m and p. Its lower
quartile is read, since a corner spoils the residuals of a few samples alone, and of all m and p the
least: what no reading explains is noise. It is read in windows, as a part may be filled in.
"""

import numpy as np

from energy.arrays import Array

# Fewest samples: with the highest order 8 and stride 2, fewer leave no quartile; a polygon of few
# corners, whose residuals are its corners, would be taken for noise.
FEWEST = 40
# Fewest samples in a window, if there are as many: a part that was filled in by a program without
# noise is seldom longer, and a quartile of as many residuals is known to a tenth.
_WINDOW = 256
# Fewest residuals for a quartile: it scatters by a third then.
_ENOUGH = 24
# Orders m and strides p that are tried: polygons have m = 2, smooth curves the higher ones.
_ORDERS = (1, 2, 4, 8)
_STRIDES = (1, 2, 3, 4)
# Lower quartile of |N(0, 1)|: the x with erf(x/√2) = ¼.
_QUARTILE = 0.318639


def noise_slope(x: Array, z: Array) -> float:
    """Rms slope that noise alone makes between neighbouring samples, in the noisiest window.

    √2 σ over the median distance of the samples there; 0 for fewer than `FEWEST` samples.

    Parameters
    ----------
    x, z : ndarray (n,)
        Increasing positions, and heights there [length].

    Returns
    -------
    float
        [1]

    Examples
    --------
    >>> import numpy as np
    >>> from energy.noise import noise_slope
    >>> x, noise = np.linspace(-1, 1, 201), np.random.default_rng(0).normal(size=201)
    >>> smooth, noisy = (noise_slope(x, x**2 + size * noise) for size in (0.0, 1e-3))
    >>> print(f"{smooth:.6f}; {noisy / (2**0.5 * 1e-3 / 0.01):.1f} of the slope of this noise")
    0.000000; 0.8 of the slope of this noise
    """
    if x.size < FEWEST:
        return 0.0
    windows = max(1, x.size // _WINDOW)
    width = x.size // windows
    places = x[: windows * width].reshape(windows, width)
    heights = z[: windows * width].reshape(windows, width)
    spacing = np.median(np.diff(places), axis=1)
    # in units of the spacing, so that products of eight distances neither overflow nor vanish
    places = (places - places[:, :1]) / spacing[:, None]
    sigma = np.full(windows, np.inf)
    for order in _ORDERS:
        for stride in _STRIDES:
            if width - order * stride < _ENOUGH:
                continue
            residual = np.abs(_residuals(places, heights, order, stride))
            quartile = np.quantile(residual, 0.25, axis=1)
            sigma = np.minimum(sigma, quartile / _QUARTILE)
    slopes = np.sqrt(2) * sigma / spacing
    return float(np.max(slopes))


def _residuals(x: Array, z: Array, order: int, stride: int) -> Array:
    """The residuals r_i (windows, width - order·stride) of the module docstring.

    x and z are (windows, width): positions and heights of the samples, one window a row. Residual i
    of a row is that of the samples i, i + stride, ..., i + order·stride.
    """
    count = x.shape[1] - order * stride
    starts = [j * stride for j in range(order + 1)]
    places = [x[:, start : start + count] for start in starts]  # of neighbour j, for all i
    heights = [z[:, start : start + count] for start in starts]
    difference = np.zeros_like(places[0])
    squares = np.zeros_like(places[0])
    for j, here in enumerate(places):
        others = [here - there for k, there in enumerate(places) if k != j]
        weight = 1 / np.prod(others, axis=0)
        difference += weight * heights[j]
        squares += weight**2
    return difference / np.sqrt(squares)
