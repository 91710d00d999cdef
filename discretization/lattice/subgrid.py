"""Contact lines between the nodes, and what that adds to U and P: of states, and on paths.

A contact that ends at node m has the energy E(m). Let ζ count links outwards from there. A line
that passes link j, from ζ = j to j + 1, stores S v²/2 in the surface and gains the adhesion W
(`Lattice`), so that it does where e_j < 0,

    e = v/|v| √(S v²/2) - √W.

Between the nodes a line is where e, taken at the middles of the links, is zero: by the cubic
through the links -2..1. Where the profile or the pattern has a corner within two links, it is by
the straight line through -1 and 0. A corner that is less than a link away holds the line if e
changes sign there by a jump; what is inside and what is outside then continue straight. U and P are
interpolated between the same contact sets, beside a corner those on one side of it. Raw lattice
values are off by up to Δx/2 in the line; these are off by O(Δx²).

Where opening takes another work of adhesion than closing there are two such positions, and a line
between them stays where it last moved (a play operator):

    ζ = min(max(ζ before, ζ of closing at d), ζ of opening at d).

So a state has to remember the positions of its lines, too, not their nodes alone. Lines that face
each other are found in turns. Of the energy of both moves together each adds its own with the other
one half way, which is exact for a quadratic energy.

Conventions
-----------
Depths d are positive down into the layer, heights f of the profile upwards; g = d - f is the
displacement in contact; P is positive if compressive. All lengths called ζ, or "in links", are in
units of the spacing.

Arrays over s states of m contacts each have the shape (s, 2m): the left and the right line of the
first contact, then of the second, ...; so even columns are left lines, odd ones right lines.
`nodes` has the contact nodes at these lines, numbered from 0 in the row (`row.first` is the
lattice's number of node 0). `side` is -1 for left lines and 1 for right ones, and

    x = position of the node + side (ζ + overhang) Δx,      overhang ½ without tension, else 0.

Outwards of a contact, ζ > 0, is towards the free surface of the line. The line that it faces is the
other line of that free surface; an outermost line faces none. A last axis of length 6 has the links
j = -3 ... 2 (`LINKS`), link j from ζ = j to j + 1. Where an axis n of works of adhesion comes first
it has that of closing first, and that of opening last: one entry where both are alike.

v = A g + B u' - g_after is the gap at the node beyond a link, u' the displacement of the line that
is faced, and S the stiffness at that node: `Lattice.free_node_response` gives B, 1 - A - B and S.
`row.bonds` has for each link its length or area times the factor of the pattern, so that the
adhesion of a link is a work of adhesion times it. `row.corners` are x of corners of profile and
pattern, `row.breaks` the same in numbers of nodes of the row. `row.scene.hysteretic` is whether
opening takes another work of adhesion than closing, and `is_lost_smoothly(row)` whether contacts
adhere and have two free lines: then walks keep lone nodes for contacts narrower than a link.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON
from discretization.lattice.loss import is_lost_smoothly
from discretization.nodes.row import Contacts, Row
from energy.arrays import Array, Mask, Nodes

Lines = tuple[float, ...]  # x of all lines of a state, from left to right
LINKS = np.arange(-3, 3)  # j of the links beside a line, outwards from its node


class LineRules(NamedTuple):
    """Where lines between the nodes may be; lengths in links.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each but `half` leaves the 4 or
    more random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.lattice.subgrid`.

    Attributes
    ----------
    half : float
        How far a line may be from its node: a little less than half, so that it keeps that node.
        With less than that lines are stopped short of where they rest.
    nearly_half : float
        A line that faces another one may be further from its node. Its position then has to lead
        back to the node: what is beyond this distance is recorded shorter,
    shortened : float
        by this factor.
    rounds : int
        Rounds at most in which lines that face each other are found; each is a contraction.
    settled : float
        A round that moves no line by more is the last.
    closest : float
        Distance of two lines at least, for what they feel of each other.
    independent : int
        Lines that are closer to each other stay on their nodes.
    rounding : float
        Of x: a line that has moved by less has not moved.
    """

    half: float = 0.5 - 1e-9
    nearly_half: float = 0.4999
    shortened: float = 1e-4
    rounds: int = 20
    settled: float = 1e-9
    closest: float = 1.5
    independent: int = 4
    rounding: float = 16 * EPSILON


_LINE = LineRules()


class Advances(NamedTuple):
    """Changes as a line passes each of the links beside it; arrays of one shape, the links last.

    The first three are nan where there is no link to pass.

    Attributes
    ----------
    gap : ndarray
        v of the node beyond the link [length].
    stored : ndarray
        S v²/2 [energy/length].
    force : ndarray
        ΔP [force/length].
    bonds : ndarray
        The links' lengths or areas times the pattern's factor.
    """

    gap: Array
    stored: Array
    force: Array
    bonds: Array

    def excess(self, works: Sequence[float]) -> Array:
        """e of the module's docstring, with each of these works of adhesion (n, s, 2m, 6).

        Negative where a line passes the link.
        """
        root_stored = np.copysign(np.sqrt(self.stored), self.gap)
        root_bonds = np.sqrt(self.bonds)
        return np.array([root_stored - math.sqrt(work) * root_bonds for work in works])


class Cubic(NamedTuple):
    """mean + rise t + (bend + turn t)(t² - 1/4) of t, in links outwards from a node; (n, s, 2m).

    The middles of the two links beside the node are t = ∓½, where the last term is zero: mean is
    the mean of their values and rise the difference.
    """

    mean: Array
    rise: Array
    bend: Array
    turn: Array


class Corners(NamedTuple):
    """The corner of the profile or the pattern beside each line; arrays (s, 2m).

    Attributes
    ----------
    zeta : ndarray
        ζ of the only corner within a link; nan: none, or several.
    smooth : ndarray of bool
        Whether the two links on each side of the node are without any corner.
    narrow : ndarray of bool
        Whether the node, a lone one, stands for a contact narrower than a link.
    """

    zeta: Array
    smooth: Mask
    narrow: Mask

    def middle(self, outside: Mask | bool) -> Nodes:
        """ζ of the node between the two links nearest to the corner on one side of it.

        The corner is in neither of them. Without a corner 0, the line's own node.

        Parameters
        ----------
        outside : bool or ndarray of bool (s, 2m)
            Whether the links are those outwards of the corner; else those inwards.

        Returns
        -------
        ndarray of int (s, 2m)
        """
        middle = np.where(outside, np.ceil(self.zeta) + 1, np.floor(self.zeta) - 1)
        return np.where(np.isnan(middle), 0, middle).astype(int)

    def cubic(self, parts: Array, middle: Nodes) -> Cubic:
        """The cubic through values of links, at their middles.

        It goes through four links where these are smooth; if one of the outer two is missing it is
        the parabola through the other three, else the straight line through the two beside the
        node. If one of these is missing, the line is constant; but inside a narrow contact it goes
        on straight from the two links outside.

        Parameters
        ----------
        parts : ndarray (n, s, 2m, 6)
            Values of the links, nan where there is none.
        middle : ndarray of int (s, 2m)
            ζ of the node between the second and the third of the four links, the origin of t.

        Returns
        -------
        Cubic
        """
        columns = np.arange(-2, 2) - LINKS[0]  # of the two links on each side of the line's node
        if middle.any():
            # Beside a corner columns beyond the six wrap round; they are only those of `innermost`
            # and `outermost`, which do not count there, as the four links are not smooth.
            own = (middle[None, ..., None] + columns) % LINKS.size
            parts = np.take_along_axis(parts, own, -1)
            columns = np.arange(4)
        innermost, inner, outer, outermost = (parts[..., i] for i in columns)
        continued = np.where(self.narrow & ~np.isnan(outermost), 2 * outer - outermost, outer)
        before = np.where(np.isnan(inner), continued, inner)
        after = np.where(np.isnan(outer), inner, outer)
        rise = after - before
        mean = (before + after) / 2
        # turn = 0 where one of the outer two is missing.
        first = np.where(np.isnan(innermost), outermost - 3 * rise, innermost)
        last = np.where(np.isnan(outermost), innermost + 3 * rise, outermost)
        bend = (first + last - 2 * mean) / 4
        turn = (last - first - 3 * rise) / 6
        known = self.smooth & ~np.isnan(bend)
        return Cubic(mean, rise, np.where(known, bend, 0.0), np.where(known, turn, 0.0))


@functools.lru_cache
def facing_sides(lines: int) -> Nodes:
    """Sides on which the free surfaces of lines are: -1 for left lines, 1 for right ones.

    Parameters
    ----------
    lines : int
        How many lines there are, from left to right.

    Returns
    -------
    ndarray of int (lines,)
    """
    return np.resize([-1, 1], lines)


def advances(row: Row, nodes: Nodes, depth: Array, zeta: Array | None = None) -> Advances:
    """Changes as lines pass the links beside them, one at a time.

    Link j is passed by a line that has come to ζ = j, while all other lines stay. A line can pass
    the links between the other line of its contact and the one that it faces, but not the last one,
    beyond which the surface would be closed.

    Parameters
    ----------
    row : Row
    nodes : ndarray of int (s, 2m)
        First and last nodes of m contacts each.
    depth : ndarray (s,)
        [length].
    zeta : ndarray (s, 2m), optional
        ζ at which lines are as far as others face them; by default they are on their nodes.

    Returns
    -------
    Advances
        Of arrays (s, 2m, 6).
    """
    lattice = row.lattice
    sides = facing_sides(nodes.shape[1])[:, None]
    start = nodes[..., None] + sides * LINKS  # nodes at the inner ends of the links,
    after = start + sides  # and at their outer ends
    places, u_faced = _faced_lines(row, nodes, depth, zeta)
    distance = np.maximum(np.abs(places[..., None] - start), _LINE.closest)
    far, remainder, stiffness = lattice.free_node_response(row.first + start, sides, distance)
    g = depth[:, None, None] - row.f.take(start, mode="clip")
    g_after = depth[:, None, None] - row.f.take(after, mode="clip")
    gap = g - g_after - remainder * g + far * (u_faced[..., None] - g)
    gap = np.where(_can_be_passed(row, nodes, start, after), gap, math.nan)
    link = np.minimum(np.maximum(np.minimum(start, after), 0), row.size - 2)
    return Advances(
        gap,
        stored=stiffness / 2 * gap * gap,
        force=-stiffness * remainder * gap,
        bonds=row.bonds[link],
    )


def _can_be_passed(row: Row, nodes: Nodes, start: Nodes, after: Nodes) -> Mask:
    """Which of the links from the nodes `start` to `after` (s, 2m, 6) lines at `nodes` can pass.

    Those from the other line of the contact on, which leave a node to the line that is faced, or to
    the end of the row. None at an axis: there is no line, and the contact goes on.
    """
    sides = facing_sides(nodes.shape[1])
    faced = _of_faced(nodes, before=-1, beyond=row.size)[..., None]
    other = nodes[:, np.arange(sides.size) - sides, None]
    outwards = sides[:, None]
    exists = (outwards * (faced - after) > 0) & (outwards * (start - other) >= 0)
    exists[row.first + nodes == row.lattice.axis] = False
    return exists


def _faced_lines(row: Row, nodes: Nodes, depth: Array, zeta: Array | None) -> tuple[Array, Array]:
    """Places, in numbers of nodes, and displacements of the lines that lines face (s, 2m).

    Where none is faced it is infinitely far away, with u = 0. Arguments as of `advances`.
    """
    places: Array | Nodes
    if zeta is None:
        places = nodes
        f = row.f[nodes]
    else:
        places = nodes + facing_sides(nodes.shape[1]) * zeta
        indenter = row.scene.indenter
        x = row.lattice.x(row.first + places)
        f = indenter.height(np.clip(x, *indenter.extent))
    faced_places = _of_faced(places, before=-math.inf, beyond=math.inf)
    faced_u = _of_faced(depth[:, None] - f, before=0.0, beyond=0.0)
    return faced_places, faced_u


def _of_faced(values: Array | Nodes, *, before: float, beyond: float) -> Array:
    """Of each line the value (s, 2m) that the line that it faces has among `values` (s, 2m).

    Of the first line, which faces none, that is `before`; of the last one `beyond`.
    """
    count = values.shape[1]
    padded = np.empty((len(values), count + 2))
    padded[:, 0] = before
    padded[:, 1:-1] = values
    padded[:, -1] = beyond
    own = np.arange(count) + 1
    return padded[:, own + facing_sides(count)]


def corners(row: Row, nodes: Nodes) -> Corners:
    """The corners beside lines at these nodes (s, 2m); no contact is taken for narrow here."""
    nowhere = np.full(nodes.shape, False)
    if not row.corners.size:
        return Corners(np.full(nodes.shape, math.nan), ~nowhere, nowhere)
    known = np.append(row.breaks, math.nan)  # nan sorts last: it is taken where no corner follows
    first = known.searchsorted(nodes - 1, "right")
    count = known.searchsorted(nodes + 1) - first  # less than a link from the node
    zeta = facing_sides(nodes.shape[1]) * (known[first] - nodes) - row.lattice.overhang
    count_within_two = known.searchsorted(nodes + 2) - known.searchsorted(nodes - 2, "right")
    return Corners(np.where(count == 1, zeta, math.nan), count_within_two == 0, nowhere)


def placed(excess: Array, corner: Corners) -> Array:
    """ζ (n, s, 2m) at which lines with this excess (n, s, 2m, 6) rest; nan where it grows nowhere.

    At a corner e jumps: a line is pinned there if its zero from inside is beyond the corner, and
    that from outside before it.
    """
    inside = _zero(excess, corner, outside=False)
    at = corner.zeta
    if np.isnan(at).all():
        return inside
    outside = np.fmax(_zero(excess, corner, outside=True), at)  # before the corner: pinned at it
    return np.where(np.isnan(at) | (inside < at), inside, outside)


def _zero(excess: Array, corner: Corners, *, outside: bool) -> Array:
    """ζ (n, s, 2m) where e is zero as it continues from one side of a corner.

    Where e does not grow outwards there it has the same sign everywhere, so that the zero is at ∞
    if e < 0 (the line passes all links) and at -∞ if e > 0; without a corner nan. The zero of the
    straight line is corrected by the parabola, exactly, and then by the cubic, to first order,
    where both are small corrections: at most as large as what the straight line has.
    """
    middle = corner.middle(outside)
    mean, rise, bend, turn = corner.cubic(excess, middle)
    with np.errstate(invalid="ignore", divide="ignore"):
        at_corner = mean - rise / 2 if outside else mean + rise / 2  # e of the link next to it
        everywhere = np.where(np.isnan(corner.zeta), math.nan, -math.inf * at_corner)
        straight = np.where(rise > 0, -mean / rise, everywhere)
        # With p = t + ½ the parabola is zero where b p² + (1 - b) p = straight + ½.
        b = bend / rise
        relative_turn = turn / rise
        constant = straight + 0.5
        root = np.sqrt((1 - b) ** 2 + 4 * b * constant)
        p = 2 * constant / (1 - b + root)
        cubic = p - 0.5 + relative_turn * p * (1 - p) * (p - 0.5)
        largest = np.maximum(np.abs(b), np.abs(relative_turn))
        small = np.maximum(largest, np.abs(straight)) <= 1
    return np.asarray(middle + np.where(small & ~np.isnan(cubic), cubic, straight))


def _added(steps: Array, zeta: Array, corner: Corners) -> Array:
    """What contacts that end at ζ have more than those at their nodes (n, s, 2m).

    ∫ (p - p''/24) dt from 0 to ζ, p the cubic through the steps over links, taken at their middles;
    over a whole link that is p at its middle, and so the step itself. A step of a link that does
    not exist counts as 0.

    steps: of n quantities, here U and P, over each link (n, s, 2m, 6).
    """
    middle = corner.middle(zeta > corner.zeta)
    mean, rise, bend, turn = corner.cubic(steps, middle)
    # Whole links between the node of the line and the middle of the cubic, inwards ones negative.
    is_before_middle = middle[..., None] > LINKS
    is_inside_contact = LINKS < 0
    passed = is_before_middle * 1 - is_inside_contact  # 1, 0 or -1
    known_steps = np.where(np.isnan(steps), 0.0, steps)
    whole_links = (known_steps * passed).sum(axis=-1)

    t = zeta - middle
    mean_of_part = mean + rise / 2 * t + (t * t - 1) * (bend / 3 + turn / 4 * t)
    return whole_links + np.where(np.isnan(mean_of_part), 0.0, t * mean_of_part)


def offsets(
    row: Row,
    nodes: Nodes,
    depth: Array,
    passed: Advances,
    corner: Corners,
    works: Sequence[float],
    before: Array | None = None,
) -> Array:
    """ζ of all lines of s states with m contacts each.

    Lines that face each other are found one with the others where they were, in rounds until

        max |ζ - ζ of the round before| <= 1e-9 links,

    at most 20 of them.

    Parameters
    ----------
    row : Row
    nodes : ndarray of int (s, 2m)
    depth : ndarray (s,)
        [length].
    passed : Advances
        Of lines on their nodes.
    corner : Corners
        Beside these nodes.
    works : sequence of float
        Of adhesion, closing and opening, or one for both [energy/area].
    before : ndarray (s, 2m), optional
        ζ from which lines come that resist; without it those of closing and opening are alike, or
        lines have just closed.

    Returns
    -------
    ndarray (s, 2m)
    """
    least, most = _limits(row, nodes, corner)
    close = np.repeat(nodes[:, 2::2] - nodes[:, 1:-1:2] < _LINE.independent, 2, axis=1)
    zeta = np.zeros(nodes.shape)
    moving = np.arange(len(nodes))  # states whose lines are not yet found
    for _ in range(_LINE.rounds):
        own = Corners(corner.zeta[moving], corner.smooth[moving], corner.narrow[moving])
        rests = placed(passed.excess(works), own)
        rests = np.maximum(np.minimum(rests, most[moving]), least[moving])
        closing = rests[0]
        opening = rests[-1]
        reached = closing if before is None else np.maximum(before[moving], closing)
        found = np.minimum(reached, opening)
        found[:, 1:-1][close[moving]] = 0.0
        found = np.where(np.isnan(found), 0.0, found)
        _keep_order(own.narrow, found)
        unsettled = np.abs(found - zeta[moving]).max(axis=1) > _LINE.settled
        zeta[moving] = found
        moving = moving[unsettled]
        if nodes.shape[1] == 2 or not moving.size:
            break
        passed = advances(row, nodes[moving], depth[moving], zeta[moving])
    return zeta


def _limits(row: Row, nodes: Nodes, corner: Corners) -> tuple[Array, Array]:
    """The least and the greatest ζ of lines (s, 2m).

    Half a link, beyond which the line is nearer to another node. A link for lines that face each
    other, as these have moved since their nodes were found; outwards at the ends of the row, where
    there is no other node; and at a corner, which pins lines up to a link away.
    """
    most = np.where((nodes == 0) | (nodes == row.size - 1), 1.0, _LINE.half)
    least = np.full(nodes.shape, -_LINE.half)
    if not row.scene.hysteretic:
        most = np.where(corner.zeta > _LINE.half, 1.0, most)
        least = np.where(corner.zeta < -_LINE.half, -1.0, least)
    most[:, 1:-1] = 1.0
    least[:, 1:-1] = -1.0
    return least, most


def _keep_order(narrow: Mask, zeta: Array) -> None:
    """Put both lines of narrow contacts that would pass each other half way between them.

    narrow, zeta (s, 2m): which lines are those of narrow contacts, and ζ, which changes in place.
    As ζ counts outwards on both sides of one node, they have passed where its sum is less than 0.
    """
    left = zeta[:, ::2]
    right = zeta[:, 1::2]
    crossed = narrow[:, ::2] & (left + right < 0)
    middle = (right - left)[crossed] / 2
    left[crossed] = -middle
    right[crossed] = middle


def between(
    row: Row,
    nodes: Nodes,
    depth: Array,
    passed: Advances,
    known: Array | None = None,
    work: float | None = None,
    *,
    narrow: bool = False,
) -> tuple[Array, Array]:
    """Where lines are between the nodes, and what each adds to energy and force.

    Parameters
    ----------
    row : Row
    nodes : ndarray of int (s, 2m)
        First and last nodes of m contacts each.
    depth : ndarray (s,)
        [length].
    passed : Advances
        Of lines on their nodes.
    known : ndarray (s, 2m), optional
        x of lines that resist both ways, which do not follow from the depth [length].
    work : float, optional
        Work of adhesion by which lines rest, if not w [energy/area].
    narrow : bool
        Whether lone nodes that are pulled stand for contacts narrower than a link.

    Returns
    -------
    lines : ndarray (s, 2m)
        x [length].
    added : ndarray (2, s, 2m)
        U [energy/length] and P [force/length] that states have more, by each line, than those on
        their nodes.
    """
    corner = corners(row, nodes)
    if narrow:
        is_lone_node = np.repeat(nodes[:, ::2] == nodes[:, 1::2], 2, axis=1)
        is_pulled = depth[:, None] < row.f[nodes]
        corner = corner._replace(narrow=is_lone_node & is_pulled)
    if known is None:
        works = (row.works[0] if work is None else work,)
        zeta = offsets(row, nodes, depth, passed, corner, works)
        lines = positions(row, nodes, zeta, corner)
    else:
        zeta = offsets_of(row, nodes, known)
        lines = known
    if nodes.shape[1] > 2:
        # Lines move together: each adds its own with the others half way, see the module.
        passed = advances(row, nodes, depth, zeta / 2)
    energy = passed.stored - row.works[0] * passed.bonds
    return lines, _added(np.array([energy, passed.force]), zeta, corner)


def of_states(row: Row, states: Sequence[Contacts], depths: Array) -> tuple[list[Array], Array]:
    """Lines of states with any number of contacts each, where closing and opening are alike.

    Lines feel nothing but the line that they face, so that every gap is found once, with the
    contacts beside it, of all states.

    Parameters
    ----------
    row : Row
    states : sequence of Contacts
        Of s states.
    depths : ndarray (s,)
        [length].

    Returns
    -------
    lines : list of ndarray (2m,)
        x [length] in each state.
    added : ndarray (2, s)
        U [energy/length] and P [force/length] that states have more than those on their nodes.
    """
    if max(map(len, states)) == 1:
        lines, by_line = _lines_on_path(row, np.reshape(states, (-1, 2)), depths)
        return list(lines), by_line.sum(axis=-1)
    nodes = [np.ravel(contacts) for contacts in states]
    left, right, added = _outermost_lines(row, nodes, depths)
    inner, by_gaps = _facing_lines(row, nodes, depths)
    of_each_state = zip(left, inner, right, strict=True)
    lines_of_states = [np.array([first, *facing, last]) for first, facing, last in of_each_state]
    return lines_of_states, added + by_gaps


def _facing_lines(row: Row, nodes: Sequence[Nodes], depths: Array) -> tuple[list[Array], Array]:
    """The lines beside gaps of each state (2m - 2,), and what they add to U and P (2, s).

    A gap is found with the contacts on either side, and only once if states of one depth have it
    with the same two contacts. nodes: of each state first and last nodes of all contacts, in a row.
    """
    count = len(nodes)
    gaps = [one.size // 2 - 1 for one in nodes]
    state_of_gap = np.repeat(np.arange(count), gaps)
    contacts_beside = np.concatenate([_pairs_of_contacts(one) for one in nodes if one.size > 2])
    known_depths, depth_number = np.unique(depths[state_of_gap], return_inverse=True)
    gaps_and_depths = np.column_stack([contacts_beside, depth_number])
    distinct, number = np.unique(gaps_and_depths, axis=0, return_inverse=True)
    number = number.ravel()  # of each gap that among the distinct ones
    two_contacts = distinct[:, :4]
    lines, by_line = _lines_on_path(row, two_contacts, known_depths[distinct[:, 4]])

    beside_gap = by_line[..., 1] + by_line[..., 2]  # of four lines those in the middle
    added = [np.bincount(state_of_gap, each, count) for each in beside_gap[:, number]]
    facing_lines = lines[number, 1:3].ravel()
    return np.split(facing_lines, 2 * np.cumsum(gaps)[:-1]), np.array(added)


def _outermost_lines(row: Row, nodes: Sequence[Nodes], depths: Array) -> tuple[Array, Array, Array]:
    """The leftmost and the rightmost line of each state, and what both add to U and P (2, s)."""
    count = len(nodes)
    first_contacts = [one[:2] for one in nodes]
    last_contacts = [one[-2:] for one in nodes]
    lines, by_line = _lines_on_path(
        row, np.array(first_contacts + last_contacts), np.tile(depths, 2)
    )
    left = lines[:count, 0]
    right = lines[count:, 1]
    return left, right, by_line[:, :count, 0] + by_line[:, count:, 1]


def _pairs_of_contacts(nodes: Nodes) -> Nodes:
    """First and last nodes of the two contacts beside each gap (m - 1, 4), from those of all."""
    contacts = nodes.reshape(-1, 2)
    return np.hstack([contacts[:-1], contacts[1:]])


def _lines_on_path(row: Row, nodes: Nodes, depth: Array) -> tuple[Array, Array]:
    """Lines (s, 2m) and what each adds to U and P (2, s, 2m), as `between`, of states on a path.

    On paths lone nodes stand for contacts narrower than a link wherever the walk keeps them so.
    """
    passed = advances(row, nodes, depth)
    return between(row, nodes, depth, passed, narrow=is_lost_smoothly(row))


def positions(row: Row, nodes: Nodes, zeta: Array, corner: Corners) -> Array:
    """x of lines (s, 2m) at ζ from their nodes; of those at a corner that of the corner [length].

    As lines that face each other feel each other, one may be more than half a link from its node.
    Where the node has to follow from the position, as a line that stays where it was, the position
    is recorded within half a link.
    """
    sides = facing_sides(nodes.shape[1])
    at_corner = zeta == corner.zeta
    recorded = _stretched(zeta, _LINE.shortened) if row.scene.hysteretic else zeta
    x = row.lattice.x(row.first + nodes + sides * (recorded + row.lattice.overhang))
    if at_corner.any():
        nearest = np.abs(row.corners - x[at_corner][:, None]).argmin(axis=1)
        x[at_corner] = row.corners[nearest]
    return np.clip(x, *row.scene.indenter.extent)


def offsets_of(row: Row, nodes: Nodes, lines: Array) -> Array:
    """ζ of lines at these positions (s, 2m), the inverse of `positions`.

    Only with tension, where the overhang is 0.
    """
    links = (lines - row.lattice.x(row.first + nodes)) / row.lattice.spacing
    zeta = facing_sides(nodes.shape[1]) * links
    return np.where(np.isin(lines, row.corners), zeta, _stretched(zeta, 1 / _LINE.shortened))


def _stretched(zeta: Array, factor: float) -> Array:
    """ζ with what is beyond nearly half a link times a factor, of all lines but the outermost."""
    beyond = zeta - np.clip(zeta, -_LINE.nearly_half, _LINE.nearly_half)
    found = zeta.copy()
    found[:, 1:-1] += (factor - 1) * beyond[:, 1:-1]
    return found


def moved(
    row: Row, contacts: Sequence[Contacts], depths: Array, before: Contacts, lines: Lines
) -> list[Lines]:
    """Where lines are that resist, at depths to which they come from another state.

    A line that is less than a link from where one was comes from there, and keeps its x to the last
    bit if it has not moved; others come from the side on which their contacts were.

    Parameters
    ----------
    row : Row
    contacts : sequence of Contacts
        Equally many in each of s states.
    depths : ndarray (s,)
        [length].
    before, lines : Contacts, tuple of float
        The contacts before, and x of their lines [length].

    Returns
    -------
    list of tuple of float
        x of the lines of each state [length].
    """
    nodes = np.reshape(contacts, (len(contacts), -1))
    came, x_before = _came_from(row, nodes, before, lines)
    corner = corners(row, nodes)
    passed = advances(row, nodes, depths)
    zeta = offsets(row, nodes, depths, passed, corner, row.works, came)
    found = positions(row, nodes, zeta, corner)
    unmoved = np.abs(x_before - found) <= _LINE.rounding * float(np.abs(found).max())
    found = np.where(unmoved, x_before, found)
    return [tuple(own) for own in found.tolist()]


def _came_from(row: Row, nodes: Nodes, before: Contacts, lines: Lines) -> tuple[Array, Array]:
    """ζ from which lines at nodes come, at most a link away, and x of the lines before (s, 2m).

    Of the two lines before that enclose a node one has the same side: it is the line before. ±∞ if
    that is beyond all of them.
    """
    nodes_before = np.array(before, int).reshape(1, -1)
    x_before = np.array(lines)
    zeta_before = offsets_of(row, nodes_before, x_before)
    places = nodes_before + facing_sides(nodes_before.size) * zeta_before  # in numbers of nodes
    places = np.concatenate([[-math.inf], places.ravel(), [math.inf]])
    x_before = np.concatenate([[-math.inf], x_before.ravel(), [math.inf]])

    # Left lines have odd numbers in `places`, right lines even ones. First the line to the right of
    # the node is taken, then the other one if that has the wrong side.
    sides = facing_sides(nodes.shape[1])
    for_right_lines = np.searchsorted(places, nodes, "right")
    for_left_lines = np.searchsorted(places, nodes)
    nearest = np.where(sides > 0, for_right_lines, for_left_lines)
    nearest -= nearest % 2 == (sides > 0)
    came = np.clip(sides * (places[nearest] - nodes), -1.0, 1.0)
    return came, x_before[nearest]
