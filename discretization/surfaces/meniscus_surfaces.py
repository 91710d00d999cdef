"""Free surfaces with rotational symmetry and finite slopes.

D = f + u₀ of the surface that is inclined by φ = β - 2 asin √(w/(2γ₁)) at its line, tan β = f', of
the family of menisci.py. ∂U/∂x = 2πx [2γ₁ sin²((β-φ)/2) - w]/cos β as for a line contact, because

    d(s F)/ds = ±s (1 - cos φ - u₀²/2)   at a given u₀

on the mesh to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces import menisci
from discretization.surfaces.protocol import ANY, At, Free, alone
from discretization.surfaces.rings import BESIDE, rough
from energy import Scene

Array = NDArray[np.float64]
_STEP = 1e-3  # of a radius: differences of fourth order are then good to 1e-11
_UPRIGHT = 1e-12  # of the steepest inclination: it is found no better
_DIFFERENCES = np.array([(-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)]).T


@dataclass(frozen=True, eq=False)
class MeniscusSurfaces:
    """Free surfaces of a scene."""

    scene: Scene

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: the inclination at rest is known, and the displacement that has it is read.

        Beyond the steepest of the family it only has to grow: a line that rests there is refused.
        At the axis it is next to nothing, of the right sign.
        """
        if facing is not None:
            raise ValueError(_rings(facing))
        length = self.scene.elastocapillary_length
        deficit = 2 * np.arcsin(np.sqrt(w / (2 * self.scene.gamma1)))
        known = side, x / length, np.arctan(side * f1) - deficit, f
        side, s, phi, f = np.broadcast_arrays(*map(np.atleast_1d, known))
        least = np.maximum(s, np.where(side > 0, menisci.LEAST[1], menisci.LEAST[-1]))
        off, u = s > 0, np.sin(phi) * rough(1, BESIDE)
        u[off] = menisci.read(side[off], least[off], phi[off])[0]
        beyond = np.maximum(np.abs(np.sin(phi / 2)) / math.sin(menisci.STEEPEST / 2), 1.0)
        beyond = beyond * least / np.maximum(s, BESIDE)  # what is on a tiny disc does not count
        rest = np.where(off | (side > 0), f + length * u * beyond, ANY)
        return rest if np.ndim(x) else rest[0]

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """From the mesh."""
        if left is not None and right is not None:
            raise ValueError(_rings(right))
        line, side = left if right is None else right, 1 if right is None else -1
        if line is None or not line.x:
            return np.zeros_like(z), np.zeros_like(z)
        length = self.scene.elastocapillary_length
        place = side, line.x / length, (depth - line.f) / length
        u, u1 = menisci.shape(*place, side * (np.ravel(z) - line.x) / length)
        return length * u.reshape(np.shape(z)), side * u1.reshape(np.shape(z))

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F and S, read from the family."""
        length, line = self.scene.elastocapillary_length, alone(left, right)
        side, unit = 1 if right is None else -1, 2 * math.pi * self.scene.gamma1 * length
        s = np.maximum(line.x / length, menisci.LEAST[side])
        phi = menisci.inclination(side, s, (depth - line.f) / length)
        energy = np.where(line.x > 0, s * menisci.read(side, s, phi)[1], 0.0)
        return unit * length * energy, unit * np.where(line.x > 0, s * np.sin(phi), 0.0)

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface, read from the family. ValueError if it would be too steep.

        As all its nodes are balanced, k∫u over it is what it pulls.
        """
        line, side = alone(left, right), 1 if right is None else -1
        if not line.x:
            return Free(0.0, (0.0, 0.0), 0.0, 0.0)
        length = self.scene.elastocapillary_length
        s, u = line.x / length, (depth - line.f) / length
        (phi,) = menisci.inclination(side, np.array([s]), np.array([u])).tolist()
        if s < menisci.LEAST[side] or abs(phi) >= menisci.STEEPEST * (1 - _UPRIGHT):
            raise ValueError(_too_steep(line, depth))
        _, (energy,) = menisci.read(side, np.array([s]), np.array([phi]))
        pull, unit = math.sin(phi), 2 * math.pi * self.scene.gamma1 * line.x
        pulls = (unit * pull, 0.0)[::side]
        off = self._imbalance(side, s, u, pull)
        return Free(unit * length * float(energy), (pulls[0], pulls[1]), unit * pull, off)

    def _imbalance(self, side: int, s: float, u: float, pull: float) -> float:
        """How far d(sF)/ds is from side s (1 - cos φ - u₀²/2), over its terms."""
        steps, rule = _DIFFERENCES
        radii = s * (1 + _STEP * steps)
        phi = menisci.inclination(side, radii, np.full_like(radii, u))
        rate = float(rule @ (radii * menisci.read(side, radii, phi)[1])) / (_STEP * s * s)
        cos = math.sqrt(1 - pull * pull)
        off = abs(rate - side * (pull * pull / (1 + cos) - u * u / 2))
        return off / (pull * pull + u * u or 1.0)


def _too_steep(line: At, depth: float) -> str:
    return (
        f"depth = {depth!r}: at the contact line r = {line.x!r} the surface, displaced by "
        f"{depth - line.f!r}, would be inclined by more than 86° or is narrower than a millionth "
        "of l, and is not resolved; use a smaller |depth|, a smaller w or a blunter indenter"
    )


def _rings(line: At) -> str:
    return (
        f"slopes = 'finite' with geometry = 'axisymmetric': there is another contact at r = "
        f"{float(np.ravel(line.x)[0])!r}, and the ring of free surface between two is not "
        "implemented with finite slopes; use slopes='small', or a profile with one contact"
    )
