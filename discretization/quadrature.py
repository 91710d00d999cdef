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

Conventions
-----------
Depths d and g = d - f, by which the surface is displaced in contact, are positive downwards, the
height f of the profile upwards; forces are positive if the indenter is pressed. Integrals are over
dx, or about an axis over 2πr dr. Panels are columns (2, n): their left ends and their right ends.
Contacts are rows (m, 2), from left to right; about an axis the first may begin at 0. Places are
(.., p), several densities m of them (m, .., p). Those of `densities` are five, in this order:

    0  ∫1    1  ∫g    2  ∫g²    3  ∫γ₁ψ(f')    4  ∫c s(f'), c the pattern's factor on w

A `Free` surface has its `energy` F, `pulls` S at both lines, and `area` k∫u dx over it. A profile
that is `Resolved` has its samples `x` with heights `f`, increasing, and `touch`, the depth of first
touch, its least height.

EPSILON is 2⁻⁵², ROUNDING 16 times that. `terms.contact` is the energy γ₁ψ(f') - w s(f') per length,
`Scene.spring(g)` the energy of the springs per area with its derivatives; `hookean` is whether it
is k g²/2. `height_and_slope` are f and f' at once. `measure(x)` is 1, about an axis 2πx. l =
√(γ₁/k) is `elastocapillary_length`: free surfaces of the length l on both sides feel rounding of
the height at lines, too.
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
from energy.arrays import Array, Mask

Density = Callable[[Array], Array]  # of places (.., p): several densities (m, .., p)


class PanelRules(NamedTuple):
    """When panels are halved, and how far their integrals are trusted.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each but `summed` leaves 28
    random states and paths as they are to 1e-9: `python -m tests.sensitivity
    discretization.quadrature`.

    Attributes
    ----------
    halvings : int
        Times that a panel is halved at most: 2⁻⁴⁸ of it is the spacing of floating-point numbers.
    most : int
        Panels that are halved at once at most, for each given one: more is noise of the slopes.
    summed : float
        Of the sizes of the terms of a panel's sum: its rounding. A tenth of it takes more
        than ten times as long, as panels are halved in vain.
    luck : float
        Of what a panel was off by: the error of its halves at least, where they may agree with it
        by luck.
    exact : float
        Of a whole integral: what halving a panel may change it by.
    agree : float
        Of the sizes of integrals: what they may differ by on other panels.
    close : float
        Interval between samples, or a panel's own, over the widest one, below which it counts as
        narrower: half of it is.
    samples_apart : int
        Wide intervals between samples that make one panel.
    """

    halvings: int = 48
    most: int = 20_000
    summed: float = 80 * EPSILON
    luck: float = 1 / 8
    exact: float = 1e-15
    agree: float = 1e-9
    close: float = 0.6
    samples_apart: int = 8


_PANEL = PanelRules()


class HeightSteps(NamedTuple):
    """Short steps over which heights are compared with the integral of the slope.

    They find profiles whose height and slope disagree. Halved or doubled, none of these changes 28
    random states and paths, of which one has another error estimate (`python -m tests.sensitivity
    discretization.quadrature`).

    Attributes
    ----------
    steps : int
        Number of steps in a contact.
    length : float
        Of a panel: so short that the slope is smooth on a step, so long that the height changes by
        more than its rounding.
    left_out : int
        Steps with the largest differences that do not count, as there may be a corner on them.
    golden : float
        Golden section: the fractional parts of its multiples repeat at no period of the profile.
    """

    steps: int = 32
    length: float = 2.0**-10
    left_out: int = 2
    golden: float = 0.6180339887498949


_HEIGHTS = HeightSteps()


class GaussRule(NamedTuple):
    """Places (p,) on a panel from 0 to 1, and their weights, whose sum is 1."""

    places: Array
    weights: Array

    @classmethod
    def of(cls, count: int) -> GaussRule:
        """The rule of Gauss and Legendre with so many points."""
        points, weights = np.polynomial.legendre.leggauss(count)
        return cls(points / 2 + 1 / 2, weights / 2)

    @classmethod
    def crowded(cls, count: int) -> GaussRule:
        """Twice so many points, crowded at both ends like t⁴, where a power law is not smooth.

        Each half of the panel is t⁴/2 of a Gauss rule in t from 0 to 1, or its mirror image, and
        the weights are those of the rule times 2t³.
        """
        points, weights = np.polynomial.legendre.leggauss(count)  # on [-1, 1], t = (points + 1)/2
        near = ((points + 1) / 2) ** 4 / 2
        weights = weights * ((points + 1) / 2) ** 3
        return cls(np.append(near, 1 - near), np.append(weights, weights))


