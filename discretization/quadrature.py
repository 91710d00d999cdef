"""Integrals over the profile, by Gauss points on panels that are halved until that changes nothing.

Panels end at corners, knots, the apex and the edges of a pattern, between which a built-in indenter
is smooth. Of one that does not say so (Indenter.complete) a panel and its halves may agree by luck
beside a jump of the slope or of a higher derivative. There the halves are no better than a part of
what the panel was off by: that counts, too. What is off by rounding of sums or heights is kept.

States integrate over their contacts (`refined`); for lines that move the sums are made once
(`Integrals`). A free surface between the contact lines q < p bounds the contact on its left and
that on its right. Of the energy and the force of a state it accounts for

    E = C(q) - C(p) + F,      P = ∂C/∂d (q) - ∂C/∂d (p) + S_q + S_p,
    C(x) = ∫ [k/2 (d - f)² + γ₁ ψ(f') - w s(f')] dx  from the lowest point to x,

ψ and s the density and the length of the surface in contact (energy/terms.py), F and S what the
free surface stores and pulls. Summed over all free surfaces, the tails among them, that is U and P:
what lies between the lowest point and a line cancels.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import EPSILON, ROUNDING
from discretization.profile import Resolved
from discretization.surfaces.protocol import Free
from energy import Indenter, Scene, terms
from energy.arrays import Array

Density = Callable[[Array], Array]  # of places (.., p): several densities (m, .., p)
_T, _DT = np.polynomial.legendre.leggauss(12)
_NEAR, _DT = ((_T + 1) / 2) ** 4 / 2, _DT * ((_T + 1) / 2) ** 3
# of a panel, half of them for each half, crowded at its ends by t⁴, where a power law is not smooth
_AT, _OF = np.append(_NEAR, 1 - _NEAR), np.append(_DT, _DT)
_COARSE = 12  # points of the coarser one of two rules of Gauss, for panels where all is smooth
_PAIR_AT, _PAIR_OF = (
    np.hstack(part) / 2
    for part in zip(*map(np.polynomial.legendre.leggauss, (_COARSE, 2 * _COARSE)), strict=True)
)
_PAIR_AT = _PAIR_AT + 1 / 2
_HALVINGS = 48  # of a panel, to the spacing of floating-point numbers
_MOST = 20_000  # panels for each given one that are halved at once: more is noise of the slopes
_SUMMED = 80 * EPSILON  # of the sizes of the terms of a panel's sum
_LUCK = 1 / 8  # of what the whole was off by
_EXACT = 1e-15  # of a whole integral: what halving a panel may change it by
_STEPS = 32  # steps of a contact in which heights are read
_SHORT = 2.0**-10  # of a panel: a slope is smooth there, a height changes by more than its rounding
_AGREE = 1e-9  # of the sizes of integrals: by no more do they differ on other panels
_CLOSE = 0.6  # of the widest interval between samples, or of a panel's own: half of it is closer
_APART = 8  # wide intervals between samples that make one panel
_LEFT_OUT = 2  # of the steps, those with the largest differences
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_GOLDEN = 0.6180339887498949  # irrational: no period of the profile falls on all steps


class Sums(NamedTuple):
    """Integrals (m, n) over panels with ends (2, n), those of absolute values, errors (m, n)."""

    ends: Array
    sums: Array
    sizes: Array
    off: Array


def over(density: Density, ends: Array) -> tuple[Array, Array]:
    """Integrals (m, ..) over panels with ends (2, ..) as they are, and of absolute values."""
    lo, hi = ends[..., None]
    values, width = density(lo + (hi - lo) * _AT), (hi - lo)[..., 0]
    return (values @ _OF) * width, (np.abs(values) @ _OF) * width


def summed(density: Density, ends: Array, part: float, lost: Array, *, smooth: bool) -> Sums:
    """Integrals over panels, those halved that are off by more than a part of the whole's size.

    lost (m, 1): what they are off by however often they are halved; smooth: on each panel.
    """
    done, limit, luck = list[Sums](), None, np.zeros((len(lost), 1))
    most = _MOST * ends.shape[1]
    for more in reversed(range(_HALVINGS)):
        (lo, hi), middle = ends, ends.sum(axis=0) / 2
        panels = np.array([[lo, lo, middle], [hi, middle, hi]])  # whole ones and their halves
        sums, sizes = over(density, panels)
        if limit is None:
            limit = part * sizes[:, 0].sum(axis=1, keepdims=True) + lost
        both, size = sums[:, 1:].sum(axis=1), sizes[:, 1:].sum(axis=1)
        off = np.maximum(apart := np.abs(both - sums[:, 0]), luck)
        rough = (off > np.maximum(limit, _SUMMED * size)).any(axis=0)
        rough &= (lo < middle) & (middle < hi)
        if not (more and rough.any() and rough.sum() <= most):
            done.append(Sums(ends, both, size, off))
            break
        done.append(Sums(*(each[:, ~rough] for each in (ends, both, size, off))))
        ends = panels[:, 1:, rough].reshape(2, -1)
        luck = np.tile(apart[:, rough] * (0.0 if smooth else _LUCK), 2)
    found = Sums(*map(np.hstack, zip(*done, strict=True))) if done[1:] else done[0]
    found.off[:, :1] += lost
    return found


def summed_each(density: Density, ends: Array, *, smooth: bool) -> Array:
    """Integrals (m, n) over each of the panels with ends (2, n), to rounding of its own size.

    Where Gauss's rules of 12 and of 24 points agree they are right; other panels are halved as in
    `summed`, each by itself: what a panel gives does not depend on the others. No density changes
    its sign.
    """
    lo, width = ends[0], ends[1] - ends[0]
    values = density(lo[:, None] + width[:, None] * _PAIR_AT)
    coarse = values[..., :_COARSE] @ _PAIR_OF[:_COARSE] * width
    total = np.asarray(values[..., _COARSE:] @ _PAIR_OF[_COARSE:] * width)
    rough = (np.abs(total - coarse) > ROUNDING * np.abs(total)).any(axis=0)
    if rough.any():
        total[:, rough] = _halved_each(density, ends[:, rough], smooth)
    return total


def _halved_each(density: Density, ends: Array, smooth: bool) -> Array:
    """Integrals (m, n) over panels that are halved until that changes nothing."""
    count = ends.shape[1]
    own, luck = np.arange(count), np.zeros(1)
    total = limit = np.zeros((0, 0))
    for more in reversed(range(_HALVINGS)):
        (lo, hi), middle = ends, ends.sum(axis=0) / 2
        panels = np.array([[lo, lo, middle], [hi, middle, hi]])  # whole ones and their halves
        sums, sizes = over(density, panels)
        if not total.size:
            total = np.zeros((len(sums), count))
            limit = ROUNDING * sizes[:, 0]
        both, size = sums[:, 1:].sum(axis=1), sizes[:, 1:].sum(axis=1)
        apart = np.abs(both - sums[:, 0])
        off = np.maximum(apart, luck)
        rough = (off > np.maximum(limit[:, own], _SUMMED * size)).any(axis=0)
        rough &= (lo < middle) & (middle < hi)
        if not more or rough.sum() > _MOST * count:
            rough[:] = False
        for row in range(len(total)):
            total[row] += np.bincount(own[~rough], both[row, ~rough], count)
        if not rough.any():
            break
        ends = panels[:, 1:, rough].reshape(2, -1)
        own = np.tile(own[rough], 2)
        luck = np.tile(apart[:, rough] * (0.0 if smooth else _LUCK), 2)
    return total


def densities(scene: Scene, level: float, x: Array) -> Array:
    """Of ∫1, ∫g, ∫g², ∫γ₁ψ(f') and ∫c s(f'), g = level - f, over dx or 2πr dr.

    c: the factor of the scene's pattern on the work of adhesion.
    """
    g, slope = level - scene.indenter.height(x), np.asarray(scene.indenter.slope(x), float)
    stored = terms.contact(slope, gamma1=scene.gamma1, w=0.0, slopes=scene.slopes)
    bound = np.ones_like(slope) if scene.slopes == "small" else np.sqrt(1 + slope * slope)
    if scene.pattern is not None:
        bound = bound * scene.pattern.factor(x)
    pressed = np.array([g, g * g])
    if not scene.hookean:  # what stands for them in P and U
        pressed = np.array([scene.spring(g).first, 2 * scene.spring(g).value]) / scene.stiffness
    found = np.array([np.ones_like(slope), *pressed, stored, bound])
    return found * scene.measure(x) if scene.axisymmetric else found


def in_contact(
    scene: Scene, depth: float, contacts: Array, profile: Resolved | None = None
) -> tuple[Array, float, Array]:
    """Springs, surface, adhesion as it binds and pressure over contacts (m, 2).

    Their integrals, those of absolute values, and errors (3, 4); what the heights are off by as
    measured, which is counted in the errors; and where there are features that the samples of the
    profile, if it is given, have missed.
    """
    ends, smooth, k = _ends(scene, contacts), scene.indenter.complete, scene.stiffness
    rounding, lost = height_rounding(scene.indenter, ends.T), np.zeros((5, 1))
    if rounding:
        deepest = float(np.abs(depth - scene.indenter.height(ends)).max())
        wide = np.diff(contacts).sum() + 2 * scene.elastocapillary_length
        lost[1] = rounding * wide * float(scene.measure(contacts.max()))
        lost[2] = 2 * deepest * lost[1]
    part, density = ROUNDING / max(1, ends.shape[1]), functools.partial(densities, scene, depth)
    sums = summed(density, ends, part, lost, smooth=smooth)
    hidden = np.empty(0)
    if profile is not None and not smooth:
        sums = _compared(scene, density, contacts, profile, sums, part, lost)
        hidden = profile.hidden(scene, _closer(profile, sums.ends))
    found = np.array(sums[1:]).sum(axis=2)
    return found[:, [2, 3, 4, 1]] * (k / 2, 1.0, scene.work_of_adhesion, k), rounding, hidden


def _compared(
    scene: Scene,
    density: Density,
    contacts: Array,
    profile: Resolved,
    sums: Sums,
    part: float,
    lost: Array,
) -> Sums:
    """Sums over contacts, or what panels that end at samples of the profile add up to instead.

    Wide panels and their halves may agree by luck where both miss a feature that the samples have
    resolved. So the integrals are compared with those over narrower panels.
    """
    ends = _ends(scene, contacts, _thinned(profile.x))
    allowed = sums.off.sum(axis=1) + lost[:, 0] + _AGREE * sums.sizes.sum(axis=1)

    def agree(found: Array) -> bool:
        return bool((np.abs(found.sum(axis=1) - sums.sums.sum(axis=1)) <= allowed).all())

    if agree(over(density, ends)[0]):
        return sums
    closer = summed(density, ends, part, lost, smooth=False)
    return sums if agree(closer.sums) else closer


def _thinned(x: Array) -> Array:
    """Samples where they are closer than elsewhere, and some of the others."""
    width = np.diff(x)
    close = width < _CLOSE * width.max()
    kept = np.append(False, close) | np.append(close, False)
    kept[::_APART] = True
    return x[kept]


def _closer(profile: Resolved, ends: Array) -> Array:
    """The places at which panels (2, n) were looked at that are narrower than the samples."""
    middle, x = ends.sum(axis=0) / 2, profile.x
    i = np.clip(np.searchsorted(x, middle, "right") - 1, 0, x.size - 2)
    lo, hi = ends[:, ends[1] - ends[0] < _CLOSE * (x[i + 1] - x[i])]
    return np.asarray((lo[:, None] + (hi - lo)[:, None] * _AT).ravel())


def _ends(scene: Scene, contacts: Array, more: ArrayLike = ()) -> Array:
    """Ends (2, n) of the panels of contacts (m, 2); more: places where panels end besides."""
    cuts = np.append(scene.indenter.breaks(), more)
    if scene.pattern is not None:
        cuts = np.append(cuts, scene.pattern.edges)
    own = contacts[:, 0].searchsorted(cuts) - 1  # the contact that begins before
    inner = cuts[(own >= 0) & (cuts < contacts[own, 1])]
    if np.size(more):  # some twice
        inner = np.unique(inner)
    return np.sort([np.concatenate([end, inner]) for end in contacts.T])


def height_rounding(indenter: Indenter, ends: Array) -> float:
    """How far f(x) is off by its own arithmetic [length], on panels with ends (n, 2).

    It may lose digits that the height itself has not: cosh(x) - 1 is a multiple of 2⁻⁵³ however
    small x is. Over a short step s the height must change by the integral of the slope,

        f(x + s) - f(x) = ∫ f' dx,    s = 2⁻¹⁰ of a panel,

    which Gauss points give exactly for a profile that is smooth on s; what the two differ by is the
    rounding of f. Corners nobody declared fall on few of the steps, which are left out. 0 for
    indenters that say where they are smooth: their heights are computed without such a loss.
    """
    if indenter.complete or not (ends[:, 1] > ends[:, 0]).any():
        return 0.0
    wide = ends[ends[:, 1] > ends[:, 0]]
    lo, hi = wide[np.arange(_STEPS) * len(wide) // _STEPS].T
    start = lo + (hi - lo) * (1 - _SHORT) * (np.arange(_STEPS) * _GOLDEN % 1)
    stop = np.minimum(start + _SHORT * (hi - lo), hi)
    x = start[:, None] + np.outer(stop - start, (_POINTS + 1) / 2)
    rise = (np.asarray(indenter.slope(x), float) @ _WEIGHTS) * ((stop - start) / 2)
    step = np.asarray(indenter.height(stop), float) - np.asarray(indenter.height(start), float)
    return float(np.sort(np.abs(step - rise))[-1 - _LEFT_OUT])


class Interval(NamedTuple):
    """Totals over contacts and their free surfaces, with the force by two routes.

    errors: of energy and force; rounding: what measured heights are off by [length], among these;
    hidden: places of features that the samples of the profile have missed.
    """

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    errors: tuple[float, float] = (0.0, 0.0)
    rounding: float = 0.0
    hidden: Array = np.empty(0)

    @property
    def of_state(self) -> dict[str, Any]:
        """Energy and force with their scales, as a state has them."""
        scales = {"force": self.force_scale, "energy": self.energy_scale}
        return {"force": self.force, "energy": self.energy, "scales": scales}


def refined(
    scene: Scene,
    depth: float,
    contacts: Array,
    free: Sequence[Free],
    profile: Resolved | None = None,
) -> Interval:
    """Energy and force of contacts (m, 2) and of the free surfaces beside them."""
    parts, rounding, hidden = in_contact(scene, depth, contacts, profile)
    (springs, tension, adhesion, force), (*_, size), off = parts.tolist()
    pulls = [pull for each in free for pull in each.pulls]
    stored = springs + tension + sum(each.energy for each in free)
    by_field = force + sum(each.area for each in free)
    scales = stored + adhesion, size + sum(map(abs, pulls))
    totals = stored - adhesion, force + sum(pulls), by_field, *scales
    return Interval(*totals, (sum(off[:3]), off[3]), rounding, hidden)


@dataclass(frozen=True, eq=False)
class Integrals:
    """The integrals of `densities` over a resolved profile, g from the depth of first touch.

    Only of what may be in contact, f <= level: what stands higher would but cost digits. parts
    (5, n): from the lowest point to each x (n,), increasing, with the heights f. hidden: places of
    features that the samples of the profile have missed.
    """

    scene: Scene
    profile: Resolved
    x: Array
    f: Array
    parts: Array
    hidden: Array

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, level: float) -> Integrals:
        """Summed between the samples, outwards from the lowest point."""
        density = functools.partial(densities, scene, profile.touch)
        ends = np.array([profile.x[:-1], profile.x[1:]])
        low = (np.minimum(profile.f[:-1], profile.f[1:]) <= level) & (ends[0] < ends[1])
        found = summed(density, ends[:, low], _EXACT, np.zeros((5, 1)), smooth=True)
        x = np.unique(np.append(profile.x, found.ends))
        f = np.asarray(profile.indenter.height(x), float)
        start, sums = int(np.argmin(f)), np.zeros((5, x.size - 1))
        sums[:, np.searchsorted(x, found.ends[0])] = found.sums
        before = -np.cumsum(sums[:, :start][:, ::-1], axis=1)[:, ::-1]
        after = np.cumsum(sums[:, start:], axis=1)
        hidden = np.empty(0)
        if not profile.indenter.complete:
            hidden = profile.hidden(scene, _closer(profile, found.ends))
        return cls(scene, profile, x, f, np.hstack([before, np.zeros((5, 1)), after]), hidden)

    def at(self, x: Array) -> Array:
        """The five integrals from the lowest point to x (n,)."""
        last = self.x.size - 1
        i = np.clip(np.searchsorted(self.x, x) - 1, 0, last)
        beyond = np.minimum(i + 1, last)
        i = np.where(self.f[i] <= self.f[beyond], i, beyond)  # the lower
        density = functools.partial(densities, self.scene, self.profile.touch)
        return self.parts[:, i] + over(density, np.array([self.x[i], x]))[0]

    def contact(self, x: Array, depth: Array, w: float) -> Array:
        """C(x), the sum of its terms' absolute values, and ∂C/∂d (3, n)."""
        width, g, square, stored, bound = self.at(x)
        d, k = depth - self.profile.touch, self.scene.stiffness
        parts = np.array([k / 2 * d * d * width, k * d * g, k / 2 * square, stored, -w * bound])
        return np.array([parts.sum(axis=0), np.abs(parts).sum(axis=0), k * (d * width + g)])
