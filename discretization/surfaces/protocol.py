"""What contact lines feel of the free surfaces of the fitted mesh, and the shape of those.

A line rests at x at the depth D(x) at which ∂U/∂x = 0. On the mesh ∂U/∂x = γ₁/2 r² - w with
r = f' - S/γ₁, f' outwards of the contact and S the reaction of the free surface there: of
k/2 g² + γ₁/2 f'² - w - S f', by which the energy grows as the contact does, a square is left
because S² = kγ₁ g² on the mesh of a tail to rounding, and k g² - S²/γ₁ = 2 ∂F/∂L on that of a gap
of length L. With finite slopes, tan β = f' and sin φ = S/γ₁, it is likewise

    ∂U/∂x = k/2 g² + (γ₁-w)√(1+f'²) - γ₁ - S f' = [2γ₁ sin²((β-φ)/2) - w]/cos β.

A line advances where D < d and recedes where D > d. Small and finite slopes differ in what answers
the questions below (one module for each, see __init__.py), and nowhere else.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from energy import Scene

Array = NDArray[np.float64]
ANY = -1e200  # below every depth
MET = 1e-13  # elastocapillary lengths: lines that have met are no closer than that


class At(NamedTuple):
    """Contact lines at x and the heights f of the profile there, numbers or arrays."""

    x: Any
    f: Any


def alone(left: At | None, right: At | None) -> At:
    """The line of a tail."""
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


class Surfaces(Protocol):
    """Free surfaces beside contacts; a line that is None is infinitely far away."""

    @property
    def scene(self) -> Scene: ...

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D at x, numbers or arrays, with the height f and the slope f' there.

        side: +1 for a line whose contact is on its left, else -1; facing: the line beyond the free
        surface.
        """

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """Energy F of free surfaces (n,) and what they pull at all their lines, ∂F/∂d."""

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface. ValueError if it would turn over."""

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' at positions between two lines."""
