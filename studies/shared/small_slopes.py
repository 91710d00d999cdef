"""Eqs. (11), (15) and (16) against states simulated with true surface lengths, one at a time.

Material for the studies `applicability` and `contact_angle`. k = 1 throughout; results depend on
w/γ₁, on a/l and on the steepness, the slope f'(a) of the indenter at the line of (16). Only k of a
layer enters: slopes that are not small strain any film with h <= l by as much, so that these are
numbers of the model, outside the limits of independent springs.

Conventions: the depth d is positive into the layer, the height f of the indenter upwards from its
lowest point, the force P positive where it presses; a is the half-width of a line contact or the
radius about an axis. l = √(γ₁/k), δ₀ = √(2w/k), and

    d = f(a) + (f'(a) - √(2w/γ₁)) l        (16)
    P = 2k ∫₀ᵃ (d - f) dx + 2√(kγ₁) (d - f(a))        (11)
    π - θ = √(2w/γ₁) (15);   w = γ₁ (1 + cos θ), Young's law (8).

A flat punch has its line pinned at the edge: f'(a) = 0 there is the slope of its bottom, at which
the line recedes, and (16) becomes d = -δ₀, where it detaches. `energy.cards` evaluates these
equations. `minimise` gives the state of the path that touches first and then moves to the depth: it
keeps its contact down to detachment, where `label` becomes "detached" and `half_width` is 0. It
raises ValueError where the surface would turn over, and warns with AccuracyWarning where the
estimated error of a state exceeds 1e-8. Of a state, `angle_deficit` is its π - θ; of surfaces,
`angle_deficit` is that of (8) and `small_slope_deficit` that of (15).
Of `cards`, `contact_line` has `depth(f, f')`, (16), and `force` has `total(d, a)`, (11);
`axisymmetric` has both about an axis, where the depth takes the radius, too.
"""

import functools
import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from scipy.optimize import brentq

from discretization import AccuracyWarning, Equilibrium, minimise
from energy import ElasticLayer, FlatPunch, Indenter, Parabola, Scene, SurfaceEnergies, Wedge, cards

K = 1.0  # stiffness per area k of all layers: a unit

# In a search for the depth of detachment, over δ₀. No contact reaches beyond -1, with small slopes
# or finite ones, and a profile that is in the layer has a contact.
_ABOVE_CONTACT = -1.01  # a hundredth beyond the last detachment there is
_IN_CONTACT = 0.01  # a hundredth below first touch
# What the search takes for the half-width: any negative number without contact, so that the sign
# changes there, and a positive one of a contact at a tip, whose half-width is 0.
_WITHOUT_CONTACT = -1e-7
_TIP_IN_CONTACT = 1e-12
# Of the depth that is found, relative to it, in brentq: so far below any tolerance that is given,
# at least 1e-12 δ₀, that this one alone decides.
_NEVER_DECIDES = 1e-14


class Errors(NamedTuple):
    """Signed relative errors against a simulated state; NaN without one.

    Attributes
    ----------
    half_width : float
        Of a by Eq. (16).
    force : float
        Of P by Eq. (11).
    angle : float
        Of π - θ by Eq. (15).
    young : float
        Of the simulated π - θ against Young's law (8), which the simulation has to reproduce.
    """

    half_width: float
    force: float
    angle: float
    young: float

    @property
    def exists(self) -> bool:
        """Whether there is a state: its surface does not turn over."""
        return not math.isnan(self.force)


def scene(
    body: Indenter, gamma1: float, w: float, slopes: str = "finite", geometry: str = "line"
) -> Scene:
    """An indenter on a layer with k = 1.

    Parameters
    ----------
    body : Indenter
    gamma1, w : float
        Surface tension and work of adhesion.
    slopes, geometry : str
        As in `Scene`.

    Returns
    -------
    Scene
    """
    layer = ElasticLayer(E=K, nu=0.0, h=1.0)  # k = Ẽ/h, with Ẽ = E for ν = 0
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    return Scene(layer, surfaces, body, slopes, geometry=geometry)


