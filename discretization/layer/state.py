"""States of one contact of a layer with its exact response, their certificates and error estimates.

The force is known from what the poles' fields press, and as dU/dd of the energy at fixed contact,
a parabola of the depth; what these fields press and pull is known from other elements, too.
"""

import functools
import math
import warnings
from typing import Any

import numpy as np

from discretization.certificate import (
    EPSILON,
    ROUNDING,
    AccuracyWarning,
    Certificate,
    NotCertifiedError,
)
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import Body
from discretization.layer.contact import Contact, at_depth, decayed
from discretization.layer.lines import Lines
from discretization.readings import with_surface
from discretization.surfaces.network import on_elements
from discretization.surfaces.protocol import alone
from discretization.surfaces.small import SmallSurfaces
from energy import Scene
from energy.arrays import Array

_SAFE = 0.5  # of the relative error that is asked for: tolerance of the poles
_LOOSEST = 5e-5  # tolerance up to which what poles leave is told by coarser ones
_FELT, _BESIDE = 1e-7, 1e-4  # of the half-width: D changes by more than roundings, but straight
_STEP = 1.0  # of log₂ a: half-widths at which a line is looked for
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_LUCKY = 0.1  # of the error of the poles: what may be left where coarser ones happen to agree
PRESSURE_KNOWN = 1e-3  # of the largest: by how much the pressures on two sets of elements differ
_OTHER_PRESSURE = 0.9  # the same, of the elements that the pressure is compared with
_OTHER = 0.7  # of the way to the line, where elements of another set begin
_FAR = 40.0  # decay lengths: how far the free surface is felt
_APART = 0.1  # of ln x: places on it, for integrals
_AHEAD = np.exp(np.arange(-30.0, _APART, _APART))  # of how far it is felt
_LOOK, _NEAREST = 0.2, 0.1  # of ln x, and of the shortest decay length: places looked at
_CLOSER = 401  # of them in a step in which the gap is least
body_of, contact_of = functools.lru_cache(8)(Body), functools.lru_cache(32)(Contact)


