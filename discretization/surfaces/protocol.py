"""What contact lines feel of the free surfaces of the fitted mesh, and the shape of those.

A line rests at x at the depth D(x) at which ∂U/∂x = 0. On the mesh ∂U/∂x = γ₁/2 r² - w with
r = f' - S/γ₁, f' outwards of the contact and S the reaction of the free surface there: of
k/2 g² + γ₁/2 f'² - w - S f', by which the energy grows as the contact does, a square is left
because S² = kγ₁ g² on the mesh of a tail to rounding, and k g² - S²/γ₁ = 2 ∂F/∂L on that of a gap
of length L. With finite slopes, tan β = f' and sin φ = S/γ₁, it is likewise

    ∂U/∂x = k/2 g² + (γ₁-w)√(1+f'²) - γ₁ - S f' = [2γ₁ sin²((β-φ)/2) - w]/cos β.

A line advances where D < d and recedes where D > d. Small and finite slopes, line contacts and
rotational symmetry differ in the answers that `Surfaces` leaves open, and nowhere else.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from discretization.surfaces.network import Shape
from energy import Scene
from energy.arrays import Array

ANY = -1e200  # below every depth
NARROWEST = 1e-13  # elastocapillary lengths: gaps are taken to be at least that wide


class At(NamedTuple):
    """Contact lines at x and the heights f of the profile there, numbers or arrays."""

    x: Any
    f: Any


def alone(left: At | None, right: At | None) -> At:
    """The line of a tail, the first one of a gap."""
    line = left if left is not None else right
    assert line is not None, "a free surface has a line"
    return line


class Free(NamedTuple):
    """A free surface: energy F, what it pulls at its left and right line, ∂F/∂g, and k∫u dx.

    residual: imbalance of its free nodes, and of what lines are found by, over its displacement.
    """

    energy: float
    pulls: tuple[float, float]
    area: float
    residual: float


class Felt(NamedTuple):
    """What judges the line of a contact at x: depths D [length] and their changes.

    free: not held by a corner; closing: D just ahead of a contact that closes; bare: the same
    without adhesion; opening: D behind one that opens, -∞ for one of a point; size: of the terms
    that cancel in D - d; moved: how far it moves over what D of the lines of its free surface is
    off by; stable: whether D grows outwards of these.
    """

    x: float
    free: bool
    closing: float
    bare: float
    opening: float
    size: float
    moved: float
    stable: bool


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Free surfaces beside contacts; a line that is None is infinitely far away.

    lost: why one is refused, in words.
    """

    scene: Scene
    lost: ClassVar[str]

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D at x, numbers or arrays, with the height f and the slope f' there.

        side: +1 for a line whose contact is on its left, else -1; facing: that beyond the surface.
        """
        length, width, rise = self.scene.elastocapillary_length, math.inf, 0.0
        if facing is not None:
            width = side * (facing.x - x) / length
            width = max(width, NARROWEST) if np.ndim(width) == 0 else np.maximum(width, NARROWEST)
            rise = (f - facing.f) / length
        work = w / self.scene.gamma1
        return f + length * self.at_rest(side, x / length, width, rise, side * f1, work)

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """Energy F of free surfaces (n,) and what they pull at all their lines, ∂F/∂d.

        ValueError if a tail would turn over.
        """
        found = self.held(*self._lines(left, right, depth))
        if found is None:
            i = int(np.argmax(np.abs(depth - alone(left, right).f)))
            one, other = (line and At(float(line.x[i]), float(line.f[i])) for line in (left, right))
            raise ValueError(self.refusal(one, other, float(depth[i])))
        return self._unit * self.scene.elastocapillary_length * found[0], self._unit * found[1]

    def solve(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface. ValueError if it would turn over."""
        lines, unit = self._lines(left, right, depth), self._unit
        if not self.scene.axisymmetric:
            lines = (1, 0.0, *lines[2:])  # wherever it is
        elif lines[1:3] == (0.0, math.inf):
            return Free(0.0, (0.0, 0.0), 0.0, 0.0)  # at the axis there is none
        found = self.solved(*lines)
        if found is None:
            raise ValueError(self.refusal(left, right, depth))
        (one, other), length = found.pulls, self.scene.elastocapillary_length
        pulls = (unit * one, unit * other) if left else (unit * other, unit * one)
        return Free(unit * length * found.energy, pulls, unit * found.area, found.residual)

    def shape(self, z: Array, left: At | None, right: At | None, depth: float) -> Shape:
        """u and u' at positions between two lines."""
        if left is None and right is None:
            return np.zeros_like(z), np.zeros_like(z)
        length, (side, *lines) = self.scene.elastocapillary_length, self._lines(left, right, depth)
        x = side * (np.ravel(z) - alone(left, right).x) / length
        u, u1 = self.form(x, side, *lines)
        return length * u.reshape(np.shape(z)), side * u1.reshape(np.shape(z))

    @property
    def _unit(self) -> float:
        """Of forces: γ₁, or 2πγ₁l about an axis."""
        return self.scene.gamma1 * float(self.scene.measure(self.scene.elastocapillary_length))

    def _lines(self, left: At | None, right: At | None, depth: Any) -> tuple[Any, ...]:
        """A free surface from its first line on, in units of l, as below."""
        length, line = self.scene.elastocapillary_length, alone(left, right)
        s, u = line.x / length, (depth - line.f) / length
        if left is None or right is None:
            return 1 if left else -1, s, math.inf, u, -u
        return 1, s, (right.x - left.x) / length, u, (left.f - right.f) / length

    # In units of l and γ₁, a surface on a side of a line at s that is displaced by u, to another
    # one in a distance of `width`, ∞ if there is none, that is displaced by u + rise:

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, steep: Any, w: Any) -> Any:
        """u at which the line rests, f' outwards of the contact being `steep`."""
        raise NotImplementedError

    def held(self, side: int, s: Any, width: Any, u: Any, rise: Any) -> Any:
        """F and what both lines are pulled by, (n,) each; None if a tail would turn over."""
        raise NotImplementedError

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """One such surface, its first line first; None if it would turn over."""
        raise NotImplementedError

    def form(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """u and its slope towards the other line, at distances from the first line."""
        raise NotImplementedError

    def refusal(self, left: At | None, right: At | None, depth: float) -> str:
        """Why a surface that would turn over is refused."""
        line, name = alone(left, right), "r" if self.scene.axisymmetric else "x"
        where = f"at the contact line {name} = {line.x!r}"
        if left is not None and right is not None:
            where = f"between the contact lines {name} = {left.x!r} and {right.x!r}"
        return (
            f"depth = {depth!r}: {where} the surface, displaced by {depth - line.f!r}, {self.lost} "
            f"(l = {self.scene.elastocapillary_length!r}); use a smaller |depth|, a smaller w or a "
            "blunter indenter"
        )