class Kind(NamedTuple):
    """A family of indenters with a given slope s at their line, f'(a) = s.

    With d = 0 and δ₀ = 1 Eq. (16) is f(a) + l f'(a) = 1, for l √(2w/γ₁) = δ₀. Without tension it is
    f(a₀) = 1. The indenter is the same with tension and without: the wedge keeps its slope, the
    parabola its radius R = a₀/s.

    Attributes
    ----------
    body : callable
        The indenter of s and a.
    width : float
        a s without tension, at d = 0 and δ₀ = 1.
    at_touch : callable
        The half-width by (16) at d = 0 of a₀, which it is without tension, and l: from
        s (a + l) = s a₀ of a wedge, so that a < 0, no contact, for l > a₀; from
        a² + 2 l a = a₀² of a parabola.
    """

    body: Callable[[float, float], Indenter]
    width: float
    at_touch: Callable[[float, float], float]


KINDS = {
    "wedge": Kind(
        body=lambda s, a: Wedge(math.atan(s)),
        width=1.0,
        at_touch=lambda a0, ell: a0 - ell,
    ),
    "parabola": Kind(
        body=lambda s, a: Parabola(a / s),
        width=2.0,
        at_touch=lambda a0, ell: a0 / (ell / a0 + math.hypot(ell / a0, 1)),
    ),
}
SHAPES = tuple(KINDS)
ROUND = {"cone": "wedge", "sphere": "parabola"}  # turned about their axis


def blunt(shape: str, steepness: float, a: float = 1.0) -> Indenter:
    """The wedge or parabola with f'(a) = steepness.

    Parameters
    ----------
    shape : str
        One of SHAPES.
    steepness, a : float

    Returns
    -------
    Indenter
    """
    return KINDS[shape].body(steepness, a)


def simulated(given: Scene, depth: float) -> Equilibrium | None:
    """The equilibrium at a depth, of several the one that keeps the contact made before.

    Parameters
    ----------
    given : Scene
    depth : float
        Positive into the layer.

    Returns
    -------
    Equilibrium or None
        Without contact where it has detached. None where its surface would turn over, which takes
        w >= γ₁; any other refusal is raised.
    """
    try:
        return minimise(given, depth)
    except ValueError:
        if given.work_of_adhesion < given.gamma1:
            raise
        return None


def depth_by_16(given: Scene, a: float) -> float:
    """The depth at which Eq. (16), or its like around an axis, places the line.

    Parameters
    ----------
    given : Scene
    a : float
        Half-width or radius of the contact, > 0.

    Returns
    -------
    float
    """
    body = given.indenter
    height = float(body.height(a))
    # of a punch the bottom's, at which its pinned line recedes; the edge itself is vertical
    slope = 0.0 if isinstance(body, FlatPunch) else float(body.slope(a))
    parameters = {"k": K, "gamma1": given.gamma1, "w": given.work_of_adhesion}
    if given.axisymmetric:
        return float(cards.axisymmetric.contact_line.depth(height, slope, a, **parameters))
    return float(cards.contact_line.depth(height, slope, **parameters))


def compare(given: Scene, depth: float, a: float, size: float | None = None) -> Errors:
    """Half-width (16), force (11) and angle (15) against the simulation at a depth.

    Parameters
    ----------
    given : Scene
    depth : float
        One at which the simulated state has a contact.
    a : float
        The half-width of (16), about an axis the radius; `half_width` of a state is the same.
    size : float, optional
        What the error of a is relative to; None: the simulated half-width, which is then not 0.

    Returns
    -------
    Errors
        That of P relative to max(|P|, 2√(2wγ₁)), the tension term of (22), or around an axis
        2πa√(2wγ₁). NaN where the surface turns over; the angles NaN at a pinned line, whose angle
        is not that of (15).
    """
    state = simulated(given, depth)
    if state is None:
        return Errors(*[math.nan] * 4)
    card = cards.axisymmetric.force if given.axisymmetric else cards.force
    force = float(card.total(depth, a, f=given.indenter.height, k=K, gamma1=given.gamma1))
    pinned = isinstance(given.indenter, FlatPunch)
    deficit = math.nan if pinned else state.angle_deficit
    return Errors(
        (a - state.half_width) / (size or state.half_width),
        (force - state.force) / _force_scale(given, state.force, a),
        given.surfaces.small_slope_deficit / deficit - 1,
        deficit / given.surfaces.angle_deficit - 1,
    )


