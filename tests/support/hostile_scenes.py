"""Random scenes, hostile ones included, and what counts as an answer.

A few hundred examples; ELASTOCAP_FUZZ=20000 asks for as many, at random.
"""

import math
import os
import re
import warnings

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from discretization import AccuracyWarning, NotCertifiedError
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

ASKED = int(os.environ.get("ELASTOCAP_FUZZ", "0"))


fuzz = settings(
    deadline=None,
    derandomize=not ASKED,
    max_examples=ASKED or 250,
    database=None,
    suppress_health_check=list(HealthCheck),
)


HOUSE_STYLE = re.compile(r" = |\] |has the attributes|exactly one of|have shapes")


def answered(question):
    """Its answer; None for a documented refusal. Anything else is raised."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", AccuracyWarning)
        try:
            return question()
        except (NotCertifiedError, ValueError) as problem:
            message = str(problem)
    assert HOUSE_STYLE.search(message), message
    return None


class Dice:
    """Random choices from one seed."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)

    def between(self, low, high):
        return float(self.rng.uniform(low, high))

    def decade(self, low, high):
        return 10 ** self.between(low, high)

    def one_of(self, *values):
        return values[self.rng.integers(len(values))]

    def chance(self, probability):
        return bool(self.rng.random() < probability)


dice = st.integers(0, 2**62).map(Dice)


def body(dice, ell, rise):
    """An indenter with a slope of the size of `rise` at a distance of some l."""
    a = ell * dice.decade(-2, 2)
    n = dice.one_of(1, 2, 3, 4, 2.5, 20)
    made = dice.one_of(
        lambda: Plane(),
        lambda: FlatPunch(a),
        lambda: Wedge(math.atan(rise)),
        lambda: Parabola(a / rise),
        lambda: PowerLaw(rise / n * a ** (1 - n), n),
        lambda: PowerLaw(rise / n * a ** (1 - n), n),
        lambda: rough(dice, a, rise),
    )()
    changes = (
        lambda: made.shifted(dice.between(-3, 3) * a),
        lambda: made.tilted(dice.between(-0.5, 0.5) * rise),
        lambda: made + FlatPunch(2 * a),
        lambda: made + Parabola(a / rise),
        lambda: Profile(made.height, made.slope, made.extent, made.corners, made.convex),
    )
    return dice.one_of(*changes)() if dice.chance(0.3) else made


def rough(dice, a, rise):
    """Measured profiles: noise, plateaus, jumps, kinks."""
    n = int(dice.rng.integers(3, 40))
    x = a * (np.sort(dice.rng.uniform(-4, 4, n)) if dice.chance(0.5) else np.linspace(-4, 4, n))
    z = rise / (2 * a) * x * x
    z = z + dice.one_of(0.0, 1e-6, 0.1) * rise * a * dice.rng.normal(size=n)
    if dice.chance(0.3):
        z = np.maximum(z, 0.1 * rise * a)
    if dice.chance(0.3):
        z = z + rise * a * (x > a)
    return Sampled(x, z, kind=dice.one_of("linear", "smooth"))


def scene_and_depth(dice):
    """A scene over many decades, and a displacement of its to measure depths by."""
    ell = dice.decade(-9, 9)
    stress = dice.decade(-9, 9)
    layer = ElasticLayer(stress, dice.one_of(0.0, 0.3, 0.4999, -0.9), ell * dice.decade(-1, 1))
    gamma1 = layer.stiffness * ell**2
    work = dice.one_of(0.0, 1e-12, 1e-6, 1e-2, 0.3, 1.0, 1.9, 10.0)
    slopes = dice.one_of("small", "small", "finite")
    surfaces = SurfaceEnergies.from_work(0.0 if dice.chance(0.1) else gamma1, work * gamma1)
    rise = math.sqrt(work) * dice.decade(-1, 1) or dice.decade(-4, 0)
    indenter = body(dice, ell, rise)
    scene = answered(lambda: Scene(layer, surfaces, indenter, slopes=slopes))
    return scene, max(scene.critical_separation, rise * ell) if scene else 0.0


def depth_of(dice, scene, unit):
    """Any depth, or one near letting go."""
    if dice.chance(0.7):
        return unit * dice.between(-2, 2) * dice.one_of(1, 10)
    near = dice.one_of(-1.0, -1 + 1e-12, -1 - 1e-12, -1 + 1e-6, 0.0, 1e-12, -1e-12)
    return near * scene.critical_separation


def sound(state):
    """No NaN, certified, consistent."""
    assert state.certificate.ok
    numbers = (state.half_width, state.force, state.energy)
    assert not any(map(math.isnan, (*numbers, *state.error_estimate.values())))
    assert (state.contacts[:, 0] <= state.contacts[:, 1]).all()
    if math.isfinite(state.half_width):
        assert all(map(math.isfinite, numbers))
        reach = max(state.half_width, state.scene.elastocapillary_length)
        x = np.concatenate([state.contacts.ravel(), np.linspace(-5, 5, 11) * reach])
        assert np.isfinite(state.displacement(x)).all()
        assert np.isfinite(state.pressure(x)).all()
    assert str(state)
