"""The metastable branch of one contact on the mesh: a disc, a ring, or a line contact.

Its lines do not feel each other (single_line.py). Of a convex indenter there is no other contact;
of others a path is followed up to where a second one begins.

Conventions
-----------
The depth d and the rest depth D(x) of a line are positive down into the layer, heights f of the
profile upwards [length]; `direction` is 1 where the depth grows and lines advance outwards, -1
where it falls and they recede. P is positive where pressed, U is 0 without contact; both count per
length of a line contact.

Lines of the contact are a tuple (left, right), `column` is 0 for the left and 1 for the right one.
About an axis they are radii: the left line of a ring is its inner one, that of a disc is 0 and no
line. `side` of a line is 1 if its contact is on its left, that is for the right line, else -1.

An `Arc` is what one line does first on the way to another depth: it moves in one direction or
stays, from the place `start` at the depth `first` to `end` at `last`, and `how` says why it ends:
"goal", "free" of a corner or at one, or "jump". A `SingleContactTrack` has both lines where there
can be no other contact and nothing happens to them but, in the end, the loss of contact.

`SingleLine.arc` is the `Arc` of a line, `places` are its positions along it, and `landing` is where
it comes to rest after a jump, None if nowhere. `SingleContact` finds the lines of the only contact
of a scene, by search outwards from its apex; its `tip` is the least distance of a line from the
apex, 0 if lines get there. `one_contact` is whether a scene has never more than one contact; under
a `pattern` of adhesion D jumps at its edges. `resolve` samples the profile; `hidden` are places of
features that the samples have missed, and `complete` profiles have none. `free_surface_lines` are
the lines of both tails, ((-inf, left), (right, inf)).

`ContactLines.rests` gives the depths D at which lines rest, its `size` the largest depth that
occurs; TIE is the part of it that is rounding, TOLERANCE what certificates tolerate. `opening` are
forces that would open the contact, `penetration` is how far the profile is inside the free
surfaces, `gradual` whether lines never jump, and `surfaces.stored` the energies and forces of free
surfaces at depths. `Integrals.contact(x, depths, w)` are three rows: the energy of contact from a
fixed place to x, the size of its terms, and its derivative by the depth. l = √(γ₁/k) is
`elastocapillary_length`, and `opened` is the scene with the work of adhesion of contacts that open.
`DIFFERENCES.least_radius`, of l, is so near to the apex that lines are looked for by logarithms.
`Contacts` and `certify` give the certificate, whose `demand` raises NotCertifiedError if it fails.

A `FittedBranch` has the states at imposed depths: `segment(point, goal)` is the path from a `Point`
(depth and lines, None without contact) towards a depth, up to an event. A `PathSegment` has its
points `start` and `end`, the point `after` the event, None if there is none, and whether lines jump
there. `bracketed` is the zero between two places at which a function differs in sign, `worst` the
largest of its arguments, or nan; `unknown(depth, x)` is the error of a line at the end of the known
profile, and `warn_hidden` warns of the features that samples have missed.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.certificate import TOLERANCE, NotCertifiedError, worst
from discretization.fitted.contact_lines import ContactLines, free_surface_lines
from discretization.fitted.contacts import Contacts, certify
from discretization.fitted.rest_depths import DIFFERENCES, TIE
from discretization.fitted.single_contact import SingleContact
from discretization.paths.branch import PathSegment, Point
from discretization.paths.fitted_branch import FittedBranch
from discretization.paths.single_contact_track import SingleContactTrack
from discretization.paths.single_line import Arc, SingleLine
from discretization.profile import resolve, unknown, warn_hidden
from discretization.quadrature import Integrals
from discretization.roots import bracketed
from discretization.routes import one_contact
from energy import Scene
from energy.arrays import Array

Lines = tuple[float, ...]


@dataclass(eq=False)
class OneContactSegment(PathSegment):
    """A segment on which each line moves in one direction or stays.

    Attributes
    ----------
    arcs : tuple of Arc
        What each moving line does, in the order of `OneContactBranch.moving`.
    track : SingleContactTrack or None
        Both lines, in place of arcs, where it is known.
    """

    arcs: tuple[Arc, ...] = ()
    track: SingleContactTrack | None = None

    def lines(self, depths: Array) -> Array:
        """Left and right line (k, 2) of the contact at depths (k,) [length]."""
        if self.track is not None:
            return self.track.lines(depths).reshape(depths.size, -1)[:, 1:-1]
        found = np.zeros((depths.size, 2))
        moving = self.branch.moving(self.start.lines)
        for arc, (column, line) in zip(self.arcs, moving, strict=True):
            found[:, column] = line.places(arc, depths)
        return found

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the segment (n,)."""
        rows = self.lines(depths).tolist()
        return [Point(d, tuple(row)) for d, row in zip(depths.tolist(), rows, strict=True)]


