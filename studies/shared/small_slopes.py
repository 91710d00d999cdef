"""Eqs. (11), (15) and (16) against states simulated with true surface lengths, one at a time.

Material for the studies `applicability` and `contact_angle`. k = 1 throughout; results depend on
w/γ₁, on a/l and on the steepness, the slope f'(a) of the indenter at the line of (16). Only k of a
layer enters: slopes that are not small strain any film with h <= l by as much, so that these are
numbers of the model, outside the limits of independent springs.
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

K = 1.0  # stiffness per area of all layers

# In a search for the depth of detachment, over δ₀. With small slopes it is at -1, with finite ones
# above, and a profile that it has entered has a contact.
_ABOVE_CONTACT = -1.01  # a hundredth beyond the last detachment there is
_IN_CONTACT = 0.01  # a hundredth below first touch
# What the search takes for the half-width: any negative number without contact, so that the sign
# changes there, and a positive one of a contact at a tip, whose half-width is 0.
_WITHOUT_CONTACT = -1e-7
_TIP_IN_CONTACT = 1e-12


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
    layer = ElasticLayer(K, 0.0, 1.0)
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    return Scene(layer, surfaces, body, slopes, geometry=geometry)


class Kind(NamedTuple):
    """A family of indenters with a given slope s at their line, f'(a) = s.

    Attributes
    ----------
    body : callable
        The indenter of s and a.
    width : float
        a s without tension, at d = 0 and δ₀ = 1.
    at_touch : callable
        The half-width by (16) at d = 0 of a₀, which it is without tension, and l.
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
    """The equilibrium at a depth.

    Parameters
    ----------
    given : Scene
    depth : float

    Returns
    -------
    Equilibrium or None
        None where its surface would turn over, which takes w >= γ₁.
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
    a : float
        The half-width of (16).
    size : float, optional
        What the error of a is relative to; None: the simulated half-width.

    Returns
    -------
    Errors
        That of P relative to max(|P|, 2√(2wγ₁)), the tension term of (22), or around an axis
        2πa√(2wγ₁).
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
    """Errors at the depth where (16) gives a = l, for w/γ₁ = ratio.

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
def punch(width: float, ratio: float) -> Errors:
    """Errors of a flat punch of half-width `width` l at d = -δ₀, where (16) lets it go."""
    given = scene(FlatPunch(width), 1.0, ratio)
    return compare(given, depth_by_16(given, width), width)


def detachment(given: Scene, tolerance: float = 1e-6) -> float:
    """The depth at which the simulated contact vanishes, by root finding.

    Parameters
    ----------
    given : Scene
    tolerance : float
        Of the depth, over δ₀.

    Returns
    -------
    float
    """
    delta0 = given.critical_separation

    def width(depth: float) -> float:
        """The half-width, negative without contact."""
        with warnings.catch_warnings():  # an exact width does not matter to whether there is one
            warnings.simplefilter("ignore", AccuracyWarning)
            state = simulated(given, depth)
        if state is None or state.label == "detached":
            return _WITHOUT_CONTACT
        return state.half_width + _TIP_IN_CONTACT

    above = _ABOVE_CONTACT * delta0
    inside = _IN_CONTACT * delta0
    return float(brentq(width, above, inside, xtol=tolerance * delta0, rtol=1e-14))


# Errors by shape, steepness and w/γ₁.
QUANTITIES: dict[str, Callable[[str, float, float], float]] = {
    "half-width": lambda *at: at_unit_width(*at).half_width,
    "force": lambda *at: at_unit_width(*at).force,
}
