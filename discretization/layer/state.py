"""States of one contact of a layer with its exact response, their certificates and error estimates.

The force is known from what the poles' fields press, and as dU/dd of the energy at fixed contact,
a parabola of the depth; what these fields press and pull is known from other elements, too.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING, Certificate, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import Body
from discretization.layer.contact import Contacts, contacts, decayed
from discretization.layer.elements import DEGREE
from discretization.layer.lines import Lines, Single
from discretization.quadrature import summed
from discretization.readings import with_surface
from discretization.surfaces.network import polynomial
from discretization.surfaces.protocol import At, alone
from discretization.surfaces.small import SmallSurfaces
from energy import Scene

Array = NDArray[np.float64]
_SAFE = 0.5  # of the relative error that is asked for: tolerance of the poles
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_BESIDE = 1e-7  # of the half-width: over which D changes by more than roundings
_LUCKY = 0.1  # of the error of the poles: what may be left where coarser ones happen to agree
_OTHER = 0.7  # of the way to the line, where elements of another set begin
_OUTSIDE = 200  # places at which the free surface is compared with the indenter
_NEAREST = 1e-9  # of its reach: the first of them
_FAR = 40.0  # decay lengths
_EXACT = 1e-11  # of the energy of the free surface


@dataclass(frozen=True, eq=False)
class Layer:
    """A contact at a depth, the only one of `contact`, with poles to a tolerance."""

    contact: Contacts
    depth: float
    tolerance: float

    @property
    def body(self) -> Body:
        """Of the scene."""
        return self.contact.body

    @property
    def a(self) -> float:
        """Half-width."""
        return float(self.contact.a[0])

    def again(self, tolerance: float, **given: float) -> Layer:
        """The same contact, found otherwise."""
        found = contacts(self.body, self.contact.a, tolerance, **given)
        return Layer(found, self.depth, tolerance)

    @functools.cached_property
    def both(self) -> Array:
        """u(a) and 1."""
        return np.array([self.depth - float(self.contact.f[0]), 1.0])

    @property
    def touches(self) -> bool:
        """Whether it is one with the lowest point alone, and nothing is pressed."""
        return self.a <= self.body.tip and self.depth == self.body.touch

    def rest_depth(self, excess: float, side: int) -> float:
        """D of its line."""
        reaction = self.contact.reaction.T
        return float(self.body.rest_depth(self.contact.a, reaction, excess, side)[0])

    @property
    def lines(self) -> float:
        """What its lines pull."""
        return float(self.contact.lines[0] @ self.both)

    @property
    def force(self) -> float:
        """P."""
        return float(self.both @ self.contact.form[0, :, 0])

    @functools.cached_property
    def stored(self) -> float:
        """Energy of the layer and its surface."""
        form = self.both @ self.contact.form[0] @ self.both
        return float(form / 2 + self.contact.stretched[0])

    @property
    def bound(self) -> float:
        """What adheres."""
        return self.body.scene.work_of_adhesion * float(self.body.area(self.a))

    @property
    def energy(self) -> float:
        """U."""
        return self.stored - self.bound

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """∫|p| and what the free surface pulls; the sizes of the terms of the energy."""
        pressed = float((self.contact.weights[0] * np.abs(self.pressed)).sum())
        return {"force": pressed + abs(self.lines), "energy": self.stored + self.bound}

    @functools.cached_property
    def pressed(self) -> Array:
        """Pressure at nodes (e, 13)."""
        return np.tensordot(self.both, self.contact.pressure[0], 1)

    @property
    def rounding(self) -> float:
        """How far the force is from dU/dd, over the sizes of its terms."""
        form = self.contact.form[0]
        return float(abs(form[0, 1] - form[1, 0])) / 2 / (self.scales["force"] or 1.0)

    @property
    def unbalanced(self) -> float:
        """By how much what the fields press, pull and store is different on other elements."""
        other = self.again(self.tolerance, first=_OTHER)
        off = abs(other.force - self.force) + abs(other.lines - self.lines)
        stored = abs(other.stored - self.stored) / (self.stored or 1.0)
        return max(off / (self.scales["force"] or 1.0), stored)

    def displacement(self, excess: float = 0.0) -> float:
        """|u| at the line, and by how much its slope and adhesion lift it."""
        lifted = abs(float(self.contact.slopes[0, -1, -1])) + excess
        return abs(float(self.both[0])) + lifted / float(self.contact.reaction[0, 0])

    def certificate(self) -> Certificate:
        """The conditions of ../certificate.py, depths over |d|, u and what lifts a line.

        stationarity  what the poles' fields press and pull, on two sets of elements
        neighbours    d <= D just outside the line by closing, D just inside by opening <= d
        force         P against dU/dd
        """
        scene, body, pulled = self.body.scene, self.body, 0.0
        if self.touches:
            return Certificate.undeformed()
        opening = scene.opened.surfaces.small_slope_deficit
        size = abs(self.depth - body.touch) + self.displacement(opening) or 1.0
        beyond = self.depth - self.rest_depth(scene.surfaces.small_slope_deficit, 1)
        within = self.rest_depth(opening, -1) - self.depth
        if not opening and self.a > body.tip:
            pulled = -float(self.pressed.min()) / (float(np.abs(self.pressed).max()) or 1.0)
        return Certificate(
            max(0.0, self.through) / size,
            self.unbalanced,
            max(0.0, pulled),
            max(0.0, beyond, within) / size,
            self.rounding,
        )

    def errors(self, rate: float) -> dict[str, float]:
        """Of half-width, force and energy; rate: dD/da, infinite of a line that is pinned.

        What coarser poles change, by their tolerance, and rounding. The energy at a fixed contact
        is the least of a quadratic form, and as wrong as its stiffness. At rest dP/da = -m γ₁σ
        √(2w/γ₁), as that is what dU/da changes by with the depth.
        """
        if self.touches:
            return dict.fromkeys(QUANTITIES, 0.0)
        excess, fit = self.body.scene.surfaces.small_slope_deficit, self.contact.poles.error
        coarse, move = self.again(_COARSER * self.tolerance), 0.0
        force = abs(coarse.force - self.force)
        if math.isfinite(rate):
            move = abs(coarse.rest_depth(excess, 1) - self.rest_depth(excess, 1)) / abs(rate)
            force += move * excess * float(self.contact.lines[0, 0])
            move += _COARSER * (self.rounding + _LUCKY * fit) * self.displacement() / abs(rate)
        least = self.rounding + ROUNDING + _LUCKY * fit
        parts = (move / self.a, force / (self.scales["force"] or 1.0), _COARSER * fit)
        return {
            q: float(part / _COARSER + least) for q, part in zip(QUANTITIES, parts, strict=True)
        }

    def free(self, beside: Array, order: int = 0) -> Array:
        """u of the free surface, or its slope outwards (order 1), so far from the line."""
        contact, a = self.contact, np.full(beside.size, self.a)
        found = decayed(self.body.power, contact.poles.decays, a, beside, order)
        return np.asarray((contact.amplitudes[0] @ self.both @ found).real)

    @property
    def reach(self) -> float:
        """How far the free surface is felt."""
        return _FAR / float(self.contact.poles.decays.real.min())

    @functools.cached_property
    def through(self) -> float:
        """How far the free surface is inside the indenter at most.

        It varies the more slowly the farther from the line it is, and so do the places.
        """
        reach = min(self.reach, self.body.edge - self.a)
        beside = reach * np.geomspace(_NEAREST, 1.0, _OUTSIDE)
        return float((self.depth - self.body.height(self.a + beside) - self.free(beside)).max())

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' of the free surface at positions beside a line."""
        side = 1 if left is not None else -1
        beside = side * (z - alone(left, right).x)
        return self.free(beside), side * self.free(beside, 1)

    def pressure(self, state: Any, x: Array) -> Array:
        """p in contact at positions, sums of the fields of the poles."""
        nodes, x = self.a * self.contact.elements.x, np.abs(x - self.body.apex)
        own = np.clip(np.searchsorted(nodes[:, 0], x, side="right") - 1, 0, len(nodes) - 1)
        found = np.empty(x.shape)
        for i in np.unique(own).tolist():
            here, (lo, hi) = own == i, nodes[i, [0, -1]]
            found[here] = polynomial(DEGREE, (2 * x[here] - lo - hi) / (hi - lo), self.pressed[i])
        return found

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts."""

        def density(x: Array) -> Array:
            """γ₁/2 u'² of the free surface."""
            slope = self.free(x.ravel(), 1).reshape(x.shape)
            whole = self.body.whole * (self.a + x) ** self.body.power
            return np.array([self.body.scene.gamma1 / 2 * slope**2 * whole])

        ends = np.array([[0.0], [self.reach]])
        outside = summed(density, ends, _EXACT, np.zeros((1, 1)), smooth=True)
        return with_surface(state, float(self.contact.stretched[0] + outside.sums.sum()))


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of one contact on the way from first touch, and its error estimate."""
    single = Single(Body(scene), _SAFE * rtol)
    lines = Lines(single, scene.surfaces.small_slope_deficit)
    a, _, how = lines.settled(depth)
    if how == "lost":
        return detached(scene, depth, branch, SmallSurfaces(scene), Certificate.undeformed())
    found, rate = Layer(single.contact(a), depth, single.tolerance), math.inf
    certificate, pinned = found.certificate(), how == "corner"
    if not pinned:
        beside = min(
            (x for x in single.known if abs(x - a) > _BESIDE * a), key=lambda x: abs(x - a)
        )
        rate = (lines.rest_depth(beside, 1) - depth) / (beside - a)
        if rate < 0:  # D falls outwards: the line would run away
            certificate = certificate._replace(neighbours=1.0)
    ends = found.a, found.a
    return certified(found, certificate, ends, pinned, branch, lambda _: found.errors(rate))


def certified(
    found: Any,
    certificate: Certificate,
    ends: tuple[float, float],
    pinned: bool,
    branch: str,
    errors: Callable[[Equilibrium], dict[str, float]],
    spacing: float = math.nan,
) -> Equilibrium:
    """The state of a contact, a `Layer` or a `NodeState`, whose line and outermost node are here.

    NotCertifiedError where it is no equilibrium.
    """
    body, named = found.body, f"the state at depth = {found.depth!r}"
    if not certificate.penetration <= certificate.tolerance:
        raise NotCertifiedError(
            f"{named} touches the indenter again beside its contact: a layer that is nearly "
            "incompressible rises there; use another depth, or response='springs'"
        )
    certificate.demand(named, "try another depth or spacing")
    line, node = (np.array([body.ends(x)]) for x in ends)
    return Equilibrium(
        body.scene,
        found.depth,
        branch,
        "fitted" if math.isnan(spacing) else "lattice",
        certificate,
        found,
        spacing,
        contacts=line,
        nodes=node,
        pinned=np.array([[pinned or bool(body.power), pinned]]),
        force=found.force,
        energy=found.energy,
        scales=found.scales,
        errors=errors,
    )
