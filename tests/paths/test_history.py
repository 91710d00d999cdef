"""Histories: saved, read back, continued, and cut off in the middle."""

import itertools
import os
import subprocess
import sys
from dataclasses import fields, replace

import numpy as np
import pytest
from scenes import PLACES, ROOT, adhesive

from discretization import History, load_path
from energy import ElasticLayer, Parabola, PowerLaw, Profile, Sampled, Scene, SurfaceEnergies, Wedge

PROGRAMME = np.r_[np.linspace(-0.001, 0.01, 40), np.linspace(0.01, -0.01, 60)] * 0.7


def identical(a: History, b: History) -> bool:
    """Equal to the last bit."""
    for name in (field.name for field in fields(History)):
        first, second = getattr(a, name), getattr(b, name)
        if isinstance(first, np.ndarray):
            if first.tobytes() != second.tobytes():
                return False
        elif name == "events":
            if repr(tuple(map(plain, first))) != repr(tuple(map(plain, second))):
                return False
        elif name != "scene" and first != second:
            return False
    return True


def alike(a: History, b: History) -> bool:
    """Equal to rounding: legs begin at another state, and lines are found from there."""
    if [event.kind for event in a.events] != [event.kind for event in b.events]:
        return False
    for name in ("depth", "force", "energy", "contacts"):
        first, second = getattr(a, name), getattr(b, name)
        size = np.nanmax(np.abs(first))
        if not np.allclose(first, second, rtol=0, atol=1e-13 * size, equal_nan=True):
            return False
    numbers = [(e.depth, e.force, e.energy_released) for e in a.events]
    others = [(e.depth, e.force, e.energy_released) for e in b.events]
    size = np.abs(numbers).max(axis=0)
    return bool((np.abs(np.subtract(numbers, others)) <= 1e-13 * size).all())


def plain(event):
    """An event as nested tuples of Python numbers; repr tells every bit, and nan equals nan."""
    kind, control, before, after, released, step = event
    states = (*before.lines, *before[:3], *after.lines, *after[:3])
    return kind, float(control), *map(float, states), float(released), int(step)


SCENES = [
    adhesive(Parabola(0.02)),
    adhesive(Wedge(0.05).shifted(0.3)),
    adhesive(Parabola(0.02).tilted(0.04)),
    adhesive(Sampled([-0.03, -0.01, 0.0, 0.02, 0.03], [0.01, 0.001, 0.0, 0.004, 0.02])),
]


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: type(s.indenter).__name__)
def test_a_file_keeps_every_bit(scene, tmp_path):
    path = load_path(scene, depths=PROGRAMME)
    path.to_csv(tmp_path / "path.csv")
    again = History.from_csv(tmp_path / "path.csv")
    assert identical(path, again)
    assert again.pull_off == path.pull_off
    assert again.work() == path.work()
    assert repr(again.scene.layer) == repr(scene.layer)
    text = (tmp_path / "path.csv").read_text("utf-8")
    assert "force P [force] > 0 compressive" in text
    assert '"scene"' in text


def test_a_scene_given_in_whole_numbers_of_numpy_is_read_again(tmp_path):
    layer = ElasticLayer(np.int64(3), 0.0, np.float32(2.0))
    scene = Scene(layer, SurfaceEnergies.from_work(1.0, 0.01), PowerLaw(1.0, np.int64(2)))
    load_path(scene, depths=[0.1]).to_csv(tmp_path / "path.csv")
    assert History.from_csv(tmp_path / "path.csv").scene == scene
    other = replace(scene, layer=ElasticLayer(np.int64(4), 0.0, 2.0))
    with pytest.raises(ValueError, match="scene"):
        History.from_csv(tmp_path / "path.csv", other)


def test_no_pull_is_no_pull_off():
    path = load_path(adhesive(Parabola(0.02), w=0.0), depths=[1e-3, 2e-3])
    with pytest.raises(ValueError, match=r"least force = \d.* is not tensile; retract"):
        _ = path.pull_off


def test_every_control_continues():
    scene = adhesive(Parabola(0.02))
    for name, more in (("forces", {}), ("drives", {"machine_stiffness": 3.0})):
        values = {"forces": [0.02, 0.05, -0.01, -0.03], "drives": [0.02, 0.05, -0.04, -0.06]}[name]
        whole = load_path(scene, **{name: values}, **more)
        first = load_path(scene, **{name: values[:2]}, **more)
        assert alike(whole, load_path(scene, **{name: values[2:]}, **more, after=first))


