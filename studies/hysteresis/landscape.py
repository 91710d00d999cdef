"""Energy landscapes of a load path: U(a; d) with the states of the path on it.

At a depth d, with small slopes, every half-width a has its surface of least energy: u = d - f in
the contact and free beside it. U(a; d) is its energy; its minima over a are the states of a path
under imposed depth, and what separates one from the detached surface, U = 0, is the barrier that
keeps it metastable.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import History
from energy.units import prefixed
from studies.shared.figures import Figure, canvas, shades
from studies.shared.types import Array

_POINTS = 160
_WIDER = 1.3
_CLOSED = 1e-3


class Curve(NamedTuple):
    """U (n,) over the half-width a (n,) at the depth of a step.

    through: the surface would pass through the indenter; state: (a, U) of the path at this step.
    """

    depth: float
    half_width: Array
    energy: Array
    through: NDArray[np.bool_]
    state: tuple[float, float]


def curves(history: History, steps: Sequence[int]) -> list[Curve]:
    """Landscapes at the depths of these steps, from almost closed to wider than the states.

    ValueError for finite slopes, an indenter that is not symmetric, and steps without contact.
    """
    if history.scene.slopes != "small":
        raise ValueError(
            f"slopes = {history.scene.slopes!r} must be 'small' for a landscape over a"
        )
    indenter, widths = history.scene.indenter, history.half_width[list(steps)]
    if not indenter.symmetric or indenter.apex is None:
        raise ValueError(f"indenter = {indenter!r} must be symmetric for a landscape over a")
    if not np.any(widths > 0):
        raise ValueError(f"steps = {list(steps)!r} must contain one with a contact")
    widest = min(_WIDER * float(widths.max()), float(np.diff(indenter.extent)[0]) / 2)
    a = widest * np.linspace(_CLOSED, 1, _POINTS)
    return [_curve(history, step, a) for step in steps]


def _curve(history: History, step: int, a: Array) -> Curve:
    """U = ∫ (k/2 g² + γ₁/2 f'²) dx + √(kγ₁) g(a)² - 2wa, outside decaying over l by Eq. (6)."""
    scene, depth = history.scene, float(history.depth[step])
    k, gamma1, ell = scene.stiffness, scene.gamma1, scene.elastocapillary_length
    apex, (x, weight) = scene.indenter.apex or 0.0, np.polynomial.legendre.leggauss(40)
    at = apex + a[:, None] * (1 + x) / 2
    g, slope = depth - scene.indenter.height(at), scene.indenter.slope(at)
    inside = a * ((k * g**2 + gamma1 * slope**2) / 2 @ weight)
    end = depth - scene.indenter.height(apex + a)
    energy = inside + np.sqrt(gamma1 * k) * end**2 - 2 * scene.work_of_adhesion * a
    through = ell * scene.indenter.slope(apex + a) < end
    return Curve(depth, a, energy, through, (history.at(step).half_width, history.at(step).energy))


def landscape(history: History, steps: Sequence[int]) -> Figure:
    """U(a; d) at the depths of these steps; thin where the surface would pass through the indenter.

    A filled dot is the state of the path, a ring the detached surface.
    """
    (drawn, axes), found = canvas(8, 5.5), curves(history, steps)
    states = np.array([curve.state for curve in found])
    shown = np.concatenate([states[:, 1], [curve.energy[0] for curve in found]])
    depth, x = prefixed([curve.depth for curve in found], "m"), prefixed(found[0].half_width, "m")
    y = prefixed(shown, "J/m")
    for curve, colour in zip(found, shades(len(found)), strict=True):
        name = f"d = {curve.depth / depth.size:.3g} {depth.symbol}".replace("-", "−")
        a, energy = curve.half_width / x.size, curve.energy / y.size
        axes.plot(a, np.where(curve.through, np.nan, energy), color=colour, lw=2, label=name)
        axes.plot(a, energy, color=colour, lw=0.7)
        at = curve.state[0] / x.size, curve.state[1] / y.size
        axes.plot(*at, "o", color=colour, ms=9, mec="black", zorder=5, clip_on=False)
    ring: dict[str, Any] = {"ls": "", "marker": "o", "mfc": "white", "mec": "black", "ms": 9}
    axes.plot(0, 0, label="detached", clip_on=False, zorder=6, **ring)
    axes.axhline(0, color="black", lw=0.6, ls=":")
    low, high = float(shown.min()) / y.size, max(float(shown.max()), 0.0) / y.size
    axes.set(ylim=(low - 0.12 * (high - low), high + 0.25 * (high - low)))
    axes.set(xlabel=f"half-width a in {x.symbol}", ylabel=f"energy U in {y.symbol}")
    axes.set(
        xlim=(0, None), title="The path (dots) stays in a minimum of the energy until none is left"
    )
    axes.legend(fontsize=9)
    axes.grid(alpha=0.25)
    return drawn
