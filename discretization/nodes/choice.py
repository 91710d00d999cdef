"""How far apart nodes should be for a scene, where nobody says.

So many nodes in each of the lengths on which something varies: the elastocapillary length l, half
waves of the profile from one extreme to the next, patches of a pattern, an ended body, and the
contact that begins at a lowest point of curvature 1/R, whose lines rest where the slope is about
δ₀/l: δ₀R/l to each side.

Depths are positive down into the layer, heights f of the profile upwards: at a depth d the indenter
is in the surface where f < d, and adheres at most where f < d + δ₀. `Resolved` has samples of the
profile at increasing x, a corner twice, with the slope on its left and then on its right; its
`touch` is the least height, the depth of first touch. `resolve(scene, depth)` takes as many as
show all that may be in contact at that depth.

Of a scene, `elastocapillary_length` is l = √(γ₁/k), and `critical_separation` δ₀ = √(2w/k), of a
contact that closes; `opened` is the scene with the surface energies of contacts that open. `extent`
of an indenter is (low, high), where its profile is known, and `walls` are those of its ends at
which the body itself ends. A `pattern` has the x of its `edges`, or is None.
"""

import warnings
from typing import NamedTuple

import numpy as np

from discretization.certificate import AccuracyWarning
from discretization.profile import Resolved, resolve
from energy import Scene
from energy.arrays import Array


class NodesPerLength(NamedTuple):
    """How many nodes there are in each length on which something varies.

    Depths, forces and energies are those of nodes, of second order in the spacing. With twice as
    many nodes in l the depths and forces of events of three random paths over patterns change by
    up to 2e-3 of the largest, the energies that they release by up to 7e-3, and it takes 1.6 times
    as long: `python -m tests.sensitivity discretization.nodes.choice` (which finds more where the
    programme has the very depth of an event).

    Attributes
    ----------
    elastocapillary : int
        Nodes in l: then events are right to about 2e-3 of the energy.
    half_wave : int
        Nodes from one extreme of the profile to the next.
    first_contact : int
        Nodes on each side of a contact that has just begun.
    slight : float
        Of δ₀, or of the depth of indentation without adhesion: contacts do not feel lower waves.
        Half or twice of it gives the same nodes in these paths.
    most : int
        Nodes at most: with these a path takes some seconds.
    """

    elastocapillary: int = 32
    half_wave: int = elastocapillary // 2
    first_contact: int = 8
    slight: float = 1e-3
    most: int = 200_000


_NODES = NodesPerLength()


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
        If that is more than what the profile needs, as the nodes would be too many.
    """
    profile = resolve(scene, depth)
    indenter = scene.indenter
    reach = scene.opened.critical_separation
    pressed = max(depth - profile.touch, 0.0)
    size = reach or pressed or scene.elastocapillary_length
    level = max(depth, profile.touch) + reach  # heights that may be in contact
    wanted = [scene.elastocapillary_length / _NODES.elastocapillary]
    wanted += (_half_waves(profile, level, _NODES.slight * size) / _NODES.half_wave).tolist()
    wanted += (_first_contacts(scene, profile, level) / _NODES.first_contact).tolist()
    if len(indenter.walls) == 2:
        wanted.append(float(np.ptp(indenter.extent)) / _NODES.half_wave)
    if scene.pattern is not None:
        wanted += (np.diff(scene.pattern.edges) / _NODES.half_wave).tolist()
    spacing = min(wanted)
    least = float(np.ptp(profile.x[[0, -1]])) / _NODES.most
    if spacing < least:
        warnings.warn(
            f"the profile needs nodes {spacing!r} apart; with {_NODES.most} of them they are "
            f"{least!r} apart, and contacts may be missed; give it a smaller extent, or a spacing",
            AccuracyWarning,
            stacklevel=3,
        )
        return least
    return spacing


def _half_waves(profile: Resolved, level: float, slight: float) -> Array:
    """Lengths from one local extreme to the next (n,), one of both no higher than `level`.

    Ends of the profile are extremes, too. Without those between which f differs by no more than
    `slight`, nor jumps at one x.
    """
    slope_changes_sign = np.diff(np.sign(profile.slope)) != 0
    turns = np.flatnonzero(slope_changes_sign)
    ends = [0, profile.x.size - 1]
    extremes = np.unique(np.append(turns, ends))
    heights = profile.f[extremes]
    lengths = np.diff(profile.x[extremes])
    rises = np.abs(np.diff(heights))
    is_low = np.minimum(heights[1:], heights[:-1]) <= level
    return np.asarray(lengths[is_low & (rises > slight) & (lengths > 0)])


def _first_contacts(scene: Scene, profile: Resolved, level: float) -> Array:
    """δ₀R/l of the local minima no higher than `level` (n,); none without adhesion, and at corners.

    From the minimum of a parabola x²/2R the slope rises to δ₀/l, which is that of the free surface
    at a line, within δ₀R/l. 1/R is found by the slopes of the samples on both sides of a minimum.
    """
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
