"""States of one contact of a layer with its exact response, their certificates and error estimates.

The force is known from what the poles' fields press, and as dU/dd of the energy at fixed contact,
a parabola of the depth; what these fields press and pull is known from other elements, too.

Conventions
-----------
Depths and displacements u are positive downwards, heights f upwards; a is the half-width or radius,
and distances x from the line count outwards. A `Contact` is the response of a contact of fixed a:
its `reaction` (σ, s₀) gives what the line pulls, γ₁ (σ u(a) + s₀), and D(a) = f + (f' - s₀ -
√(2w/γ₁))/σ (`Body.rest_depth`, whose last argument says for a corner whether the slope outside, 1,
or inside, -1, counts); its `coefficients` are (σ, s₀, P', P₀, U₀) with P = P₀ + P'u and
U + w·area = U₀ + P₀u + P'u²/2. `small_slope_deficit` is √(2w/γ₁), and `scene.opened` the same scene
with the work of adhesion of a contact that opens. `Body.tip` is the half-width that counts as a
contact of the lowest point alone, `Body.touch` the depth of first touch, `Body.apex` the position
of the lowest point, `Body.bound(a)` w·area, `Body.power` 1 about an axis and else 0, and
`Body.symmetry_factor` 2 or 2π, by which integrals over x > 0 count.

Of a `Contact`, `slopes` and `weights` (e, 13) are f' at the nodes of its e elements and their
weights in integrals over the contact, half of the `quadratic_form` (2, 2) of (u(a), 1) is what it
stores but for the energy `stretched` of its surface, `lines` (2,) are the pull of its lines.
`poles.decays` are the n λ of exp(-λx) outside, complex ones with their conjugates, `amplitudes`
(n, 2) those by u(a) and 1, and `decayed` these functions with their slopes (2, n, k).
`at_depth(coefficients, u)` are P and U + w·area. `Lines.settled(depth)` is where the line rests, as
(a, D, how): it "rests", is stopped at a "corner", or the contact is "lost".

A `Certificate` has by how much a state violates each condition of equilibrium; that without forces
is `undeformed()`; `worst` is the largest violation, 0 if none is positive, nan if one is nan.
`certified` makes the `Equilibrium`, and raises where that fails; it takes `outermost` for the
distance of the outermost node. `FreeSurface` gives the shape of a free surface from `displaced`.
`on_elements(ends, values, x)` are a function and its slope at x from nodal values. `EPSILON` is
2⁻⁵², `ROUNDING` 16 of that, of sums of a dozen terms; `DECAYED` is 40: e⁻⁴⁰ is less than rounding.
"""

import functools
import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import (
    DECAYED,
    EPSILON,
    ROUNDING,
    AccuracyWarning,
    Certificate,
    worst,
)
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.layer.body import Body
from discretization.layer.contact import Contact, at_depth, decayed
from discretization.layer.lines import Lines
from discretization.layer.one_contact import FreeSurface, certified
from discretization.readings import with_surface
from discretization.surfaces.network import on_elements
from energy import Scene
from energy.arrays import Array


class ErrorRules(NamedTuple):
    """How a state estimates its errors.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each but `other_elements`
    leaves 5 random states, branches and paths as they are to 1e-9: `python -m tests.sensitivity
    discretization.layer.state`. `poles`, `coarser` and `chance` decide about estimates alone, and
    `other_elements` is a fraction, of which twice would be more than 1.

    Attributes
    ----------
    poles : float
        Of rtol: tolerance of the poles; the rest is left to what lines move by.
    loosest : float
        Tolerance of the poles at most: up to here comparing with coarser ones shows their error.
    coarser : float
        Tolerance of the poles that a state is compared with, over its own.
    chance : float
        Of the error of the poles: what is assumed even if coarser ones happen to give the same.
    nearest : float
        Relative distances of half-widths whose D gives dD/da by a difference: D changes by far more
        than its rounding at this one,
    furthest : float
        and is straight still at this one.
    other_elements : float
        `Contact.first` of the elements that the certificate compares with; states have 0.5.
    other_pressure : float
        The same of those that the pressure is compared with.
    """

    poles: float = 0.5
    loosest: float = 5e-5
    coarser: float = 30.0
    chance: float = 0.1
    nearest: float = 1e-7
    furthest: float = 1e-4
    other_elements: float = 0.7
    other_pressure: float = 0.9