# Points of Gauss rules, exact for polynomials to degree 23. Over a contact of a parabola, a circle
# or a power law |x|¹·⁵ or |x|²·⁵ the same integrals, to 1e-14, take 4 to 80 times as many values of
# f with 8 points, since panels have to be halved; with 16 they take a third more, but for |x|¹·⁵.
# Half or twice as many change none of 198 random states and paths; half as many change 84 of their
# error estimates (`python -m tests.sensitivity discretization.quadrature _GAUSS_POINTS`).
_GAUSS_POINTS = 12
_CROWDED = GaussRule.crowded(_GAUSS_POINTS)
# Two rules for panels where all is smooth: where they agree they are right.
_COARSE = GaussRule.of(_GAUSS_POINTS)
_FINE = GaussRule.of(2 * _GAUSS_POINTS)
_BOTH_PLACES = np.append(_COARSE.places, _FINE.places)
# On [-1, 1], for steps of 2⁻¹⁰ of a panel, over which f' is smooth: six points leave the twelfth
# power of such a step, far below rounding.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)


class Sums(NamedTuple):
    """Integrals of m densities over n panels.

    Attributes
    ----------
    ends : ndarray (2, n)
        Of the panels, in no order.
    sums, sizes, off : ndarray (m, n)
        Integrals over each panel, those of absolute values, and errors.
    """

    ends: Array
    sums: Array
    sizes: Array
    off: Array


class Halves(NamedTuple):
    """Integrals over n panels, and over their halves.

    Attributes
    ----------
    ends : ndarray (2, 2, n)
        Ends (2) of the first and the second halves (2) of the panels.
    divisible : ndarray of bool (n,)
        Whether there is a floating-point number in the middle.
    coarse, coarse_sizes : ndarray (m, n)
        Integrals over the panels, and of absolute values.
    sums, sizes : ndarray (m, n)
        The same over both halves together.
    """

    ends: Array
    divisible: Mask
    coarse: Array
    coarse_sizes: Array
    sums: Array
    sizes: Array

    @classmethod
    def of(cls, density: Density, ends: Array) -> Halves:
        """Of panels with ends (2, n)."""
        low, high = ends
        middle = ends.sum(axis=0) / 2
        # Ends (2) of each panel and of both its halves (3).
        panels = np.array([[low, low, middle], [high, middle, high]])
        sums, sizes = over(density, panels)
        return cls(
            ends=panels[:, 1:],
            divisible=(low < middle) & (middle < high),
            coarse=sums[:, 0],
            coarse_sizes=sizes[:, 0],
            sums=sums[:, 1:].sum(axis=1),
            sizes=sizes[:, 1:].sum(axis=1),
        )


def over(density: Density, ends: Array) -> tuple[Array, Array]:
    """Integrals over panels as they are, by one rule whose points are crowded at both ends.

    Parameters
    ----------
    density : callable
        m densities (m, ..., p) at places (..., p).
    ends : ndarray (2, ...)
        Of the panels; the integral from an end to a smaller one is negative, and its size, too.

    Returns
    -------
    sums, sizes : ndarray (m, ...)
        Integrals, and those of absolute values.
    """
    values, width = _at_places(density, ends)
    return (values @ _CROWDED.weights) * width, (np.abs(values) @ _CROWDED.weights) * width


def _at_places(density: Density, ends: Array) -> tuple[Array, Array]:
    """Densities (m, ..., p) at the p places of the crowded rule on panels, and their widths."""
    low, high = ends[..., None]
    values = density(low + (high - low) * _CROWDED.places)
    return values, (high - low)[..., 0]


