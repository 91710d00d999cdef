"""One scene of every kind that a load path can meet, by name."""

import math
from dataclasses import replace

import numpy as np

from energy import Circle, FlatPunch, Parabola, Patches, SurfaceEnergies, Wedge

from .example_scenes import ALPHA, DELTA0, L, adhesive, dimple, exact, rippled, steep, turned, wavy

A = 1.7 * L  # a radius of contacts about an axis
STRONGER = SurfaceEnergies.from_work(0.07, 0.003)
PATCHES = Patches(np.array([-1.3, -0.45, 0.15, 0.8]) * L, (1.0, 0.5, 0.9, 0.4, 1.0))
RINGS = Patches(np.array([0.4, 0.9, 1.5]) * L, (1.0, 0.3, 1.4, 0.6))
CRESTS = adhesive(rippled(0.03, 0.6 * L, 0.17 * DELTA0, (-8 * L, 8 * L)))
SPHERE = turned(Parabola(A / (0.9 * ALPHA)))
RIPPLED_SPHERE = turned(rippled(0.9, 2 * L, 0.7 * DELTA0, (0, 12 * L)))  # several rings
STEEP_CRESTS = replace(wavy(crests=3), slopes="finite")
PATTERNED = ("ripples, pattern", "ripples, both")  # several contacts over a pattern: on nodes alone
SPHERE_OPENING = SurfaceEnergies.from_work(0.07, 0.004)
SCENES = {
    "parabola": adhesive(Parabola(0.02)),
    "tilted": adhesive(Parabola(0.02).tilted(0.05)),
    "wedge": adhesive(Wedge(0.05).shifted(0.0123)),
    "punch": adhesive(FlatPunch(0.03)),
    "tilted punch": adhesive(FlatPunch(0.03).tilted(0.05)),
    "sharp edge": adhesive(FlatPunch(0.03).tilted(0.3)),
    "opening": adhesive(Parabola(0.02), w=0.001, opening=0.003),
    "opening, edge": adhesive(Parabola(0.02) + FlatPunch(0.35 * L), w=0.001, opening=0.003),
    "opening alone": adhesive(Parabola(0.02), w=0.0, opening=0.002),
    "springs": adhesive(Parabola(0.02), gamma1=0.0),
    "springs, opening": adhesive(Parabola(0.02), gamma1=0.0, w=0.0, opening=0.002),
    "layer": exact(Parabola(0.02)),
    "layer, opening": exact(Parabola(0.02), w=0.001, opening=0.003),
    "layer, punch": exact(FlatPunch(0.03)),
    "layer, sphere": replace(exact(Parabola(0.02)), geometry="axisymmetric"),
    "crests": wavy(crests=3),
    "ripples": CRESTS,
    "ripples, opening": replace(CRESTS, opening=STRONGER),
    "ripples, pattern": replace(CRESTS, pattern=PATCHES),
    "ripples, both": replace(CRESTS, opening=STRONGER, pattern=PATCHES),
    "sphere": SPHERE,
    "sphere, opening": replace(SPHERE, opening=SPHERE_OPENING),
    "cone": turned(Wedge(math.atan(0.6 * ALPHA))),
    "arc": turned(Circle(A / (0.9 * ALPHA))),
    "cylinder": turned(FlatPunch(A)),
    "rings of a pattern": replace(turned(Parabola(0.17)), pattern=RINGS),
    "dimple": turned(dimple()),
    "steep parabola": steep(Parabola(0.02), 0.3),
    "steep opening": adhesive(Parabola(0.02), opening=0.005, slopes="finite"),
}
ON_NODES = {  # with the options of nodes: a tip lets go while links are as wide as its contact
    name: {"method": "lattice", "spacing": L / (60 if scene.axisymmetric else 240)}
    for name, scene in SCENES.items()
    if scene.gamma1 and name[:5] not in ("steep", "rings", "dimpl", "layer")
}
