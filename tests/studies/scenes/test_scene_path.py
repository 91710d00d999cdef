"""Load paths, hysteresis and rotational symmetry in scene files, and the file that `new` writes."""

import inspect
import re
import tomllib

import numpy as np
import pytest
from support import scene_files
from support.scene_files import refused, writer

from discretization import History, load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies import __main__ as command_line
from studies.scenes import grid as scene_path
from studies.scenes import new, run
from studies.scenes import run as study
from studies.scenes.file import load
from studies.scenes.fit import study as fit

DEPTHS = "depths = [-1e-6, 2e-6, -6e-6]"
TEXT = scene_files.TEXT.replace(scene_files.SURFACES, "w = 4e-4").replace(scene_files.DEPTH, "")
TEXT = TEXT.replace("[options]\nrtol = 1e-6", f"[path]\n{DEPTHS}\nsteps = 4")
SCENE = Scene(
    ElasticLayer(2e3, 0.31, 60e-6), SurfaceEnergies.from_work(0.05, 4e-4), Parabola(0.017)
)
LEGS = [-1e-6, -0.25e-6, 0.5e-6, 1.25e-6, 2e-6, 0, -2e-6, -4e-6, -6e-6]

BODY = '[indenter]\nshape = "parabola"\nR = 0.017'
ROUND = (TEXT[TEXT.index("[path]") :], '[options]\ngeometry = "axisymmetric"\n')
NO_TABLE = r"indenter = 3 must be a table: \[indenter\]"
TEMPLATE = (new.TEMPLATES / "template.toml").read_text("utf-8")


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "loop.toml", TEXT)


@pytest.mark.parametrize(
    ("text", "control", "values", "stiffness"),
    [
        (f"{DEPTHS}\nsteps = 4", "depths", LEGS, None),
        ("depths = [0.0, 1e-6]", "depths", np.linspace(0, 1e-6, 51), None),
        ("depths = { from = 0.0, to = 1e-6, steps = 7 }", "depths", np.linspace(0, 1e-6, 7), None),
        ("forces = [0.1, -1.0]\nsteps = 2", "forces", [0.1, -0.45, -1.0], None),
        ("drives = 1e-6\nmachine_stiffness = 5.0", "drives", [1e-6], 5.0),
    ],
)
def test_every_control_is_read(written, text, control, values, stiffness):
    """Turning points are joined by steps."""
    given = load(written((f"{DEPTHS}\nsteps = 4", text)))
    assert given.depths.size == 0
    programme = given.programme
    assert (programme.control, programme.machine_stiffness) == (control, stiffness)
    assert programme.values == pytest.approx(values, rel=1e-14, abs=1e-20)


def test_a_path_is_followed_told_and_written(written, tmp_path, capsys):
    path = written((TEXT, "depth = 1e-6\n" + TEXT))
    assert study.main([str(path), "--quick", "--out", str(tmp_path)]) == 0
    wanted = load_path(SCENE, depths=load(path).programme.values)
    read = History.from_csv(tmp_path / "loop_path.csv", SCENE)
    assert np.array_equal(read.force, wanted.force)
    assert repr(read.events) == repr(wanted.events)  # nan is not itself
    said = capsys.readouterr().out
    assert str(minimise(SCENE, 1e-6)) in said
    assert [event.kind for event in wanted.events] == ["jump-in", "detachment"]
    for event in wanted.events:
        assert f"{event.force:.6g}" in said and f"{event.energy_released:.6g}" in said
    assert f"P = {wanted.pull_off.force:.6g} N/m" in said
    assert "# title: A test" in (tmp_path / "loop_path.csv").read_text("utf-8")
    assert {"loop.csv", "loop.png", "loop_path.png"} < {p.name for p in tmp_path.iterdir()}


def test_hysteresis_slopes_and_lattice_reach_the_path(written):
    text = '[opening]\nw = 9e-4\n[options]\nslopes = "finite"\n[indenter]'
    given = load(written(("[indenter]", text)))
    opened = SurfaceEnergies.from_work(0.05, 9e-4)
    assert given.scene == Scene(SCENE.layer, SCENE.surfaces, SCENE.indenter, "finite", opened)
    assert scene_path.follow(given).friction > 0
    text = '[options]\nmethod = "lattice"\nspacing = 4e-6\n[indenter]'
    assert scene_path.follow(load(written(("[indenter]", text)))).spacing == 4e-6


