"""Where the line of a contact of a layer rests, and how far it moves.

A convex profile, mirrored about its lowest point or turned about an axis, has one contact with one
line, at the half-width or radius a. From first touch the line advances while D(a) < d; withdrawn it
recedes while D(a) > d, D as in contact.py. At corners and edges D jumps and may pin it.

The coefficients of a contact are the same at any depth: a state computes them at a few a, a path
reads a `Table`.

Conventions
-----------
Depths are positive downwards, heights f of the profile upwards. a is a distance from the lowest
point of the profile, or the axis. A direction is 1 outwards, as the depth grows, and -1 inwards, as
it falls: then direction times (D - d) < 0 is what moves a line on in its direction. A side is the
direction of a line for which D is meant; it matters at corners, where D outwards is that of the
slope outside, D inwards of the slope inside, and D outwards is no less. `Body` has the profile:
its `touch` is the depth of first touch, `tip` the half-width that counts as a contact of the lowest
point alone, `edge` where the known profile ends, `corners` the places that may pin a line.

`Contact.coefficients` are σ, s₀, P', P₀, U₀ of a contact of half-width a in this order: the line
pulls γ₁ (σ u + s₀) if it is displaced by u, and the force is P₀ + P' u. Of these σ and s₀, the
`reaction`, give D = f + (f' - s₀ - √(2w/γ₁))/σ. Of a scene, `elastocapillary_length` is l,
`shear_modulus` of its layer G, `opened` the same scene with the work of adhesion of a contact that
opens, and `small_slope_deficit` of its surfaces √(2w/γ₁). `Body.apex` is the position from which a
counts.

`bracketed` finds a zero between a place where a function is <= 0 and one where it is > 0,
`bracketed_minimum` the least value between two places, or the first one found that is low enough.
`unknown(depth, x)` is the error of a contact that spreads to x, the end of the known profile.
`gauss_lobatto(degree)` begins with degree + 1 points on [-1, 1], and `to_legendre` is the matrix
from rows of values there to rows of Legendre coefficients.
"""

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.polynomial.legendre import legval

from discretization.layer.body import Body
from discretization.layer.contact import Contact
from discretization.profile import unknown
from discretization.roots import bracketed, bracketed_minimum
from discretization.surfaces.network import gauss_lobatto, to_legendre
from energy.arrays import Array

# Half-widths over h that are tried first, and the largest: from 1e-9, which is an atom under a
# layer of 0.1 m, to 1e9.
_PLACES = 2.0 ** np.arange(-30, 31)


class LineRules(NamedTuple):
    """Where the line of a contact is looked for, and how exactly.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 5 random states,
    branches and paths as they are to 1e-9: `python -m tests.sensitivity
    discretization.layer.lines`.

    Attributes
    ----------
    adhesion_dominates : float
        Slope over √(2w/γ₁), and height over the depth, up to which a line advances, whatever lies
        below it: where the slope is √(2w/γ₁) it would rest if the free surface were flat.
    far_below : float
        Half-width over the shortest length of the layer: at smaller ones D is a power of a but for
        this part, and so turns nowhere.
    closed : float
        Half-width at which a line contact counts as closed up, over one where adhesion dominates.
    sparse : float
        Octaves of a between places where D is a power of a: there it turns nowhere, and few are
        enough.
    turn_rounds : int
        Rounds of the search for the greatest D. Each narrows it fourfold, and D is known twice as
        well as the place: 4⁻¹⁰ = 1e-6, and 1e-12 of D.
    tie : float
        Relative difference of depths that count as the same, above the rounding of D.
    straight : float
        Width of the last bracket over a: over so little D is straight but for 3e-7² = 1e-13, and
        the straight line through both ends gives its zero.
    """

    adhesion_dominates: float = 1 / 4
    far_below: float = 1 / 64
    closed: float = 1e-8
    sparse: float = 6.0
    turn_rounds: int = 10
    tie: float = 1e-12
    straight: float = 3e-7


_LINE = LineRules()


class PanelRules(NamedTuple):
    """Polynomials in log₂ a of the coefficients of contacts.

    Halved or doubled, each leaves 5 random states, branches and paths as they are to 1e-9: `python
    -m tests.sensitivity discretization.layer.lines`.

    Attributes
    ----------
    degree : int
        Degree on a panel. No result depends on it, as panels are halved until they are fine enough.
    narrowest : float
        Octaves of a: a narrower panel is not halved, it holds a kink.
    coefficients_left : float
        Of the tolerance: size of the last coefficients of a panel that is fine enough.
    """

    degree: int = 10
    narrowest: float = 2.0**-9
    coefficients_left: float = 0.1


_PANEL = PanelRules()