def _force_scale(given: Scene, force: float, a: float) -> float:
    """|P|, or the pull of the lines if that is larger."""
    length_of_lines = 2 * math.pi * a if given.axisymmetric else 2
    pull = length_of_lines * math.sqrt(2 * given.work_of_adhesion * given.gamma1)
    return max(abs(force), pull)


@functools.cache
def at_unit_width(shape: str, steepness: float, ratio: float) -> Errors:
    """Errors at the depth where (16) gives a = l, for w/γ₁ = ratio; l = √(γ₁/k) = 1 here.

    Around an axis that line may be unstable: a is then the radius of the stable one at this depth.

    Parameters
    ----------
    shape : str
        One of SHAPES or ROUND.
    steepness : float
        f' where the line is.
    ratio : float
        w/γ₁.

    Returns
    -------
    Errors
    """
    geometry = "axisymmetric" if shape in ROUND else "line"
    body = blunt(ROUND.get(shape, shape), steepness)
    given = scene(body, 1.0, ratio, geometry=geometry)
    depth = depth_by_16(given, 1.0)
    if not given.axisymmetric:
        return compare(given, depth, 1.0)
    return compare(given, depth, minimise(replace(given, slopes="small"), depth).radius)


@functools.cache
def punch(half_width: float, ratio: float) -> Errors:
    """Errors of a flat punch at d = -δ₀, the last depth at which (16) and the simulation hold it.

    At that depth itself, where contact and none have the line in balance, the simulation still has
    the contact, with the label "neutral".

    Parameters
    ----------
    half_width : float
        Of the punch, over l = 1.
    ratio : float
        w/γ₁.

    Returns
    -------
    Errors
    """
    given = scene(FlatPunch(half_width), 1.0, ratio)
    return compare(given, depth_by_16(given, half_width), half_width)


def detachment(given: Scene, tolerance: float = 1e-6) -> float:
    """The depth at which the simulated contact vanishes, by root finding.

    A depth at which the surface would turn over has no state, and counts as without contact: a
    contact that is pulled ends there. For w >= γ₁ the depth that is found may be that one.

    Parameters
    ----------
    given : Scene
    tolerance : float
        Of the depth, over δ₀. The default is a thousandth of the distance that `contact_angle`
        keeps from this depth, 1e-3 of its path; `applicability`, which subtracts the depth from
        that of (16), gives 1e-12.

    Returns
    -------
    float
        Negative: above the surface.
    """
    delta0 = given.critical_separation

    def width(depth: float) -> float:
        """The half-width, positive also at a tip in contact, negative without contact."""
        with warnings.catch_warnings():  # an exact width does not matter to whether there is one
            warnings.simplefilter("ignore", AccuracyWarning)
            state = simulated(given, depth)
        if state is None or state.label == "detached":  # turned over, or let go
            return _WITHOUT_CONTACT
        return state.half_width + _TIP_IN_CONTACT

    above = _ABOVE_CONTACT * delta0
    inside = _IN_CONTACT * delta0
    return float(brentq(width, above, inside, xtol=tolerance * delta0, rtol=_NEVER_DECIDES))


# Errors by shape, steepness and w/γ₁.
QUANTITIES: dict[str, Callable[[str, float, float], float]] = {
    "half-width": lambda *at: at_unit_width(*at).half_width,
    "force": lambda *at: at_unit_width(*at).force,
}
