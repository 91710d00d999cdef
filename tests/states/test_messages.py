"""What the first mistakes of a new user are answered with."""

import os
import subprocess
import sys

import numpy as np
import pytest
from scenes import ROOT, plain

from discretization import minimise
from energy import ElasticLayer, Parabola, Profile, Scene, SurfaceEnergies
from studies.scenes.file import load


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
    (warning,) = (
        told
        for told in minimise(Scene(layer, swapped, Parabola(0.02)), 3e-7).warnings
        if asked in told
    )
    assert "2w/γ₁" in warning and "there is no contact angle" in warning
    with pytest.raises(ValueError, match=asked):
        _ = swapped.contact_angle
    told = str(minimise(Scene(layer, swapped, Parabola(0.02)), 3e-7))
    assert "angle        none with small slopes" in told and "θ = -" not in told
    with pytest.raises(ValueError, match=asked):
        Scene(layer, swapped, Parabola(0.02), slopes="finite")
    for gamma1, w in ((0.03, 0.07), (0.0, 0.07)):  # as rubber may have them
        state = minimise(Scene(layer, SurfaceEnergies.from_work(gamma1, w), Parabola(0.02)), 3e-7)
        assert not any(asked in told for told in state.warnings) and state.warnings


@pytest.mark.parametrize("start", ["from discretization import minimise", None])
def test_a_file_that_hides_the_package_energy_is_named(start, tmp_path):
    hiding = tmp_path / "energy.py"
    hiding.write_text(start or "x = 1\n")
    for command in (
        [hiding] if start else [["-c", "import discretization"], ["-m", "studies", "run"]]
    ):
        command = command if isinstance(command, list) else [command]
        given = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(
            [sys.executable, *command], cwd=tmp_path, env=given, capture_output=True
        )
        told = done.stderr.decode()
        assert f"{hiding} hides the package energy" in told.splitlines()[-1] and done.returncode
        assert ("Traceback" in told) == ("studies" not in command)


SCENE = """# a scene
depth = 1e-6
[layer]
E = 3e3
nu = 0.3
h = 5e-6

[surfaces]
gamma1 = 0.07
w = 6e-5
[indenter]
shape = "parabola"
R = 0.1
"""


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("1e-6", "'1e-6'", 2),
        ("h = 5e-6", "h = '5e-6'", 6),
        ("E = 3e3", "E = 3,5e3", 4),
        ("E = 3e3", "E = -3e3", 4),
        ("E = 3e3\n", "", 3),
        ("[surfaces]", "[surface]", 8),
        ("w = 6e-5", "w = { from = 1e-5, to = 7e-5, steps = 5 }", 10),
        ("R = 0.1", "R = 0.1\nradius = 1", 14),
    ],
)
def test_what_is_wrong_in_a_scene_file_has_its_line(old, new, line, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.replace(old, new, 1), "utf-8")
    with pytest.raises(ValueError, match=rf"scene.toml: .*\(at line {line}\b"):
        load(path)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_scene_file_may_begin_with_a_byte_order_mark(newline, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE, "utf-8-sig", newline=newline)
    assert load(path).scene.work_of_adhesion == 6e-5
    path.write_text(SCENE.replace("0.1", "'0.1'"), "utf-8-sig", newline=newline)
    with pytest.raises(ValueError, match=r"\(at line 13\)"):
        load(path)
