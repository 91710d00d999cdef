"""Any number of contacts on the fitted mesh: energy and force, certificate and error estimate.

In contact u = d - f is prescribed, so the free surfaces, two tails and the gaps between contacts,
do not feel each other, and energy and force are sums over the contacts and over them.

The conditions of ../certificate.py for lines that move continuously, depths over the largest of |d|
and δ₀, at lines with l |f'| added, a term of D. Depths of a path are only known to
TIE of the largest, and the scale is no less than makes that pass:

    penetration   max (g - u) between the contacts and beyond them, at the samples that resolve the
                  profile and at the extremes between them; and just ahead of every line the
                  surface does not pass through the indenter, D₀ >= d, D₀ that of no adhesion
    stationarity  residual of the free nodes, and of the energy's derivative by the gap
    opening       no corner in contact is torn open, -[f'] <= 2√(2w/γ₁) (or angles); a contact of
                  one point, which does not adhere, is not pulled; where w = 0, neither is
                  any part of a contact, kg + γ₁f'' >= 0; all as forces over kl
    neighbours    every line rests: D >= d just ahead of it with the adhesion of a contact that
                  closes, D <= d just behind with that of one that opens; where a line is free, D
                  grows outwards, of both lines of a gap together
    force         dU/dd against k∫u dx

Conventions
-----------
The depth d, the rest depth D, at which a line would be in equilibrium, and the displacement u of
the surface are positive down into the layer, heights f of the profile upwards [length]; the profile
stands at g = d - f. Forces are positive where the indenter is pressed. Lines are a flat tuple, both
ends of every contact from left to right; as arrays (m, 2) they are the left and right ends of m
contacts. Free surfaces are listed from left to right: m contacts have m + 1 of them, the first and
the last one tails. About an axis x is the radius, the left end of a disc at x = 0 is no line, and
the first free surface of a disc is none.

`LineState` is the evidence of one line: `closing` is D just outside with the adhesion of a contact
that closes, `bare` the same without adhesion, `opening` D just inside with the adhesion of one that
opens. `Free` is one free surface; its `pulls` are ∂F/∂u at its left and right line. `Interval`,
of quadrature.py, has energy and force with the errors of their integrals, and `force_by_field`,
the second way to the force.

Of the scene, l = √(γ₁/k) is `elastocapillary_length`, `measure(x)` is 1, about an axis 2πx, and
`hysteretic` is whether lines are pinned over a range of depths, by two works of adhesion or as
there is no tension. Of the indenter, `walls` are the ends of the body, and `slope_beside(x, side)`
is f' just on the right (1) or left (-1) of x, or at x (0). `displacement_scale` is the largest of
|d| and δ₀, as above. `Surfaces.solve(left, right, depth)` is the `Free` between two `LinePosition`s
(x and the height f there), None for a line that does not exist. `refined`, of quadrature.py, is the
`Interval` of contacts with such surfaces; its `energy_scale` and `force_scale` are sums of the
sizes of the terms. `worst` is the largest of its arguments, 0 if none is positive, nan if one is
nan. ROUNDING is 16 times 2⁻⁵², what a sum of a dozen terms leaves. A line state's `moved` is how
far the line moves over what D is off by, and `stable` whether D grows outwards.

`ContactLines.pointed(x)` is whether a contact of the one point x stands for one that is too narrow
for doubles, which adheres. `Certificate.undeformed` is that of a surface on which no force acts.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np

from discretization.certificate import ROUNDING, Certificate, worst
from discretization.equilibrium import QUANTITIES
from discretization.fitted.contact_lines import ContactLines, Lines
from discretization.fitted.rest_depths import displacement_scale
from discretization.fitted.single_contact import SingleContact
from discretization.quadrature import Interval, refined
from discretization.surfaces.protocol import Free, LinePosition, LineState
from energy import Scene
from energy.arrays import Array, Mask

# Of |x|: a line is found to four roundings of its position, as root finders leave it (roots.py).
_POSITION = ROUNDING / 4
# Of the sizes of the terms of force and energy: rounding of the integrals and of their sum.
_SUMMED = 4 * ROUNDING


@dataclass(frozen=True, eq=False)
class Contacts:
    """One or more contacts at a depth, with what is computed of them.

    Attributes
    ----------
    contact_lines : ContactLines or SingleContact
        The scene with its lines and free surfaces: evidence of lines, and what penetrates or opens.
    lines : tuple of float
        Both ends of every contact, from left to right [length].
    depth : float
        [length].
    """

    contact_lines: ContactLines | SingleContact
    lines: Lines
    depth: float

    @functools.cached_property
    def x(self) -> Array:
        """Left and right end of each contact (m, 2) [length]."""
        return np.array(self.lines).reshape(-1, 2)

    @functools.cached_property
    def pinned(self) -> Mask:
        """Which lines (m, 2) are pinned; the end of a contact at an axis counts as pinned."""
        of_lines = [not line.free for line in self.line_states]
        at_axis = [True] * (self.x.size - len(of_lines))
        return np.array(at_axis + of_lines).reshape(-1, 2)

    @functools.cached_property
    def surfaces(self) -> list[Free]:
        """The m + 1 free surfaces of m contacts from left to right.

        Raises
        ------
        ValueError
            If one would turn over.
        """
        f = np.asarray(self.contact_lines.scene.indenter.height(self.x), float)
        # In turns the left and the right line of each surface; the tails have only one.
        lines = [None, *map(LinePosition, self.lines, f.ravel().tolist()), None]
        solve = self.contact_lines.surfaces.solve
        return [
            solve(left, right, self.depth)
            for left, right in zip(lines[::2], lines[1::2], strict=True)
        ]

    @functools.cached_property
    def line_states(self) -> list[LineState]:
        """Evidence for the certificate, of every line."""
        return self.contact_lines.line_states(self.lines, self.depth)

    @property
    def size(self) -> float:
        """The size of the terms that cancel in D - d, the largest of all lines [length]."""
        return max(line.size for line in self.line_states)

    @property
    def neutral(self) -> bool:
        """Whether the energy does not change as a line at an edge of the body moves inwards.

        There D just inside is the depth, to rounding, as of a flat punch at its critical depth.
        """
        scene = self.contact_lines.scene
        walls = scene.indenter.walls
        if not (scene.work_of_adhesion and walls):
            return False
        distances = [abs(line.opening - self.depth) for line in self.line_states if line.x in walls]
        return min(distances, default=math.inf) <= 2 * ROUNDING * self.size

    def totals(self) -> Interval:
        """Energy and force, with errors, and features that the samples of the profile have missed.

        It integrates over the contacts and adds the free surfaces.
        """
        profile = self.contact_lines.profile
        return refined(self.contact_lines.scene, self.depth, self.x, self.surfaces, profile)


def estimated(
    scene: Scene, depth: float, lines: Array, moves: Array, found: Interval
) -> dict[str, float]:
    """Relative errors of half-width, force and energy: of quadrature, lines, and rounding.

    A line at q that may be off by δq changes the force by at most |dP/dq| δq, see `push`, and the
    energy by nothing: where it rests, ∂U/∂q = 0.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    lines, moves : ndarray (m, 2)
        Left and right ends of the contacts, and how far each may be off [length].
    found : Interval
        Energy and force, and the errors of their quadrature.

    Returns
    -------
    dict
        Three relative errors, by the names of `equilibrium.QUANTITIES`.
    """
    energy_error, force_error = found.errors
    uncertain = moves > 0
    force_error += float(push(scene, depth, lines[uncertain]) @ moves[uncertain])
    width = (lines[:, 1] - lines[:, 0]).sum()
    of_width = moves.sum() / width + ROUNDING if width else 0.0  # a point has no width to be off by
    of_force = force_error / (found.force_scale or 1.0) + _SUMMED
    of_energy = energy_error / (found.energy_scale or 1.0) + _SUMMED
    return dict(zip(QUANTITIES, map(float, (of_width, of_force, of_energy)), strict=True))


def push(scene: Scene, depth: float, x: Array) -> Array:
    """A bound of |dP/dq| of lines: (k|g| + k l |f'|) times the length of a line.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    x : ndarray (n,)
        Positions of the lines [length].

    Returns
    -------
    ndarray (n,)
        [force/length], or this per length of a line contact.
    """
    g = depth - scene.indenter.height(x)
    slope = scene.indenter.slope(x)
    displacement = np.abs(g) + scene.elastocapillary_length * np.abs(slope)
    return np.asarray(scene.stiffness * displacement * scene.measure(x))


def certify(contacts: Contacts, found: Interval) -> Certificate:
    """The certificate of contacts, by the conditions at the head of this module.

    Parameters
    ----------
    contacts : Contacts
    found : Interval
        Their energy and force.

    Returns
    -------
    Certificate

    Raises
    ------
    ValueError
        If a free surface would turn over.
    """
    scene = contacts.contact_lines.scene
    depth = contacts.depth
    lines = contacts.line_states
    scale = displacement_scale(scene, depth, contacts.size)
    # A touch at d = 0 without adhesion displaces nothing; springs without tension are judged by
    # paths/springs.py.
    if scale * scene.elastocapillary_length == 0:
        return Certificate.undeformed()

    # How much deeper than D of a line that closes the contact is, and less deep than D of one that
    # opens. Without adhesion a line rests later, D₀ >= D.
    advances = worst(*(depth - line.closing for line in lines))
    passes_through = worst(*(depth - line.bare for line in lines))
    recedes = worst(*(line.opening - depth for line in lines))
    # What is rounding where the line is judged with adhesion is rounding without it.
    rests = advances <= ROUNDING * contacts.size
    through = advances if rests else passes_through
    penetration = contacts.contact_lines.penetration(contacts.lines, depth)

    # Stable is any line that another work of adhesion holds than moves it, and any of a convex
    # energy.
    always_stable = scene.hysteretic or not scene.work_of_adhesion
    stable = always_stable or all(line.stable for line in lines)
    size = scale + _steepest(contacts)  # of the terms that cancel in D
    return Certificate(
        penetration=worst(through / size, penetration / scale),
        stationarity=worst(*(each.residual for each in contacts.surfaces)),
        opening=_opening(contacts, scale),
        neighbours=worst(advances / size, recedes / size, float(not stable)),
        force=abs(found.force - found.force_by_field) / (found.force_scale or 1.0),
    )


def _steepest(contacts: Contacts) -> float:
    """The largest l |f'| at any line, with finite slopes l |sin β| with tan β = f' [length].

    At corners the steeper side counts. It is the term of D = f + l (f' - √(2w/γ₁)) that may be much
    larger than D.
    """
    scene = contacts.contact_lines.scene
    beside = (-1, 1) if len(scene.indenter.corners) else 0
    slopes = scene.indenter.slope_beside(contacts.x[..., None], beside)
    if scene.slopes == "finite":
        slopes = slopes / np.hypot(1.0, slopes)
    return scene.elastocapillary_length * float(np.abs(slopes).max())


def _opening(contacts: Contacts, scale: float) -> float:
    """Largest force that would open a contact, over kl times `scale`, the size of depths."""
    scene = contacts.contact_lines.scene
    forces = contacts.contact_lines.opening(contacts.lines, contacts.depth)
    forces += _pulls_on_points(contacts)
    unit = scene.stiffness * scene.elastocapillary_length
    return worst(*forces) / (unit * scale)


def _pulls_on_points(contacts: Contacts) -> list[float]:
    """By what the free surfaces beside contacts of one point are pulled up there [force/length].

    The surface exerts the sum of `pulls` on the point, positive where it presses against it; where
    that is negative only adhesion could hold the point. A point that stands for a contact too
    narrow for doubles adheres, so it is left out; and so is one at the axis, which has no length.
    """
    x = contacts.x
    measure = contacts.contact_lines.scene.measure(x[:, 0])
    points = (x[:, 0] == x[:, 1]) & (measure > 0)
    if points.any():
        points &= ~np.array([contacts.contact_lines.pointed(left) for left in x[:, 0].tolist()])
    if not points.any():
        return []
    # In a row the pulls are those at the left and right line of each surface; without the ends of
    # the tails at infinity, they are those at the left and right end of each contact.
    pulls_at_lines = np.ravel([each.pulls for each in contacts.surfaces])[1:-1].reshape(-1, 2)
    return (-pulls_at_lines.sum(axis=1)[points] / measure[points]).tolist()


def errors(contacts: Contacts, found: Interval) -> dict[str, float]:
    """Errors of rounding times the condition of the lines, and of the quadrature.

    Parameters
    ----------
    contacts : Contacts
    found : Interval
        Their energy and force, and the errors of their quadrature.

    Returns
    -------
    dict
        Relative errors, as of `estimated`.
    """
    off = ROUNDING * contacts.size + found.rounding
    moves = [_line_error(line, off) for line in contacts.line_states]
    at_axis = [0.0] * (contacts.x.size - len(moves))  # the left end of a disc, which is no line
    all_moves = np.reshape(at_axis + moves, contacts.x.shape)
    return estimated(contacts.contact_lines.scene, contacts.depth, contacts.x, all_moves, found)


def _line_error(line: LineState, off: float) -> float:
    """How far a line may be off where D may be off by `off` [length]; 0 if it is pinned."""
    if not line.free:
        return 0.0
    return off * line.moved + _POSITION * abs(line.x)
