"""Load paths about an axis: the line of a built-in shape is found by itself, that of the same shape
given by two functions among any number of lines; both are held against each other and their energy
balance."""

import numpy as np
import pytest

from discretization import load_path
from energy import ElasticLayer, FlatPunch, Parabola, Profile, Scene, SurfaceEnergies, Wedge

GAMMA1, WORK = 0.04, 2e-4
SHAPES = {"sphere": Parabola(1.0), "cone": Wedge(0.05), "steep cone": Wedge(0.3)}
DEPTHS = np.concatenate([np.linspace(-0.001, 0.05, 10), np.linspace(0.05, -0.05, 25)])
PROGRAMMES = {
    "depth": {"depths": DEPTHS},
    "load": {"forces": np.concatenate([np.linspace(0, 0.01, 4), np.linspace(0.01, -0.02, 9)])},
    "machine": {
        "drives": np.concatenate([np.linspace(0, 0.1, 5), np.linspace(0.1, -0.2, 11)]),
        "machine_stiffness": 0.2,
    },
}


def scene(indenter, opening=None, slopes="small"):
    surfaces = SurfaceEnergies.from_work(GAMMA1, WORK)
    opened = None if opening is None else SurfaceEnergies.from_work(GAMMA1, opening * WORK)
    layer = ElasticLayer(1.0, 0.0, 1.0)
    return Scene(layer, surfaces, indenter, slopes, opened, geometry="axisymmetric")


def same(one, other):
    """Whether two paths have the same states and events, and balance their energy."""
    known = np.isfinite(one.depth)
    assert (known == np.isfinite(other.depth)).all()
    for name in ("depth", "force", "half_width", "energy"):
        ours, theirs = (getattr(path, name)[known] for path in (one, other))
        assert np.abs(ours - theirs).max() <= 1e-9 * np.abs(ours).max()
    assert [event.kind for event in one.events] == [event.kind for event in other.events]
    size = np.abs(one.energy).max()
    for ours, theirs in zip(one.events, other.events, strict=True):
        assert abs(ours.depth - theirs.depth) <= 1e-8 * np.abs(one.depth[known]).max()
        # a rounding of the depth moves the line at a fold by its root, against two works
        assert abs(ours.energy_released - theirs.energy_released) <= 1e-6 * size
    for path in (one, other):
        assert abs(path.work() - path.dissipated) <= 1e-9 * size


@pytest.mark.parametrize(
    ("name", "opening", "control"),
    [
        *((name, opening, "depth") for name in SHAPES for opening in (None, 2.0)),
        ("sphere", None, "load"),
        ("steep cone", None, "load"),
    ],
)
def test_a_line_by_itself_and_among_others(name, opening, control):
    shape = SHAPES[name]
    corners = shape.corners
    functions = Profile(shape.height, shape.slope, corners=corners, extent=(-4, 4))
    ours, theirs = (
        load_path(scene(own, opening), **PROGRAMMES[control]) for own in (shape, functions)
    )
    same(ours, theirs)


def test_finite_slopes():
    shape = Parabola(1.0)
    functions = Profile(shape.height, shape.slope, extent=(-4, 4))
    depths = np.concatenate([np.linspace(0, 0.05, 6), np.linspace(0.05, -0.05, 12)])
    same(*(load_path(scene(own, slopes="finite"), depths=depths) for own in (shape, functions)))


def test_a_cylinder_lets_go_at_once_however_it_is_held():
    for programme in PROGRAMMES.values():
        path = load_path(scene(FlatPunch(0.3)), **programme)
        assert path.events[-1].kind in ("detachment", "pull-off")
        assert path.events[-1].before.half_width == 0.3
        assert abs(path.work() - path.dissipated) <= 1e-9 * np.abs(path.energy).max()


def test_a_path_does_not_go_on_beyond_the_steepest_surface():
    """Also where it comes back before it ends: what is asked for in between is judged, too."""
    own = scene(FlatPunch(0.3), slopes="finite")
    assert load_path(own, depths=[0.0, 0.2, 0.0]).force[1] > 0
    with pytest.raises(
        ValueError, match=r"at the contact line r = 0\.3 .* inclined by more than 86"
    ):
        load_path(own, depths=[0.0, 0.3, 0.0])
