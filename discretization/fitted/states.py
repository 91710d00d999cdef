"""States of the fitted mesh, with one contact or any number.

Where there can be only one contact its lines are bracketed at once (alone.py), and only what is
next to them is judged. Any other profile is resolved on its own scale first. Line contacts with
small slopes are found on nodes (../refine/states.py). Of others, around an axis, with finite slopes
or under a pattern, "adhered" is the end of the path from first touch (motion.py), and around an
axis "global" what has the least energy of: the lowest rings of a lattice, moved to rest on the
fitted mesh, the adhered state, and none. Lattices are halved until two of them lead to the same
state.
"""

import contextlib
import math
import warnings
from collections.abc import Iterator

import numpy as np

from discretization.certificate import AccuracyWarning, Certificate, NotCertifiedError
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.alone import Alone
from discretization.fitted.contacts import Contacts, certify, errors
from discretization.fitted.motion import Lines, Motion
from discretization.lattice.lowest import lowest_contacts
from discretization.nodes.lattice import Lattice
from discretization.profile import LOOKS, resolve, warn_hidden
from discretization.refine.nodes import slope_turns
from energy import Scene
from energy.arrays import Array

_PER_LENGTH = 16  # nodes per l of the first lattice
_PER_WAVE = 16  # and per wave: from where the slope turns round to where it does so likewise
_NOTICED = 1 / 4  # of √(2w/γ₁): changes of the slope that count
_FINER = 4  # lattices, each with half the spacing of the last
_BESIDE = 1 / 64  # of δ₀: depths beside the one asked for
_MOST_RINGS = 6000  # of a lattice of which only the topology is taken
_SAME = 1e-9  # of the energy's scale: energies of the same state
_UNDECIDED = 1e-7  # of the size of depths: letting go and turning over at once