@pytest.mark.parametrize(
    ("old", "new_text", "told"),
    [
        (DEPTHS, "", "path needs exactly one of depths, forces, drives; got none"),
        (DEPTHS, f"{DEPTHS}\nforces = 1.0", "path needs exactly one of .*; got depths and forces"),
        (DEPTHS, "drives = [0.0, 1.0]", "path.machine_stiffness = None with drives does not fit"),
        (DEPTHS, f"{DEPTHS}\nmachine_stiffness = 2", r"path.machine_stiffness = 2.0 with depths"),
        ("steps = 4", "steps = 0", "path.steps = 0 must be a whole number of at least 1"),
        ("steps = 4", "steps = true", "path.steps = True must be a whole number of at least 1"),
        (DEPTHS, "depths = {from = 0, to = 1, steps = 3}", "path.steps = 4 stands beside"),
        (DEPTHS, 'depths = ["a"]', r"path.depths\[0\] = 'a' must be a number"),
        (
            "steps = 4",
            "steps = 4\nspeed = 1",
            "path.speed = 1 is unknown \\(at line 22\\); known keys: depths",
        ),
        ("[path]", '[options]\nbranch = "global"\n[path]', "options.branch = 'global' cannot be"),
        ("[path]", '[options]\nmethod = "magic"\n[path]', "options.method = 'magic' cannot be"),
        ("[path]", "[opening]\nw = 1e-5\n[path]", "opening = .* work of adhesion not below"),
        ("[path]", "[opening]\ngamma1 = 1\nw = 1\n[path]", "opening.gamma1 = 1 is unknown"),
        ("[layer]", "depth = 0\n[opening]\nw = 1\n[layer]", "depth = 0 cannot stand beside"),
        (BODY, "", "indenter is missing"),
        (TEXT[: TEXT.index("[path]")], "indenter = 3\n[layer]\n", "layer.E is missing"),
        (TEXT, TEXT.replace("[layer]", "indenter = 3\n[layer]").replace(BODY, ""), NO_TABLE),
        (DEPTHS, "forces = [-1e3]", r"\[path\]: .*path under force control"),
    ],
)
def test_an_unusable_path_is_refused_by_file_and_key(written, old, new_text, told):
    path = written((old, new_text))
    with refused(path, f".*{told}"):
        scene_path.follow(load(path))


def test_a_new_file_runs_unchanged_and_is_not_overwritten(tmp_path, capsys):
    path = tmp_path / "folder" / "mine.toml"
    assert command_line.main(["new", str(path)]) == 0
    assert command_line.main(["run", str(path), "--out", str(tmp_path)]) == 0
    assert "all assumptions hold in 33 of 33 states in contact" in capsys.readouterr().out
    assert command_line.main(["new", str(path)]) == 2
    assert "exists; give another name" in capsys.readouterr().err
    assert command_line.main(["new", str(tmp_path / "mine.txt")]) == 2


def test_the_defaults_that_a_new_file_shows_are_the_defaults():
    options = re.sub("(?m)^# ", "", TEMPLATE[TEMPLATE.index("[options]") :])
    shown = tomllib.loads(options)["options"]
    defaults = inspect.signature(Scene).parameters | inspect.signature(minimise).parameters
    del shown["spacing"]
    assert shown == {name: defaults[name].default for name in shown}
    assert shown.keys() >= {"slopes", "geometry"}


@pytest.mark.parametrize("control", ["depths", "forces", "drives"])
def test_what_a_new_file_shows_in_comments_can_be_used(tmp_path, control):
    text, path = TEMPLATE.replace("\ndepth = {", "\n# depth = {"), tmp_path / "mine.toml"
    shown = ["[path]", f"{control} =", "tilted", "[opening]\n# w"]
    for part in [*shown, *["machine_stiffness"] * (control == "drives")]:
        text = text.replace(f"# {part}", part.replace("# ", ""))
    path.write_text(text.replace("# steps = 50", "steps = 5"), "utf-8")
    history = scene_path.follow(load(path))
    assert history.events[-1].kind in ("detachment", "pull-off") and history.half_width[-1] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "name", "tells"),
    [
        (
            [ROUND, ("[layer]", "depth = [2e-6, 0.0]\n[layer]")],
            "loop.csv",
            "force in N, energy in J,",
        ),
        (
            [ROUND, ("[layer]", "depth = 1e-6\n[layer]"), ("w = 4e-4", "w = [3e-4, 4e-4]")],
            "loop_sweep.csv",
            "forces in N, energies in J",
        ),
        ([("[path]", '[options]\ngeometry = "axisymmetric"\n[path]')], "", "force/N        lost/J"),
    ],
)
def test_what_is_told_about_an_axis_is_in_newtons(written, tmp_path, capsys, changes, name, tells):
    assert run.main([str(written(*changes)), "--out", str(tmp_path), "--jobs", "1"]) == 0
    said = capsys.readouterr().out
    table = (tmp_path / name).read_text("utf-8") if name else said
    assert tells in table and "N/m" not in table + said


def test_a_fit_finds_what_a_sphere_was_simulated_with(written, tmp_path, capsys):
    depths = ("[layer]", "depth = 0.0\n[layer]")
    path = load_path(load(written(ROUND, depths)).scene, depths=np.linspace(0, 4e-6, 30))
    data = tmp_path / "data.csv"
    rows = zip(path.depth, 1e6 * path.force, strict=True)
    text = [f"{d:.17g},{p:.17g}" for d, p in rows]
    data.write_text("\n".join(["depth [m],force [µN]", *text]), "utf-8")
    start = written(ROUND, depths, ("w = 4e-4", "w = 3e-4"))
    asked = [str(data), "--scene", str(start), "--parameters", "w", "--quick"]
    assert fit.main([*asked, "--out", str(tmp_path)]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("w "))
    assert float(row.split()[1]) == pytest.approx(4e-4, rel=1e-4)
    with pytest.raises(ValueError, match=r"width = 0.01 with geometry = 'axisymmetric': leave it"):
        fit.main([*asked, "--width", "0.01"])
