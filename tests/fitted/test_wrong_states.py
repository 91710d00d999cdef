"""The certificate of the fitted mesh refuses states that are a little wrong, adhesion or not."""

import numpy as np
import pytest

from discretization.certificate import NotCertifiedError
from discretization.fitted.motion import Motion
from discretization.fitted.several import state_of
from discretization.profile import resolve
from discretization.surfaces import surfaces_of
from energy import ElasticLayer, Profile, Scene, SurfaceEnergies

MOVED = 1e-6  # of the width of the contact or gap on the other side of a line
DEPTH = 0.22


def rests(w, geometry):
    """The motion of lines on waves in a bowl, and the lines of a state."""
    profile = Profile(
        lambda x: x * x / 40 - 0.1 * np.cos(2 * x) + 0.1,
        lambda x: x / 20 + 0.2 * np.sin(2 * x),
        extent=(-12, 12),
    )
    layer, surfaces = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(0.1, w)
    scene = Scene(layer, surfaces, profile, geometry=geometry)
    motion = Motion.of(scene, resolve(scene, DEPTH), surfaces_of(scene), DEPTH)
    lines = motion.adhered(DEPTH)
    assert len(lines) >= 4
    return motion, lines


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("w", [0.0, 1e-6])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_line_off_by_a_millionth_of_what_is_beside_it_is_refused(w, geometry, sign):
    motion, lines = rests(w, geometry)
    state_of(motion, lines, DEPTH, "adhered", 1e-9)
    for i, x in enumerate(lines):
        beside = [abs(x - other) for other in lines[max(i - 1, 0) : i + 2] if other != x]
        wrong = (*lines[:i], x + sign * MOVED * min(beside), *lines[i + 1 :])
        if x == 0 and geometry == "axisymmetric":
            continue  # the axis is no line
        with pytest.raises(NotCertifiedError):
            state_of(motion, wrong, DEPTH, "adhered", 1e-9)


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_a_missing_contact_and_a_missing_gap_are_refused(geometry):
    motion, lines = rests(0.0, geometry)
    for i in range(0, len(lines), 2):
        with pytest.raises(NotCertifiedError):
            state_of(motion, lines[:i] + lines[i + 2 :], DEPTH, "adhered", 1e-9)
    for i in range(1, len(lines) - 1, 2):
        with pytest.raises(NotCertifiedError):
            state_of(motion, lines[:i] + lines[i + 2 :], DEPTH, "adhered", 1e-9)


def test_a_missing_contact_is_refused_with_adhesion():
    motion, lines = rests(1e-6, "line")
    with pytest.raises(NotCertifiedError):
        state_of(motion, lines[2:], DEPTH, "adhered", 1e-9)