_ERRORS = ErrorRules()


_OCTAVE = 1.0  # log₂ of a: over so much of it D turns once at most
# Of the largest: by how much the pressures on two sets of elements may differ without a warning. It
# is what can be seen in a figure; forces and energies do not depend on it.
PRESSURE_KNOWN = 1e-3


class OutsideRules(NamedTuple):
    """Places on the free surface.

    Halved or doubled, each leaves 5 random states, branches and paths as they are to 1e-9: `python
    -m tests.sensitivity discretization.layer.state`.

    Attributes
    ----------
    step : float
        Step of ln x, for integrals by the trapezoidal rule.
    search_step : float
        Step of ln x at which the gap beside a contact is looked at.
    nearest : float
        The first of these places, in the shortest decay length.
    closer : int
        Places in a step of these in which the gap is least.
    """

    step: float = 0.1
    search_step: float = 0.2
    nearest: float = 0.1
    closer: int = 401


_OUTSIDE = OutsideRules()


# Places for integrals over the free surface, over how far that reaches: from e⁻³⁰ = 9e-14 to 1.
_PLACES = np.exp(np.arange(-30.0, _OUTSIDE.step, _OUTSIDE.step))


# A few scenes at a time, as a study that compares some has; a body is a dozen numbers.
@functools.lru_cache(maxsize=8)
def body_of(scene: Scene) -> Body:
    """The profile of a scene by the distance from its lowest point, kept."""
    return Body(scene)


# A search for a state needs about ten contacts, of which the next depth needs some again; one holds
# 0.05 to 0.4 MB, all up to 13 MB.
@functools.lru_cache(maxsize=32)
def contact_of(body: Body, a: float, tolerance: float) -> Contact:
    """The response of a contact of half-width a, with poles to a tolerance, kept."""
    return Contact(body, a, tolerance)


