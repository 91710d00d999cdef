"""What a contact line feels of its free surface: functions of the displacement u₀ at the line.

All free surfaces form a family with one parameter, so the discrete one is solved at a few u₀ and
read in between: with z = u₀², in units of l and γ₁,

    reaction S = u₀ s(z),   energy F = u₀² e(z),   area ∫u dx = u₀ m(z),   start of u = u₀ n(z),

constant for small slopes, polynomials through Chebyshev points for finite ones. Beyond STEEP, on
the way to turning over, the meshes differ: s, e and m have polynomials of their own there, solved
when first asked for, and n is not read but solved.

A response has two a-posteriori errors: `error`, the relative change of S, F and the area from the
next lower degree; and `mismatch`, how far the slope of the polynomial at the line is from carrying
the reaction, as an angle [rad]. A slope is less accurate, so the mismatch chooses the degree.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.mesh import OVERHANG, FreeSurface, graded, linear, relaxed, steep
from discretization.surfaces.polynomials import Powers, horner, powers
from discretization.surfaces.spectral import nodes

Array = NDArray[np.float64]
DEGREES = {"small": (6, 8, 10, 12), "finite": (8, 12, 16, 20)}
STEEP = 1.3  # l: displacement from which the surface is so steep that its elements are graded
_POINTS = 18  # displacements at which surfaces are solved; all others to rounding between them
_STEEP_POINTS = 12  # the same between 1.3 l and turning over
_ANGLE = 1e-4  # part of rtol that the contact angle [rad] may be off by per u₀


class Tail(NamedTuple):
    """F [γ₁ l], S [γ₁] and ∫u dx [l²] of a tail, and its residual over u₀."""

    energy: float
    reaction: float
    area: float
    residual: float


@dataclass(frozen=True, eq=False)
class Response:
    """Free surfaces of one degree: coefficients of falling powers of t."""

    slopes: str
    degree: int
    shapes: Array
    reactions: Powers
    energies: Powers
    areas: Powers
    error: float
    mismatch: float

    def reaction(self, u0: Any) -> Any:
        """S = dF/du₀ [γ₁]; of an array where none is beyond STEEP."""
        if self.slopes == "small":
            return u0 * self.reactions[0]
        if not isinstance(u0, np.ndarray) and self._alone(u0):
            return u0 * _beyond(self.degree, u0, 0)
        return u0 * horner(self.reactions, _along(u0))

    def energy(self, u0: float) -> float:
        """F [γ₁ l]."""
        if self._alone(u0):
            return u0 * u0 * _beyond(self.degree, u0, 1)
        return u0 * u0 * horner(self.energies, _along(u0))

    def area(self, u0: float) -> float:
        """∫u dx [l²]."""
        if self._alone(u0):
            return u0 * _beyond(self.degree, u0, 2)
        return u0 * horner(self.areas, _along(u0))

    def tail(self, u0: float) -> Tail:
        """What a line feels, and what the surface's free nodes and its reaction are off by."""
        solved = self.surface(u0)
        apart = max(solved.residual, abs(solved.reaction - self.reaction(u0)))
        return Tail(self.energy(u0), self.reaction(u0), self.area(u0), apart / (abs(u0) or 1.0))

    def surface(self, u0: float) -> FreeSurface:
        """The surface itself, relaxed from what was read."""
        if self.slopes == "small":
            return linear(self.degree).scaled(u0)
        if self._alone(u0):
            return steep(u0, self.degree)
        return _mild(self, u0)

    def _alone(self, u0: float) -> bool:
        return abs(u0) > STEEP and self.slopes == "finite"


@functools.lru_cache(maxsize=256)
def _mild(response: Response, u0: float) -> FreeSurface:
    """A surface up to STEEP: it is asked for again and again while its line is at rest."""
    start = u0 * (_along(u0) ** np.arange(_POINTS)[::-1] @ response.shapes)
    return relaxed(start, graded(STEEP))