class Layer(Contact):
    """A contact at a depth; rate: dD/da of its line, infinite where that is pinned.

    contact: which one; both: u(a) and 1; size: of u and what slope and adhesion lift a line.
    """

    def __init__(self, depth: float, contact: Contact, rate: float = math.inf) -> None:
        vars(self).update(vars(contact))
        self.depth, self.rate, self.pinned, self.outermost = depth, rate, rate == math.inf, self.a
        self.both = np.array([depth - self.f, 1.0])
        self.opening = self.body.scene.opened.surfaces.small_slope_deficit
        lifts = (abs(float(self.slopes[-1, -1])) + self.opening) / self.reaction[0]
        self.size = float(abs(self.both[0]) + lifts)

    @functools.cached_property
    def touches(self) -> bool:
        """Whether it is with the lowest point alone, and P is 0 but for what its width makes."""
        tip, rise = self.a <= self.body.tip, [self.f - self.body.touch, 1.0]
        return bool(tip and abs(self.force) <= 2 * np.abs(self.taken[2:4]) @ rise)

    force = property(lambda self: float(self.found[1]))
    energy = property(lambda self: float(self.found[2] - self.body.bound(self.a)))

    @functools.cached_property
    def found(self) -> Array:
        """What its lines pull, the force, and the energy without adhesion (3,)."""
        return np.array([self.lines @ self.both, *at_depth(self.taken, self.both[0])])

    @functools.cached_property
    def pressed(self) -> Array:
        """Pressure at nodes (e, 13)."""
        return np.tensordot(self.both, self.pressures, 1)

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """∫|p| and what the free surface pulls; the sizes of the terms of the energy."""
        pressed, found = float((self.weights * np.abs(self.pressed)).sum()), np.abs(self.found)
        bound = self.body.bound(self.a)
        return {"force": pressed + float(found[0]), "energy": float(found[2] + bound)}

    @functools.cached_property
    def certificate(self) -> Certificate:
        """The conditions of ../certificate.py, depths over |d|, u and what lifts a line.

        penetration   looked for the closer the nearer to the line, and where the gap is least
        stationarity  what the poles' fields press, pull and store, on two sets of elements
        neighbours    d <= D just outside the line by closing, D just inside by opening <= d; where
                      D falls outwards the line would run away
        force         P against dU/dd, its rounding
        """
        body, a, felt, pulled = self.body, self.a, self.reaction, 0.0
        if self.touches:
            return Certificate.undeformed()
        size = abs(self.depth - body.touch) + self.size or 1.0
        beyond = self.depth - body.rest_depth(a, felt, body.scene.surfaces.small_slope_deficit, 1)
        within = body.rest_depth(a, felt, self.opening, -1) - self.depth
        if not self.opening and a > body.tip:
            pulled = -float((self.pressed * self.weights).min()) / (self.scales["force"] or 1.0)
        other = Layer(self.depth, Contact(body, a, self.tolerance, _OTHER)).found
        pressed, form, decays = self.scales["force"] or 1.0, self.form, self.poles.decays
        near, far = _NEAREST / float(np.abs(decays).max()), _FAR / float(decays.real.min())
        x = np.exp(np.arange(math.log(near), math.log(far) + _LOOK, _LOOK))
        x = np.minimum(x, (body.edge - a) * (1 - EPSILON))
        u, slope = self.displaced(x)
        falls = body.slope(a + x) + slope < 0
        if (turns := np.flatnonzero(falls[:-1] & ~falls[1:])).size:
            x = np.append(x, np.linspace(x[turns], x[turns + 1], _CLOSER))
            u = self.displaced(x)[0]
        inside = self.depth - body.height(a + x) - u
        return Certificate(
            float(inside.max(initial=0.0)) / size,
            float((np.abs(other - self.found) / (pressed, pressed, self.found[2] or 1.0)).sum()),
            max(0.0, pulled),
            float(max(self.rate < 0, beyond / size, within / size)),
            float(abs(form[0, 1] - form[1, 0])) / 2 / pressed,
        )

    def errors(self, state: Any) -> dict[str, float]:
        """Of half-width, force and energy.

        What coarser poles change, by their tolerance, and rounding. The energy at a fixed contact
        is the least of a quadratic form, and as wrong as its stiffness. At rest dP/da = -m γ₁σ
        √(2w/γ₁), as that is what dU/da changes by with the depth.
        """
        if self.touches:
            return dict.fromkeys(QUANTITIES, 0.0)
        excess, fit = self.body.scene.surfaces.small_slope_deficit, self.poles.error
        coarse = Layer(self.depth, Contact(self.body, self.a, _COARSER * self.tolerance))
        one, other = (self.body.rest_depth(self.a, x.reaction, excess, -1) for x in (coarse, self))
        move, least = abs(float(one - other) / self.rate), self.certificate.force + _LUCKY * fit
        move += _COARSER * least * self.size / abs(self.rate)
        force = abs(coarse.force - self.force) + move * excess * float(self.lines[0])
        parts = (move / self.a, force / (self.scales["force"] or 1.0), _COARSER * fit)
        known = [float(part / _COARSER + least + ROUNDING) for part in parts]
        return dict(zip(QUANTITIES, known, strict=True))

    def displaced(self, beside: Array) -> Array:
        """u of the free surface and its slope outwards (2, k), so far from the line."""
        own = self.poles.decays.imag >= 0  # of conjugates one
        decays = self.poles.decays[own]
        twice = self.amplitudes[own] @ self.both * np.where(decays.imag == 0, 1, 2)
        return np.asarray((twice @ decayed(self.body.power, decays, self.a, beside)).real)

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u and u' of the free surface at positions beside a line."""
        side = 1 if left is not None else -1
        u, slope = self.displaced(side * (z - alone(left, right).x))
        return u, side * slope

    def pressure(self, state: Any, x: Array) -> Array:
        """Pressure in contact at positions, a sum of the fields of the poles.

        AccuracyWarning where fields on other elements differ by more than PRESSURE_KNOWN of the
        largest pressure: below a contact much narrower than the layer the fields of many poles
        cancel, and what is left near the lowest point is rounding.
        """
        distance = np.abs(x - self.body.apex)
        pressure = self._pressure(distance)
        contact = Contact(self.body, self.a, self.tolerance, _OTHER_PRESSURE)
        other = Layer(self.depth, contact)._pressure(distance)
        difference = np.abs(pressure - other)
        worst = int(np.argmax(difference)) if distance.size else 0
        if distance.size and difference[worst] > PRESSURE_KNOWN * np.abs(self.pressed).max():
            warnings.warn(
                f"the pressure at x = {float(x[worst])!r} is known to {float(difference[worst])!r} "
                "only: the contact is much narrower than the layer; half-width, force and energy "
                "are not affected; give a larger rtol for the pressure",
                AccuracyWarning,
                stacklevel=3,
            )
        return pressure

    def _pressure(self, distance: Array) -> Array:
        """The pressure at distances from the lowest point, from these elements."""
        ends = self.a * np.append(self.elements.x[:, 0], 1.0)
        nodal = np.append(self.pressed[:, :-1], self.pressed[-1, -1])
        return on_elements(ends, nodal, distance)[0]

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts; γ₁/2 ∫u'² outside by the trapezoidal rule in ln x."""
        x, body = _FAR / float(self.poles.decays.real.min()) * _AHEAD, self.body
        density = self.displaced(x)[1] ** 2 * body.whole * (self.a + x) ** body.power
        outside = body.scene.gamma1 / 2 * _APART * float(x @ density)
        return with_surface(state, self.stretched + outside)


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of one contact on the way from first touch, and its error estimate."""
    body, tolerance = body_of(scene), min(_SAFE * rtol, _LOOSEST)
    known: dict[float, Contact] = {}

    def solved(a: float) -> Contact:
        known[a] = contact_of(body, a, tolerance)
        return known[a]

    lines = Lines(body, lambda a: solved(a).reaction, scene.surfaces.small_slope_deficit, _STEP)
    a, _, how = lines.settled(depth)
    near = [x for x in known if _FELT * a <= abs(x - a) <= _BESIDE * a]
    beside = near[-1] if near else a + _BESIDE * a
    rate = (lines.rest_depth(beside, 1) - depth) / (beside - a) if how == "rests" else math.inf
    found = None if how == "lost" else Layer(depth, solved(a), rate)
    return certified(scene, depth, found, branch, math.nan)


def certified(scene: Scene, depth: float, found: Any, branch: str, spacing: float) -> Equilibrium:
    """The state of a `Layer` or `Nodes`, None: it is lost. spacing: nan but of nodes."""
    if found is None:
        flat = Certificate.undeformed()
        return detached(scene, depth, branch, SmallSurfaces(scene), flat, spacing)
    body, named = found.body, f"the state at depth = {depth!r}"
    if not found.certificate.penetration <= found.certificate.tolerance:
        raise NotCertifiedError(
            f"{named} touches the indenter again beside its contact: a layer that is nearly "
            "incompressible rises there; use another depth, or response='springs'"
        )
    found.certificate.demand(named, "try another depth or spacing")
    contacts, nodes = (np.array([body.ends(x)]) for x in (found.a, found.outermost))
    pinned = np.array([[found.pinned or bool(body.power), found.pinned]])
    method = "fitted" if math.isnan(spacing) else "lattice"
    given = scene, depth, branch, method, found.certificate, found, spacing
    totals = found.force, found.energy, found.scales, found.errors
    return Equilibrium(*given, contacts, nodes, pinned, *totals)
