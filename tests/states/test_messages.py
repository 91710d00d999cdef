"""What the first mistakes of a new user are answered with, and what is refused in words."""

import math
import os
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from support import example_scenes
from support.example_scenes import (
    ALPHA,
    DELTA0,
    SCENE,
    L,
    adhesive,
    dimple,
    plain,
    steep,
    turned,
    two,
    wavy,
)
from support.repository import ROOT

from discretization import Lattice, load_path, minimise
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    Patches,
    Plane,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)


@pytest.mark.parametrize("value", ["2.5e3", True, np.True_, b"1", None])
def test_texts_and_truth_values_are_no_numbers(value):
    with pytest.raises(ValueError, match=r"^E = .* is not a number; give one finite number$"):
        ElasticLayer(value, 0.3, 5e-6)
    with pytest.raises(ValueError, match="is not finite"):
        ElasticLayer(np.nan, 0.3, 5e-6)


def parabola(x):
    return np.square(x) / 20


@pytest.mark.parametrize(
    ("function", "why"),
    [
        (lambda x: max(x * x, 0.0), "truth value of an array"),
        (lambda x: float(x) ** 2, "TypeError"),
        (lambda x: 0.0, "it gives one number"),
        (lambda x: parabola(x)[:1], r"it gives \(1,\)"),
    ],
)
@pytest.mark.parametrize("name", ["height", "slope"])
def test_profiles_must_take_arrays(name, function, why):
    given = {"height": parabola, "slope": parabola, name: function}
    with pytest.raises(ValueError, match=f"^{name} = .* must take an array .*{why}"):
        Profile(**given, extent=(1.0, 2.0))
    with pytest.raises(ValueError, match=f"^{name} = .* must take an array .*{why}"):
        plain(type("Own", (), {n: staticmethod(f) for n, f in given.items()})())


def test_swapped_energies_are_asked_about():
    swapped = SurfaceEnergies.from_work(6e-5, 0.07)
    layer = ElasticLayer(2.5e3, 0.3, 5e-6)
    asked = "are the two swapped"
    found = minimise(Scene(layer, swapped, Parabola(0.02)), 3e-7)
    (warning,) = (told for told in found.warnings if asked in told)
    assert "2w/γ₁" in warning
    assert "Young's law (8) has no contact angle" in warning
    with pytest.raises(ValueError, match=asked):
        _ = swapped.contact_angle
    told = str(found)
    assert "angle        none by Young's law, w > 2γ₁" in told
    assert "θ = -" not in told
    with pytest.raises(ValueError, match=asked):
        Scene(layer, swapped, Parabola(0.02), slopes="finite")
    for gamma1, w in ((0.03, 0.07), (0.0, 0.07)):  # as rubber may have them
        state = minimise(Scene(layer, SurfaceEnergies.from_work(gamma1, w), Parabola(0.02)), 3e-7)
        assert not any(asked in told for told in state.warnings)
        assert state.warnings


@pytest.mark.parametrize(
    "command", [["energy.py"], ["-c", "import discretization"], ["-m", "studies", "run"]]
)
def test_a_file_that_hides_the_package_energy_is_named(command, tmp_path):
    hiding = tmp_path / "energy.py"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    hiding.write_text("from discretization import minimise" if len(command) == 1 else "x = 1\n")
    command = [sys.executable, *command]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True)
    told = done.stderr.decode()
    assert f"{hiding} hides the package energy" in told.splitlines()[-1]
    assert done.returncode
    assert ("Traceback" in told) == ("studies" not in command)