def on_one_contact(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium with its contact lines as unknowns, and its error estimate.

    branch "global" of a convex indenter: this state or, before it touches, the detached one,
    whichever has less energy. There is no other: the force on each line grows outwards.
    """
    alone = Alone.of(scene)
    lines, size = alone.lines(depth), alone.size(depth) or 1.0
    if lines:
        state = state_of(alone, lines, depth, branch)
        if branch != "global" or state.energy <= 0 or depth > alone.touch:
            return state
    elif abs(float(alone.rest_depth(1, alone.apex)) - depth) <= _UNDECIDED * size:
        alone.solve(1, alone.apex, depth)
    return state_of(alone, (), depth, branch)


def on_several(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium with lines that move from first touch on, and its error estimate.

    NotCertifiedError if it was not found; ValueError for a contact that leaves the known profile;
    AccuracyWarning where the profile is not resolved, or a finer lattice might lead to a lower one.
    """
    places = np.empty(0)
    for _ in range(LOOKS):
        motion = Motion.of(scene, resolve(scene, depth, places), depth)
        adhered, hidden = judged(motion, motion.adhered(depth), depth, branch)
        if not hidden.size:
            break
        places = np.union1d(places, hidden)
    if places.size:
        warn_hidden(places, stacklevel=3)
    if branch == "adhered" or not scene.work_of_adhesion:
        return adhered
    discs, found, same = scene.axisymmetric and scene.indenter.convex, list[Equilibrium](), False
    for candidates, seen in [(_discs(motion, depth), 0)] if discs else _lowest(motion, depth):
        states = [adhered]
        for lines in candidates:
            with contextlib.suppress(NotCertifiedError):
                states.append(state_of(motion, lines, depth, branch))
        found.append(min(states, key=lambda state: state.energy))
        one, other = found[-2:] if found[1:] else found * 2
        off, alike = abs(one.energy - other.energy), len(one.contacts) == len(other.contacts)
        same = discs or bool(found[1:] and alike and off <= _SAME * other.scales["energy"])
        if same and (discs or len(one.contacts) == seen):
            break
    if not same:
        warnings.warn(
            f"the lowest energy at depth = {depth!r} is not the same on lattices each with half "
            "the spacing of the last: the state found may not be the lowest; give a spacing, or a "
            "smoother profile",
            AccuracyWarning,
            stacklevel=3,
        )
    return min(found, key=lambda state: state.energy)


def _lowest(motion: Motion, depth: float) -> Iterator[tuple[set[Lines], int]]:
    """The lowest rings of finer and finer lattices, moved to rest, and how many there were.

    Those of depths a little less and more are among them: two states may have so nearly the same
    energy that a lattice takes one for the other.
    """
    scene, profile, length = motion.scene, motion.profile, motion.scene.elastocapillary_length
    noticed = _NOTICED * math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    turns = slope_turns(profile.x, profile.slope, noticed)
    spacing = min([length / _PER_LENGTH, *((turns[2:] - turns[:-2]) / _PER_WAVE).tolist()])
    least = scene.indenter.extent[1] / (_MOST_RINGS - 1)
    beside = _BESIDE * scene.critical_separation
    for i in range(_FINER):
        lattice = Lattice.of(scene, max(spacing / 2**i, least))
        found: set[Lines] = {()}
        for at in (depth - beside, depth + beside, depth):
            nodes = lowest_contacts(lattice.seen(scene), at, lattice)
            lines = np.clip(lattice.x(nodes.astype(float).ravel()), *scene.indenter.extent)
            found.add(motion.settled(tuple(lines.tolist()), depth))
        yield found, len(nodes)


def _discs(motion: Motion, depth: float) -> set[Lines]:
    """No contact, and all contacts around the axis whose line is at rest; of a convex profile.

    The lowest state of that is one of them. A gap a < r < b in a contact would cost energy: filled,
    it gains ∫ [w - k/2 (g² - u²)] dA + γ₁ ∫ [v'²/2 + v Δf] dA with v = u - g >= 0 and Δf >= 0, more
    than 0 where |g| <= δ₀; and beyond r = b, where g is less still, every contact with |g| > δ₀
    costs more than the surface that is free there.
    """
    x = motion.profile.x
    beyond = motion.rests.ahead(np.column_stack([x, np.full(x.size, math.inf)]), 1)[:, 0]
    ends = x[1:][(beyond[:-1] < depth) & (beyond[1:] >= depth)]
    found = {motion.settled((0.0, end), depth) for end in ends.tolist()}
    return {(), *found}


def state_of(motion: Motion | Alone, lines: Lines, depth: float, branch: str) -> Equilibrium:
    """The certified state with these lines.

    NotCertifiedError if it is no equilibrium; ValueError if the surface would turn over;
    AccuracyWarning where there are features that the samples of the profile have missed.
    """
    state, hidden = judged(motion, lines, depth, branch)
    if hidden.size:
        warn_hidden(hidden, stacklevel=4)
    return state


def judged(
    motion: Motion | Alone, lines: Lines, depth: float, branch: str
) -> tuple[Equilibrium, Array]:
    """The certified state, and places of features that the samples of the profile have missed."""
    scene, hidden = motion.scene, np.empty(0)
    if lines:
        contacts = Contacts(motion, lines, depth)
        found = contacts.totals()
        hidden = found.hidden
        state = Equilibrium(
            scene,
            depth,
            branch,
            "fitted",
            certify(contacts, found),
            motion.surfaces,
            contacts=contacts.x,
            nodes=contacts.x,
            pinned=contacts.pinned,
            errors=errors(contacts, found),
            neutral=contacts.neutral,
            **found.of_state,
        )
    else:
        scale = max(abs(depth), scene.opened.critical_separation) or 1.0
        apart = Certificate.undeformed(motion.penetration(lines, depth) / scale)
        state = detached(scene, depth, branch, motion.surfaces, apart)
    name = f"the state at depth = {depth!r} with {len(state.contacts)} contacts"
    state.certificate.demand(name, "try another depth: this one may be that of an event")
    return state, hidden
