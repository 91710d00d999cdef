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

from energy import terms

Array = NDArray[np.float64]
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(14)
_VALUES = np.polynomial.legendre.legvander(_POINTS, _POINTS.size - 1)
_DERIVATIVE = np.linalg.solve(
    _VALUES.T, np.polynomial.legendre.legval(_POINTS, np.polynomial.legendre.legder(np.eye(14)))
).T  # of the polynomial through values at the points
_NEAR = -4  # the first panel beside a line is 2**_NEAR of l wide
_HALVINGS = 9  # of a panel, 500 parts: of rougher profiles the parts are less exact
_AGREED = 1e-13  # change of the integrals relative to their size: all but rounding


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
    springs, surface, adhesion, pressure = _in_contact(state)
    free, pull = np.zeros(2), 0.0
    if state.scene.gamma1:
        free = _of_free(state)
        pull = _of_lines(state)
    stored = float(springs + free[0]), float(surface + free[1])
    return Parts.of(*stored, float(adhesion), float(pressure), pull)


def _of_lines(state: Any) -> float:
    """-γ₁ Σ sin β, or -γ₁ Σ u' with small slopes (11); about an axis each times 2πr."""
    beside = state.line_slopes[1]
    if state.scene.slopes == "finite":
        beside = beside / np.hypot(1.0, beside)
    return -state.scene.gamma1 * float((beside * state.scene.measure(state.contacts)).sum())


def _in_contact(state: Any) -> Array:
    """Springs, surface, adhesion and pressure (4,) of the contacts.

    Panels end at corners, knots and the apex. They are halved until no integral changes by more
    than rounding, or a number of times: a profile may be rougher than any panel.
    """
    ends = _panels(state)
    found, _ = _summed(state, ends)
    for _ in range(_HALVINGS):
        middle = ends.mean(axis=1)
        ends = np.concatenate(
            [np.column_stack([ends[:, 0], middle]), np.column_stack([middle, ends[:, 1]])]
        )
        before = found
        found, size = _summed(state, ends)
        if (np.abs(found - before) <= _AGREED * size).all():
            break
    return found


def _panels(state: Any) -> Array:
    """Ends (n, 2) of the panels in contact."""
    indenter = state.scene.indenter
    apex = [] if indenter.apex is None else [indenter.apex]
    edges = () if state.scene.pattern is None else state.scene.pattern.edges
    known = (indenter.corners, indenter.knots, apex, edges)
    kinks = (np.asarray(part, float) for part in known)
    cuts = np.unique(np.concatenate([*kinks]))
    found: list[tuple[float, float]] = []
    for left, right in state.contacts.tolist():
        inner = cuts[(cuts > left) & (cuts < right)]
        found += itertools.pairwise([left, *inner.tolist(), right])
    return np.reshape(np.array(found, np.float64), (-1, 2))


def _summed(state: Any, ends: Array) -> tuple[Array, Array]:
    """The integrals of `_in_contact` on these panels (n, 2), and of their absolute values."""
    scene, half = state.scene, (ends[:, 1:] - ends[:, :1]) / 2
    x = ends.mean(axis=1)[:, None] + half * _POINTS
    gamma1, w, slopes = scene.gamma1, scene.work_of_adhesion, scene.slopes
    u, slope = state.depth - scene.indenter.height(x), scene.indenter.slope(x)
    stretched = terms.contact(slope, gamma1=gamma1, w=0.0, slopes=slopes)
    bound = terms.contact(slope, gamma1=gamma1, w=w, slopes=slopes) - stretched
    if scene.pattern is not None:
        bound = bound * scene.pattern.factor(x)
    stored, pressure, _ = terms.spring(u, k=scene.stiffness)
    densities = np.array([stored, stretched, bound, pressure]) * scene.measure(x)
    weights = half * _WEIGHTS
    return (densities * weights).sum(axis=(1, 2)), (np.abs(densities) * weights).sum(axis=(1, 2))


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
