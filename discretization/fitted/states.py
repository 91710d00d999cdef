"""States of the fitted mesh, with one contact or any number.

Where there can be only one contact its lines are bracketed at once (single_contact.py), and only
what is next to them is judged. Any other profile is resolved on its own scale first. Line contacts
with small slopes are found on nodes (../refine/states.py). Of others, around an axis, with finite
slopes or under a pattern, "adhered" is the end of the path from first touch (contact_lines.py), and
around an axis "global" what has the least energy of: the lowest rings of a lattice, moved to rest
on the fitted mesh, the adhered state, and none. Lattices are halved until two of them lead to the
same state.

Conventions
-----------
The depth d is positive down into the layer [length]. `Lines` are both ends of every contact from
left to right, a flat tuple; () is the flat surface without contact. About an axis x is the radius,
and the left end of a contact around the axis is 0. Energies count from the undeformed surface, so
that a state of less than 0 has less than no contact has.

`ContactLines.adhered` are the lines of the adhered state at a depth; its `settled` moves lines that
are near a state at rest to it. `hidden` are places of features between the samples of the profile
that quadrature has come across: the profile is resolved again with samples there.

`Contacts` are lines at a depth with their free surfaces; `certify` gives their `Certificate`, whose
`demand` raises NotCertifiedError if it fails, `errors` their relative errors, and `totals` their
energy and force, whose `of_state` are the entries of an `Equilibrium`. `ContactLines.penetration`
is how far the profile sticks through the free surfaces [length], its `rests.ahead(lines, 1)` D just
outwards of the lines (n, 2) of free surfaces. `SingleContact.rest_depth(1, apex)` is D of a right
line at the lowest point; `solve` is the surface beside it. UNDECIDED says, of the size of depths,
how near to the loss of contact that surface may turn over.

`resolve` samples the profile, with samples at the given places, too; this is done at most LOOKS
times, and `warn_hidden` warns of features that are left. A `Lattice` has nodes of one spacing,
about an axis with `scene_on_nodes` the scene for r >= 0 alone; `lowest_contacts` are first and last
nodes (m, 2) of the contacts of least energy. `slope_turns` are the places where the slope of the
profile turns round. δ₀ = √(2w/k) is `Scene.critical_separation`, and `opened` is the scene with the
work of adhesion of contacts that open.

`Contacts.pinned` is which lines (m, 2) are pinned, and `neutral` whether the energy stays the same
as a line at an edge of the body moves inwards. `Equilibrium.scales` are the sums of the sizes of
the terms of "force" and "energy".
"""

import math
import warnings
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from discretization.certificate import AccuracyWarning, Certificate, NotCertifiedError
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.contact_lines import ContactLines, Lines
from discretization.fitted.contacts import Contacts, certify, errors
from discretization.fitted.single_contact import UNDECIDED, SingleContact
from discretization.lattice.lowest import lowest_contacts
from discretization.nodes.lattice import Lattice
from discretization.profile import LOOKS, resolve, warn_hidden
from discretization.refine.nodes import slope_turns
from energy import Scene
from energy.arrays import Array


class LatticeSearch(NamedTuple):
    """Lattices on which the state of least energy is looked for.

    They only supply contacts, which are moved to rest on the mesh, and are halved until two of them
    lead to the same state. So the values decide how fast that is, and may decide whether the lowest
    state is found, but change none: halved or doubled (`same_energy` a tenth or ten times), each
    leaves 6 random lowest states of rings as they are to 1e-9 (`python -m tests.sensitivity
    discretization.fitted.states`).

    Attributes
    ----------
    per_length : int
        Nodes in l of the first one: tails decay right to 16⁻²/24 = 2e-4 there.
    per_wave : int
        Nodes of it in a wave: from where the slope turns round to where it does so likewise.
    noticed : float
        Of √(2w/γ₁): changes of the slope that count as a wave.
    most_lattices : int
        Lattices at most, each with half the spacing of the last.
    aside : float
        Of δ₀: depths on both sides of that of the state, whose lowest contacts are tried as well.
    most_nodes : int
        Nodes at most, as only the contacts are needed: what takes some seconds.
    same_energy : float
        Of the energy's scale: energies of the same state, far above rounding and as far below what
        two states differ by that a lattice can distinguish.
    """

    per_length: int = 16
    per_wave: int = 16
    noticed: float = 1 / 4
    most_lattices: int = 4
    aside: float = 1 / 64
    most_nodes: int = 6000
    same_energy: float = 1e-9


_SEARCH = LatticeSearch()