def summed(density: Density, ends: Array, part: float, lost: Array, *, smooth: bool) -> Sums:
    """Integrals over panels that are halved until that changes nothing.

    A panel is done when halving it changes its integral by at most

        max(part · ∫|density| + lost, 80 ε of its own size),

    the integral over all given panels, and with it the halves of each. It is also done if it is as
    narrow as numbers allow; all are if they have been halved 48 times, or are too many.

    Parameters
    ----------
    density : callable
        m densities.
    ends : ndarray (2, n)
        Of the panels.
    part : float
        As in the rule above, dimensionless.
    lost : ndarray (m, 1)
        What the integrals are off by however often panels are halved.
    smooth : bool
        Whether the densities are, on each panel. Else halves that agree with the whole by luck
        count as off by an eighth of what that was off by.

    Returns
    -------
    Sums
    """
    done: list[Sums] = []
    limit = None
    luck = np.zeros((len(lost), 1))  # what each panel is off by at least, though its halves agree
    most = _PANEL.most * ends.shape[1]
    for left in reversed(range(_PANEL.halvings)):
        panels = Halves.of(density, ends)
        if limit is None:
            limit = part * panels.coarse_sizes.sum(axis=1, keepdims=True) + lost
        change = np.abs(panels.sums - panels.coarse)
        off = np.maximum(change, luck)
        unresolved = (off > np.maximum(limit, _PANEL.summed * panels.sizes)).any(axis=0)
        unresolved &= panels.divisible
        if not left or not unresolved.any() or unresolved.sum() > most:
            done.append(Sums(ends, panels.sums, panels.sizes, off))
            break
        all_panels = (ends, panels.sums, panels.sizes, off)
        done.append(Sums(*(each[:, ~unresolved] for each in all_panels)))
        ends = panels.ends[:, :, unresolved].reshape(2, -1)
        luck = np.tile(change[:, unresolved] * (0.0 if smooth else _PANEL.luck), 2)
    found = done[0]
    if len(done) > 1:
        found = Sums(*map(np.hstack, zip(*done, strict=True)))
    found.off[:, :1] += lost  # once, with the first panel
    return found


def summed_each(density: Density, ends: Array, *, smooth: bool) -> Array:
    """Integrals over each of some panels, to rounding of its own size.

    Where Gauss's rules of 12 and of 24 points agree they are right; other panels are halved as in
    `summed`, each by itself: what a panel gives does not depend on the others. No density may
    change its sign on a panel, as an integral is judged by its own size.

    Parameters
    ----------
    density : callable
        m densities.
    ends : ndarray (2, n)
    smooth : bool
        As in `summed`.

    Returns
    -------
    ndarray (m, n)
    """
    low = ends[0]
    width = ends[1] - ends[0]
    values = density(low[:, None] + width[:, None] * _BOTH_PLACES)
    count = _COARSE.places.size
    coarse = values[..., :count] @ _COARSE.weights * width
    total = np.asarray(values[..., count:] @ _FINE.weights * width)
    unresolved = (np.abs(total - coarse) > ROUNDING * np.abs(total)).any(axis=0)
    if unresolved.any():
        total[:, unresolved] = _halved_each(density, ends[:, unresolved], smooth)
    return total


def _halved_each(density: Density, ends: Array, smooth: bool) -> Array:
    """Integrals (m, n) over panels (2, n) that are halved until that changes nothing.

    As `summed`, but each of the given panels has a limit of its own, rounding of its integral.

    density, smooth: as of `summed`; ends (2, n): of the given panels.
    """
    count = ends.shape[1]
    own = np.arange(count)  # the given panel of which each is a part
    luck = np.zeros(1)
    panels = Halves.of(density, ends)
    limit = ROUNDING * panels.coarse_sizes
    total = np.zeros_like(limit)
    for left in reversed(range(_PANEL.halvings)):
        change = np.abs(panels.sums - panels.coarse)
        off = np.maximum(change, luck)
        unresolved = (off > np.maximum(limit[:, own], _PANEL.summed * panels.sizes)).any(axis=0)
        unresolved &= panels.divisible
        if not left or unresolved.sum() > _PANEL.most * count:
            unresolved[:] = False
        for row in range(len(total)):
            total[row] += np.bincount(own[~unresolved], panels.sums[row, ~unresolved], count)
        if not unresolved.any():
            break
        ends = panels.ends[:, :, unresolved].reshape(2, -1)
        own = np.tile(own[unresolved], 2)
        luck = np.tile(change[:, unresolved] * (0.0 if smooth else _PANEL.luck), 2)
        panels = Halves.of(density, ends)
    return total


