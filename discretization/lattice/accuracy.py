"""How accurate a lattice state is: next to coarser and finer lattices, and to its own parts.

With e a relative error of a, P or U, as in the docstring of `Equilibrium.error_estimate`, and Q_c
that of the same state on nodes c = 2, 1.7, 1.4 times further apart, errors are O(Δx²), so that

    e <= 3/2 |Q - Q_c|/|c² - 1|,

the largest of all c, as two errors of this order may happen to be equal; for the same reason 3/2 of
what U and P and their parts differ by, quadrature between the lines of the profile itself. If f is
not convex, nodes four times closer, c = 1/4, count as those further apart do; the energy decides
where there are contacts, and a is no more certain than U.

Where the other state has another number of contacts errors are of first order, and c² is c. Q are
totals all the same: what a contact that one of both has alone adds to them is in the estimate.

The state is not resolved, and all errors are infinite, where

    f is convex, and the contact has fewer than LEAST links and is not pinned at both ends,
    f is not convex, and on nodes four times closer a contact has fewer than 2 links, or
    the widths of the contacts that both states have differ by more than UNEVEN of all: what lies
    between the nodes decides where the lines are (nodes four times closer are also compared where
    f is convex and has corners),
    the other nodes have no contact or no state, or
    the state is detached and a lattice finer by one of FINER has a contact.

What the nodes do not resolve of the profile itself is looked for by unresolved.py.

Conventions
-----------
`fine` is the state that is judged, of the spacing Δx; the *other* state, there called `other`,
`closer` or `finer`, is that of the same scene, depth and branch on nodes c Δx apart, coarser if
c > 1. Of an `Equilibrium`, `contacts` (m, 2) are the ends of m contacts, from left to right
[length], `nodes` (m, 2) the positions of their outermost nodes, `force_parts` and `energy_parts`
P and U again by quadrature between the lines, `scales` the sums of the sizes of their terms,
`pinned` (m, 2) which ends are at corners or ends of the body. QUANTITIES are "half_width" (a, that
of all contacts together), "force" (P) and "energy" (U).

Of an indenter, `apex` is x of its lowest point if the profile falls nowhere on the way outwards,
else None; `walls` are the ends of its known profile at which the body itself ends; `corners` are x
at which f' jumps, `within(low, high)` is the part of it between two places.
`lost_too_early(scene, lattice, depth, branch)` is half the width of a contact that the profile
holds and the nodes do not, 0 if there is none. NotCertifiedError is raised by a solver that finds
no state. EPSILON is 2⁻⁵².
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.lattice.unresolved import lost_too_early
from discretization.nodes.lattice import Lattice
from discretization.profile import resolve
from energy.arrays import Mask

Solver = Callable[..., Equilibrium]  # on_lattice
LEAST = 4  # links of a resolved contact
# Of 160 rough states with several contacts, on nodes that resolve the waves, none was off by more
# than its estimate whatever these two limits are. Of 148 random shapes, on nodes as far apart as
# these are wide, two were without the limits (one by four times), and none within.
UNEVEN = 0.05  # of a: what the profile between the nodes may make of it


class Comparison(NamedTuple):
    """How a state is compared with that on other nodes.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 8 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.lattice.accuracy`.

    Attributes
    ----------
    safety : float
        Factor by which differences between two lattices are enlarged: two errors of second order
        may happen to be equal.
    closer : float
        Spacing of the nodes with which a profile that is not convex is compared, over that of the
        state.
    half_a_link : int
        Links at least of a contact on these closer nodes.
    rounding : float
        Of every quantity: what every estimate is at least.
    """

    safety: float = 1.5
    closer: float = 1 / 4
    half_a_link: int = 2
    rounding: float = 4 * EPSILON


_COMPARED = Comparison()


# Finer lattices that are searched for a contact: how much finer they are, and how many nodes they
# have on each side of the lowest point: many where a contact may be wide, 512 of the finest, next
# to the lowest point alone. Half or twice of all changes no result (`python -m tests.sensitivity
# discretization.lattice.accuracy FINER`).
FINER = ((2, 10**5), (8, 10**5), (64, 10**5), (2**14, 512), (2**22, 512), (2**30, 512))
# Coarser spacings over this one: three, as two errors may happen to be equal, and none a multiple
# of another, so that lines lie differently between the nodes. They decide about estimates alone.
_FACTORS = (2.0, 1.7, 1.4)
UNRESOLVED = dict.fromkeys(QUANTITIES, math.inf)
EXACT = dict.fromkeys(QUANTITIES, 0.0)


