"""What contact lines feel of the free surfaces of the fitted mesh, and the shape of those.

A line rests at x at the depth D(x) at which ∂U/∂x = 0. On the mesh ∂U/∂x = γ₁/2 r² - w with
r = f' - S/γ₁, f' outwards of the contact and S the reaction of the free surface there: of
k/2 g² + γ₁/2 f'² - w - S f', by which the energy grows as the contact does, a square is left
because S² = kγ₁ g² on the mesh of a tail to rounding, and k g² - S²/γ₁ = 2 ∂F/∂L on that of a gap
of length L. With finite slopes, tan β = f' and sin φ = S/γ₁, it is likewise

    ∂U/∂x = k/2 g² + (γ₁-w)√(1+f'²) - γ₁ - S f' = [2γ₁ sin²((β-φ)/2) - w]/cos β.

A line advances where D < d and recedes where D > d. Small and finite slopes, line contacts and
rotational symmetry differ in the methods that `Surfaces` leaves open, and nowhere else.

Conventions
-----------
The depth d and displacements u are positive downwards, into the layer; the height f of the profile
is positive upwards, from the lowest point or what the profile calls 0, so that u = d - f in
contact. A free surface lies between a `left` and a `right` line, by their positions x (or radii).
A line that is None is infinitely far away, or about an axis the axis itself: the surface is then a
tail, the far surface or a disc around the axis. With both lines it is a gap, or a ring.

Within this package a surface is described from its first line, at s: that is the left one if there
is one, else the right one. `side` is 1 if the surface extends to the right of the first line, -1 if
to the left, and f' is the slope towards the surface, `side` times df/dx. The reaction S of the free
surface at a line, ∂F/∂u per length of the line, is the force downwards that holds the surface at
u > 0 there.

Callers see lengths and forces in the units of the scene (forces per length of a line contact; of
all around an axis). The methods that subclasses define have lengths in l, forces in γ₁ and energies
in γ₁l, or about an axis, per radian, in γ₁l and γ₁l².

Of a scene, `elastocapillary_length` is l, `axisymmetric` whether it is turned about the axis, and
`measure(l)` the length of a line at the radius l, 2πl, or 1 for a line contact. A `Shape` is u and
du/dx at the same places.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from discretization.surfaces.network import Shape
from energy import Scene
from energy.arrays import Array

# A displacement below every one there is [l]. D of its line is below every depth, so that it never
# recedes; it is finite, as infinities would become nan in differences.
ANY = -1e200
# Width of a gap at least [l]. It is far above the rounding of positions, and the energy of a
# narrower gap is rounding of that of the scene.
NARROWEST = 1e-13


class LinePosition(NamedTuple):
    """One contact line, or one line each of many free surfaces.

    Attributes
    ----------
    x, f : float or ndarray (n,)
        Positions or radii, and the heights of the profile there [length].
    """

    x: Any
    f: Any


def only_line(left: LinePosition | None, right: LinePosition | None) -> LinePosition:
    """The line of a tail, or the left one of a gap: the first line of a surface.

    Parameters
    ----------
    left, right : LinePosition or None
        The lines of a free surface.

    Returns
    -------
    LinePosition
    """
    line = left if left is not None else right
    assert line is not None, "a free surface has a line"
    return line


class Free(NamedTuple):
    """A free surface in equilibrium between lines that are held.

    From `Surfaces.solve` it has the units of the scene and its lines are the left and the right
    one; from `Surfaces.solved` its units are l and γ₁ and its lines the first and the other one.

    Attributes
    ----------
    energy : float
        F, what springs and tension store in it.
    pulls : tuple of float
        ∂F/∂u at both lines: the forces downwards that hold them. That of a line that is infinitely
        far away, or none, is 0.
    area : float
        k∫u dx over it, the force of its springs.
    residual : float
        The larger of two violations, dimensionless: the forces that are left at its free nodes,
        and how far ∂F/∂x of its lines is from what the head of this module says.
    """

    energy: float
    pulls: tuple[float, float]
    area: float
    residual: float


class LineState(NamedTuple):
    """Evidence for the certificate, of one contact line.

    A line is at rest at the depth d if opening <= d <= closing. Of a free line both are equal but
    for rounding, unless lines advance and recede under different works of adhesion.

    Attributes
    ----------
    x : float
        Its position [length].
    free : bool
        Whether it is not pinned at a corner.
    closing : float
        D just outside the contact, with the work of adhesion of a line that advances [length].
    bare : float
        The same without adhesion.
    opening : float
        D just inside the contact, with the work of adhesion of a line that recedes; -∞ for a
        contact of one point, which has no inside [length].
    size : float
        Sum of the sizes of the terms that cancel in D - d, of which rounding is a part [length].
    moved : float
        How far the line moves, over an error of D at the lines of its free surface.
    stable : bool
        Whether D grows outwards of these lines: whether a line that is moved comes back.
    """

    x: float
    free: bool
    closing: float
    bare: float
    opening: float
    size: float
    moved: float
    stable: bool


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Free surfaces beside contacts; a line that is None is infinitely far away.

    Subclasses define `at_rest`, `energy_and_reaction`, `solved` and `profile` in units of l and γ₁.
    Their parameters are alike: a surface is on one `side` of a first line at s, which is displaced
    by u; the other line, at a distance `width`, infinite if there is none, by u + rise: `rise` is
    positive if the other line is deeper.

    Attributes
    ----------
    scene : Scene
    lost : str
        Why a surface that turns over has no state, for messages.
    """

    scene: Scene
    lost: ClassVar[str]

    def rest_depth(
        self, side: Any, x: Any, f: Any, f1: Any, facing: LinePosition | None, w: Any
    ) -> Any:
        """Depth D at which lines rest.

        Parameters
        ----------
        side : {1, -1}, or ndarray (n,)
            1 for a line whose contact is on its left, and its free surface on its right.
        x, f, f1 : float or ndarray (n,)
            Positions of the lines [length], and height [length] and slope df/dx of the profile
            there; at a corner the slope on the side that is meant.
        facing : LinePosition or None
            The lines on the other side of the free surfaces; None if these are tails.
        w : float or ndarray (n,)
            Work of adhesion [energy/area].

        Returns
        -------
        float or ndarray (n,)
            [length].
        """
        length = self.scene.elastocapillary_length
        width: Any = math.inf
        rise: Any = 0.0
        if facing is not None:
            width = side * (facing.x - x) / length
            width = max(width, NARROWEST) if np.ndim(width) == 0 else np.maximum(width, NARROWEST)
            rise = (f - facing.f) / length
        work = w / self.scene.gamma1
        return f + length * self.at_rest(side, x / length, width, rise, side * f1, work)

    def stored(
        self, left: LinePosition | None, right: LinePosition | None, depth: Array
    ) -> tuple[Array, Array]:
        """Energy of n free surfaces of one kind, each at a depth of its own.

        Parameters
        ----------
        left, right : LinePosition or None
            Lines (n,).
        depth : ndarray (n,)
            [length].

        Returns
        -------
        energy, reaction : ndarray (n,)
            F, and ∂F/∂d: the sum of the pulls at both lines.

        Raises
        ------
        ValueError
            If a tail would turn over.
        """
        found = self.energy_and_reaction(*self._lines(left, right, depth))
        if found is None:
            i = int(np.argmax(np.abs(depth - only_line(left, right).f)))  # the steepest tail
            left_line = left and LinePosition(float(left.x[i]), float(left.f[i]))
            right_line = right and LinePosition(float(right.x[i]), float(right.f[i]))
            raise ValueError(self.refusal(left_line, right_line, float(depth[i])))
        energy, reaction = found
        return self._unit * self.scene.elastocapillary_length * energy, self._unit * reaction

    def solve(self, left: LinePosition | None, right: LinePosition | None, depth: float) -> Free:
        """One free surface.

        Parameters
        ----------
        left, right : LinePosition or None
            Its lines.
        depth : float
            [length].

        Returns
        -------
        Free

        Raises
        ------
        ValueError
            If it would turn over.
        """
        side, s, width, u, rise = self._lines(left, right, depth)
        if not self.scene.axisymmetric:
            # Surfaces of a line contact are alike on either side and at any place: with these
            # values `solved` meets again what it has cached.
            side = 1
            s = 0.0
        elif s == 0.0 and width == math.inf:
            return Free(0.0, (0.0, 0.0), 0.0, 0.0)  # at the axis there is none
        found = self.solved(side, s, width, u, rise)
        if found is None:
            raise ValueError(self.refusal(left, right, depth))
        first, other = found.pulls
        if left:
            pulls = (self._unit * first, self._unit * other)
        else:  # the first line is the right one
            pulls = (self._unit * other, self._unit * first)
        energy = self._unit * self.scene.elastocapillary_length * found.energy
        return Free(energy, pulls, self._unit * found.area, found.residual)

    def shape(
        self, z: Array, left: LinePosition | None, right: LinePosition | None, depth: float
    ) -> Shape:
        """Displacement and slope of one free surface.

        Parameters
        ----------
        z : ndarray
            Positions between its lines [length].
        left, right : LinePosition or None
            Its lines.
        depth : float
            [length].

        Returns
        -------
        u, slope : ndarray
            [length] and du/dz, in the shape of z.
        """
        if left is None and right is None:  # no contact at all
            return np.zeros_like(z), np.zeros_like(z)
        length = self.scene.elastocapillary_length
        side, *line = self._lines(left, right, depth)
        x = side * (np.ravel(z) - only_line(left, right).x) / length  # from the first line
        u, slope = self.profile(x, side, *line)
        return length * u.reshape(np.shape(z)), side * slope.reshape(np.shape(z))

    @property
    def _unit(self) -> float:
        """Unit of forces: γ₁ per length of a line contact, or 2πγ₁l all around an axis."""
        return self.scene.gamma1 * float(self.scene.measure(self.scene.elastocapillary_length))

    def _lines(
        self, left: LinePosition | None, right: LinePosition | None, depth: Any
    ) -> tuple[Any, ...]:
        """side, s, width, u and rise of free surfaces, in units of l; see `Surfaces`."""
        length = self.scene.elastocapillary_length
        line = only_line(left, right)
        s = line.x / length
        u = (depth - line.f) / length
        if left is None or right is None:  # a tail ends at u + rise = 0
            return 1 if left else -1, s, math.inf, u, -u
        return 1, s, (right.x - left.x) / length, u, (left.f - right.f) / length

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, outward_slope: Any, w: Any) -> Any:
        """Displacement u at which the first line rests: D - f in units of l.

        Parameters
        ----------
        side, s, width, rise
            As of the class.
        outward_slope : float or ndarray (n,)
            f' at the line, outwards of its contact: `side` times df/dx.
        w : float or ndarray (n,)
            Work of adhesion over γ₁.

        Returns
        -------
        float or ndarray (n,)
            [l].
        """
        raise NotImplementedError

    def energy_and_reaction(self, side: int, s: Any, width: Any, u: Any, rise: Any) -> Any:
        """Energy F of each of n surfaces, and the sum of the reactions of its lines.

        Parameters
        ----------
        side : {1, -1}
        s, width, u, rise : float or ndarray (n,)
            As of the class.

        Returns
        -------
        tuple of ndarray (n,), or None
            F and ∂F/∂u at fixed rise; None if a tail would turn over.
        """
        raise NotImplementedError

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """One surface, whose pulls are those at its first and at its other line.

        The parameters are those of the class. None if it would turn over.
        """
        raise NotImplementedError

    def profile(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """Displacement and slope of one surface.

        Parameters
        ----------
        x : ndarray (n,)
            Distances from the first line, towards the other one [l].
        side, s, width, u, rise
            As of the class.

        Returns
        -------
        u, slope : ndarray (n,)
            [l], and du/dx.
        """
        raise NotImplementedError

    def refusal(self, left: LinePosition | None, right: LinePosition | None, depth: float) -> str:
        """The message for a surface that would turn over.

        Parameters
        ----------
        left, right : LinePosition or None
            The lines of the surface.
        depth : float
            [length].

        Returns
        -------
        str
        """
        line = only_line(left, right)
        name = "r" if self.scene.axisymmetric else "x"
        where = f"at the contact line {name} = {line.x!r}"
        if left is not None and right is not None:
            where = f"between the contact lines {name} = {left.x!r} and {right.x!r}"
        return (
            f"depth = {depth!r}: {where} the surface, displaced by {depth - line.f!r}, {self.lost} "
            f"(l = {self.scene.elastocapillary_length!r}); use a smaller |depth|, a smaller w or a "
            "blunter indenter"
        )