def densities(scene: Scene, level: float, x: Array) -> Array:
    """Densities of ∫1, ∫g, ∫g², ∫γ₁ψ(f') and ∫c s(f'), g = level - f, over dx or 2πr dr.

    c is the factor of the scene's pattern on the work of adhesion; s is 1 with small slopes. Of
    springs that are not linear with the energy e(g) per area, g and g² are e'/k and 2e/k.

    Parameters
    ----------
    scene : Scene
    level : float
        The depth from which g counts [length].
    x : ndarray
        Positions [length].

    Returns
    -------
    ndarray (5, ...)
        In the order of the summary.
    """
    height, slope = scene.indenter.height_and_slope(x)
    g = level - height
    stored = terms.contact(slope, gamma1=scene.gamma1, w=0.0, slopes=scene.slopes)
    bound = np.ones_like(slope) if scene.slopes == "small" else np.sqrt(1 + slope * slope)
    if scene.pattern is not None:
        bound = bound * scene.pattern.factor(x)
    pressed = np.array([g, g * g])
    if not scene.hookean:
        spring = scene.spring(g)
        pressed = np.array([spring.first, 2 * spring.value]) / scene.stiffness
    found = np.array([np.ones_like(slope), *pressed, stored, bound])
    return found * scene.measure(x) if scene.axisymmetric else found


class ContactParts(NamedTuple):
    """What contacts store, and how they press; per length of a line contact.

    Attributes
    ----------
    springs, surface : float
        ∫ k/2 g² dx and ∫ γ₁ψ(f') dx [energy].
    adhesion : float
        w ∫ c s(f') dx, what adhesion binds, positive [energy].
    pressure : float
        k∫g dx [force].
    """

    springs: float
    surface: float
    adhesion: float
    pressure: float


class ContactIntegrals(NamedTuple):
    """Integrals over contacts.

    Attributes
    ----------
    totals, sizes, errors : ContactParts
        The integrals, those of absolute values, and what the integrals may be off by.
    rounding : float
        What the heights are off by as measured, which is counted in the errors [length].
    hidden : ndarray
        Places of features that the samples of the profile have missed [length].
    """

    totals: ContactParts
    sizes: ContactParts
    errors: ContactParts
    rounding: float
    hidden: Array


