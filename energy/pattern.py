"""Adhesion that varies along the surface: chemical patterns and defects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from energy.arrays import Array
from energy.checks import array, positive


@dataclass(frozen=True)
class Patches:
    """Piecewise constant factor c(x) >= 0 on the work of adhesion: w(x) = c(x) w.

    Parameters
    ----------
    edges : sequence of float
        Increasing x [length] at which the factor changes, n of them.
    factors : sequence of float
        The n + 1 factors from left to right, >= 0.

    Raises
    ------
    ValueError
        For unsorted edges, another number of factors, negative ones or NaN.

    Examples
    --------
    >>> from energy import Patches
    >>> Patches(edges=[0.0], factors=[1.0, 2.0]).factor([-1.0, 1.0])
    array([1., 2.])
    """

    edges: Sequence[float]
    factors: Sequence[float]

    def __post_init__(self) -> None:
        """Check edges and factors, and keep them as tuples of floats."""
        edges = array("edges", self.edges)
        factors = array("factors", self.factors)
        if edges.ndim != 1 or not np.isfinite(edges).all() or (np.diff(edges) <= 0).any():
            raise ValueError(f"edges = {self.edges!r} must be increasing finite numbers; sort them")
        if factors.shape != (edges.size + 1,):
            raise ValueError(
                f"factors has {factors.size} values for {edges.size} edges; give one more than "
                "edges"
            )
        if not (np.isfinite(factors) & (factors >= 0)).all():
            raise ValueError(
                f"factors = {self.factors!r} must be finite and not negative: give numbers >= 0"
            )
        object.__setattr__(self, "edges", tuple(edges.tolist()))
        object.__setattr__(self, "factors", tuple(factors.tolist()))

    @classmethod
    def stripes(cls, period: float, low: float, high: float, extent: float) -> Patches:
        """Stripes of two factors that alternate, `high` at x = 0.

        Parameters
        ----------
        period : float
            Width of two stripes [length].
        low, high : float
            The factors, >= 0.
        extent : float
            There are stripes from -extent to extent [length].

        Returns
        -------
        Patches

        Raises
        ------
        ValueError
            For lengths that are not positive, a period above `extent`, and factors as above.
        """
        if positive("period", period) > positive("extent", extent):
            raise ValueError(
                f"period = {period!r} exceeds extent = {extent!r}: give a larger extent"
            )
        # Edges at odd multiples of a quarter period, two in each period. The factor of index
        # 2 count, an even one, lies between -period/4 and period/4, so that it is `high` at x = 0.
        count = int(extent / period)
        edges = period / 2 * (np.arange(-2 * count, 2 * count) + 0.5)
        factors = np.where(np.arange(edges.size + 1) % 2, low, high)
        return cls(edges.tolist(), factors.tolist())

    def factor(self, x: ArrayLike) -> Array:
        """The factor at some places.

        Parameters
        ----------
        x : array_like
            Positions [length], of any shape.

        Returns
        -------
        ndarray
            c(x) [1], of the shape of x; at an edge that on its right.
        """
        stripe = np.searchsorted(self.edges, x, side="right")
        return np.asarray(self.factors)[stripe]
