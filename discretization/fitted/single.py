"""The state of a scene that can only have one contact."""

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.alone import Alone
from discretization.fitted.motion import Motion
from discretization.fitted.rest_depths import RestDepths
from discretization.fitted.several import state_of
from discretization.profile import Resolved, breaks
from energy import Scene
from energy.axis import Radial

_UNDECIDED = 1e-7  # of the size of depths: letting go and turning over at once
_ADHERES = np.array([[True], [False]])
_ASIDE = 1e-3  # of l and of the width: so far beyond its lines a contact is judged


def on_one_contact(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium with its contact lines as unknowns, and its error estimate.

    branch "global" of a convex indenter: this state or, before it touches, the detached one,
    whichever has less energy. There is no other: the force on each line grows outwards.
    """
    alone = Alone.of(scene)
    lines, size = alone.lines(depth), alone.size(depth) or 1.0
    if lines:
        state = state_of(motion_of(alone, lines, depth), lines, depth, branch)
        if branch != "global" or state.energy <= 0 or depth > alone.touch:
            return state
    elif abs(float(alone.rest_depth(1, alone.apex)) - depth) <= _UNDECIDED * size:
        alone.solve(1, alone.apex, depth)
    pressed = max(0.0, depth - alone.touch) / size
    return detached(scene, depth, branch, alone.surfaces, Certificate.undeformed(pressed))


def motion_of(alone: Alone, ends: tuple[float, ...], depth: float) -> Motion:
    """What judges a contact with these ends: its profile is convex, few samples resolve it.

    They are the ends, a little beyond the lines, and what cuts it into smooth parts. The size of
    depths is the sum of the terms that cancel in D - d: d, f, and what f' and w add to D.
    """
    scene, sides = alone.scene, np.array(alone.sides)
    indenter, length = scene.indenter, scene.elastocapillary_length
    lines = np.array(ends)[-sides.size :]
    f = np.asarray(indenter.height(lines), float)
    rest, bare = alone.rest_depth(sides, lines, adhesive=_ADHERES)
    terms = abs(depth) + np.abs(f) + np.abs(bare - f) + np.abs(bare - rest)
    profile = Radial(indenter) if scene.axisymmetric else indenter
    aside = _ASIDE * min(length, max(ends[1] - ends[0], _ASIDE * length))
    lo, hi = max(ends[0] - aside, profile.extent[0]), min(ends[1] + aside, profile.extent[1])
    inner = breaks(profile)
    x = {lo, hi, *inner[(inner > lo) & (inner < hi)].tolist()}
    samples = Resolved.of(profile, np.array(sorted(x)))
    rests = RestDepths(scene, samples, alone.surfaces, float(terms.max()) or scene.layer.h)
    return Motion(scene, samples, alone.surfaces, rests)