class Rest(NamedTuple):
    """Where a line that moves towards a depth comes to rest, or what stops it.

    Attributes
    ----------
    a : float
        Half-width [length].
    depth : float
        D there, as the line comes to it [length]: the depth itself if the line rests there.
    how : {"rests", "corner", "turns", "lost"}
        It is in equilibrium; pinned at a corner; where D turns, from where it jumps; or the contact
        is lost.
    """

    a: float
    depth: float
    how: Literal["rests", "corner", "turns", "lost"]


@dataclass(frozen=True, eq=False)
class Lines:
    """The line of a body under one work of adhesion.

    Attributes
    ----------
    body : Body
    reaction : callable
        reaction(a): σ [1/length] and s₀ in the first two rows, at a half-width or at many.
    excess : float
        √(2w/γ₁), by which the slope of the indenter exceeds that of the free surface at the line.
    step : float
        Octaves of a in which D turns once at most.
    """

    body: Body
    reaction: Callable[[Any], Array]
    excess: float
    step: float

    def rest_depth(self, a: Any, side: Any) -> Any:
        """Depth D at which a line would rest; see `Body.rest_depth`.

        Parameters
        ----------
        a : float or ndarray (n,)
            Half-widths [length].
        side : {1, -1}
            At a corner 1 for a line that advances, -1 for one that recedes.

        Returns
        -------
        float or ndarray (n,)
            [length].
        """
        depth = self.body.rest_depth(a, self.reaction(a), self.excess, side)
        return depth if np.ndim(a) else depth.item()

    def walk(
        self, start: float, here: float, to: float, direction: int, *, past: bool = True
    ) -> Rest:
        """How far a line comes that moves in one direction as the depth changes.

        It goes from place to place (`_ahead`) until D has come as far as the depth: between the
        last two it then rests. Where D turns between places, its extreme decides.

        Parameters
        ----------
        start : float
            Half-width at which it begins [length].
        here, to : float
            D there in this direction, and the depth that is reached [length].
        direction : {1, -1}
            Outwards or inwards.
        past : bool
            True for the line at the depth `to`, whatever is in between: it goes on where D turns,
            and over corners that do not pin it at `to`. False for a path from `start`, where the
            line rests, up to what interrupts it: the first such place.

        Returns
        -------
        Rest

        Raises
        ------
        ValueError
            If it comes beyond a known profile.
        """
        tie = _LINE.tie * (abs(here - to) + abs(self.body.height(start) - self.body.touch))
        place_before = start
        place = start
        depth = here
        # Whether D has changed in the direction of the line so far: of a line at rest it does. It
        # turns only if it then changes the other way, by more than rounding.
        depth_follows = not past
        for next_place, next_depth in self._ahead(start, direction):
            # A place that comes twice is a corner; here D jumps on its far side.
            is_corner = next_place == place
            if is_corner and (not past or direction * (next_depth - to) >= 0):
                return Rest(next_place, depth, "corner")
            turns = depth_follows and direction * (next_depth - depth) < -tie
            if turns:  # within the last two intervals
                begin = place_before
                end, furthest = self._turn(place_before, next_place, to, direction)
            else:
                begin = place
                end = next_place
                furthest = next_depth
            if direction * (furthest - to) >= 0:
                fraction = (to - depth) / ((furthest - depth) or 1.0)
                return Rest(self._zero(begin, end, to, direction, fraction), to, "rests")
            if turns and not past:
                return Rest(end, furthest, "turns")
            depth_follows = direction * (next_depth - depth) > 0
            place_before = place
            place = next_place
            depth = next_depth
        if direction > 0:
            raise unknown(to, place + self.body.apex)
        return Rest(place, depth, "lost")

    def _turn(self, one: float, other: float, to: float, direction: int) -> tuple[float, float]:
        """Where D turns back between two half-widths, or where it has come as far as a depth.

        Parameters
        ----------
        one, other : float
            Half-widths between which D has one extreme: a maximum for a line that moves outwards, a
            minimum for one that moves inwards [length].
        to : float
            The depth [length].
        direction : {1, -1}

        Returns
        -------
        a, depth : float
            The half-width, and D there [length].
        """
        backwards = np.vectorize(lambda a: -direction * self.rest_depth(a, direction))
        low, high = sorted((one, other))
        a, value = bracketed_minimum(backwards, low, high, -direction * to, _LINE.turn_rounds)
        return a, -direction * value

    def _zero(self, begin: float, end: float, to: float, direction: int, fraction: float) -> float:
        """The half-width between two others at which D is a depth.

        At the end, which may be a corner, D counts as the line comes to it.

        Parameters
        ----------
        begin, end : float
            The half-widths, in the order in which the line comes to them [length].
        to : float
            The depth [length].
        direction : {1, -1}
            From `begin` to `end`.
        fraction : float
            Where it is looked for first, from 0 at `begin` to 1 at `end`.
        """

        def beyond_depth(a: float) -> float:
            """How far D is beyond the depth in the direction of the line: negative at `begin`."""
            side = -direction if a == end else direction
            return float(direction * (self.rest_depth(a, side) - to))

        # Inside, whatever the straight line says; 0.01 to 0.99 or the middle instead take as many
        # evaluations, 172 and 179 of 30 states instead of 174.
        first = max(0.1, min(0.9, fraction))
        return bracketed(beyond_depth, begin, end, _LINE.straight, first)

    def _ahead(self, a: float, direction: int) -> Iterator[tuple[float, float]]:
        """Half-widths to which a line comes one after the other, and D there.

        A corner comes twice, first with D before it, then with D beyond it if that is further on.
        A lowest point alone opens at first touch, until when it stays. A line contact closes up;
        about an axis D returns to first touch as the radius vanishes. Far below all lengths, and
        where adhesion begins to rule, D turns once at most.

        Parameters
        ----------
        a : float
            Where the line is [length].
        direction : {1, -1}

        Yields
        ------
        a, depth : float
            The half-width, and D there [length].
        """
        body = self.body
        layer = body.scene.layer
        small = self._small(body.touch)
        if direction > 0:
            end = min(body.edge, float(_PLACES[-1]) * layer.h)
        else:
            end = min(a, max(_LINE.closed * small, self.narrowest))
        # The shortest length of the layer: its thickness, or γ₁/G, below which tension rules.
        length = max(small, min(layer.h, body.scene.gamma1 / layer.shear_modulus))
        middle = sorted((a, _LINE.far_below * length, end))[1]  # the second of three
        # Outwards, contacts are far below all lengths before the middle; inwards, beyond it.
        step_before = _LINE.sparse if direction > 0 else self.step
        step_beyond = self.step if direction > 0 else _LINE.sparse
        places = set(_octaves(a, middle, step_before, direction))
        places |= set(_octaves(middle, end, step_beyond, direction))
        pinning = {*body.corners, self.narrowest}
        corners = {x for x in pinning if direction * a < direction * x <= direction * end}
        places |= {middle, end, *corners}
        for x in sorted(places - {a}, reverse=direction < 0):
            # D before a corner has the slope on the side from which the line comes.
            is_corner = x == end or x in corners
            before = self.rest_depth(x, -direction if is_corner else direction)
            yield x, before
            if x in corners:
                beyond = self.rest_depth(x, direction)
                if direction * beyond > direction * before:
                    yield x, beyond

    def settled(self, depth: float) -> Rest:
        """Where the line rests at a depth on the path from first touch.

        The line advances from a small half-width to where it rests at this depth, or at that of
        first touch if the depth is less, from where it then recedes.

        Parameters
        ----------
        depth : float
            [length].

        Returns
        -------
        Rest

        Raises
        ------
        ValueError
            If it comes beyond a known profile.
        """
        pressed = max(depth, self.body.touch)
        a = 8 * self._small(pressed)  # 8 times as wide as the first that is tried
        here = math.inf
        # A line that does not advance at the small half-width may at one 8 times smaller.
        while a > self.narrowest and here >= pressed:
            a = max(a / 8, self.narrowest)
            here = self.rest_depth(a, 1)
        found = Rest(a, pressed, "corner")
        if here < pressed:
            found = self.walk(a, here, pressed, 1)
        if depth < self.body.touch:
            opens = self.rest_depth(found.a, -1)
            if opens > depth:
                return self.walk(found.a, opens, depth, -1)
        return found

    def _small(self, depth: float) -> float:
        """A half-width so small that a line there advances at this depth, if any does [length].

        It is the largest of powers of 2 times h at which the slope is a quarter at most of
        √(2w/γ₁), and the height a quarter at most of the sum of the depth of indentation and
        √(2w/γ₁) times h or l, whichever is longer; the narrowest half-width, if there is none.
        """
        body = self.body
        h = body.scene.layer.h
        places = np.minimum(_PLACES * h, body.edge / 2)
        by_adhesion = self.excess * max(h, body.scene.elastocapillary_length)
        allowed = _LINE.adhesion_dominates * (depth - body.touch + by_adhesion)
        flat = body.height(places) - body.touch < allowed
        if self.excess:
            flat &= body.slope(places) < _LINE.adhesion_dominates * self.excess
        return max(float(places[flat].max(initial=0.0)), self.narrowest)

    @functools.cached_property
    def narrowest(self) -> float:
        """The half-width that counts as a contact of the lowest point alone [length].

        Without adhesion it is that of a flat face around the lowest point, which parts at once.
        """
        if self.excess:
            return self.body.tip
        level = [x for x in self.body.corners if self.body.height(x) == self.body.touch]
        return max(level, default=self.body.tip)


