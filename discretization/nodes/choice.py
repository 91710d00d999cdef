"""How far apart nodes should be for a scene, where nobody says.

So many nodes in each of the lengths on which something varies: the elastocapillary length l, half
waves of the profile from one extreme to the next, patches of a pattern, an ended body, and the
contact that begins at a lowest point of curvature 1/R, whose lines rest where the slope is about
δ₀/l: δ₀R/l to each side.
"""

import warnings

import numpy as np

from discretization.certificate import AccuracyWarning
from discretization.profile import Resolved, resolve
from energy import Scene
from energy.arrays import Array

_PER_LENGTH = 32  # nodes in l, and in a wave of the profile: events to about 2e-3 of the energy
_PER_HALF_WAVE = _PER_LENGTH // 2
_PER_FIRST_CONTACT = 8  # nodes on each side of a contact that has just begun
_SLIGHT = 1e-3  # of δ₀ or the depth of indentation: contacts do not feel lower waves
_MOST = 200_000  # nodes: some seconds for a path


def chosen_spacing(scene: Scene, depth: float) -> float:
    """A spacing for paths to depths up to this one.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].

    Returns
    -------
    float
        [length].

    Warns
    -----
    AccuracyWarning
        If that is more than what the profile asks for, as the nodes would be too many.
    """
    profile = resolve(scene, depth)
    indenter = scene.indenter
    reach = scene.opened.critical_separation
    pressed = max(depth - profile.touch, 0.0)
    size = reach or pressed or scene.elastocapillary_length
    level = max(depth, profile.touch) + reach  # heights that may be in contact
    wanted = [scene.elastocapillary_length / _PER_LENGTH]
    wanted += (_half_waves(profile, level, _SLIGHT * size) / _PER_HALF_WAVE).tolist()
    wanted += (_first_contacts(scene, profile, level) / _PER_FIRST_CONTACT).tolist()
    if len(indenter.walls) == 2:
        wanted.append(float(np.ptp(indenter.extent)) / _PER_HALF_WAVE)
    if scene.pattern is not None:
        wanted += (np.diff(scene.pattern.edges) / _PER_HALF_WAVE).tolist()
    spacing = min(wanted)
    least = float(np.ptp(profile.x[[0, -1]])) / _MOST
    if spacing < least:
        warnings.warn(
            f"the profile asks for nodes {spacing!r} apart; with {_MOST} of them they are "
            f"{least!r} apart, and contacts may be missed; give it a smaller extent, or a spacing",
            AccuracyWarning,
            stacklevel=3,
        )
        return least
    return spacing


def _half_waves(profile: Resolved, level: float, slight: float) -> Array:
    """Lengths from one local extreme to the next, one of them at most this high above f = 0."""
    turns = np.flatnonzero(np.diff(np.sign(profile.slope)) != 0)
    extremes = np.unique(np.concatenate([[0], turns, [profile.x.size - 1]]))
    lengths = np.diff(profile.x[extremes])
    heights = profile.f[extremes]
    rises = np.abs(np.diff(heights))
    low = np.minimum(heights[1:], heights[:-1]) <= level
    return np.asarray(lengths[low & (rises > slight) & (lengths > 0)])


def _first_contacts(scene: Scene, profile: Resolved, level: float) -> Array:
    """δ₀R/l of the local minima at most this high; none without adhesion, and at corners."""
    angle = scene.critical_separation / scene.elastocapillary_length
    if not angle:
        return np.empty(0)
    x = profile.x
    f = profile.f
    inner = np.arange(1, x.size - 1)
    is_minimum = (f[inner] <= f[inner - 1]) & (f[inner] <= f[inner + 1])
    minima = inner[is_minimum & (f[inner] <= level)]
    corner = (x[minima] == x[minima - 1]) | (x[minima] == x[minima + 1])
    minima = minima[~corner]
    width = x[minima + 1] - x[minima - 1]
    curvature = (profile.slope[minima + 1] - profile.slope[minima - 1]) / width
    return np.asarray(angle / curvature[curvature > 0])
