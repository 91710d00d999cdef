"""The nodes on which contacts and the order of events are found, and lines near them.

Conventions
-----------
Depths grow as the indenter goes down, positions to the right [length]. Nodes of the row are counted
from 0 on the left. Contacts are ((first, last), ...), their first and last nodes from left to
right; () is detached. `lines` of contacts are the 2m positions of their ends from left to right. A
turn of a slope is an extreme of it, and a wave of the profile lies between two turns of one kind.

Of a `Row`, `touch` is the node that touches first, `lowest` its height, the depth at which it does,
and `first` the lattice's number of node 0; a lattice has x = `origin` + number * `spacing`, and
`scene_on_nodes` is the scene itself for a line contact. `Walk.touched(depth)` are the contacts of
the path pressed from first touch on, () before that, and `Walk.moved(contacts, from, to)` what
contacts become; `lowest_contacts` are those of lowest energy, in the lattice's numbers. Of a scene,
`opened` is the scene with the work of adhesion of opening, `critical_separation` δ₀ = √(2w/k) and
`elastocapillary_length` l; `profile.touch` is the least height of the profile.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from discretization.lattice.lowest import lowest_contacts
from discretization.lattice.walk import Walk
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Row, positions
from discretization.profile import Resolved
from energy import Scene
from energy.arrays import Array

# Nodes only supply contacts and the order of events, so that digits do not depend on how many there
# are: each of these halved or doubled changes none of 18 to 23 random states and paths by 1e-9
# (`python -m tests.sensitivity discretization.refine.nodes`).
PER_LENGTH = 32  # nodes per l: events are then found in the right order (98 of 100 rough loops)
PER_WAVE = 16  # and per wave of the profile, from where its slope turns to where it does so again
PER_TIP = 4  # and over the length on which the profile's slope rises by √(2w/γ₁) at low points
NOTICED = 1 / 4  # of √(2w/γ₁): changes of the slope that make a wave
MOST_NODES = 100_000  # in a row: a walk over them takes seconds
FROM_NODES = 0.5  # of l, 16 nodes or more: how far lines may rest from their nodes; those that
# Newton's method takes further are of another equilibrium
AHEAD = 0.1  # of δ₀: by how much events on nodes may come too early or too late
_AHEAD_OF_RANGE = 0.05  # the same without adhesion, of the range of depths
_ROUNDED = 1e-12  # of the size of depths: at least, some thousand roundings of a depth


@dataclass(frozen=True, eq=False)
class FoundNodes:
    """A row of nodes under a profile, with the walk over them.

    Attributes
    ----------
    scene : Scene
    spacing : float
        Of the nodes [length].
    margin : float
        By how much the depths of events on them may be off [length]: AHEAD δ₀, without adhesion a
        part of the range of depths.
    lattice : Lattice
    deepest : float
        The largest depth for which there are nodes [length].
    """

    scene: Scene
    spacing: float
    margin: float
    lattice: Lattice
    deepest: float

    @classmethod
    def of(
        cls,
        scene: Scene,
        profile: Resolved,
        deepest: float,
        closer: float = 1,
        *,
        tips: bool = True,
    ) -> FoundNodes:
        """Nodes for depths up to the deepest.

        Parameters
        ----------
        scene : Scene
        profile : Resolved
        deepest : float
            [length].
        closer : float
            How many times closer the nodes are than usual.
        tips : bool
            Whether they resolve the lowest point of the profile.

        Returns
        -------
        FoundNodes
        """
        spacing = usual_spacing(scene, profile, tips=tips) / closer
        spacing = max(spacing, float(np.ptp(profile.x)) / MOST_NODES)
        lattice = Lattice.of(scene, spacing)
        reach = scene.opened.critical_separation
        margin = AHEAD * reach if reach else _AHEAD_OF_RANGE * abs(deepest - profile.touch)
        margin = max(margin, _ROUNDED * (abs(deepest) + abs(profile.touch)))
        return cls(scene, lattice.spacing, margin, lattice, deepest + margin)

    @functools.cached_property
    def row(self) -> Row:
        """The nodes that may be in contact at depths up to `deepest`."""
        return Row.of(self.lattice.scene_on_nodes(self.scene), self.lattice, self.deepest)

    @functools.cached_property
    def walk(self) -> Walk:
        """The walk over them, on which lone nodes let go as soon as they are pulled."""
        return Walk(self.row)

    @functools.cached_property
    def positions(self) -> Array:
        """x of all nodes of the row [length]."""
        return positions(
            self.lattice, self.scene.indenter, self.row.first + np.arange(self.row.size)
        )

    def lines(self, contacts: Contacts) -> tuple[float, ...]:
        """The positions of the first and last nodes of contacts, from left to right [length]."""
        return tuple(self.positions[np.ravel(contacts).astype(int)].tolist())

    def contacts(self, lines: tuple[float, ...]) -> Contacts:
        """The contacts whose first and last nodes are nearest to these lines.

        lines: 2m positions [length]. Nodes beyond the row are its last ones.
        """
        at = np.rint((np.array(lines) - self.lattice.origin) / self.lattice.spacing).astype(int)
        at = np.clip(at - self.row.first, 0, self.row.size - 1)
        return tuple(zip(at[::2].tolist(), at[1::2].tolist(), strict=True))

    def adhered(self, depth: float) -> Contacts:
        """The contacts of the path that touches first and then moves to this depth; () if lost."""
        touch = self.row.lowest
        if depth >= touch:
            return self.walk.touched(depth)
        first = self.walk.touched(touch)
        return self.walk.moved(first, touch, depth)

    def lowest(self, depth: float) -> tuple[float, ...]:
        """The lines of the contacts of lowest energy of all at a depth; () is detached [length]."""
        nodes = lowest_contacts(self.lattice.scene_on_nodes(self.scene), depth, self.lattice)
        at = positions(self.lattice, self.scene.indenter, nodes.astype(float).ravel())
        return tuple(at.tolist())


def usual_spacing(scene: Scene, profile: Resolved, *, tips: bool = True) -> float:
    """Distance of nodes that resolve l, the waves of the profile and its lowest point.

    The least of l/PER_LENGTH, of every wave of the profile over PER_WAVE, and of what `_tips` has.

    Parameters
    ----------
    scene : Scene
    profile : Resolved
    tips : bool
        Whether the lowest point of the profile is resolved.

    Returns
    -------
    float
        [length].
    """
    length = scene.elastocapillary_length
    kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    turns = slope_turns(profile.x, profile.slope, NOTICED * kink)
    waves = turns[2:] - turns[:-2]  # from a turn to the next but one
    lowest = _tips(profile, kink) if tips else []
    return min([length / PER_LENGTH, *(waves / PER_WAVE).tolist(), *lowest])


def _tips(profile: Resolved, kink: float) -> list[float]:
    """The distance of nodes that the lowest point asks for; [] where it asks for none.

    Over PER_TIP of them the slope rises by √(2w/γ₁), `kink`: about so wide is the contact there
    when it is lost. Without adhesion, at a corner and on a flat face there is no such width.
    """
    lowest = int(np.argmin(profile.f))
    around = slice(max(lowest - 1, 0), lowest + 2)
    width = float(np.ptp(profile.x[around]))
    rise = float(np.ptp(profile.slope[around]))
    corner = np.isin(profile.x[lowest], profile.corners)
    if not kink or not rise or corner:
        return []
    return [kink * width / rise / PER_TIP]


def slope_turns(x: Array, slope: Array, least: float) -> Array:
    """Where a slope turns round, having changed and then changing back by more than `least`.

    Extremes between smaller changes are left out, so that turns are maxima and minima by turns.

    Parameters
    ----------
    x, slope : ndarray (n,)
        Samples of the profile [length], and its slope there.
    least : float
        Smaller changes of the slope are no turns.

    Returns
    -------
    ndarray (m,)
        Positions of the turns [length].
    """
    rises = np.sign(np.diff(slope))
    inner = 1 + np.flatnonzero(rises[1:] != rises[:-1])
    places = np.concatenate([[0], inner, [slope.size - 1]])  # between them it rises, or falls
    turns = list[float]()
    extreme = 0  # number of the sample furthest in the present direction since the last turn
    rising = 1  # the present direction: 1 where the slope rises, -1 where it falls
    for i, value in zip(places.tolist(), slope[places].tolist(), strict=True):
        beyond = rising * (value - slope[extreme])
        if beyond > 0:
            extreme = i
        elif -beyond > least:
            turns.append(float(x[extreme]))
            extreme = i
            rising = -rising
    return np.array(turns)
