"""How large the noise of measured heights is, told from the profile that they measure.

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

FEWEST = 40  # samples: of fewer, corners of the body cannot be told from noise
_WINDOW = 256  # samples at least, if there are as many
_ENOUGH = 24  # residuals for a quartile: it scatters by a third
_ORDERS = (1, 2, 4, 8)
_STRIDES = (1, 2, 3, 4)
_QUARTILE = 0.318639  # of |N(0, 1)|, the lower one


def noise_slope(x: Array, z: Array) -> float:
    """Rms slope that noise alone makes between neighbouring samples, in the noisiest window.

    √2 σ over the median distance of the samples there; 0 for fewer than `FEWEST` samples.

    Parameters
    ----------
    x, z : array (n,)
        Increasing positions, and heights there [length].

    Examples
    --------
    >>> import numpy as np
    >>> from energy.noise import noise_slope
    >>> x, noise = np.linspace(-1, 1, 201), np.random.default_rng(0).normal(size=201)
    >>> smooth, noisy = (noise_slope(x, x**2 + size * noise) for size in (0.0, 1e-3))
    >>> print(f"{smooth:.1e}, {noisy / (2**0.5 * 1e-3 / 0.01):.1f} of what it is")
    """
    if x.size < FEWEST:
        return 0.0
    count = max(1, x.size // _WINDOW)
    width = x.size // count
    rows = (count, width)
    places = x[: count * width].reshape(rows)
    heights = z[: count * width].reshape(rows)
    spacing = np.median(np.diff(places), axis=1)
    places = (places - places[:, :1]) / spacing[:, None]  # numbers whose powers are numbers, too
    least = np.full(count, np.inf)
    for order in _ORDERS:
        for stride in _STRIDES:
            if width - order * stride >= _ENOUGH:
                residual = np.abs(_residuals(places, heights, order, stride))
                least = np.minimum(least, np.quantile(residual, 0.25, axis=1) / _QUARTILE)
    return float(np.max(np.sqrt(2) * least / spacing))


def _residuals(x: Array, z: Array, order: int, stride: int) -> Array:
    """r_i of the module, of all i that have so many neighbours in their row."""
    count = x.shape[1] - order * stride
    starts = [j * stride for j in range(order + 1)]
    places = [x[:, start : start + count] for start in starts]
    heights = [z[:, start : start + count] for start in starts]
    difference = np.zeros_like(places[0])
    squares = np.zeros_like(places[0])
    for j, here in enumerate(places):
        others = [here - there for k, there in enumerate(places) if k != j]
        weight = 1 / np.prod(others, axis=0)
        difference += weight * heights[j]
        squares += weight**2
    return difference / np.sqrt(squares)