@dataclass(frozen=True, eq=False)
class OneContactBranch(FittedBranch):
    """One contact under a prescribed depth.

    Attributes
    ----------
    scene : Scene
    contact_lines : ContactLines
        The lines of the scene, their rest depths and their free surfaces.
    single_contacts : dict
        By direction, what finds the contact where there can be no other: 1 with the adhesion of
        closing, -1 with that of opening. Empty where there may be others.
    """

    scene: Scene
    contact_lines: ContactLines
    single_contacts: dict[int, SingleContact]

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> OneContactBranch:
        """The branch of a scene, for depths up to the largest one of the programme, `deepest`.

        Warns
        -----
        AccuracyWarning
            Where the profile has features that its samples have missed.
        """
        single_contacts = {}
        if one_contact(scene) and scene.pattern is None:
            single_contacts = {1: SingleContact.of(scene), -1: SingleContact.of(scene.opened)}
        branch = cls(
            scene, ContactLines.of(scene, resolve(scene, deepest), deepest), single_contacts
        )
        if not (scene.indenter.convex or scene.indenter.complete):
            hidden = branch.integrals.hidden
            if hidden.size:
                warn_hidden(hidden, stacklevel=4)
        return branch

    touch = property(lambda self: self.contact_lines.profile.touch)

    @functools.cached_property
    def integrals(self) -> Integrals:
        """Integrals over the profile up to a line, by which U and P of contacts are differences."""
        rests = self.contact_lines.rests
        level = rests.size + max(rests.size, self.touch)
        return Integrals.of(self.scene, self.contact_lines.profile, level)

    def moving(self, lines: Lines) -> list[tuple[int, SingleLine]]:
        """The lines of a contact with their columns: both, or only the right one of a disc."""
        both = self.both
        return both[1:] if self.scene.axisymmetric and not lines[0] else both

    @functools.cached_property
    def both(self) -> list[tuple[int, SingleLine]]:
        """The left and the right line of a contact, each with its column."""
        return [
            (0, SingleLine(self.contact_lines.rests, -1)),
            (1, SingleLine(self.contact_lines.rests, 1)),
        ]

    @functools.cached_property
    def first(self) -> Point:
        """The contact at first touch, spread from the lowest point to where its lines rest."""
        lowest = self.contact_lines.profile.lowest
        lines = self._landed((lowest, lowest), self.touch, 1)
        assert lines is not None, "a line that is pressed rests somewhere"
        if contact := self._near_apex(lines):
            lines = contact.lines(self.touch)
        self._refuse_others(lines, self.touch)
        return Point(self.touch, lines)

    def _near_apex(self, lines: Lines) -> SingleContact | None:
        """What finds lines closer to the apex of a lone contact than the samples of the profile.

        None if these lines are not so close, or if there is no such contact.
        """
        contact = self.single_contacts.get(1)
        near = DIFFERENCES.least_radius * self.scene.elastocapillary_length
        if contact is None or not contact.tip or not lines:
            return None
        return contact if max(abs(x - contact.apex) for x in lines) <= near else None

    def segment(self, point: Point, goal: float) -> OneContactSegment:
        """The path from a point towards another depth, up to the first change.

        That is where a line jumps, becomes pinned or free, or the contact is lost.
        """
        lines = point.lines or ()
        direction = 1 if goal >= point.depth else -1
        contact = self.single_contacts.get(direction)
        if contact and (track := SingleContactTrack.of(contact, lines, point.depth, goal)):
            there = (0.0, *track.last.tolist())[-2:]
            after = None if track.end == goal else Point(track.end, None)
            jumps = after is not None and not self.contact_lines.gradual
            return OneContactSegment(
                self, point, Point(track.end, there), after, jumps, track=track
            )
        moving = self.moving(lines)
        arcs = [line.arc(lines[column], point.depth, goal) for column, line in moving]
        ends = [goal, *(arc.last for arc in arcs)]
        end = min(ends, key=lambda depth: direction * depth)  # the first one on the path
        lost = False
        if direction < 0:
            end, lost = self._lost(lines, point.depth, arcs, end)
        there = self._there(lines, arcs, end)
        segment = OneContactSegment(self, point, Point(end, there), None, False, tuple(arcs))
        if lost:
            if there[0] == there[1] and lines[0] != lines[1]:
                # The last state before is a little wider, so that it is not one of one point.
                wider = [math.nextafter(x, before) for x, before in zip(there, lines, strict=True)]
                segment.end = Point(end, (wider[0], wider[1]))
            segment.after = Point(end, None)
            segment.jumps = not self.contact_lines.gradual
            return segment
        tie = TIE * self.contact_lines.rests.size
        jumping = [arc.how == "jump" and abs(arc.last - end) <= tie for arc in arcs]
        self._refuse_others(there, end)
        if any(jumping):
            landed = self._landed(there, end, direction, jumping)
            if landed is not None:
                self._refuse_others(landed, end)
            segment.after = Point(end, landed)
            segment.jumps = self.jumps(segment.end, segment.after)
        return segment

    def _there(self, lines: Lines, arcs: Sequence[Arc], depth: float) -> Lines:
        """Both lines at a depth on the arcs of those that move."""
        found = list(lines)
        for arc, (column, line) in zip(arcs, self.moving(lines), strict=True):
            found[column] = float(line.places(arc, np.array([depth]))[0])
        return tuple(found)

    def _lost(
        self, lines: Lines, start: float, arcs: Sequence[Arc], end: float
    ) -> tuple[float, bool]:
        """Whether, and where, the contact is lost on the path to the smaller depth `end`.

        A contact of one point is lost at the height of the profile there. Another one is lost where
        its lines meet, unless it is pressed there: then it goes on as one of a point.

        Parameters
        ----------
        lines : tuple of float
            At the start [length].
        start, end : float
            Depths [length].
        arcs : sequence of Arc
            Of the lines that move.

        Returns
        -------
        depth : float
            Where the contact is lost or its lines meet, or the end [length].
        lost : bool
        """

        def width(depth: float) -> float:
            """Of the contact; negative where its lines would have crossed."""
            left, right = self._there(lines, arcs, depth)
            return right - left

        if lines[0] == lines[1]:
            lowest = float(self.scene.indenter.height(np.array(lines[0])))
            return (lowest, True) if end < lowest <= start else (end, end < lowest)
        if width(end) > 0:
            return end, False
        if width(end) == 0 and all(arc.start == arc.end for arc in arcs):
            return end, False
        met = bracketed(lambda depth: -width(depth), start, end) if width(end) < 0 else end
        left, right = self._there(lines, arcs, met)
        pressed = left == right and met >= float(self.scene.indenter.height(np.array(left)))
        return met, not pressed

    def _landed(
        self, lines: Lines, depth: float, direction: int, jumping: Sequence[bool] = (True, True)
    ) -> Lines | None:
        """The lines after those that jump have come to rest; None where the contact is lost.

        An inner line about an axis that finds no rest on its way inwards closes the hole: 0. A
        right line that recedes to the axis has lost the contact, and so have lines that cross.

        Parameters
        ----------
        lines : tuple of float
            Before the jump [length].
        depth : float
            d [length].
        direction : {1, -1}
            1 where lines advance.
        jumping : sequence of bool
            Which of the lines that move do, in the order of `moving`.

        Raises
        ------
        ValueError
            If one leaves the known profile.
        """
        found = list(lines)
        for (column, line), jumps in zip(self.moving(lines), jumping, strict=False):
            if not jumps:
                continue
            place = line.landing(lines[column], depth, direction)
            if place is None and direction > 0 and self.scene.axisymmetric and column == 0:
                place = 0.0
            if place is None and direction > 0:
                raise unknown(depth, lines[column])
            closed = direction < 0 and place == 0 and column == 1 and self.scene.axisymmetric
            if place is None or closed:
                return None
            found[column] = place
        return (found[0], found[1]) if found[0] <= found[1] else None

    def _refuse_others(self, lines: Lines, depth: float) -> None:
        """NotCertifiedError if the contact with these lines opens inside, or is not the only one.

        It opens where something pulls at it by more than rounding, and another contact begins where
        the profile penetrates the free surfaces. A convex profile under one work of adhesion has
        neither.
        """
        if self.scene.indenter.convex and self.scene.pattern is None:
            return
        scale = TOLERANCE * self.contact_lines.rests.size
        unit = self.scene.stiffness * self.scene.elastocapillary_length
        # Not <=, rather than >, since what is nan must not pass.
        torn = not worst(*self.contact_lines.opening(lines, depth)) <= unit * scale
        if torn or not self.contact_lines.penetration(lines, depth) <= scale:
            what = "a gap opens inside the contact" if torn else "another contact begins"
            remedy = "use other depths, or a line contact with slopes='small'"
            if not self.scene.axisymmetric and self.scene.slopes == "small":
                remedy = "use method='lattice'"
            raise NotCertifiedError(
                f"{what} at or before depth = {depth!r}: several contacts about an axis, over a "
                f"pattern or with slopes='finite' are not followed on the mesh; {remedy}"
            )

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact.

        Each is the integral over the profile up to the right line less that up to the left one, and
        what both tails contribute.
        """
        lines = np.array([free_surface_lines(point.lines or ()) for point in points])
        depths = np.array([point.depth for point in points])
        total = np.zeros((2, len(points)))
        for column, sign in ((0, -1.0), (1, 1.0)):
            line = lines[:, column, 1 - column]  # the right line of the left tail, and vice versa
            contact = self.integrals.contact(line, depths, self.scene.work_of_adhesion)
            total += sign * contact[::2]
            at = self.contact_lines.rests.at(line)
            left, right = (None, at) if column == 0 else (at, None)
            total += np.array(self.contact_lines.surfaces.stored(left, right, depths))
        return total

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contact is in equilibrium."""
        if not point.lines:
            return
        # The lines of the path know the size of its depths, of which rounding is a part.
        judge = self._near_apex(point.lines) or self.contact_lines
        contacts = Contacts(judge, point.lines, point.depth)
        certify(contacts, contacts.totals()).demand(
            f"the state at depth = {point.depth!r}",
            "the path stops before it; try other depths, or method='lattice'",
        )