KILLED = """
import os, signal, sys
import numpy as np
from scenes import adhesive
from discretization import load_path
from energy import Parabola
programme = np.array([float(x) for x in sys.argv[2].split(",")])
left = int(sys.argv[3])
def count(*event):
    global left
    left -= 1
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)
sys.setprofile(count)
load_path(adhesive(Parabola(0.02)), depths=programme, save=sys.argv[1], every=3)
sys.setprofile(None)
"""


def test_a_path_killed_at_any_moment_goes_on(tmp_path):
    """SIGKILL again and again, each time after more calls of functions, until it has ended."""
    save, scene, count = tmp_path / "path.csv", adhesive(Parabola(0.02)), itertools.count()
    before = sys.getprofile()
    sys.setprofile(lambda *event: next(count))
    whole = load_path(scene, depths=PROGRAMME, save=tmp_path / "whole.csv", every=3)
    sys.setprofile(before)
    calls = more = next(count) // 4
    text = ",".join(map(repr, PROGRAMME.tolist()))
    environment = {**os.environ, "PYTHONPATH": PLACES}
    seen, ended = [], False
    while not ended:
        command = [sys.executable, "-c", KILLED, str(save), text, str(calls)]
        ended = subprocess.run(command, env=environment, cwd=ROOT).returncode == 0
        seen.append(len(History.from_csv(save).values) if save.exists() else 0)
        calls += more
    assert seen == sorted(seen)
    assert len(set(seen)) >= 3  # it was cut off in the middle, several times
    resumed = load_path(scene, depths=PROGRAMME, save=save, every=3)
    assert identical(whole, resumed)
    assert identical(whole, History.from_csv(save))


def test_a_file_of_something_else_is_refused(tmp_path):
    scene, other = adhesive(Parabola(0.02)), adhesive(Parabola(0.03))
    save = tmp_path / "path.csv"
    load_path(scene, depths=PROGRAMME[:50], save=save)
    with pytest.raises(ValueError, match="is not the scene of"):
        load_path(other, depths=PROGRAMME, save=save)
    with pytest.raises(ValueError, match="holds another programme"):
        load_path(scene, depths=PROGRAMME[1:], save=save)
    with pytest.raises(ValueError, match="control = 'force' differs"):
        load_path(scene, forces=PROGRAMME[:50], save=save)
    with pytest.raises(ValueError, match="rtol = 1e-06 differs"):
        load_path(scene, depths=PROGRAMME, save=save, rtol=1e-6)
    with pytest.raises(ValueError, match="not that of the path to continue"):
        load_path(other, depths=[0.1], after=History.from_csv(save))
    (tmp_path / "no.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="holds no load path"):
        History.from_csv(tmp_path / "no.csv")


def test_a_profile_of_functions_is_read_with_its_scene(tmp_path):
    scene = adhesive(Profile(lambda x: 25 * x**2, lambda x: 50 * x, convex=True))
    path = load_path(scene, depths=PROGRAMME)
    path.to_csv(tmp_path / "path.csv")
    assert identical(path, History.from_csv(tmp_path / "path.csv", scene))
    with pytest.raises(ValueError, match="pass the scene that was used"):
        History.from_csv(tmp_path / "path.csv")


def test_a_file_says_what_was_given_of_the_surface_energies(tmp_path):
    layer, path = ElasticLayer(2e3, 0.31, 6e-5), tmp_path / "path.csv"
    for surfaces, told, kept in (
        (SurfaceEnergies.from_work(0.05, 1e-4), '"w": 0.0001', ("gamma2", "gamma12")),
        (SurfaceEnergies(0.05, 0.03, 0.0799), '"gamma2": 0.03, "gamma12": 0.0799', ('"w"',)),
    ):
        scene = Scene(layer, surfaces, Parabola(0.017))
        load_path(scene, depths=[0.0, 1e-6]).to_csv(path)
        text = path.read_text("utf-8")
        assert told in text
        assert not [name for name in kept if name in text]
        again = History.from_csv(path).scene
        assert again == scene and repr(again) == repr(scene)
    by_work = Scene(layer, SurfaceEnergies.from_work(0.05, 1e-4), Parabola(0.017))
    load_path(by_work, depths=[0.0, 1e-6]).to_csv(path)
    spelt_out = replace(by_work, surfaces=SurfaceEnergies(0.05, 1e-4, 0.05))
    assert History.from_csv(path, scene=spelt_out).scene == by_work
    assert eval(repr(by_work.surfaces)) == by_work.surfaces