def on_one_contact(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium of a scene with one contact, whose lines are bracketed at once.

    There is at most one state in contact: the force on each line grows outwards.

    Parameters
    ----------
    scene : Scene
        With a convex indenter.
    depth : float
        [length].
    branch : {"adhered", "global"}
        "global": this state or, before it touches, the detached one, whichever has less energy.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If it is no equilibrium.
    ValueError
        If the contact leaves the known profile, or a surface would turn over.
    """
    contact = SingleContact.of(scene)
    lines = contact.lines(depth)
    if lines:
        state = state_of(contact, lines, depth, branch)
        # Before first touch no contact is a state, too, with the energy 0.
        if branch != "global" or state.energy <= 0 or depth > contact.touch:
            return state
    else:
        # So near to the depth at which contact is lost, none is the state only if the surface
        # beside a contact would not turn over.
        size = contact.size(depth) or 1.0
        distance = abs(float(contact.rest_depth(1, contact.apex)) - depth)
        if distance <= UNDECIDED * size:
            contact.solve(1, contact.apex, depth)  # raises where the surface would turn over
    return state_of(contact, (), depth, branch)


def on_several(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium of a scene that may have several contacts.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    branch : {"adhered", "global"}
        "adhered": the end of the path from first touch; "global": the state of least energy.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If it was not found.
    ValueError
        If a contact leaves the known profile.

    Warns
    -----
    AccuracyWarning
        Where the profile is not resolved, or a finer lattice might lead to a lower state.
    """
    missed = np.empty(0)
    for _ in range(LOOKS):
        contact_lines = ContactLines.of(scene, resolve(scene, depth, missed), depth)
        adhered, hidden = judged(contact_lines, contact_lines.adhered(depth), depth, branch)
        if not hidden.size:
            break
        missed = np.union1d(missed, hidden)
    if missed.size:
        warn_hidden(missed, stacklevel=3)
    if branch == "adhered" or not scene.work_of_adhesion:
        return adhered
    if scene.axisymmetric and scene.indenter.convex:
        return _lowest_of_discs(contact_lines, adhered)
    return _lowest_on_lattices(contact_lines, adhered)


def _lowest_of(
    contact_lines: ContactLines, candidates: set[Lines], adhered: Equilibrium
) -> Equilibrium:
    """The state of least energy: the adhered one, or one of the candidates.

    Candidates that fail their certificate are no equilibria and are left out.
    """
    states = [adhered]
    for lines in candidates:
        try:
            state, hidden = judged(contact_lines, lines, adhered.depth, adhered.branch)
        except NotCertifiedError:
            continue
        if hidden.size:
            warn_hidden(hidden, stacklevel=5)
        states.append(state)
    return min(states, key=lambda state: state.energy)


def _lowest_of_discs(contact_lines: ContactLines, adhered: Equilibrium) -> Equilibrium:
    """The state of least energy of a convex profile about an axis: a disc, or no contact."""
    return _lowest_of(contact_lines, _discs(contact_lines, adhered.depth), adhered)


def _lowest_on_lattices(contact_lines: ContactLines, adhered: Equilibrium) -> Equilibrium:
    """The state of least energy to which finer and finer lattices lead.

    The spacing is halved until two lattices lead to the same state, with as many contacts as the
    finer one has itself. A warning says that this has not happened.

    adhered: the state of the path from first touch at this depth, one of those that are compared.
    """
    found: list[Equilibrium] = []
    is_confirmed = False
    for candidates, contacts_on_lattice in _lattice_candidates(contact_lines, adhered.depth):
        found.append(_lowest_of(contact_lines, candidates, adhered))
        is_confirmed = len(found) > 1 and _alike(*found[-2:])
        if is_confirmed and len(found[-2].contacts) == contacts_on_lattice:
            break
    if not is_confirmed:
        warnings.warn(
            f"the lowest energy at depth = {adhered.depth!r} is not the same on lattices each with "
            "half the spacing of the last: the state found may not be the lowest; give a spacing, "
            "or a smoother profile",
            AccuracyWarning,
            stacklevel=4,
        )
    return min(found, key=lambda state: state.energy)


def _alike(one: Equilibrium, other: Equilibrium) -> bool:
    """Whether two states are the same, by the number of their contacts and their energies."""
    if len(one.contacts) != len(other.contacts):
        return False
    return abs(one.energy - other.energy) <= _SEARCH.same_energy * other.scales["energy"]


def _lattice_candidates(
    contact_lines: ContactLines, depth: float
) -> Iterator[tuple[set[Lines], int]]:
    """Contacts of least energy on finer and finer lattices, moved to rest on the mesh.

    Those of depths a little less and more are among them: two states may have so nearly the same
    energy that a lattice takes one for the other.

    Yields
    ------
    candidates : set of tuple of float
        Lines at rest at the depth [length]; () without contact.
    contacts : int
        How many contacts the lattice itself has at the depth.
    """
    scene = contact_lines.scene
    aside = _SEARCH.aside * scene.critical_separation
    for spacing in _spacings(contact_lines):
        lattice = Lattice.of(scene, spacing)
        candidates: set[Lines] = {()}
        for lattice_depth in (depth - aside, depth + aside, depth):
            nodes = lowest_contacts(lattice.scene_on_nodes(scene), lattice_depth, lattice)
            x = lattice.x(nodes.astype(float).ravel())
            lines = np.clip(x, *scene.indenter.extent)
            candidates.add(contact_lines.settled(tuple(lines.tolist()), depth))
        yield candidates, len(nodes)


def _spacings(contact_lines: ContactLines) -> list[float]:
    """Spacings of the lattices in the order in which they are tried [length].

    The first one has so many nodes in l, and in the shortest wave of the slope of the profile; each
    further one is half of that before, down to what the most nodes leave.
    """
    scene = contact_lines.scene
    profile = contact_lines.profile
    kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    turns = slope_turns(profile.x, profile.slope, _SEARCH.noticed * kink)
    waves = turns[2:] - turns[:-2]  # from a maximum of the slope to the next one, and of minima
    of_length = scene.elastocapillary_length / _SEARCH.per_length
    of_waves = (waves / _SEARCH.per_wave).tolist()
    first = min([of_length, *of_waves])
    # A profile without an end is resolved as far as contact is possible.
    outermost = min(scene.indenter.extent[1], float(profile.x[-1]))
    least = outermost / (_SEARCH.most_nodes - 1)
    return [max(first / 2**i, least) for i in range(_SEARCH.most_lattices)]


def _discs(contact_lines: ContactLines, depth: float) -> set[Lines]:
    """No contact, and all contacts around the axis whose line is at rest; of a convex profile.

    Their lines stand between samples where D - d changes its sign, growing outwards. The state of
    least energy of a convex profile is one of these: a gap a < r < b in a contact would cost
    energy. Filled, it gains ∫ [w - k/2 (g² - u²)] dA + γ₁ ∫ [v'²/2 + v Δf] dA with v = u - g >= 0
    and Δf >= 0, more than 0 where |g| <= δ₀; and beyond r = b, where g is less still, every contact
    with |g| > δ₀ costs more than the surface that is free there.

    depth: d [length]. The lines are (0, radius) of each contact, () of none.
    """
    # D of the left line of a tail, with the contact around the axis on its left, at all samples.
    x = contact_lines.profile.x
    no_line = np.full(x.size, math.inf)
    rest_depths = contact_lines.rests.ahead(np.column_stack([x, no_line]), 1)[:, 0]
    rests_between = (rest_depths[:-1] < depth) & (rest_depths[1:] >= depth)
    ends = x[1:][rests_between]
    found = {contact_lines.settled((0.0, end), depth) for end in ends.tolist()}
    return {(), *found}


def state_of(
    contact_lines: ContactLines | SingleContact, lines: Lines, depth: float, branch: str
) -> Equilibrium:
    """The certified state with these lines.

    Parameters
    ----------
    contact_lines : ContactLines or SingleContact
        What knows the lines of the scene.
    lines : tuple of float
        Both ends of every contact [length]; () without contact.
    depth : float
        [length].
    branch : str
        Named in the state.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If it is no equilibrium.
    ValueError
        If the surface would turn over.

    Warns
    -----
    AccuracyWarning
        Where there are features that the samples of the profile have missed.
    """
    state, hidden = judged(contact_lines, lines, depth, branch)
    if hidden.size:
        warn_hidden(hidden, stacklevel=4)
    return state


def judged(
    contact_lines: ContactLines | SingleContact, lines: Lines, depth: float, branch: str
) -> tuple[Equilibrium, Array]:
    """The certified state, and places of features that the samples of the profile have missed.

    Parameters
    ----------
    contact_lines, lines, depth, branch
        As of `state_of`.

    Returns
    -------
    Equilibrium
    ndarray (n,)
        [length].

    Raises
    ------
    NotCertifiedError
        If it is no equilibrium.
    ValueError
        If the surface would turn over.
    """
    scene = contact_lines.scene
    if lines:
        contacts = Contacts(contact_lines, lines, depth)
        found = contacts.totals()
        hidden = found.hidden
        state = Equilibrium(
            scene,
            depth,
            branch,
            "fitted",
            certify(contacts, found),
            contact_lines.surfaces,
            contacts=contacts.x,
            nodes=contacts.x,
            pinned=contacts.pinned,
            errors=errors(contacts, found),
            neutral=contacts.neutral,
            **found.of_state,
        )
    else:
        hidden = np.empty(0)
        scale = max(abs(depth), scene.opened.critical_separation) or 1.0
        penetration = contact_lines.penetration(lines, depth) / scale
        certificate = Certificate.undeformed(penetration)
        state = detached(scene, depth, branch, contact_lines.surfaces, certificate)
    name = f"the state at depth = {depth!r} with {len(state.contacts)} contacts"
    state.certificate.demand(name, "try another depth: this one may be that of an event")
    return state, hidden
