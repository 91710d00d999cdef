"""Energy and force of an equilibrium in parts, by quadrature over its contacts and free surfaces.

    springs   ∫ k/2 u² dx, over the whole surface
    surface   ∫ γ₁/2 u'² dx, or ∫ γ₁ (√(1+u'²) - 1) dx with finite slopes
    adhesion  -w times the length in contact, along the indenter with finite slopes
    pressure  k ∫ (d - f) dx over the contacts (9)
    lines     -γ₁ Σ sin β over all contact lines (10), β the outward inclination beside each

They are read from the displacement field and its slopes at the lines, whoever found those. Their
sums are the energy and the force up to quadrature and to what `error_estimate` says of the latter.

state: an `Equilibrium`, which is built on this module, not it on that.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.quadrature import in_contact
from energy import terms

Array = NDArray[np.float64]
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(14)
_VALUES = np.polynomial.legendre.legvander(_POINTS, _POINTS.size - 1)
_DERIVATIVE = np.linalg.solve(
    _VALUES.T, np.polynomial.legendre.legval(_POINTS, np.polynomial.legendre.legder(np.eye(14)))
).T  # of the polynomial through values at the points
_NEAR = -4  # the first panel beside a line is 2**_NEAR of l wide


class Parts(NamedTuple):
    """The parts by name: of the energy [energy/length] and of the force [force/length]."""

    energy: dict[str, float]
    force: dict[str, float]

    @classmethod
    def of(cls, springs: float, surface: float, adhesion: float, *force: float) -> Parts:
        """From the five numbers of the module, in its order."""
        energy = {"springs": springs, "surface": surface, "adhesion": adhesion}
        return cls(energy, dict(zip(("pressure", "lines"), force, strict=True)))


def parts_of(state: Any) -> Parts:
    """Energy and force of a state in parts; of a plane without end every part is endless."""
    if not state.contacts.size:
        return Parts.of(0.0, 0.0, 0.0, 0.0, 0.0)
    if not np.isfinite(state.contacts).all():
        bound = -math.inf if state.scene.work_of_adhesion else 0.0
        return Parts.of(math.inf if state.depth else 0.0, 0.0, bound, state.force, 0.0)
    contacts, _ = in_contact(state.scene, state.depth, state.contacts, 0.0)
    springs, surface, adhesion, pressure = contacts.sums.sum(axis=1).tolist()
    free, pull = np.zeros(2), 0.0
    if state.scene.gamma1:
        free = _of_free(state)
        pull = _of_lines(state)
    stored = float(springs + free[0]), float(surface + free[1])
    return Parts.of(*stored, -adhesion, pressure, pull)


def _of_lines(state: Any) -> float:
    """-γ₁ Σ sin β, or -γ₁ Σ u' with small slopes (11); about an axis each times 2πr."""
    beside = state.line_slopes[1]
    if state.scene.slopes == "finite":
        beside = beside / np.hypot(1.0, beside)
    return -state.scene.gamma1 * float((beside * state.scene.measure(state.contacts)).sum())


def _of_free(state: Any) -> Array:
    """Springs and surface (2,) of all free surfaces, from u at Gauss points.

    The panels become wider away from the lines; about an axis u varies over the radius, too.
    """
    scene, lines = state.scene, state.contacts.ravel().tolist()
    near = scene.elastocapillary_length * np.append(0.0, 2.0 ** np.arange(_NEAR, 6, 0.5))
    far = float(near[-1])
    ends = [0.0 if scene.axisymmetric else lines[0] - far, *lines, lines[-1] + far]
    panels: list[tuple[float, float]] = []
    for left, right in zip(ends[::2], ends[1::2], strict=True):
        cuts = np.unique(np.concatenate([left + near, right - near, [left, right]]))
        if scene.axisymmetric and scene.elastocapillary_length > left > 0:
            cuts = np.union1d(cuts, left * 2.0 ** np.arange(0, 60, 0.5))
        panels += itertools.pairwise(cuts[(cuts >= left) & (cuts <= right)].tolist())
    edges = np.array(panels).reshape(-1, 2)
    half = (edges[:, 1:] - edges[:, :1]) / 2
    x = edges[:, :1] + half * (1 + _POINTS)
    u = state.displacement(x)
    slope = u @ _DERIVATIVE.T / half
    surface = terms.surface(slope, gamma1=scene.gamma1, slopes=scene.slopes).value
    weights = half * _WEIGHTS * scene.measure(x)
    springs = terms.spring(u, k=scene.stiffness).value
    return np.array([(springs * weights).sum(), (surface * weights).sum()])