def in_contact(
    scene: Scene, depth: float, contacts: Array, profile: Resolved | None = None
) -> ContactIntegrals:
    """Springs, surface, adhesion and pressure over contacts.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    contacts : ndarray (m, 2)
        Their ends [length].
    profile : Resolved, optional
        With whose samples panels are compared.

    Returns
    -------
    ContactIntegrals
    """
    ends = _ends(scene, contacts)
    smooth = scene.indenter.complete
    rounding = height_rounding(scene.indenter, ends.T)
    lost = np.zeros((5, 1))  # what rounding of f takes from ∫g and from ∫g²
    if rounding:
        deepest = float(np.abs(depth - scene.indenter.height(ends)).max())
        wide = np.diff(contacts).sum() + 2 * scene.elastocapillary_length
        lost[1] = rounding * wide * float(scene.measure(contacts.max()))
        lost[2] = 2 * deepest * lost[1]
    part = ROUNDING / max(1, ends.shape[1])
    density = functools.partial(densities, scene, depth)
    sums = summed(density, ends, part, lost, smooth=smooth)
    hidden = np.empty(0)
    if profile is not None and not smooth:
        sums = _compared(scene, density, contacts, profile, sums, part, lost)
        hidden = profile.hidden(scene, _closer(profile, sums.ends))
    # Of each density its integral, that of its absolute value, and the error of the first (3,).
    _, g, g_squared, stretched, bound = np.array(sums[1:]).sum(axis=2).T
    k = scene.stiffness
    parts = [g_squared * (k / 2), stretched * 1.0, bound * scene.work_of_adhesion, g * k]
    totals, sizes, errors = (ContactParts(*row) for row in np.array(parts).T.tolist())
    return ContactIntegrals(totals, sizes, errors, rounding, hidden)


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
    resolved. So the integrals are compared with those over narrower panels, as they are and, if
    these differ, halved until that changes nothing. If they then still differ, the latter count.

    Parameters
    ----------
    sums : Sums
        Of the wide panels.
    density, part, lost
        As of `summed`, from which `sums` come.
    """
    ends = _ends(scene, contacts, _thinned(profile.x))
    allowed = sums.off.sum(axis=1) + lost[:, 0] + _PANEL.agree * sums.sizes.sum(axis=1)

    def agree(found: Array) -> bool:
        """Whether integrals over panels (5, n) add up to those of the wide ones."""
        return bool((np.abs(found.sum(axis=1) - sums.sums.sum(axis=1)) <= allowed).all())

    if agree(over(density, ends)[0]):
        return sums
    closer = summed(density, ends, part, lost, smooth=False)
    return sums if agree(closer.sums) else closer


def _thinned(x: Array) -> Array:
    """Samples where they are closer than elsewhere, and every eighth of the others.

    So a panel is narrow where the profile needs it, and there are few where it does not.
    """
    width = np.diff(x)
    close = width < _PANEL.close * width.max()
    kept = np.append(False, close) | np.append(close, False)
    kept[:: _PANEL.samples_apart] = True
    return x[kept]


def _closer(profile: Resolved, ends: Array) -> Array:
    """Gauss points of those panels (2, n) that are narrower than the intervals between samples.

    Of these it is known what the samples have not seen.
    """
    x = profile.x
    middle = ends.sum(axis=0) / 2
    i = np.clip(np.searchsorted(x, middle, "right") - 1, 0, x.size - 2)
    narrow = ends[1] - ends[0] < _PANEL.close * (x[i + 1] - x[i])
    low, high = ends[:, narrow]
    return np.asarray((low[:, None] + (high - low)[:, None] * _CROWDED.places).ravel())


def _ends(scene: Scene, contacts: Array, more: ArrayLike = ()) -> Array:
    """Ends (2, n) of the panels of contacts (m, 2).

    They are those of the contacts and, inside, the breaks of the profile, the edges of a pattern,
    and `more` places. As contacts do not overlap, all left ends and all right ends, each in
    increasing order, make pairs.
    """
    cuts = np.append(scene.indenter.breaks(), more)
    if scene.pattern is not None:
        cuts = np.append(cuts, scene.pattern.edges)
    own = contacts[:, 0].searchsorted(cuts) - 1  # the last contact that begins before
    inner = cuts[(own >= 0) & (cuts < contacts[own, 1])]
    if np.size(more):  # breaks are samples, too
        inner = np.unique(inner)
    return np.sort([np.concatenate([end, inner]) for end in contacts.T])


def height_rounding(indenter: Indenter, ends: Array) -> float:
    """How far f(x) is off by its own arithmetic.

    It may lose digits that the height itself has not: cosh(x) - 1 is a multiple of 2⁻⁵³ however
    small x is. Over a short step s the height must change by the integral of the slope,

        f(x + s) - f(x) = ∫ f' dx,    s = 2⁻¹⁰ of a panel,

    which Gauss points give exactly for a profile that is smooth on s; what the two differ by is the
    rounding of f. Corners nobody declared fall on few of the steps, which are left out.

    Parameters
    ----------
    indenter : Indenter
    ends : ndarray (n, 2)
        Of panels [length].

    Returns
    -------
    float
        [length]; 0 for indenters that say where they are smooth: their heights are computed without
        such a loss.
    """
    if indenter.complete or not (ends[:, 1] > ends[:, 0]).any():
        return 0.0
    panels = ends[ends[:, 1] > ends[:, 0]]
    number = np.arange(_HEIGHTS.steps)
    low, high = panels[number * len(panels) // _HEIGHTS.steps].T  # as many steps in each panel
    width = high - low
    place_in_panel = number * _HEIGHTS.golden % 1
    start = low + width * (1 - _HEIGHTS.length) * place_in_panel
    stop = np.minimum(start + _HEIGHTS.length * width, high)

    x = start[:, None] + np.outer(stop - start, (_POINTS + 1) / 2)
    slope = np.asarray(indenter.slope(x), float)
    by_slope = (slope @ _WEIGHTS) * ((stop - start) / 2)
    by_height = np.asarray(indenter.height(stop), float) - np.asarray(indenter.height(start), float)
    differences = np.sort(np.abs(by_height - by_slope))
    return float(differences[-1 - _HEIGHTS.left_out])


class Interval(NamedTuple):
    """Totals over contacts and their free surfaces, with the force by two routes.

    Attributes
    ----------
    energy, force : float
        U and P = dU/dd, what presses in contact and what the lines pull.
    force_by_field : float
        k∫u dx over contacts and free surfaces, the same but for errors.
    energy_scale, force_scale : float
        Sums of the sizes of the terms.
    errors : tuple of float
        Of energy and force, absolute: those of the integrals over the contacts.
    rounding : float
        What measured heights are off by, which is counted in these [length].
    hidden : ndarray
        Places of features that the samples of the profile have missed [length].
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
    """Energy and force of contacts and of the free surfaces beside them.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    contacts : ndarray (m, 2)
        [length].
    free : sequence of Free
        All free surfaces.
    profile : Resolved, optional
        As in `in_contact`.

    Returns
    -------
    Interval
    """
    found = in_contact(scene, depth, contacts, profile)
    totals = found.totals
    errors = found.errors
    pulls = [pull for surface in free for pull in surface.pulls]
    stored = totals.springs + totals.surface + sum(surface.energy for surface in free)
    return Interval(
        energy=stored - totals.adhesion,
        force=totals.pressure + sum(pulls),
        force_by_field=totals.pressure + sum(surface.area for surface in free),
        energy_scale=stored + totals.adhesion,
        force_scale=found.sizes.pressure + sum(map(abs, pulls)),
        errors=(errors.springs + errors.surface + errors.adhesion, errors.pressure),
        rounding=found.rounding,
        hidden=found.hidden,
    )


