"""Random convex scenes with arrays of states, limits among them, and how these compare."""

import math
import warnings
from dataclasses import replace

import numpy as np

from discretization import AccuracyWarning, NotCertifiedError, minimise, minimise_many
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

from .hostile_scenes import Dice

STATES = 10  # of each scene
CLOSE = 1e-12  # relative to scales: what one state and many may differ by
SLOPE = 1e-9  # of π: angles that one state reads off the steep end of a mesh about an axis
UNKNOWN = 0.1  # of the half-width: with such an error it is nothing but small
UNSURE = 1e-12  # of δ₀ and the depth: so near to where contact is lost either may be right


def closed(dice, a, rise):
    """A built-in shape with a slope of the size of `rise` at a distance a."""
    n = dice.one_of(1, 1.5, 2, 3, 4, 2.5, 20)
    return dice.one_of(
        lambda: FlatPunch(a),
        lambda: Wedge(math.atan(rise)),
        lambda: Parabola(a / rise),
        lambda: PowerLaw(rise / n * a ** (1 - n), n),
        lambda: Circle(a * math.hypot(1, 1 / rise)),
    )()


def convex(dice, a, rise):
    """Any convex profile: shapes, their sums, shifted and tilted; samples, and functions."""
    made = closed(dice, a, rise)
    x = np.sort(dice.rng.uniform(-6, 6, int(dice.rng.integers(5, 40)))) * a
    return dice.one_of(
        lambda: made,
        lambda: made.shifted(dice.between(-3, 3) * a),
        lambda: Parabola(a / rise).tilted(dice.between(-0.9, 0.9) * rise),
        lambda: Wedge(math.atan(rise)).tilted(dice.between(-0.5, 0.5) * rise) + Parabola(a / rise),
        lambda: Parabola(a / rise) + FlatPunch(dice.decade(-1, 1) * a),
        lambda: PowerLaw(rise / 3 * a**-2, 3) + Parabola(a / rise).shifted(a),
        lambda: Sampled(x, rise / (2 * a) * x**2, kind="linear"),
        lambda: Sampled(np.linspace(-9, 9, 61) * a, rise * a / 2 * np.linspace(-9, 9, 61) ** 2),
        lambda: Sampled(
            np.linspace(-9, 9, 61) * a, rise * a / 2 * np.linspace(-9, 9, 61) ** 2, kind="smooth"
        ),
        lambda: Profile(
            lambda z: rise * a * 2 * np.sinh(np.asarray(z) / (2 * a)) ** 2,
            lambda z: rise * np.sinh(np.asarray(z) / a),
            (-100 * a, 100 * a),
            convex=True,
        ),
    )()


class Case:
    """A scene, and depths, works of adhesion, tensions and stiffnesses of some of its states."""

    def __init__(self, seed):
        dice = Dice(seed)
        self.seed = seed
        ell = dice.decade(-7, 3)
        stress = dice.decade(-6, 6)
        layer = ElasticLayer(stress, dice.one_of(0.0, 0.3, 0.49), ell * dice.decade(-1, 1))
        k = layer.stiffness
        gamma1 = k * ell**2
        work = dice.one_of(1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.5)
        slopes = dice.one_of("small", "small", "finite")
        geometry = dice.one_of("line", "line", "axisymmetric")
        rise = min(math.sqrt(work) * dice.decade(-1, 0.7), 3.0 if slopes == "finite" else 1e3)
        a = ell * dice.decade(-1.5, 1.5)
        body = closed(dice, a, rise) if geometry == "axisymmetric" else convex(dice, a, rise)
        surfaces = SurfaceEnergies.from_work(gamma1, work * gamma1)
        self.scene = Scene(layer, surfaces, body, slopes, geometry=geometry)

        rng = dice.rng
        self.gamma1 = gamma1 * 10 ** rng.uniform(-0.5, 0.5, STATES)
        self.w = np.minimum(work * gamma1 * 10 ** rng.uniform(-0.7, 0.7, STATES), 1.9 * self.gamma1)
        self.w[rng.random(STATES) < 0.1] = 0.0
        self.gamma1[(rng.random(STATES) < 0.1) & ((slopes == "small") | (self.w == 0))] = 0.0
        self.stiffness = k * 10 ** rng.uniform(-0.5, 0.5, STATES)
        apex = body.apex if body.apex is not None else 0.0
        self.touch = float(body.height(apex))
        separation = np.sqrt(2 * self.w / self.stiffness)
        unit = np.maximum(separation, 0.1 * rise * ell)
        self.depths = self.touch + unit * rng.uniform(-1.2, 2, STATES)
        self.depths[rng.random(STATES) < 0.3] *= 5
        limit = rng.random(STATES) < 0.1
        self.depths[limit] = (
            float(body.height(apex)) + rng.choice([0.0, -1.0], limit.sum()) * (separation[limit])
        )

    def arrays(self, own=slice(None)):
        """The keywords of `minimise_many`."""
        return {
            "depths": self.depths[own],
            "w": self.w[own],
            "gamma1": self.gamma1[own],
            "stiffness": self.stiffness[own],
        }

    def one(self, i):
        """The scene of one state."""
        factor = float(self.stiffness[i]) / self.scene.stiffness
        layer = replace(self.scene.layer, E=self.scene.layer.E * factor)
        surfaces = SurfaceEnergies.from_work(float(self.gamma1[i]), float(self.w[i]))
        return replace(self.scene, layer=layer, surfaces=surfaces)


