"""An equilibrium: what was found, and the observables read from it.

Conventions
-----------
The depth d and displacements u are positive downwards, heights f of the profile upwards, forces if
the indenter is pressed. Slopes are outward ones: by the distance from the contact, f' of the
indenter positive where it rises away from the contact, u' of the free surface positive where it
sinks. Arrays (m, 2) have a row for each contact, from left to right, and its left and its right
line in the columns; about an axis these are radii, and the left end of a contact around the axis is
0 and no line. A `LinePosition` has the position `x` of a line and the height `f` there. `surfaces`
knows the free surfaces by the method shape(x, left, right, depth): u and du/dx at places between
two lines, of which None is infinitely far away.

`Scene.path_dependent` is whether lines rest at places that depend on the path, `one_contact`
whether a scene never has more than one contact, and `spring(u)` the energy of the springs, whose
first derivative is the pressure. `slope_beside(x, side)` is df/dx just on the right (1) or left
(-1) of x, or at x (0). In readings.py, `parts_of` has the parts of energy and force, by the names
STORED and ACTING, `deformation` the largest depths and slopes of a state (its `indentation` is d
less the least height in contact), `of_nodes` what its nodes assume, `angle_error` the error of θ,
`violated` what an `Assumption` that fails says, and `state_row`, `state_line`, `state_text` and
`html` are what is shown; `plot_state`, of plots.py, is the figure.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from discretization import plots, readings
from discretization.certificate import Certificate, Proof
from discretization.routes import one_contact
from discretization.surfaces.protocol import LinePosition
from energy import Assumption, Scene
from energy.arrays import Array, Mask
from energy.validity import assumptions

QUANTITIES = ("half_width", "force", "energy")


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """State of a scene at one depth, per unit length of the line contact, as `minimise` finds it.

    Attributes
    ----------
    scene : Scene
        What it is a state of.
    depth : float
        d [length].
    branch : {"adhered", "global"}
        Which state was wanted; see `minimise`.
    method : str
        "fitted" for the mesh; "lattice", "shortest_path" or "oracle" for nodes.
    contacts : array (m, 2)
        Ends of each contact interval [length].
    half_width : float
        a, half the sum of the lengths of the contacts, or the radius about an axis [length].
    force, energy : float
        P [force/length], positive if it presses, and U [energy/length], 0 without contact.
    contact_angle : float
        θ [rad], the mean over the contact lines, read from the displacement field beside them. On
        nodes it emerges from energies of contact sets, with an error O(spacing²); on the mesh a
        free line rests where ∂U/∂x = 0, which is Young's law (8), or (15), in other words. Lines
        that are `pinned` count, too, and have the angle that the depth gives them.
    label : str
        "global", "metastable", "adhered", "neutral" or "detached".
    validity, warnings : tuple
        How far the model's assumptions hold, and those that do not, in words.
    certificate : Certificate
        How far it is from an equilibrium.
    error_estimate : dict of float
        Relative numerical errors of half_width, and of force and energy relative to `scales`.
    errors : dict of float, or callable
        These, or a function of this state that finds them when they are needed.
    scales : dict of float
        Sums of the absolute values of the terms of "force" and of "energy".
    proof : Proof or None
        Why no state on these nodes has a lower energy, where `shortest_path` has found it.
    nodes : array (m, 2)
        On nodes the outermost contact nodes themselves, as `contacts` lie between them [length].
    spacing : float
        Distance of the nodes [length]; nan where there are none.
    pinned : array of bool (m, 2)
        Which ends are lines pinned at corners or edges; an end at the axis may count as such.
    neutral : bool
        Whether a line rests anywhere in a range at no cost.
    surfaces
        What the free surfaces look like; of a layer with its exact response also what presses.

    Notes
    -----
    With rotational symmetry force and energy are those of the whole contact, and all positions are
    radii: contacts are intervals of r >= 0, and one that includes the axis begins at 0.

    Examples
    --------
    Of the state of the example of `minimise`:

    >>> print(f"{state.displacement(0.0):.3g}, {state.displacement(2e-4):.3g}")
    3e-07, -6.79e-09
    """

    scene: Scene
    depth: float
    branch: str
    method: str
    certificate: Certificate
    surfaces: Any
    spacing: float = math.nan
    contacts: Array = field(default_factory=lambda: np.empty((0, 2)))
    nodes: Array = field(default_factory=lambda: np.empty((0, 2)))
    pinned: Mask = field(default_factory=lambda: np.empty((0, 2), bool))
    force: float = 0.0
    energy: float = 0.0
    scales: dict[str, float] = field(default_factory=lambda: {"force": 0.0, "energy": 0.0})
    errors: dict[str, float] | Callable[[Equilibrium], dict[str, float]] = field(
        default_factory=lambda: dict.fromkeys(QUANTITIES, 0.0)
    )
    proof: Proof | None = None
    neutral: bool = False

    @functools.cached_property
    def error_estimate(self) -> dict[str, float]:
        """Relative errors of half_width, force and energy, the last two relative to `scales`.

        Infinite: not resolved, the lattice is too coarse for an estimate; see lattice.accuracy.
        """
        return self.errors(self) if callable(self.errors) else self.errors

    @property
    def uncertainty(self) -> dict[str, float]:
        """`error_estimate` as absolute errors: of half_width [length], force and energy."""
        # Of what is 0 they count as absolute ones, of a half-width on nodes in links.
        link = 0.0 if math.isnan(self.spacing) else self.spacing
        scales = {"half_width": self.half_width or link, **self.scales}
        return {name: error * (scales[name] or 1.0) for name, error in self.error_estimate.items()}

    @functools.cached_property
    def contact_angle_error(self) -> float:
        """Numerical error of θ [rad]; nan where there is none to give, inf where not resolved."""
        return readings.angle_error(self)

    @functools.cached_property
    def label(self) -> str:
        """What is known of this state among all of its scene at its depth, in one word.

        "detached"    the flat surface without contact
        "neutral"     a contact line rests anywhere in a range: states of any width cost the same
        "global"      no state has less energy
        "metastable"  a state with less energy is known
        "adhered"     that of the path from first touch; whether another has less is not known

        "global" was searched for, or is the only minimum where w = 0 (a convex problem). Otherwise
        it is compared with the detached state, whose energy is 0, up to first touch: of a convex
        indenter with tension the only other minimum, as the force on a line grows outwards. Without
        tension springs beside a contact would gain w by attaching, but at an end of the body.
        """
        scene = self.scene
        if not self.contacts.size:
            return "detached"
        if self.neutral:
            return "neutral"
        if scene.path_dependent:
            return "adhered"
        if self.branch == "global" or not scene.work_of_adhesion:
            return "global"
        springs_gain = not scene.gamma1 and (np.isfinite(self.contacts) & ~self.pinned).any()
        if springs_gain or (self.energy > 0 and self._deformation.indentation <= 0):
            return "metastable"
        return "global" if one_contact(scene) else "adhered"

    _deformation = functools.cached_property(readings.deformation)
    _parts = functools.cached_property(readings.parts_of)
    resolution = property(readings.of_nodes)

    @property
    def energy_parts(self) -> dict[str, float]:
        """Energy [energy/length] of springs, surface and adhesion; see discretization.readings."""
        return {name: self._parts[name] for name in readings.STORED}

    @property
    def force_parts(self) -> dict[str, float]:
        """Force [force/length] of the pressure (9) and of the lines (10); likewise."""
        return {name: self._parts[name] for name in readings.ACTING}

    @property
    def half_width(self) -> float:
        """a: half the total contact length, or `radius`; 0 when detached."""
        if self.scene.axisymmetric:
            return self.radius
        return float(np.sum(self.contacts[:, 1] - self.contacts[:, 0])) / 2

    @property
    def radius(self) -> float:
        """a: that of the outermost contact line, 0 when detached. ValueError for a line contact."""
        if not self.scene.axisymmetric:
            raise ValueError("radius: a line contact has none; use half_width")
        return float(self.contacts[-1, 1]) if self.contacts.size else 0.0

    @property
    def contact_area(self) -> float:
        """2a per unit length, or π Σ (r_out² - r_in²) with rotational symmetry."""
        ends = self.contacts.T
        if self.scene.axisymmetric:
            return math.pi * float(np.sum((ends[1] - ends[0]) * (ends[1] + ends[0])))
        return 2 * self.half_width

    @functools.cached_property
    def free_surfaces(self) -> list[tuple[LinePosition | None, LinePosition | None]]:
        """The lines (left, right) of every free surface from left to right.

        There are m + 1 for m contacts. The first has no left line, the last no right one: None,
        infinitely far away. About an axis the first is the disc inside the innermost line, which
        has no surface if that is the axis.
        """
        x = self.contacts.ravel()
        f = np.asarray(self.scene.indenter.height(x), float)
        lines = [None, *map(LinePosition, x.tolist(), f.tolist()), None]
        return list(zip(lines[::2], lines[1::2], strict=True))

    @functools.cached_property
    def line_slopes(self) -> tuple[Array, Array]:
        """Outward slopes at the contact lines, (m, 2) each: indenter f', free surface u'.

        At a corner f' is taken on the contact's side (12); at a lone tip on the outer side.
        """
        sides = np.array([-1.0, 1.0])  # of the free surface beside left and right lines
        is_point = self.contacts[:, 1:] == self.contacts[:, :1]
        # On which side f' of a corner is read; 0 where there is no corner.
        read_side = np.where(is_point, sides, -sides)
        read_side = np.where(self.pinned, read_side, 0.0)
        f1 = self.scene.indenter.slope_beside(self.contacts, read_side)  # by x, to the right
        if not (self.scene.gamma1 and self.contacts.size):
            return sides * f1, np.zeros_like(f1)
        # The lines of all free surfaces, from left to right, are those of all contacts.
        u1 = []
        for lines in self.free_surfaces:
            x = np.array([line.x for line in lines if line])
            _, slope = self.surfaces.shape(x, *lines, self.depth)
            u1.append(slope)
        return sides * f1, sides * np.concatenate(u1).reshape(-1, 2)

    @property
    def angle_deficits(self) -> Array:
        """π - θ [rad] at each end, (m, 2): f'(a-0) + u'(a+0), Eq. (12), or with their angles.

        nan at the axis, where a contact ends without a line.
        """
        if not (self.scene.gamma1 and np.isfinite(self.contacts).all()):
            return np.full_like(self.contacts, math.nan)
        f1, u1 = self.line_slopes
        found = f1 + u1 if self.scene.slopes == "small" else np.arctan(f1) + np.arctan(u1)
        return np.where(self.at_axis, math.nan, found)

    @property
    def at_axis(self) -> Mask:
        """Which ends of contacts (m, 2) are the axis, and no lines: at most the first of all."""
        return (self.contacts == 0) & self.scene.axisymmetric & np.array([True, False])

    @property
    def contact_angles(self) -> Array:
        """θ [rad] at each end of each contact (m, 2), read from the displacement field."""
        return math.pi - self.angle_deficits

    @property
    def angle_deficit(self) -> float:
        """Mean π - θ [rad] over all contact lines; nan without a contact line."""
        deficits = self.angle_deficits[~self.at_axis]
        return float(deficits.mean()) if deficits.size else math.nan

    @property
    def contact_angle(self) -> float:
        """Mean contact angle θ [rad] over all lines, pinned ones too; nan without a contact line.

        π - θ = f'(a-0) + u'(a+0) (12), read from the displacement field; with finite slopes the
        sum of both inclinations.
        """
        return math.pi - self.angle_deficit

    def displacement(self, x: ArrayLike) -> Array:
        """u(x), positive downwards: d - f(x) in contact (4), the free surface (6) outside.

        Parameters
        ----------
        x : array_like
            Positions [length].

        Returns
        -------
        ndarray
            u [length], in the shape of x; nan where x is.
        """
        x, u, inside = self._undisplaced(x)
        u[inside] = self.depth - self.scene.indenter.height(x[inside])
        if not (self.scene.gamma1 and self.contacts.size):
            return u
        # Free surface number i is the one beyond i contacts.
        contacts_before = np.searchsorted(self.contacts[:, 0], x)
        surface = np.where(inside | np.isnan(x), -1, contacts_before)
        for i, lines in enumerate(self.free_surfaces):
            own = surface == i
            if own.any():
                u[own] = self.surfaces.shape(x[own], *lines, self.depth)[0]
        return u

    def _undisplaced(self, x: ArrayLike) -> tuple[Array, Array, Mask]:
        """What fields at positions begin with, all in the shape of x.

        Returns
        -------
        positions, u : ndarray
            About an axis radii, the sizes of x; and 0, or nan where x is.
        inside : ndarray of bool
            Which positions are in contact.
        """
        positions = np.asarray(x, float)
        if self.scene.axisymmetric:
            positions = np.abs(positions)
        u = np.where(np.isnan(positions), math.nan, 0.0)
        return positions, u, self.inside(positions)

    def inside(self, x: Array) -> Mask:
        """Whether positions are in contact.

        Parameters
        ----------
        x : ndarray
            [length].

        Returns
        -------
        ndarray of bool
        """
        # The last contact that begins at or before x; -1, the nan, if none does.
        contact = np.searchsorted(self.contacts[:, 0], x, side="right") - 1
        right_ends = np.append(self.contacts[:, 1], math.nan)
        return x <= right_ends[contact]

    def pressure(self, x: ArrayLike) -> Array:
        """Elastic stress of the layer on the indenter, k u(x) of springs: the integrand of Eq. (9).

        Zero outside the contact. The surface tension adds line forces at the contact lines (10).

        Parameters
        ----------
        x : array_like
            Positions [length].

        Returns
        -------
        ndarray
            [stress], in the shape of x.
        """
        x, found, inside = self._undisplaced(x)
        if self.scene.layer.exact and inside.any():
            found[inside] = self.surfaces.pressure(self, x[inside])
        else:
            found[inside] = self.scene.spring(self.displacement(x[inside])).first
        return found

    @property
    def validity(self) -> tuple[Assumption, ...]:
        """How far the assumptions of the model hold here (energy.validity), and of its nodes."""
        deformed = self._deformation if self.contacts.size else None
        return (*assumptions(self.scene, deformed), *self.resolution)

    warnings = property(readings.violated)

    plot = plots.plot_state
    to_dict = readings.state_row
    _repr_html_ = readings.html
    __repr__ = readings.state_line
    __str__ = readings.state_text


def detached(
    scene: Scene,
    depth: float,
    branch: str,
    surfaces: Any,
    certificate: Certificate,
    spacing: float = math.nan,
) -> Equilibrium:
    """The state of the flat surface without contact.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    branch : str
        For the record.
    surfaces : Surfaces or LatticeTail
        What knows its free surfaces; the one without lines is flat.
    certificate : Certificate
    spacing : float
        Of the nodes [length]; nan on the mesh.

    Returns
    -------
    Equilibrium
    """
    method = "fitted" if math.isnan(spacing) else "lattice"
    return Equilibrium(scene, depth, branch, method, certificate, surfaces, spacing)
