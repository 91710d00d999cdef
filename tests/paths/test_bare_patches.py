"""Patterns of which a patch does not adhere at all: paths of depth of a wedge and a cone.

Beside what adheres the bare patch opens as soon as the profile pulls there, at an edge first.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from discretization import load_path
from energy import ElasticLayer, Patches, Scene, SurfaceEnergies, Wedge

T, ALPHA = math.tan(0.05), math.sqrt(0.02)
DEPTHS = np.array([0.0, 0.05, 0.2, 0.3, 0.06, 0.045, 0.03, 0.01, 0.0, -0.1])
LINE = {"one": Patches([1.0], [0.0, 1.0]), "both": Patches([-1.0, 1.0], [1.0, 0.0, 1.0])}


def path(pattern, geometry, **how):
    """A depth path with l = 1, k = 1."""
    layer, surfaces = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(1.0, 0.01)
    scene = Scene(layer, surfaces, Wedge(0.05), pattern=pattern, geometry=geometry)
    return load_path(scene, depths=DEPTHS, **how)


def half(d):
    """Force of the right half of a wedge at depths less than T, retracted: ∫u dx for x > 0.

    The right line rests against what adheres, the one beside the gap where u' = -T, or at the tip.
    """
    p = (d + ALPHA - T) / T
    q = gap(d)
    start = -T if q else (d - T - d * math.cosh(1)) / math.sinh(1)
    end = (d - T * q) * math.sinh(1 - q) + start * math.cosh(1 - q)  # u' at the edge
    pressed = sum((b - a) * (d - T * (a + b) / 2) for a, b in ((0.0, q), (1.0, p)))
    return pressed + end - start + d - T * p


def gap(d):
    """Where the gap that ends at the edge begins."""

    def over(x):
        return (d - T * x) * math.cosh(1 - x) - T * math.sinh(1 - x) - d + T

    return brentq(over, 0, 0.99, xtol=1e-15) if over(0.0) > 0 else 0.0


@pytest.mark.parametrize("kind", LINE)
def test_a_gap_opens_at_the_edge_of_a_bare_patch(kind):
    found = path(LINE[kind], "line")
    for step in (5, 6, 7, 8):
        d = float(DEPTHS[step])
        beside = half(d) if kind == "both" else d
        assert found.force[step] == pytest.approx(half(d) + beside, rel=1e-9, abs=1e-10)
    assert [event.kind for event in found.events[:3]] == ["touch", "jump", "splitting"]
    assert found.events[2].depth == pytest.approx(T, rel=0, abs=1e-5)


@pytest.mark.parametrize("factor", [1e-6, 1e-9])
@pytest.mark.parametrize("kind", [*LINE, "cone"])
def test_while_it_is_closed_it_is_that_of_a_patch_that_all_but_adheres(kind, factor):
    geometry = "axisymmetric" if kind == "cone" else "line"
    bare = path(LINE.get(kind, LINE["one"]), geometry)
    inside = [1.0, factor, 1.0] if kind == "both" else [factor, 1.0]
    nearly = path(Patches([-1.0, 1.0] if kind == "both" else [1.0], inside), geometry)
    closed = [0, 1, 2, 3, 4, -1]
    scale = 10 * math.sqrt(factor)
    assert bare.force[closed] == pytest.approx(nearly.force[closed], rel=0, abs=scale)
    assert bare.events[1].depth == pytest.approx(nearly.events[1].depth, rel=0, abs=scale)


def test_about_an_axis_it_is_that_of_nodes():
    depths = [0.0, 0.3, -0.005, -0.01, -0.013]
    layer, surfaces = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(1.0, 0.01)
    scene = Scene(layer, surfaces, Wedge(0.05), pattern=LINE["one"], geometry="axisymmetric")
    mesh, one, two = (
        load_path(scene, depths=depths, **how)
        for how in ({}, *({"method": "lattice", "spacing": h} for h in (0.01, 0.005)))
    )
    assert len(mesh.at(3).lines) == 4
    off, finer = (np.abs(nodes.force - mesh.force)[1:].max() for nodes in (one, two))
    assert off < 1e-4 and finer < 0.7 * off