def alone(case, i, off=0.0):
    """What `minimise` says of a state at its depth or `off` it; None for a documented refusal."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        try:
            return minimise(case.one(i), float(case.depths[i]) + off)
        except (ValueError, NotCertifiedError):
            return None


def undecided(case, i):
    """Whether contact is lost within rounding of the depth of a state."""
    size = abs(case.depths[i]) + math.sqrt(2 * case.w[i] / case.stiffness[i])
    one, other = (alone(case, i, part * UNSURE * size) for part in (-1, 1))
    return one is None or other is None or bool(one.contacts.size) != bool(other.contacts.size)


def differences(case):
    """The largest differences of a, P, U, θ over their tolerance, and how many states there were.

    a over itself, P and U over the sums of their terms, θ over π; each tolerance no less than the
    error that `minimise` estimates. The residual over 1e-12 is the last.
    """
    # of a touch without adhesion nothing is left but the rounding of the lowest sample's place
    blank = case.w == 0
    blank &= (case.depths == case.touch) & isinstance(case.scene.indenter, Sampled)
    asked = np.flatnonzero(~blank).tolist()
    one = {i: alone(case, i) for i in asked}
    kept = [i for i in asked if one[i] is not None]
    for i in set(asked) - set(kept):
        if case.gamma1[i]:  # without tension one state has to know the profile further out
            _refused(case, i)
    if not kept:
        return np.zeros(5), 0
    many = minimise_many(case.scene, **case.arrays(kept))
    worst = np.zeros(5)
    for at, i in enumerate(kept):
        state = one[i]
        where = f"seed {case.seed}, state {i}"
        assert many.stable[at] or not case.w[i], where
        if bool(state.contacts.size) != many.in_contact[at]:
            assert undecided(case, i), where
        elif not state.contacts.size:
            assert math.isnan(many.contact_angle[at]), where
            assert many.half_width[at] == many.force[at] == many.energy[at] == 0, where
        else:
            worst = np.maximum(worst, _of_state(case, many, at, state))
    return worst, len(kept)


def _refused(case, i):
    """AssertionError unless many refuse it, too, or know that nothing holds so high.

    About an axis one state is refused at any depth below touching if the contact of touching is.
    """
    try:
        found = minimise_many(case.scene, **case.arrays([i]))
        unit = math.sqrt(2 * case.w[i] / case.stiffness[i])
        if case.scene.axisymmetric and case.depths[i] < -unit and not found.in_contact[0]:
            return
    except (ValueError, NotCertifiedError):
        return
    raise AssertionError(f"seed {case.seed}: state {i} is refused one by one only")


def _of_state(case, many, at, state):
    """Differences of one state in contact."""
    close = {n: max(CLOSE, 4 * e) for n, e in state.error_estimate.items()}
    if close["half_width"] > UNKNOWN:  # of a point, one state knows no more
        assert many.half_width[at] <= (1 + close["half_width"]) * state.half_width
        return np.zeros(5)
    found = []
    for name, size in {"half_width": state.half_width, **state.scales}.items():
        off = abs(getattr(many, name)[at] - getattr(state, name))
        assert size or not off, f"seed {case.seed}: {name} of {state!r}"
        found.append(off / (close[name] * size) if size else 0.0)
    angle = state.contact_angle
    other = many.contact_angle[at]
    assert math.isnan(angle) == math.isnan(other), f"seed {case.seed}: {state!r}"
    steep = case.scene.slopes == "finite" and case.scene.axisymmetric
    x = state.half_width
    bend = np.abs(np.diff(case.scene.indenter.slope(np.array([x, x * (1 - 4e-16)])))).max()
    tolerance = max(SLOPE if steep else CLOSE, close["half_width"], float(np.nan_to_num(bend)))
    off = 0.0 if math.isnan(angle) else abs(angle - other) / (tolerance * math.pi)
    return [*found, off, many.residual[at] / CLOSE]