FINITE = replace(SCENE, slopes="finite")
OPEN_ENDED = adhesive(Sampled(np.linspace(-L, L, 9), np.array([3, 1, 2, 0, 2, 0, 3, 1, 0]) * 1e-3))
OPENING = adhesive(Parabola(0.02), w=0.001, opening=0.003)
PATTERN = replace(SCENE, pattern=Patches([-L, 1.5 * L], [1.0, 0.5, 0.8]))
RAMP = adhesive(Profile(lambda x: 0.1 * x, lambda x: 0.1 + 0 * x))
HOLE = adhesive(Profile(lambda x: np.where(np.abs(x) < 0.003, x**2, np.nan), lambda x: 2 * x))
BUMPY = Profile(lambda x: 1e-5 * np.cos(900 * np.asarray(x)), lambda x: 0 * x, (-0.02, 0.02))
ROUND_WAVES = turned(example_scenes.rippled(0.9, 2 * L, 0.7 * DELTA0, (-12 * L, 12 * L)))
LIPS = steep(two(5 * L, 0.1 * L, 0.1 * L))
NODES = {"method": "lattice", "spacing": L / 50}
LOWEST = {"branch": "global"}
SEARCH = {"method": "shortest_path", "spacing": L / 20, **LOWEST}
ORACLE = {"method": "oracle", "spacing": L / 400, **LOWEST}
FITTED = ": nodes support.* use method='fitted'"
AXIS = "geometry = 'axisymmetric'" + FITTED
SPHERE = turned(Parabola(0.02))
STRIPES = Patches.stripes(0.004, 0.25, 1.0, 0.1)
BENT = Sampled(np.array([0, 0.5, 0.6, 2, 9]) * L, DELTA0 * np.array([0, 0.02, 0.1, 1.6, 12]))
RINGS = [turned(dimple()), turned(dimple(), w=0.0), replace(SPHERE, pattern=STRIPES)]
RINGS += [replace(SPHERE, slopes="finite")]
STATES = [  # scene, depth, options, words
    (SCENE, math.nan, {}, "depth = nan"),
    (SCENE, "1 mm", {}, "depth = '1 mm'"),
    ("a scene", 1e-3, {}, "scene = 'a scene'"),
    (SCENE, 1e-3, {"method": "magic"}, "'auto', 'lattice'"),
    (SCENE, 1e-3, {"branch": "lucky"}, "'adhered', 'global'"),
    (SCENE, 1e-3, {"rtol": 0.0}, "rtol = 0.0"),
    (SCENE, 1e-3, {"rtol": 2.0}, "rtol = 2.0"),
    (SCENE, 1e-3, {"method": "lattice"}, "spacing = None"),
    (SCENE, 1e-3, {"method": "lattice", "spacing": 0.0}, "spacing = 0.0"),
    (SCENE, 1e-3, {"spacing": 1e-4}, "method='lattice'"),
    (SCENE, 0.0, {"method": "fitted", "spacing": L}, "has no spacing"),
    (SCENE, 0.0, {"method": "shortest_path", **LOWEST}, "spacing = None"),
    (SCENE, 0.0, {**SEARCH, "branch": "adhered"}, "branch = 'adhered'"),
    (SCENE, 0.0, {**ORACLE, "branch": "adhered"}, "branch = 'adhered'"),
    (SCENE, 0.0, ORACLE, "too many for integers"),
    (adhesive(Parabola(1.0), gamma1=0.0), 0.0, ORACLE, "gamma1 = 0"),
    (adhesive(BUMPY, gamma1=0.0), 0.0, NODES, "gamma1 = 0" + FITTED),
    (OPEN_ENDED, 0.0, LOWEST, "not known any more"),
    (OPEN_ENDED, 0.0, {**NODES, **LOWEST}, "not known any more"),
    (RAMP, 0.0, {"method": "lattice", "spacing": 0.1}, "no lowest point.*rise in the end.*extent"),
    (HOLE, 1e-3, {"method": "lattice", "spacing": 1e-4}, "is not finite"),
    (plain(FlatPunch(1.0)), 0.1, {"method": "lattice", "spacing": 4.6}, "4.6 leaves one node"),
    (plain(Plane().tilted(0.1)), 0.1, {"method": "lattice", "spacing": 0.1}, "no lowest point"),
    (plain(Parabola(10.0)), 0.1, {"method": "lattice", "spacing": 1e-300}, "spacing"),
    (adhesive(Plane()), 0.0, SEARCH, "end to the plane"),
    # finite slopes
    (FINITE, 0.0, SEARCH, "slopes = 'finite'"),
    (replace(OPEN_ENDED, slopes="finite"), 0.0, LOWEST, "slopes='small'"),
    (replace(wavy(), slopes="finite"), 2.3 * DELTA0, LOWEST, "slopes = 'finite'.*slopes='small'"),
    (LIPS, DELTA0, {**NODES, **LOWEST}, "slopes='small'"),
    (LIPS, DELTA0, NODES, "states of one contact only: use method='fitted'"),
    (FINITE, 1e-3, {**NODES, "spacing": 1e-6 * L}, "nodes on a free surface.* use method='fitted'"),
    (replace(OPENING, slopes="finite"), 1e-3, NODES, "slopes = 'finite'" + FITTED),
    (replace(PATTERN, slopes="finite"), 1e-3, NODES, "slopes = 'finite'" + FITTED),
    (steep(FlatPunch(0.03), 1.5), -1.35 * L, NODES, "turn over; use method='fitted'"),
    (steep(Plane(), 1.5), -1.35 * L, NODES, "turn over; use method='fitted'"),
    (steep(Wedge(0.03), 1.5), -1.35 * L, NODES, "turn over; use method='fitted'"),
    (steep(FlatPunch(0.03), 1.4), -1.5 * L, {}, "depth = .* at the contact line x = .* turn over"),
    (plain(Wedge(0.1), w=1.3, slopes="finite"), 0.1, {}, "turn over and be no graph"),
    # rotational symmetry
    (turned(BUMPY, gamma1=0.0), 0.0, NODES, AXIS),
    *((scene, 0.1 * DELTA0, NODES, AXIS) for scene in RINGS),
    *((scene, 0.1 * DELTA0, {**NODES, **LOWEST}, AXIS) for scene in (RINGS[0], turned(BENT))),
    *((turned(Parabola(0.02)), 0.0, given, AXIS) for given in (ORACLE, SEARCH)),
    (replace(ROUND_WAVES, slopes="finite"), 0.5 * DELTA0, LOWEST, "only found for slopes='small'"),
    (replace(ROUND_WAVES, slopes="finite"), 0.5 * DELTA0, {}, "between two is not implemented"),
    # what depends on the way
    (OPENING, 1e-3, LOWEST, "opening = .* use branch='adhered'"),
    (OPENING, 1e-3, {**NODES, **LOWEST}, "opening = .* use branch='adhered'"),
    (PATTERN, 1e-3, LOWEST, "pattern = .* depends on the path; use branch='adhered'"),
    (PATTERN, 1e-3, {**NODES, **LOWEST}, "pattern = .* use branch='adhered'"),
    (replace(OPENING, indenter=Plane()), 1e-3, NODES, "opening = "),
]


