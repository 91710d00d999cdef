"""Gauss-Lobatto elements: points, weights, derivatives, and the polynomial between the points."""

from __future__ import annotations

import functools

import numpy as np
from numpy.polynomial import Legendre, legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@functools.lru_cache(maxsize=64)
def lobatto(degree: int) -> tuple[Array, Array, Array]:
    """Gauss-Lobatto points on [-1, 1], their weights, and the matrix of derivatives there.

    In the widest floating-point type of the machine: the rounding of these entries would be the
    largest error of a smooth solution.
    """
    p = Legendre.basis(degree)
    slope, curvature = p.deriv(), p.deriv(2)
    inner = np.sort(slope.roots().real).astype(np.longdouble)
    for _ in range(3):
        inner -= slope(inner) / curvature(inner)
    x = np.concatenate([[-1], (inner - inner[::-1]) / 2, [1]])
    values = legendre.legval(x, p.coef)
    weights = 2 / (degree * (degree + 1) * values**2)
    d = values[:, None] / values[None, :] / (x[:, None] - x[None, :] + np.eye(x.size))
    np.fill_diagonal(d, 0)
    np.fill_diagonal(d, -d.sum(axis=1))
    return x, weights, d


@functools.lru_cache(maxsize=64)
def rounded(degree: int) -> tuple[Array, Array, Array]:
    """`lobatto` in double precision."""
    x, weights, d = lobatto(degree)
    return x.astype(float), weights.astype(float), d.astype(float)


@functools.lru_cache(maxsize=64)
def _transform(degree: int) -> Array:
    """Values at the Gauss-Lobatto points to coefficients of Legendre polynomials."""
    points, weights, _ = rounded(degree)
    basis = legendre.legvander(points, degree)
    return np.asarray((basis * weights[:, None] / (weights @ basis**2)).T)


def coefficients(degree: int, values: Array) -> Array:
    """Legendre coefficients of the polynomials with these values (..., degree+1) at the points."""
    return np.asarray(values @ _transform(degree).T)


def polynomial(degree: int, at: Array, values: Array) -> Array:
    """The polynomial with these values at the Gauss-Lobatto points, at other points."""
    return np.asarray(legendre.legval(at, _transform(degree) @ values))


def on_elements(ends: Array, u: Array, x: Array) -> tuple[Array, Array]:
    """A surface and its slope at x (n,), from its nodal values on elements between ends."""
    degree, e = (u.size - 1) // (ends.size - 1), np.searchsorted(ends[1:-1], x, side="right")
    own, width = u[e[:, None] * degree + np.arange(degree + 1)], np.diff(ends)[e]
    both = _transform(degree) @ np.array([own.T, rounded(degree)[2] @ own.T])
    at = 2 * (x - ends[e]) / width - 1
    values, slopes = (legendre.legval(at, part, tensor=False) for part in both)
    return np.asarray(values), np.asarray(slopes * 2 / width)


@functools.lru_cache(maxsize=64)
def _lower(size: int) -> tuple[Indices, Indices]:
    """Rows and columns of an element's lower triangle without the node shared with the next."""
    row, column = np.tril_indices(size)
    own = column < size - 1
    return row[own], column[own]


def band(blocks: Array) -> Array:
    """Element matrices (..., m, degree+1, degree+1) added up, lower banded (..., degree+1, n)."""
    *many, elements, size, _ = blocks.shape
    row, column = _lower(size)
    result = np.zeros((*many, size, elements, size - 1))
    result[..., row - column, :, column] = np.moveaxis(blocks[..., row, column], -1, 0)
    ends = np.zeros((*many, size, 1))
    result = np.concatenate([result.reshape(*many, size, -1), ends], axis=-1)
    result[..., 0, size - 1 :: size - 1] += blocks[..., -1, -1]
    return result