def _octaves(start: float, end: float, step: float, direction: int) -> list[float]:
    """Half-widths from one to another, in steps of so many octaves, without these two.

    `end` is in the direction of `start`: larger for 1, smaller for -1.
    """
    exponents = direction * np.arange(step, direction * math.log2(end / start), step)
    return list((start * 2.0**exponents).tolist())


class Panel(NamedTuple):
    """Polynomials of `Contact.coefficients` over a range of log₂ a.

    Attributes
    ----------
    series : ndarray (5, 11)
        Their Legendre coefficients, of increasing degree, on the range from -1 to 1.
    resolved : bool
        Whether the last two of each are small enough.
    """

    series: Array
    resolved: bool


class Table:
    """`Contact.coefficients` as polynomials of log₂ a on panels.

    Panels are octaves, or what breaks of the profile leave of them. They are made when needed, and
    halved until their last coefficients are a tenth of the tolerance.

    Parameters
    ----------
    body : Body
    tolerance : float
        That of the poles, and of the polynomials.

    Attributes
    ----------
    breaks : list of float
        log₂ of the half-widths at which the coefficients are not smooth, or the profile ends.
    panels : dict of Panel
        Those that are known, by their ends in log₂ a.
    """

    def __init__(self, body: Body, tolerance: float) -> None:
        """Note where panels have to end; each is made when it is first read."""
        self.body = body
        self.tolerance = tolerance
        self.breaks = [math.log2(x) for x in (*body.breaks, body.edge)]
        self.panels: dict[tuple[float, float], Panel] = {}

    def at(self, a: Any) -> Array:
        """`Contact.coefficients` at half-widths.

        Parameters
        ----------
        a : float or ndarray (n,)
            [length].

        Returns
        -------
        ndarray (5, n)
            n = 1 for a single one.
        """
        t = np.log2(np.atleast_1d(a))
        return self._read(t, float(np.ceil(t.min())) - 1, float(np.ceil(t.max())))

    def _read(self, t: Array, low: float, high: float) -> Array:
        """The coefficients (5, n) at t = log₂ a (n,), all between `low` and `high`.

        They are read from the panel over this range if it is an octave or less without a break, and
        resolved. Else the range is divided: between octaves, at a break, or in the middle.
        """
        breaks = [x for x in self.breaks if low < x < high]
        if high - low > 1:
            middle = (low + high) // 2
        elif breaks:
            middle = min(breaks)
        else:
            panel = self._panel(low, high)
            if panel.resolved or high - low < _PANEL.narrowest:
                return np.asarray(legval((2 * t - low - high) / (high - low), panel.series.T))
            middle = (low + high) / 2
        found = np.empty((5, t.size))
        below = t <= middle
        if below.any():
            found[:, below] = self._read(t[below], low, middle)
        if not below.all():
            found[:, ~below] = self._read(t[~below], middle, high)
        return found

    def _panel(self, low: float, high: float) -> Panel:
        """The panel between two log₂ a, made if it is not known yet."""
        if (low, high) not in self.panels:
            self.panels[low, high] = self._made(low, high)
        return self.panels[low, high]

    def _made(self, low: float, high: float) -> Panel:
        """A panel through contacts at its Gauss-Lobatto points.

        Its last coefficients count over the sizes of the five: σ; s₀ with f' and √(2w/γ₁); dP/du;
        and that times once and twice how much u(a) may change, s₀ over σ.
        """
        t = (low + high + (high - low) * gauss_lobatto(_PANEL.degree)[0]) / 2
        half_widths = np.minimum(np.exp2(t), self.body.edge)
        contacts = [Contact(self.body, a, self.tolerance) for a in half_widths.tolist()]
        values = np.array([contact.coefficients for contact in contacts])  # (11, 5)
        series = values.T @ to_legendre(_PANEL.degree)
        excess = self.body.scene.opened.surfaces.small_slope_deficit
        slope = abs(float(self.body.slope(2.0**high, -1)))
        sigma = values[:, 0].min()
        offset = np.abs(values[:, 1]).max() + (slope + excess)
        stiffness = values[:, 2].max()  # dP/du
        displacement = offset / sigma
        sizes = np.array(
            [sigma, offset, stiffness, stiffness * displacement, stiffness * displacement**2]
        )
        last = np.abs(series[:, -2:]).max(axis=1)
        resolved = (last <= _PANEL.coefficients_left * self.tolerance * sizes).all()
        return Panel(series, bool(resolved))