@pytest.mark.parametrize(("scene", "depth", "options", "words"), STATES)
def test_a_state_that_is_not_answered_is_refused_in_words(scene, depth, options, words):
    with pytest.raises(ValueError, match=words):
        minimise(scene, depth, **options)


STEPS = {"depths": [1e-3]}
TAUGHT = adhesive(Sampled([-0.01, 0.0, 0.01], [0.0025, 0.0, 0.0025]))
PATHS = [  # scene, options, words
    (SCENE, {}, "exactly one of depths, forces, drives"),
    (SCENE, {"depths": [0.1], "forces": [1.0]}, "exactly one of"),
    (SCENE, {"depths": []}, "depths = .* at least one finite number"),
    (SCENE, {"depths": [0.1, math.nan]}, "at least one finite"),
    (SCENE, {"depths": 0.1}, "must be a list"),
    (SCENE, {"forces": "x"}, "forces = 'x'"),
    (SCENE, {"forces": [-1e9]}, r"forces\[0\] = -1000000000.0 is below the pull-off force"),
    (SCENE, {"depths": [0.1], "rtol": math.nan}, "rtol = nan"),
    (SCENE, {"depths": [0.1], "rtol": 2.0}, "rtol = 2.0 is outside"),
    (SCENE, {"drives": [0.1]}, "machine_stiffness = None with drives"),
    (SCENE, {"drives": [0.1], "machine_stiffness": 0.0}, "machine_stiffness = 0.0 must be posit"),
    (SCENE, {"depths": [0.1], "machine_stiffness": 3.0}, "machine_stiffness = 3.0 with depths"),
    (Parabola(1.0), STEPS, "is not a Scene"),
    (adhesive(Plane()), STEPS, "a profile with a lowest point"),
    (SCENE, {**STEPS, "method": "fitted", "spacing": 1e-5}, "spacing = 1e-05 with method = 'fi"),
    (SCENE, {**STEPS, "method": "mesh"}, "method = 'mesh'"),
    (SCENE, {**STEPS, "method": "lattice", "spacing": -1.0}, "spacing = -1.0"),
    (adhesive(Parabola(0.02), gamma1=0.0), {**STEPS, **NODES}, "gamma1 = 0" + FITTED),
    (steep(FlatPunch(0.03)), {**STEPS, **NODES}, "slopes = 'finite'" + FITTED),
    (TAUGHT, {"depths": [0.1], **NODES}, "spreads the contact to x = "),
    (example_scenes.rough(1), {**STEPS, **NODES, "spacing": 1e-9 * L}, "puts .* nodes"),
    *((scene, {**STEPS, **NODES}, AXIS) for scene in RINGS),
]


