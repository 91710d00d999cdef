"""All states of one contact whose line rests freely, from its loss to a depth, without a search.

Where a line rests is the depth D(a), a function of the half-width a; so is the force there. A path
of depths has to find a for each depth, and where the contact is lost. Here a is chosen: D, P and
the certificate follow for all states at once. Of a convex profile D grows with a from a = 0 on;
about an axis it falls to its least value, where the contact is lost, and grows from there on
(single_contact.py).

Conventions
-----------
The depth d and the rest depth D(a), at which a contact of half-width (or radius) a is in
equilibrium, are positive down into the layer; the force P is positive where the indenter is
pressed. States are in the order of growing a, from the loss of contact on. D₀ is the least D.

`ManyLines.rest_depth` is D of right lines at given places; `ManyContacts.found` are the states of
contacts with given ends, of which `residual` is |D - d| over the size of depths, `stable` is
whether D grows outwards, and `lost` is whether a free surface turns over or is not resolved.

`States` have a depth, w, γ₁ and k each; `ManyLines.tense` are the lines of a `SingleContact` for
states with γ₁ > 0. `ManyStates` are the results of `found`, one entry a state. `vectorised` raises
ValueError for scenes whose states cannot be found as arrays, those of several contacts among them.
Of the indenter, `apex` is x of its lowest point and `extent` are the ends of the known profile:
with the apex at 0 and a mirror-symmetric profile, or about an axis, one half-width gives both
lines.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from discretization.certificate import TOLERANCE, NotCertifiedError
from discretization.fitted.many_lines import ManyLines, States
from discretization.fitted.many_states import ManyContacts, ManyStates
from discretization.fitted.single_contact import SingleContact
from discretization.routes import vectorised
from energy import Scene
from energy.arrays import Array

# Of l: half-widths among which the ends are. Twice or half as large ones change none of 8 random
# branches (`python -m tests.sensitivity discretization.fitted.free_branch _LOOKED_AT`).
_LOOKED_AT = np.exp2(np.arange(-30.0, 31.0, 0.5))


class SpreadRules(NamedTuple):
    """How half-widths are spread between the loss of contact and a depth.

    Where states lie depends on `coarse`, their accuracy on none of these. With half of `places` or
    of `rounds` the first state moves by 2e-8 or 1e-7 of its scale; with twice as many by 2e-9 or
    less (`python -m tests.sensitivity discretization.fitted.free_branch`).

    Attributes
    ----------
    places : int
        Places among which each end is looked for. The next ones lie between the two neighbours of
        the least D, 16 times as close, and between both places around the end, 32 times as close.
    rounds : int
        How often that is repeated; after that a parabola and a straight line are exact to rounding
        of D.
    coarse : int
        Half-widths between which others are interpolated, so that their roots are evenly spaced.
    uneven : float
        Times the mean: how far apart neighbouring roots √(D - D₀) may be at most.
    """

    places: int = 33
    rounds: int = 3
    coarse: int = 33
    uneven: float = 3.0


_SPREAD = SpreadRules()


RestDepths = Callable[[Array], Array]


class FreeBranch(NamedTuple):
    """States from the last one that holds to the deepest.

    Attributes
    ----------
    half_width, depth : ndarray (n,)
        [length].
    force : ndarray (n,)
        [force], or this per length of a line contact.
    """

    half_width: Array
    depth: Array
    force: Array


def applies(scene: Scene) -> bool:
    """Whether there is one contact, whose lines are free, not pinned, from its loss on.

    That is where `minimise_many` applies, with surface tension, of a profile without corners; a
    line contact has to be symmetric about x = 0 as well.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    bool
    """
    body = scene.indenter
    try:
        vectorised(scene)
    except ValueError:
        return False
    lone_line = scene.axisymmetric or (body.symmetric and body.apex == 0)
    return bool(lone_line and scene.gamma1 > 0 and not body.corners)


def free_branch(scene: Scene, deepest: float, count: int) -> FreeBranch | None:
    """States of a scene to which this `applies`, from the loss of contact to a depth.

    The roots √(d - d₀) of the distances of their depths from the first one are about evenly spaced,
    since the force is smooth over these: next to the loss, where D is least, a and P vary like the
    root.

    Parameters
    ----------
    scene : Scene
    deepest : float
        The depth of the last state [length].
    count : int
        How many states.

    Returns
    -------
    FreeBranch or None
        None where the profile is not known so far, where it changes so much beside its lowest point
        that the roots are not evenly spaced, or where the free surface beside one of the lines
        turns over or is not resolved.

    Raises
    ------
    NotCertifiedError
        If one of the states is no equilibrium: D differs from the depth by more than TOLERANCE of
        the terms it consists of, or does not grow outwards.
    """
    contact = SingleContact.of(scene)

    def rest_depth(a: Array) -> Array:
        """D of the right lines of contacts with these half-widths (n,) [length]."""
        states = _of_scene(scene, np.zeros_like(a))  # any depths, as D does not depend on them
        return ManyLines.tense(contact, states).rest_depth(1, a, np.arange(a.size))

    places = scene.elastocapillary_length * _LOOKED_AT
    places = places[places < scene.indenter.extent[1]]
    lowest = None if scene.axisymmetric else 0.0
    spread = spread_evenly(rest_depth, places, lowest, deepest, count)
    if spread is None:
        return None
    a, depth = spread
    found = _states(contact, a, depth)
    if found.lost.any():
        return None
    at_rest = found.residual <= TOLERANCE
    wrong = ~(at_rest & found.stable)
    wrong[0] = not at_rest[0]  # the last state that holds is on a fold
    if wrong.any():
        i = int(wrong.argmax())
        raise NotCertifiedError(
            f"the contact of half-width {float(a[i])!r} at depth = {float(depth[i])!r} is no "
            "equilibrium; use minimise there, which says more"
        )
    return FreeBranch(a, depth, found.force)


def spread_evenly(
    rest_depth: RestDepths, places: Array, lowest: float | None, deepest: float, count: int
) -> tuple[Array, Array] | None:
    """Half-widths from the least D to where D is `deepest`, and D there.

    The roots √(D - D₀) are about evenly spaced. First a few half-widths are tried whose own roots
    √(a - a₀) are, and then a is interpolated over √(D - D₀) by a spline.

    Parameters
    ----------
    rest_depth : callable
        D (n,) at half-widths (n,) [length].
    places : ndarray (n,)
        Half-widths among which both ends are [length].
    lowest : float or None
        Where D is least if it only grows, None if it has to fall first [length].
    deepest : float
        [length].
    count : int
        How many half-widths.

    Returns
    -------
    a, depth : ndarray (count,)
        Half-widths and D there, both increasing [length]. None in place of both where `places` do
        not reach far enough, where D does not grow, or the roots are not evenly spaced.
    """
    ends = _ends(rest_depth, places, lowest, deepest)
    if ends is None:
        return None
    lost, largest = ends
    a = lost + (largest - lost) * np.linspace(0.0, 1.0, _SPREAD.coarse) ** 2
    root = _roots(rest_depth(a))
    if not (np.diff(root) > 0).all():
        return None
    a = CubicSpline(root, a)(np.linspace(0.0, root[-1], count))
    a[0] = lost
    a[-1] = largest
    if not (np.diff(a) > 0).all():
        return None
    depth = rest_depth(a)
    steps = np.diff(_roots(depth))
    if not (steps > 0).all() or steps.max() > _SPREAD.uneven * steps.mean():
        return None
    return a, depth


def _roots(depth: Array) -> Array:
    """√(d - d₀) of depths (n,), with the first one d₀; 0 of any that are less by rounding."""
    return np.sqrt(np.maximum(depth - depth[0], 0.0))


def _ends(
    rest_depth: RestDepths, places: Array, lowest: float | None, deepest: float
) -> tuple[float, float] | None:
    """Half-widths at which the contact is lost, and at which its line rests at a depth.

    D is least at the first, and `deepest` at the other one. They are looked for between ever closer
    places, and are at last the lowest point of a parabola through three places, and the zero of a
    straight line: D is then known to rounding where it is least. Where D is least at the first of
    the places and `lowest` is given, the contact is lost at `lowest`.

    Parameters as of `spread_evenly`. None if they are not among the places.
    """
    depth = rest_depth(places)
    least = int(np.argmin(depth))
    beyond = np.flatnonzero(depth[least:] > deepest)
    if not beyond.size:
        return None
    outer = least + int(beyond[0])
    falls_first = least > 0
    if outer == 0 or (lowest is None and not falls_first):
        return None
    around_least = (float(places[max(least - 1, 0)]), float(places[least + 1]))
    around_end = (float(places[outer - 1]), float(places[outer]))
    for _ in range(_SPREAD.rounds):
        near_least = np.linspace(*around_least, _SPREAD.places)
        near_end = np.linspace(*around_end, _SPREAD.places)
        depth = rest_depth(np.append(near_least, near_end))  # of both at once
        fall = depth[: _SPREAD.places]  # D around its least value
        excess = depth[_SPREAD.places :] - deepest
        # The least D has a neighbour on both sides; the first D above `deepest` has one before it.
        i = int(np.clip(np.argmin(fall), 1, _SPREAD.places - 2))
        j = int(np.clip(np.argmax(excess > 0), 1, _SPREAD.places - 1))
        around_least = (float(near_least[i - 1]), float(near_least[i + 1]))
        around_end = (float(near_end[j - 1]), float(near_end[j]))
    largest = _zero_of_line(around_end, excess[j - 1 : j + 1].tolist())
    if lowest is not None and not falls_first:
        return lowest, largest
    return _least_of_parabola(around_least, fall[i - 1 : i + 2].tolist()), largest


def _zero_of_line(places: tuple[float, float], values: list[float]) -> float:
    """Where the straight line through the values at two places is 0."""
    low, high = places
    before, after = values
    return low - before * (high - low) / (after - before)


def _least_of_parabola(places: tuple[float, float], values: list[float]) -> float:
    """Where a parabola is least; the middle if it has no least value.

    places: two places, between which the third one is half-way; values: at these three, in order.
    """
    inner, outer = places
    before, middle, after = values
    bend = before - 2 * middle + after
    shift = (before - after) / (2 * bend) if bend > 0 else 0.0
    return (inner + outer) / 2 + shift * (outer - inner) / 2


def _states(contact: SingleContact, a: Array, depth: Array) -> ManyStates:
    """The states with half-widths a (n,) at the depths D (n,), at which these are at rest."""
    states = _of_scene(contact.scene, depth)
    left = np.zeros_like(a) if contact.scene.axisymmetric else -a
    return ManyContacts(ManyLines.tense(contact, states), states, left, a).found


def _of_scene(scene: Scene, depth: Array) -> States:
    """The parameters of n states of one scene at depths (n,)."""
    parameters = scene.work_of_adhesion, scene.gamma1, scene.stiffness
    return States(depth, *(np.full_like(depth, value) for value in parameters))
