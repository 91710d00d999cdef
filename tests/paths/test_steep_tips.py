"""Tips too steep to adhere, f' > √(2w/γ₁), in the engine of several contacts: paths of depth."""

import math
from dataclasses import replace

import numpy as np
import pytest

from discretization import load_path
from discretization.surfaces import menisci
from energy import ElasticLayer, Patches, Profile, Scene, SurfaceEnergies, Wedge

DEPTHS = [0.0, 0.1, 0.03, -0.1]


def steep(geometry="axisymmetric", slopes="small"):
    """A wedge or a cone of an angle above √(2w/γ₁)."""
    surfaces = SurfaceEnergies.from_work(1.0, 0.01)
    layer = ElasticLayer(1.0, 0.0, 1.0)
    return Scene(layer, surfaces, Wedge(0.2), slopes=slopes, geometry=geometry)


def profile():
    """The same as a profile that may have several contacts."""
    t = math.tan(0.2)
    return Profile(
        lambda x: t * np.abs(x), lambda x: t * np.sign(x), extent=(-20, 20), corners=[0.0]
    )


@pytest.mark.parametrize(
    ("geometry", "slopes"), [(g, s) for g in ("line", "axisymmetric") for s in ("small", "finite")]
)
@pytest.mark.parametrize("given", ["pattern", "profile"])
def test_a_tip_that_does_not_adhere_is_that_of_one_contact(geometry, slopes, given):
    scene = steep(geometry, slopes)
    more = {"pattern": Patches([1.0], [1.0, 1.0])}
    if given == "profile":
        more = {"indenter": profile()}
    one, several = (load_path(s, depths=DEPTHS) for s in (scene, replace(scene, **more)))
    assert several.force == pytest.approx(one.force, rel=1e-9, abs=1e-12)
    assert several.energy == pytest.approx(one.energy, rel=1e-9, abs=1e-12)
    assert [event.kind for event in several.events] == ["touch", "detachment"]


def test_a_steep_cone_with_finite_slopes_is_followed_to_its_tip():
    scene, depths = steep(slopes="finite"), [0.0, 1e-7, 1e-6, 1e-3, 1e-5, 1e-8, -1e-3]
    one, several = (
        load_path(each, depths=depths)
        for each in (scene, replace(scene, pattern=Patches([1.0], [1.0, 1.0])))
    )
    assert several.force == pytest.approx(one.force, rel=1e-9, abs=1e-18)
    assert [event.kind for event in several.events] == ["touch", "detachment"]


@pytest.mark.parametrize("s", [2.0**-21, 2.0**-33])
@pytest.mark.parametrize("phi", [0.05, -0.5, 1.0])
def test_beside_tiny_radii_the_surface_is_that_of_the_mesh(s, phi):
    radius, inclined = np.array([s]), np.array([phi])
    u, energy = menisci.read(1, radius, inclined)
    solved = menisci.solve(1, radius, np.sin(inclined), 2)
    assert u == pytest.approx(solved.u[:, 0], rel=2e-11)
    assert energy == pytest.approx(solved.energy, rel=2e-11)