@pytest.mark.parametrize(("scene", "options", "words"), PATHS)
def test_a_path_that_is_not_followed_is_refused_in_words(scene, options, words):
    with pytest.raises(ValueError, match=words):
        load_path(scene, **options)


def test_a_scan_known_too_little_is_refused():
    """A bump on a table, as a profilometer scans it: touching it spreads the contact at once."""
    x = np.linspace(0, 2e-3, 400)
    bump = Sampled(x, 6e-6 * np.exp(-(((x - 1e-3) / 3e-4) ** 2)) + 5e-8 * np.sin(x / 3e-5))
    layer = ElasticLayer(2.5e3, 0.3, 5e-6)
    surfaces = SurfaceEnergies.from_work(0.07, 6e-5)
    scene = Scene(layer, surfaces, bump)
    words = "cannot be reached: d = -4.8.*e-08, on the way there, .* upside down"
    with pytest.raises(ValueError, match=f"^depth = 3e-07 {words}") as caught:
        minimise(scene, 3e-7)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    with pytest.raises(ValueError, match=f"^depths = 0.0 to 3e-07 {words}"):
        load_path(scene, depths=[0.0, 3e-7])


def test_nodes_about_an_axis_begin_on_it():
    with pytest.raises(ValueError, match=r"origin = 0\.3: with rotational"):
        Lattice.of(turned(Parabola(0.02)), 0.1, 0.3)


def test_next_to_what_is_refused_there_is_an_answer():
    """At an angle of nearly 90°, deep inside the layer, and up to the end of a profile; rings."""
    for scene in RINGS:
        assert minimise(scene, 0.1 * DELTA0).contacts.size
    near = minimise(steep(FlatPunch(0.03), 1.4), -1.41 * L)
    assert near.certificate.ok
    assert near.angle_deficit == pytest.approx(2 * math.asin(1.41 / 2), rel=1e-10, abs=0)
    assert minimise(steep(FlatPunch(0.03), 1.5), -1.3 * L, **NODES).certificate.ok
    assert minimise(steep(Parabola(1.0)), 5 * L, **NODES).certificate.ok
    upright = minimise(plain(Wedge(0.1), w=1.0, slopes="finite"), 0.2 - math.sqrt(2))
    assert upright.contact_angle == pytest.approx(math.pi / 2, rel=1e-10, abs=0)
    x = np.linspace(-0.01, 0.01, 201)
    ended = adhesive(Sampled(x, x**2) + FlatPunch(0.009))
    assert minimise(ended, 0.01, method="lattice", spacing=1e-4).half_width == 0.009
    arc = Circle(2 * L / ALPHA)
    assert 0.999 < minimise(adhesive(arc), 400 * arc.R).half_width / arc.R < 1