@dataclass(frozen=True, eq=False)
class Integrals:
    """The integrals of `densities` over a resolved profile, g from the depth of first touch.

    Only of what may be in contact: intervals between samples whose lower end stands higher than a
    level have the integral 0, as no line gets there and what they add would but cost digits.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
    x, f : ndarray (n,)
        Places, increasing, and heights there [length]: samples, and where panels were halved.
    parts : ndarray (5, n)
        Integrals from the lowest point to each place, in the order of `densities`; on the left of
        the lowest point they are negative where the density is positive.
    hidden : ndarray
        Places of features that the samples of the profile have missed [length].
    """

    scene: Scene
    profile: Resolved
    x: Array
    f: Array
    parts: Array
    hidden: Array

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, level: float) -> Integrals:
        """Summed between the samples, outwards from the lowest point.

        Parameters
        ----------
        scene : Scene
        profile : Resolved
        level : float
            Height up to which there may be contact [length].

        Returns
        -------
        Integrals
        """
        density = functools.partial(densities, scene, profile.touch)
        between_samples = np.array([profile.x[:-1], profile.x[1:]])
        is_low = np.minimum(profile.f[:-1], profile.f[1:]) <= level
        is_low &= between_samples[0] < between_samples[1]
        no_loss = np.zeros((5, 1))
        found = summed(density, between_samples[:, is_low], _PANEL.exact, no_loss, smooth=True)

        x = np.unique(np.append(profile.x, found.ends))
        f = np.asarray(profile.indenter.height(x), float)
        sums = np.zeros((5, x.size - 1))
        sums[:, np.searchsorted(x, found.ends[0])] = found.sums
        lowest = int(np.argmin(f))
        leftwards = sums[:, :lowest][:, ::-1]  # from the lowest point on
        before = -np.cumsum(leftwards, axis=1)[:, ::-1]
        after = np.cumsum(sums[:, lowest:], axis=1)
        parts = np.hstack([before, np.zeros((5, 1)), after])

        hidden = np.empty(0)
        if not profile.indenter.complete:
            hidden = profile.hidden(scene, _closer(profile, found.ends))
        return cls(scene, profile, x, f, parts, hidden)

    def at(self, x: Array) -> Array:
        """The integrals of `densities` from the lowest point to places.

        They are those to the lower one of the two neighbours in `x`, and one panel from there.

        Parameters
        ----------
        x : ndarray (n,)
            [length].

        Returns
        -------
        ndarray (5, n)
        """
        last = self.x.size - 1
        before = np.clip(np.searchsorted(self.x, x) - 1, 0, last)
        after = np.minimum(before + 1, last)
        lower = np.where(self.f[before] <= self.f[after], before, after)
        density = functools.partial(densities, self.scene, self.profile.touch)
        values, width = _at_places(density, np.array([self.x[lower], x]))
        return self.parts[:, lower] + (values @ _CROWDED.weights) * width

    def contact(self, x: Array, depth: Array, w: float) -> Array:
        """What contacts cost from the lowest point up to lines; see the head of the module.

        Parameters
        ----------
        x, depth : ndarray (n,)
            Positions of the lines, and depths [length].
        w : float
            Work of adhesion [energy/area].

        Returns
        -------
        ndarray (3, n)
            C(x), the sum of the absolute values of its terms, and ∂C/∂d.
        """
        width, g, g_squared, stored, bound = self.at(x)
        d = depth - self.profile.touch  # so that depth - f is d + g
        k = self.scene.stiffness
        springs = [k / 2 * d * d * width, k * d * g, k / 2 * g_squared]
        parts = np.array([*springs, stored, -w * bound])
        total = parts.sum(axis=0)
        sizes = np.abs(parts).sum(axis=0)
        force = k * (d * width + g)
        return np.array([total, sizes, force])
