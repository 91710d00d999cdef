"""Equilibria without surface tension, γ₁ = 0, of profiles that may have several contacts.

Springs are independent: each attaches when it is touched and lets go at u = -δ₀. So the contact is
what lies below a level of the profile, that of the largest depth so far or that at which springs
let go, whichever is lower,

    adhered:  f <= min(max(d, min f), d + δ₀),        global:  f <= d + δ₀    (18).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING, Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.contacts import equilibrium, estimated
from discretization.profile import Resolved, resolve
from discretization.quadrature import NONE, Interval, refined
from discretization.roots import crossings
from discretization.surfaces.small import SmallSurfaces
from energy import Scene

Array = NDArray[np.float64]
_ENTRIES = 1 << 22  # heights that are compared with levels at once
_TIE = 1e-14  # of the level and δ₀: how far above the level a lowest point may lie by rounding


def on_springs(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """The certified state of independent springs.

    ValueError for a contact that leaves the known profile; NotCertifiedError if springs that are
    free would be touched.
    """
    profile, reach = resolve(scene, depth), scene.critical_separation
    touch = profile.touch
    level = depth + reach if branch == "global" else min(max(depth, touch), depth + reach)
    return at_level(scene, profile, depth, level, branch=branch)


def at_level(
    scene: Scene, profile: Resolved, depth: float, level: float, *, branch: str
) -> Equilibrium:
    """The certified state in which what lies below a level is in contact."""
    reach, touch = scene.opened.critical_separation, profile.touch
    surfaces = SmallSurfaces(scene)
    lift = max(abs(depth), reach) or 1.0
    if touch > level + _TIE * lift:
        apart = Certificate.undeformed(max(0.0, (depth - touch) / lift))
        return detached(scene, depth, branch, surfaces, apart)
    lines = below(profile, max(level, touch))
    found = refined(scene, depth, lines, NONE)
    pinned = np.isin(lines, profile.indenter.walls)
    judged = _judged(profile, lines, pinned, depth, level, lift, found)
    judged.demand(f"the state at depth = {depth!r}", "try another depth")
    return equilibrium(
        lines,
        found,
        scene=scene,
        depth=depth,
        pinned=pinned,
        certificate=judged,
        surfaces=surfaces,
        errors=_errors(scene, lines, pinned, depth, found),
        branch=branch,
    )


def below(profile: Resolved, level: float) -> Array:
    """Ends (m, 2) of the parts of the profile at or below a level.

    ValueError where one goes on beyond the known profile.
    """
    return np.reshape(lines_below(profile, np.array([level]))[0], (-1, 2))


def lines_below(profile: Resolved, levels: Array) -> list[Array]:
    """The ends (2m,) of the parts of the profile at or below each level (k,), all at once."""
    size = max(1, _ENTRIES // profile.x.size)
    blocks = (levels[i : i + size] for i in range(0, levels.size, size))
    return [lines for block in blocks for lines in _lines_below(profile, block)]


def _lines_below(profile: Resolved, levels: Array) -> list[Array]:
    x, f, last = profile.x, profile.f, profile.x.size - 1
    low = f <= levels[:, None]
    edges = np.diff(low.astype(np.int8), axis=1, prepend=0, append=0)
    row, at = np.nonzero(edges)
    starts = edges[row, at] > 0
    inside = np.where(starts, at, at - 1)
    outside = np.clip(np.where(starts, at - 1, at), 0, last)
    for i in (0, last):
        if (inside[outside == i] == i).any() and float(x[i]) not in profile.indenter.walls:
            raise ValueError(
                f"the contact spreads to x = {float(x[i])!r}, where the profile is not known any "
                "more; give a wider profile or a smaller depth"
            )
    level, found = levels[row], x[inside]
    own = np.flatnonzero((f[inside] < level) & (inside != outside) & (x[outside] != found))
    if own.size:
        goal, ends = level[own], (x[inside[own]], x[outside[own]])
        rise = (f[outside[own]] - f[inside[own]]) / (ends[1] - ends[0])
        guess = ends[0] + (goal - f[inside[own]]) / rise
        found[own] = crossings(
            lambda z, k: np.asarray(profile.indenter.height(z), float) - goal[k],
            np.minimum(*ends),
            np.maximum(*ends),
            guess,
            rise,
            0.0,
        )
    return np.split(found, np.cumsum(np.bincount(row, minlength=levels.size))[:-1])


def _judged(
    profile: Resolved,
    lines: Array,
    pinned: NDArray[np.bool_],
    depth: float,
    level: float,
    lift: float,
    found: Interval,
) -> Certificate:
    """penetration: of free springs; opening: none is held beyond δ₀; neighbours: of lines."""
    free = np.searchsorted(lines.ravel(), profile.x) % 2 == 0
    free &= ~np.isin(profile.x, lines)
    through = float((depth - profile.f[free]).max(initial=0.0)) / lift
    off = np.abs(np.asarray(profile.indenter.height(lines)) - level)[~pinned].max(initial=0.0)
    highest = float(profile.f[~free].max(initial=-math.inf))
    torn = max(0.0, highest - max(level, depth)) / lift
    force = abs(found.force - found.force_by_field) / (found.force_scale or 1.0)
    return Certificate(through, 0.0, torn, float(off) / lift, force)


def _errors(
    scene: Scene,
    lines: Array,
    pinned: NDArray[np.bool_],
    depth: float,
    found: Interval,
) -> dict[str, float]:
    """Rounding of the heights times the condition of the lines, and the quadrature."""
    height, slope = (
        np.asarray(part(lines), float) for part in (scene.indenter.height, scene.indenter.slope)
    )
    size = np.abs(height) + abs(depth)
    width = float(np.diff(lines, axis=1).sum())
    with np.errstate(divide="ignore", invalid="ignore"):
        moves = np.minimum((ROUNDING * size + found.rounding) / np.abs(slope), width)
    moves = np.where(pinned, 0.0, np.nan_to_num(moves, nan=width))
    push = scene.stiffness * np.abs(depth - height) * scene.measure(lines)
    pull = float((moves * push).sum())
    return estimated(found, width, float(moves.sum()), pull)
