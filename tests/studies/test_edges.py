"""At the edges: encodings, closed pipes, Ctrl-C, full disks, misspelt words, a class for one."""

import errno
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.repository import MODULE_PATH
from support.scene_files import DEPTH, SURFACES, refused, writer
from support.sweep_points import HELD_FROM, gone

from discretization import History, load_path, minimise
from energy import ElasticLayer, Parabola, Patches, Scene, SurfaceEnergies, Wedge
from studies import __main__ as command_line
from studies.scenes import new, run
from studies.scenes.sweep.store import Store

LAYER = ElasticLayer(2e3, 0.3, 1e-5)
SURFACE = SurfaceEnergies.from_work(0.05, 1e-4)


def started(*arguments, cwd, **options):
    """Python with this package and these tests on its path, in a process group of its own."""
    environment = {**os.environ, "PYTHONPATH": MODULE_PATH, **options.pop("env", {})}
    command = [sys.executable, "-W", "error", *map(str, arguments)]
    options = {"stderr": subprocess.PIPE, "start_new_session": True, **options}
    return subprocess.Popen(command, cwd=cwd, env=environment, **options)


STUDIES = ("-m", "studies")


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["ascii", "utf-16"])
def test_any_encoding_of_the_output_will_do(tmp_path, encoding):
    path = writer(tmp_path / "s.toml")(('"A test"', '"Ärger µ γ₁"'), (DEPTH, "depth = 0.0"))
    given = {"cwd": tmp_path, "env": {"PYTHONIOENCODING": encoding}, "stdout": subprocess.PIPE}
    child = started(*STUDIES, "run", path, **given)
    out, err = child.communicate()
    assert (child.returncode, err) == (0, b"")
    said = out.decode(encoding)
    assert "force        P" in said
    assert ("γ₁" in said) == encoding.startswith("utf")
    child = started(*STUDIES, "Ω.py", **given)
    assert "no such file" in child.communicate()[1].decode(encoding)
    assert child.returncode == 2


@pytest.mark.parametrize(
    ("arguments", "closed"),
    [([], "stdout"), (["run", "s.toml"], "stdout"), (["dance"], "stderr"), (["new"], "stderr")],
)
def test_a_closed_pipe_ends_a_study_quietly(tmp_path, arguments, closed):
    writer(tmp_path / "s.toml")()
    reading, writing = os.pipe()
    os.close(reading)
    pipes = {"stdout": subprocess.PIPE, closed: writing}
    child = started(*STUDIES, *arguments, cwd=tmp_path, **pipes)
    os.close(writing)
    assert b"".join(filter(None, child.communicate())) == b""
    assert child.returncode == (2 if arguments == ["new"] else 141)  # argparse ends that by itself


HELD = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in the background
from studies import __main__ as command_line
from studies.scenes.sweep import study
from support.sweep_points import HeldScene
study.SolvedScene = HeldScene
sys.exit(command_line.main(["sweep", *sys.argv[1:]]))
"""


@pytest.mark.parametrize("jobs", [1, 2])
def test_ctrl_c_in_a_sweep(tmp_path, jobs):
    """The signal comes when 30 lines are kept, and the points after them wait for it."""
    depths = "depth = { from = 2e-6, to = -4e-5, steps = 100 }"
    works = 'w = { from = 1e-5, to = 1e-3, steps = 100, spacing = "log" }'
    path = writer(tmp_path / "s.toml")((DEPTH, depths), (SURFACES, works))
    kept = tmp_path / "results" / "s_sweep.jsonl"
    child = started("-c", HELD, path, "--jobs", jobs, cwd=tmp_path, stdout=subprocess.DEVNULL)
    while not kept.exists() or kept.read_text("utf-8").count("\n") < HELD_FROM:
        assert child.poll() is None
        time.sleep(0.01)
    os.killpg(child.pid, signal.SIGINT)  # as a terminal does
    said = child.communicate()[1].decode().splitlines()
    count = len(kept.read_text("utf-8").splitlines()) - 1
    assert child.returncode == 130
    assert 0 < count < 10000
    told = f"sweep: stopped; {count} of 10000 points are kept in {Path('results', kept.name)}"
    assert said[-1] == f"{told}; the same command goes on from there"
    assert not any("Traceback" in line for line in said)
    assert gone(child.pid)


def test_ctrl_c_elsewhere_is_one_line(monkeypatch, capsys):
    def stopped(argv):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "main", stopped)
    assert command_line.main(["run", "any.toml"]) == 130
    assert capsys.readouterr().err == "\nrun: stopped\n"


LOCKED = """
import sys, time
from pathlib import Path
from studies.scenes.sweep.store import Record, Store
with Store(Path(sys.argv[1]), {}) as store:
    store.add(['{"at": 0, "found": {"sum": 1.0}}'])
    store.results()
    print("locked", flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no locks on Windows")
def test_two_sweeps_in_one_folder_do_not_do_the_work_twice(tmp_path):
    """The second is refused while the first lives, and goes on where that was killed."""
    path = tmp_path / "a.jsonl"
    given = {"PYTHONPATH": MODULE_PATH}
    command = [sys.executable, "-c", LOCKED, path]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, env=os.environ | given)
    assert child.stdout.readline() == b"locked\n"
    before = path.read_text("utf-8")
    with refused(path, "another command is writing this file; wait for its end"), Store(path, {}):
        pass
    assert path.read_text("utf-8") == before
    child.kill()
    child.communicate()
    with Store(path, {}) as store:
        assert store.results()[0]["found"] == {"sum": 1.0}


needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")


@needs_full
@pytest.mark.parametrize(
    ("preset", "name"),
    [([], "half_width.csv"), ([], "half_width.png"), (["--preset", "full"], "half_width.pdf")],
)
def test_a_full_disk_is_told_with_the_file(tmp_path, monkeypatch, capsys, preset, name):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    command_line.main(["new", "--study", "mine.py"])
    out = tmp_path / "out"
    out.mkdir()
    (out / f"{name}.part").symlink_to("/dev/full")
    capsys.readouterr()
    arguments = ["mine.py", "--preset", "quick", "--jobs", "1", *preset, "--out", str(out)]
    assert command_line.main(arguments) == 2
    said = capsys.readouterr().err.splitlines()
    assert said[-1] == f"mine.py: {out / name}: No space left on device"
    assert not (out / name).exists()
    assert not [*out.glob("*.part")]
    sys.modules.pop("mine", None)


@needs_full
def test_full_disk_leaves_no_empty_file(tmp_path, monkeypatch):
    """A disk that is full from the beginning keeps no empty file."""
    path = tmp_path / "a.jsonl"
    store = Store(path, {"function": "f"})
    add = Store.add

    def full(store, lines):
        store.file.close()
        store.file = open("/dev/full", "w")  # noqa: SIM115
        add(store, lines)

    monkeypatch.setattr(Store, "add", full)
    with pytest.raises(OSError, match="No space left on device"), store:
        pass
    assert not path.exists()
    part = tmp_path / "my.toml.part"
    part.symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left on device"):
        new.write(tmp_path / "my.toml", ".toml")
    part = tmp_path / "loop.csv.part"
    part.symlink_to("/dev/full")
    path = load_path(Scene(LAYER, SURFACE, Parabola(0.01)), depths=[0.0, 1e-7])
    with pytest.raises(OSError, match="No space left on device"):
        path.to_csv(tmp_path / "loop.csv")
    assert not [*tmp_path.iterdir()]


@needs_full
def test_a_full_disk_in_a_sweep_is_told_with_the_file(tmp_path):
    store = Store(tmp_path / "a.jsonl", {"function": "f"})

    def added():
        with store:
            store.file.close()
            store.file = open("/dev/full", "w")  # noqa: SIM115
            store.add(["{}"])

    with pytest.raises(OSError, match=re.escape(f"No space left on device: '{store.path}'")):
        added()


def test_a_full_disk_under_a_load_path_is_told_with_the_file(tmp_path, monkeypatch, capsys):
    def full(history, path):
        raise OSError(errno.ENOSPC, "No space left on device")

    path = "[path]\ndepths = [0, 1e-6]\n[options]"
    writer(tmp_path / "p.toml")((DEPTH, ""), ("[options]", path))
    monkeypatch.setattr(History, "to_csv", full)
    assert command_line.main(["run", str(tmp_path / "p.toml"), "--out", str(tmp_path)]) == 2
    wanted = f"run: {tmp_path / 'p_path.csv'}: No space left on device\n"
    assert capsys.readouterr().err == wanted


@pytest.mark.parametrize(
    ("wrong", "meant"), [("pulloff", "pull_off"), ("hysterisis", "hysteresis"), ("dance", None)]
)
def test_a_misspelt_study_is_understood(capsys, wrong, meant):
    assert command_line.main([wrong]) == 2
    said = capsys.readouterr().err
    assert (f"study {wrong!r} is unknown: did you mean {meant!r}?" in said) == (meant is not None)
    assert said.count("\n") == 1
    assert repr(wrong) in said
    assert meant or all(name in said for name in command_line.STUDIES)


def test_a_misspelt_option_is_understood():
    scene = Scene(LAYER, SURFACE, Parabola(0.01))
    with pytest.raises(ValueError, match=r"'latice' is unknown: did you mean 'lattice'\?; choose"):
        minimise(scene, 0.0, method="latice")
    with pytest.raises(ValueError, match=r"'Finite' is unknown: did you mean 'finite'\?"):
        Scene(LAYER, SURFACE, Parabola(0.01), "Finite")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("layer", ElasticLayer),
        ("surfaces", SurfaceEnergies),
        ("indenter", Parabola),
        ("opening", SurfaceEnergies),
        ("pattern", Patches),
    ],
)
def test_a_class_in_place_of_an_object_is_told(name, kind):
    given = {"layer": LAYER, "surfaces": SURFACE, "indenter": Parabola(0.01), name: kind}
    told = rf"^{name} = {kind.__name__} is a class; make one: {kind.__name__}\(\.\.\."
    with pytest.raises(ValueError, match=told):
        Scene(**given)
    with pytest.raises(ValueError, match="indenter = Wedge is a class"):
        Parabola(0.01) + Wedge