class Layer(FreeSurface):
    """A contact at a depth.

    Parameters
    ----------
    depth : float
        [length].
    contact : Contact
    rate : float
        dD/da of its line, negative where that would run away; infinite where it is pinned.

    Attributes
    ----------
    u_line : float
        Displacement u(a) of the line [length].
    opening : float
        √(2w/γ₁) with the work of adhesion of a contact that opens.
    size : float
        Size of u: |u(a)|, and what slope and adhesion displace the line by [length].
    pinned : bool
        Whether the line is at a corner or an edge.
    """

    def __init__(self, depth: float, contact: Contact, rate: float = math.inf) -> None:
        """Take the contact as it is at this depth."""
        self.depth = depth
        self.contact = contact
        self.rate = rate
        self.body = contact.body
        self.a = contact.a
        self.outermost = contact.a
        self.pinned = rate == math.inf
        self.u_line = depth - contact.f
        self.opening = self.body.scene.opened.surfaces.small_slope_deficit
        slope = abs(float(contact.slopes[-1, -1]))  # at the line, of the contact's side of a corner
        self.size = float(abs(self.u_line) + (slope + self.opening) / contact.reaction[0])

    @functools.cached_property
    def is_point(self) -> bool:
        """Whether it is a contact with the lowest point alone that carries no force.

        `Body.tip` stands for the half-width 0 of such a contact. So what counts as no force is up
        to twice what P₀ and the rise of the profile from 0 to there make at first touch.
        """
        if self.a > self.body.tip:
            return False
        _, _, stiffness, force, _ = self.contact.coefficients
        rise = self.contact.f - self.body.touch
        return bool(abs(self.force) <= 2 * (abs(stiffness) * rise + abs(force)))

    @functools.cached_property
    def totals(self) -> Array:
        """What its lines pull, c m S, the force P, and the energy U + w·area (3,)."""
        pull = self.contact.lines @ np.array([self.u_line, 1.0])
        return np.array([pull, *at_depth(self.contact.coefficients, self.u_line)])

    @property
    def force(self) -> float:
        """P, positive where the indenter is pressed; per length of a line contact."""
        return float(self.totals[1])

    @property
    def energy(self) -> float:
        """U = what is stored - w·area, 0 of the flat surface; per length of a line contact."""
        return float(self.totals[2] - self.body.bound(self.a))

    @functools.cached_property
    def pressed(self) -> Array:
        """Pressure of the layer at the nodes of the contact's elements (e, 13)."""
        return np.tensordot(np.array([self.u_line, 1.0]), self.contact.pressures, 1)

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """Sums of the sizes of the terms of force and energy, by these names.

        Of the force ∫|p| and what the free surface pulls; of the energy what is stored, and w·area.
        """
        pressed = float((self.contact.weights * np.abs(self.pressed)).sum())
        pull, _, stored = np.abs(self.totals)
        energy = float(stored + self.body.bound(self.a))
        return {"force": pressed + float(pull), "energy": energy}

    @functools.cached_property
    def certificate(self) -> Certificate:
        """The conditions of certificate.py.

        penetration   looked for the closer the nearer to the line, and where the gap is least
        stationarity  what the poles' fields press, pull and store, on two sets of elements
        opening       no pressure is negative where nothing adheres
        neighbours    d <= D just outside the line by closing, D just inside by opening <= d; where
                      D falls outwards the line would run away
        force         P, the first column of the quadratic form of the energy, against dU/dd, its
                      first row: what they differ by is rounding

        Depths are over the sum of |d| from first touch, |u(a)|, and what slope and adhesion
        displace the line by; forces over their sum of sizes.
        """
        if self.is_point:
            return Certificate.undeformed()
        body = self.body
        size = abs(self.depth - body.touch) + self.size or 1.0
        pressed = self.scales["force"] or 1.0
        pulled = 0.0
        if not self.opening and self.a > body.tip:
            pulled = -float((self.pressed * self.contact.weights).min()) / pressed
        quadratic_form = self.contact.quadratic_form
        return Certificate(
            penetration=self._penetration() / size,
            stationarity=self._mismatch_of_elements(pressed),
            opening=worst(pulled),
            neighbours=self._gain_of_neighbours(size),
            force=float(abs(quadratic_form[0, 1] - quadratic_form[1, 0])) / 2 / pressed,
        )

    def _penetration(self) -> float:
        """How far the free surface is inside the indenter at most [length], 0 if it is not.

        It is looked for in even steps of ln x, between them where the gap is least, and not beyond
        the edge of the profile.
        """
        decays = self.contact.poles.decays
        nearest = _OUTSIDE.nearest / float(np.abs(decays).max())
        furthest = DECAYED / float(decays.real.min())
        logs = np.arange(
            math.log(nearest), math.log(furthest) + _OUTSIDE.search_step, _OUTSIDE.search_step
        )
        x = np.minimum(np.exp(logs), (self.body.edge - self.a) * (1 - EPSILON))
        u, slope = self.displaced(x)
        # The gap is u - (d - f), the surface below the indenter.
        gap_falls = self.body.slope(self.a + x) + slope < 0
        turns = np.flatnonzero(gap_falls[:-1] & ~gap_falls[1:])
        if turns.size:
            x = np.append(x, np.linspace(x[turns], x[turns + 1], _OUTSIDE.closer))
            u = self.displaced(x)[0]
        inside = self.depth - self.body.height(self.a + x) - u
        return float(inside.max(initial=0.0))

    def _mismatch_of_elements(self, pressed: float) -> float:
        """How far totals on other elements differ, over what is pressed and what is stored.

        pressed: the size of the forces.
        """
        contact = Contact(self.body, self.a, self.contact.tolerance, _ERRORS.other_elements)
        other = Layer(self.depth, contact).totals
        sizes = (pressed, pressed, self.totals[2] or 1.0)
        return float((np.abs(other - self.totals) / sizes).sum())

    def _gain_of_neighbours(self, size: float) -> float:
        """By how much d is beyond what pins or holds the line, over a size; 1 if it is unstable."""
        reaction = self.contact.reaction
        closing = self.body.scene.surfaces.small_slope_deficit
        advances = self.depth - self.body.rest_depth(self.a, reaction, closing, 1)
        recedes = self.body.rest_depth(self.a, reaction, self.opening, -1) - self.depth
        return worst(float(self.rate < 0), float(advances) / size, float(recedes) / size)

    def errors(self, state: Any) -> dict[str, float]:
        """Relative errors of half-width, force and energy.

        With poles of a tolerance 30 times as large, everything is off by 30 times as much: what
        that changes, divided by 30, is the error, and rounding is added.

        - The half-width is off by what D is off by, over dD/da.
        - The force is off directly, and by dP/da = -c m γ₁σ √(2w/γ₁) times the error of a.
        - The energy is the least of a quadratic form at a fixed contact, and so relatively as
          wrong as the poles; a that is off changes it by nothing, as ∂U/∂a = 0.

        Parameters
        ----------
        state : Equilibrium
            Not needed.

        Returns
        -------
        dict of float
            By the names of `QUANTITIES`: of the half-width over itself, of force and energy over
            `scales`.
        """
        if self.is_point:  # no force acts, and nothing is displaced: there is nothing to be wrong
            return dict.fromkeys(QUANTITIES, 0.0)
        excess = self.body.scene.surfaces.small_slope_deficit
        fit = self.contact.poles.error
        contact = Contact(self.body, self.a, _ERRORS.coarser * self.contact.tolerance)
        coarse = Layer(self.depth, contact)
        depth_coarse = self.body.rest_depth(self.a, contact.reaction, excess, -1)
        depth_own = self.body.rest_depth(self.a, self.contact.reaction, excess, -1)
        least = self.certificate.force + _ERRORS.chance * fit

        # All that follows is 30 times the error, until the last line.
        move = abs(float(depth_coarse - depth_own) / self.rate)  # of the line; 0 if it is pinned
        move += _ERRORS.coarser * least * self.size / abs(self.rate)
        # `lines[0]` is c m γ₁σ.
        force = abs(coarse.force - self.force) + move * excess * float(self.contact.lines[0])
        coarse_errors = (
            move / self.a,
            force / (self.scales["force"] or 1.0),
            _ERRORS.coarser * fit,
        )
        errors = [float(error / _ERRORS.coarser + least + ROUNDING) for error in coarse_errors]
        return dict(zip(QUANTITIES, errors, strict=True))

    def displaced(self, distance: Array) -> Array:
        """Displacement of the free surface, and its slope du/dx, x outwards.

        Parameters
        ----------
        distance : ndarray (k,)
            Distances from the line [length].

        Returns
        -------
        ndarray (2, k)
            u [length], and u'.
        """
        of_upper_half = self.contact.poles.decays.imag >= 0  # conjugates come in pairs
        decays = self.contact.poles.decays[of_upper_half]
        amplitudes = self.contact.amplitudes[of_upper_half] @ np.array([self.u_line, 1.0])
        amplitudes = amplitudes * np.where(decays.imag == 0, 1, 2)
        fields = decayed(self.body.power, decays, self.a, distance)
        return np.asarray((amplitudes @ fields).real)

    def pressure(self, state: Any, x: Array) -> Array:
        """Pressure in contact, a sum of the fields of the poles.

        It warns where fields on other elements differ by more than PRESSURE_KNOWN of the largest
        pressure: below a contact much narrower than the layer the fields of many poles cancel, and
        what is left near the lowest point is rounding.

        Parameters
        ----------
        state : Equilibrium
            Not needed.
        x : ndarray (k,)
            Positions in contact [length].

        Returns
        -------
        ndarray (k,)
            [stress].

        Warns
        -----
        AccuracyWarning
        """
        distance = np.abs(x - self.body.apex)
        pressure = self._pressure(distance)
        contact = Contact(self.body, self.a, self.contact.tolerance, _ERRORS.other_pressure)
        other = Layer(self.depth, contact)._pressure(distance)
        difference = np.abs(pressure - other)
        largest = int(np.argmax(difference)) if distance.size else 0
        if distance.size and difference[largest] > PRESSURE_KNOWN * np.abs(self.pressed).max():
            warnings.warn(
                f"the pressure at x = {float(x[largest])!r} is known to "
                f"{float(difference[largest])!r} only: the contact is much narrower than the "
                "layer; half-width, force and energy are not affected; give a larger rtol for "
                "the pressure",
                AccuracyWarning,
                stacklevel=3,
            )
        return pressure

    def _pressure(self, distance: Array) -> Array:
        """The pressure at distances (k,) from the lowest point, from these elements."""
        ends = self.a * np.append(self.contact.elements.x[:, 0], 1.0)  # elements share their ends
        nodal = np.append(self.pressed[:, :-1], self.pressed[-1, -1])
        return on_elements(ends, nodal, distance)[0]

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force of a state in parts, under the names of `readings.with_surface`.

        The energy of the surface is γ₁/2 ∫f'² in contact, and γ₁/2 ∫u'² outside by the trapezoidal
        rule in even steps of ln x, dx = x d ln x.

        Parameters
        ----------
        state : Equilibrium
            The state of this contact.

        Returns
        -------
        dict of float
        """
        x = DECAYED / float(self.contact.poles.decays.real.min()) * _PLACES
        slope = self.displaced(x)[1]
        density = slope**2 * self.body.symmetry_factor * (self.a + x) ** self.body.power
        outside = self.body.scene.gamma1 / 2 * _OUTSIDE.step * float(x @ density)
        return with_surface(state, self.contact.stretched + outside)


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Equilibrium of one contact on the path from first touch.

    Parameters
    ----------
    scene : Scene
        With response "layer", and what routes.py demands of it.
    depth : float
        [length].
    branch : str
        For the record.
    rtol : float
        Relative error that is aimed at; the state estimates its own.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If the free surface touches the indenter again, or the state fails its certificate.
    ValueError
        If the contact spreads beyond a known profile.
    """
    body = body_of(scene)
    tolerance = min(_ERRORS.poles * rtol, _ERRORS.loosest)
    tried: dict[float, Contact] = {}

    def contact_at(a: float) -> Contact:
        """The contact of this half-width, noted in the order in which they are tried."""
        tried[a] = contact_of(body, a, tolerance)
        return tried[a]

    excess = scene.surfaces.small_slope_deficit
    lines = Lines(body, lambda a: contact_at(a).reaction, excess, _OCTAVE)
    a, _, how = lines.settled(depth)
    if how == "lost":
        return certified(scene, depth, None, branch)
    rate = math.inf  # pinned
    if how == "rests":
        # dD/da by a difference from a half-width that the search has met, or a bit outwards.
        near = [x for x in tried if _ERRORS.nearest * a <= abs(x - a) <= _ERRORS.furthest * a]
        other = near[-1] if near else a + _ERRORS.furthest * a
        rate = (lines.rest_depth(other, 1) - depth) / (other - a)
    return certified(scene, depth, Layer(depth, contact_at(a), rate), branch)
