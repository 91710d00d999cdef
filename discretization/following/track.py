"""Contact lines that have moved smoothly from one depth to another, read anywhere in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.following.pieces import Piece
from discretization.following.smooth import Smooth

Array = NDArray[np.float64]
_MOST = 256  # depths at once
_NEAR = 1e-11  # of the size of depths: D - d of lines that are read next to where they disappear


@dataclass(frozen=True, eq=False)
class Track:
    """Smooth motion of all free surfaces in pieces, on which lines are polynomials of t."""

    smooth: Smooth
    first: Array
    pieces: tuple[Piece, ...]

    def lines(self, depths: Array, *, roughly: bool = False) -> Array:
        """Lines (k, n, 2) at depths (k,) on the way; roughly: as polynomials tell."""
        found = np.repeat(self.first[None], depths.size, axis=0)
        for piece in self.pieces:
            way, which = (1 if piece.end >= piece.start else -1), list(piece.which)
            at = np.flatnonzero(way * (depths - piece.start) > 0)
            if not at.size:
                continue
            at = at[np.argsort(way * depths[at], kind="stable")]
            for k in range(0, at.size, _MOST):
                own = at[k : k + _MOST]
                found[own[:, None], which] = self._read(piece, depths[own], way, roughly)
        if self.smooth.rests.scene.axisymmetric:  # where it is lost, rounding is all there is
            found = np.where(np.isfinite(found), np.maximum(found, 0.0), found)
        return found

    def _read(self, piece: Piece, depths: Array, way: int, roughly: bool) -> Array:
        """Lines (k, n, 2) at depths on the way of a piece, in their order, or beyond its end.

        The end is known, and not followed to again: where an equilibrium disappears there, rounding
        may put its lines beyond that.
        """
        lines, inside = piece.lines, way * (depths - piece.end) < 0
        found = np.repeat(lines[None, :, -1], depths.size, axis=0)
        if not inside.any():
            return found
        depths = depths[inside]
        guess = piece.drawn(depths, way)
        # lines that come free of a corner or an edge stay on the side they leave it to
        guess = np.clip(guess, lines.min(axis=1)[:, None], lines.max(axis=1)[:, None])
        if roughly:
            found[inside] = guess.transpose(1, 0, 2)
            return found
        whole = np.concatenate([[piece.start], depths])
        guess = np.concatenate([lines[:, :1], guess], axis=1)
        x, good, _ = self.smooth.followed(lines[:, 0], whole, way, guess.copy())
        if not good.all():
            self._demand(guess[~good], whole, way)
            x[~good] = guess[~good]
        found[inside] = self.smooth.rests.snapped(x[:, 1:]).transpose(1, 0, 2)
        return found

    def _demand(self, lines: Array, depths: Array, way: int) -> None:
        """NotCertifiedError unless lines (n, j, 2) that move are at rest at these depths."""
        off = np.zeros(lines.shape)
        for i in range(depths.size):
            off[:, i] = self.smooth.rests.ahead(lines[:, i], way) - depths[i]
        moves = np.isfinite(lines) & (lines != lines[:, :1])
        known = _NEAR * self.smooth.rests.size + self.smooth.rests.noise(lines)[..., None]
        if (np.abs(np.where(moves, off, 0.0)) > known).any():
            raise NotCertifiedError(
                f"the contacts between depth = {depths[0]!r} and {depths[-1]!r} do not come to "
                "rest; try other depths, or method='lattice'"
            )