def _along(u0: Any) -> Any:
    """t, which runs from -1 to 1 up to STEEP."""
    return 2 * u0 * u0 / STEEP**2 - 1


def _beyond(degree: int, u0: float, which: int) -> float:
    """One of s, e, m of a surface between STEEP and turning over."""
    if abs(u0) >= OVERHANG:
        steep(u0, degree)  # says why there is none
    t = 2 * (u0 * u0 - STEEP**2) / (OVERHANG**2 - STEEP**2) - 1
    return horner(_steepest(degree)[which], t)


@functools.lru_cache(maxsize=16)
def _steepest(degree: int) -> tuple[Powers, ...]:
    """Coefficients of s, e, m on the way from STEEP to turning over."""
    t = np.sort(np.cos(np.pi * (np.arange(_STEEP_POINTS) + 0.5) / _STEEP_POINTS))
    u0 = np.sqrt(STEEP**2 + (OVERHANG**2 - STEEP**2) * (t + 1) / 2).tolist()
    rows = np.array([_read(steep(u, degree), u) for u in u0])
    return tuple(tuple(column) for column in powers(t, rows).T.tolist())


ABSENT = Response("small", 0, np.empty((0, 0)), (0.0,), (0.0,), (0.0,), 0.0, 0.0)  # γ₁ = 0


@functools.lru_cache(maxsize=16)
def chosen(slopes: str, rtol: float) -> Response:
    """The response of least degree that meets rtol, in S, F, area and in the contact angle."""
    for degree in DEGREES[slopes]:
        error, mismatch = _errors(slopes, degree)
        if error <= rtol and mismatch <= _ANGLE * rtol:
            break
    return response(slopes, degree)


def finer(coarse: Response) -> Response | None:
    """The response of the next degree; None if there is none."""
    degrees = DEGREES[coarse.slopes]
    at = degrees.index(coarse.degree) + 1
    return response(coarse.slopes, degrees[at]) if at < len(degrees) else None


@functools.lru_cache(maxsize=16)
def response(slopes: str, degree: int) -> Response:
    """The response of the surfaces of one degree, with its errors; solved once."""
    if slopes == "small":
        surface = linear(degree)
        table = np.array([[*_read(surface, 1.0), *surface.u]])
    else:
        t = np.sort(np.cos(np.pi * (np.arange(_POINTS) + 0.5) / _POINTS))
        table = powers(t, _family(STEEP * np.sqrt((t + 1) / 2), degree))
    reactions, energies, areas = (tuple(column) for column in table[:, :3].T.tolist())
    return Response(
        slopes, degree, table[:, 3:], reactions, energies, areas, *_errors(slopes, degree)
    )


def _family(displaced: Array, degree: int) -> Array:
    """s, e, m and the nodal n (columns) of finite-slope surfaces (rows), each from the last."""
    lengths = graded(STEEP)
    u, rows = linear(degree).displacement(nodes(lengths, degree)), []
    for u0 in displaced.tolist():
        surface = relaxed(u * (u0 / u[0]), lengths)
        u = surface.u
        rows.append([*_read(surface, u0), *(u / u0)])
    return np.array(rows)


def _read(surface: FreeSurface, u0: float) -> tuple[float, float, float]:
    """s, e, m of a solved surface."""
    return surface.reaction / u0, surface.energy / u0**2, surface.area / u0


@functools.lru_cache(maxsize=16)
def _errors(slopes: str, degree: int) -> tuple[float, float]:
    """Error and mismatch of the surfaces of one degree, at the steepest of them."""
    first, second, *_ = DEGREES[slopes]
    if slopes == "small":
        below, surface = linear(degree + first - second), linear(degree)
        mismatch = abs(surface.slope + surface.reaction)
    else:
        below, surface = steep(STEEP, degree + first - second), steep(STEEP, degree)
        mismatch = abs(math.atan(surface.slope) + math.asin(surface.reaction))
    change = np.divide(_read(below, 1.0), _read(surface, 1.0)) - 1
    return float(np.abs(change).max()), mismatch
