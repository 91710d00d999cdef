"""Energy landscapes of a load path: U(a; d) with the states of the path on it.

At a depth d every half-width a has its surface of least energy: u = d - f in the contact and free
beside it. U(a; d) is the energy of that surface; its minima over a are the states of a path under
imposed depth, and what separates one from the detached surface, U = 0, is the barrier that keeps it
metastable.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import History
from discretization.fitted.free_surface import OVERHANG
from discretization.fitted.lines import Problem
from discretization.fitted.quadrature import totals
from discretization.fitted.response import chosen
from energy.units import prefixed
from studies.shared.figures import Figure, canvas, shades
from studies.shared.types import Array

_POINTS = 160
_WIDER = 1.3
_CLOSED = 1e-3


class Curve(NamedTuple):
    """U (n,) over the half-width a (n,) at the depth of a step; nan where there is no surface.

    through: the surface would pass through the indenter; state: (a, U) of the path at this step.
    """

    depth: float
    half_width: Array
    energy: Array
    through: NDArray[np.bool_]
    state: tuple[float, float]


def curves(history: History, steps: Sequence[int]) -> list[Curve]:
    """Landscapes at the depths of these steps, from almost closed to wider than the states.

    ValueError for an indenter that is not symmetric, and for steps without contact.
    """
    indenter, widths = history.scene.indenter, history.half_width[list(steps)]
    if not indenter.symmetric or indenter.apex is None:
        raise ValueError(f"indenter = {indenter!r} must be symmetric for a landscape over a")
    if not np.any(widths > 0):
        raise ValueError(f"steps = {list(steps)!r} must contain one with a contact")
    widest = min(_WIDER * float(widths.max()), float(np.diff(indenter.extent)[0]) / 2)
    a = widest * np.linspace(_CLOSED, 1, _POINTS)
    return [_curve(history, step, a) for step in steps]


def _curve(history: History, step: int, a: Array) -> Curve:
    scene, depth = history.scene, float(history.depth[step])
    response, apex = chosen(scene.slopes, history.rtol), scene.indenter.apex or 0.0
    touch = float(scene.indenter.height(apex))
    problem = Problem(scene, depth, touch, 0.0, response)
    steepest = OVERHANG * scene.elastocapillary_length if scene.slopes == "finite" else math.inf
    energy, through = np.full(a.size, math.nan), np.zeros(a.size, bool)
    for i, width in enumerate(a.tolist()):
        left, right = apex - width, apex + width
        if abs(problem.displaced(right)) < steepest:
            energy[i] = totals(scene, response, depth, left, right, history.rtol)[1].energy
            through[i] = problem.jump(1, right, -1e-9 * width) < 0
    return Curve(depth, a, energy, through, (history.at(step).half_width, history.at(step).energy))


def landscape(history: History, steps: Sequence[int]) -> Figure:
    """U(a; d) at the depths of these steps; thin where the surface would pass through the indenter.

    A filled dot is the state of the path, a ring the detached surface.
    """
    (drawn, axes), found = canvas(8, 5.5), curves(history, steps)
    states = np.array([curve.state for curve in found])
    shown = np.concatenate([states[:, 1], [curve.energy[0] for curve in found]])
    depth, x, y = (
        prefixed(values, unit)
        for values, unit in (
            ([curve.depth for curve in found], "m"),
            (found[0].half_width, "m"),
            (shown, "J/m"),
        )
    )
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