def estimated(solve: Solver, fine: Equilibrium) -> dict[str, float]:
    """Relative errors of a lattice state; see the module.

    Parameters
    ----------
    solve : callable
        `on_lattice`, or what finds states in its place.
    fine : Equilibrium

    Returns
    -------
    dict of str to float
        Of half_width, force and energy; inf where the state is not resolved.
    """
    if not fine.contacts.size:
        lattice = Lattice.of(fine.scene, fine.spacing)
        narrow = lost_too_early(fine.scene, lattice, fine.depth, fine.branch)
        return UNRESOLVED if narrow or _held_on_finer_nodes(solve, fine) else EXACT
    if not np.isfinite(fine.contacts).all():  # a plane without end, on which all links are alike
        return EXACT
    convex = fine.scene.indenter.convex
    free = ~fine.pinned.all(axis=1)
    if convex and (_narrower(fine, LEAST) & free).any():
        return UNRESOLVED
    smooth = convex and not _has_inner_corners(fine)
    bounds = []
    for factor in _FACTORS if smooth else (*_FACTORS, _COMPARED.closer):
        state = _on_other_nodes(solve, fine, factor * fine.spacing)
        if state is None or not state.contacts.size:
            return UNRESOLVED
        if state.spacing == fine.spacing:  # of a body so few links wide
            continue
        if factor < 1 and (_narrower(state, _COMPARED.half_a_link).any() or _uneven(fine, state)):
            return UNRESOLVED
        bounds.append(_compared(fine, state))
    if not bounds:
        return UNRESOLVED
    errors = {name: max(bound[name] for bound in bounds) for name in QUANTITIES}
    if not convex:
        errors["half_width"] = max(errors["half_width"], errors["energy"])
    return errors


def _narrower(state: Equilibrium, links: int) -> Mask:
    """Which contacts (m,) have fewer than so many links."""
    return np.asarray(np.diff(state.nodes)[:, 0] < (links - 0.5) * state.spacing)


def _uneven(fine: Equilibrium, closer: Equilibrium) -> bool:
    """Whether contacts that both states have differ in width by more than UNEVEN of all.

    What has merged, or come apart, is none of these.
    """
    own = fine.contacts
    there = closer.contacts
    overlaps = (own[:, None, 0] <= there[:, 1]) & (there[:, 0] <= own[:, None, 1])
    own_meets_one = overlaps.sum(axis=1, keepdims=True) == 1
    other_meets_one = overlaps.sum(axis=0) == 1
    one, other = np.nonzero(overlaps & own_meets_one & other_meets_one)
    widths = np.diff(own)[:, 0]
    widths_there = np.diff(there)[:, 0]
    change = np.abs(widths[one] - widths_there[other])
    return bool(change.sum() > UNEVEN * widths.sum())


def _has_inner_corners(fine: Equilibrium) -> bool:
    """Whether the profile has corners between nodes: other than its tip and its edges."""
    body = fine.scene.indenter
    return bool({*map(float, body.corners)} - {body.apex, *body.walls})


def _compared(fine: Equilibrium, other: Equilibrium) -> dict[str, float]:
    """The relative errors, by name, that follow from a state of another spacing.

    3/2 |Q - Q_c|/|c² - 1|, or c in place of c² where that has another number of contacts, or 3/2 of
    what Q differs from its own parts by, if that is more; see the module.
    """
    coarser = other.spacing / fine.spacing  # c
    order = 2 if other.contacts.shape == fine.contacts.shape else 1
    scales = {"half_width": fine.half_width or fine.spacing, **fine.scales}
    parts = {
        "half_width": fine.half_width,
        "force": sum(fine.force_parts.values()),
        "energy": sum(fine.energy_parts.values()),
    }
    errors = {}
    for name, scale in scales.items():
        value = getattr(fine, name)
        there = getattr(other, name)
        size = scale or max(abs(value), abs(there))  # touching: nothing is deformed
        change = abs((value - there) / (coarser**order - 1))
        change = max(change, abs(parts[name] - value))
        errors[name] = float(_COMPARED.safety * change / size if size else 0.0) + _COMPARED.rounding
    return errors


def _held_on_finer_nodes(solve: Solver, state: Equilibrium) -> bool:
    """Whether a finer lattice has a contact where this state is detached.

    By one of FINER, which also says how many nodes on each side of the lowest point are looked at.
    """
    scene = state.scene
    lowest = resolve(scene, state.depth).lowest
    for finer, nodes in FINER:
        spacing = state.spacing / finer
        near = scene.indenter.within(lowest - nodes * spacing, lowest + nodes * spacing)
        local = replace(state, scene=replace(scene, indenter=near))
        finer_state = _on_other_nodes(solve, local, spacing)
        if finer_state is not None and finer_state.contacts.size:
            return True
    return False


def _on_other_nodes(solve: Solver, state: Equilibrium, spacing: float) -> Equilibrium | None:
    """The state of the same scene and depth on other nodes; None where none is found."""
    try:
        return solve(state.scene, state.depth, spacing, branch=state.branch)
    except (ValueError, NotCertifiedError):
        return None
