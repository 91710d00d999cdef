"""A measured curve as a fit takes it: points in contact, points without force, ends of contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from studies.scenes.fit.force_curve import (
    Curve,
    Mark,
    baseline,
    contacts,
    free_parts,
    in_contact,
    loading,
    marks,
    noise,
    turning_points,
)
from studies.shared import Array

ROUNDING = 1e-10  # of a force, relative to the largest


@dataclass(frozen=True)
class Leg:
    """Points in contact on one way in or out (by their indices); turn: drive at which it begins."""

    points: NDArray[np.intp]
    turn: float


@dataclass(frozen=True)
class Data:
    """A curve of n points, of which some are in contact and some have no force.

    columns (n, q): forces that its free line may have; pieces: the contacts, each of legs in and
    out in turn, the first one inwards, be it empty; ends: drives at which contact is seen to begin
    and to be lost; sigma: noise of the force, or rounding.
    """

    curve: Curve
    columns: Array
    used: NDArray[np.bool_]
    free: NDArray[np.bool_]
    pieces: tuple[tuple[Leg, ...], ...]
    ends: tuple[Mark, ...]
    sigma: float

    @classmethod
    def of(cls, curve: Curve) -> Data:
        """Take a curve apart, once a line through its free parts is subtracted."""
        flat = Curve(curve.drive, curve.force)
        free = free_parts(flat)
        columns = baseline(flat, free)
        if free.any():
            line = np.linalg.lstsq(columns[free], curve.force[free], rcond=None)[0]
            flat = Curve(curve.drive, curve.force - columns @ line)
        used = in_contact(flat)
        free &= ~used
        sigma = max(noise(curve.force), ROUNDING * float(np.abs(curve.force[used]).max(initial=0)))
        pieces = tuple(_legs(flat, used, own) for own in contacts(flat) if used[own].any())
        return cls(curve, columns, used, free, pieces, marks(flat), sigma)

    @property
    def span(self) -> float:
        """Range of the drives in contact."""
        return float(np.ptp(self.curve.drive[self.used]))


def _legs(curve: Curve, used: NDArray[np.bool_], piece: slice) -> tuple[Leg, ...]:
    points = piece.start + np.flatnonzero(used[piece])
    turns = [i for i in turning_points(curve.depth) if points[0] < i < points[-1]]
    inwards = loading(curve.depth)[points[0]] or points[0] == turns[:1]
    cuts = [points[0] - 1, *turns, points[-1]]
    legs = [points[(points > a) & (points <= b)] for a, b in pairwise(cuts)]
    begins = [-math.inf, *curve.depth[turns].tolist()]
    if not inwards:
        legs, begins = [points[:0], *legs], [-math.inf, float(curve.depth[points[0]]), *begins[1:]]
    return tuple(Leg(own, turn) for own, turn in zip(legs, begins, strict=True))
