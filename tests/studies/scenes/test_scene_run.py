"""The study `run`: its table, what it says, its figures, and the shipped scenes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.repository import ROOT
from support.scene_files import DEPTH, INDENTER, SURFACES, by_hand, refused, writer

import energy
from discretization import minimise
from energy import ElasticLayer, FlatPunch, Parabola, Plane, Sampled, SurfaceEnergies, Wedge
from energy.description import described
from studies.scenes import run as study
from studies.scenes.file import load
from studies.shared.table import read

SHIPPED = sorted((ROOT / "studies" / "scenes").glob("*.toml"))


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "tiny.toml")


def test_a_run_writes_what_minimise_says(written, tmp_path, capsys):
    out = tmp_path / "new" / "folder"
    path = written()
    assert study.main([str(path), "--out", str(out)]) == 0
    text = (out / "tiny.csv").read_text("utf-8")
    rows = read(out / "tiny.csv")
    for row, depth in zip(rows, (2e-6, 0.0, -4e-5), strict=True):
        state = minimise(by_hand(Parabola(0.017)), depth, rtol=1e-6)
        assert row.pop("label") == state.label
        names = ("depth", "half_width", "force", "energy", "contact_angle")
        wanted = {name: getattr(state, name) for name in names}
        wanted |= {f"error_{name}": state.uncertainty[name] for name in names[1:4]}
        assert list(row) == list(wanted)
        for name, value in wanted.items():
            assert float(row[name]) == value or (math.isnan(value) and row[name] == "nan"), name
    assert [float(row["half_width"]) > 0 for row in rows] == [True, True, False]
    assert text.startswith(f"# command: python -m studies run {path} --out {out}\n")
    scene = ("ElasticLayer(E=2000.0, nu=0.31, h=6e-05, ", "Parabola(R=0.017)", "'rtol': 1e-06")
    for part in (*scene, "title: A test", "nowhere", "force in N/m", "force > 0 compressive"):
        assert part in text, part
    assert (out / "tiny.png").stat().st_size > 10_000
    said = capsys.readouterr().out
    assert said.count("global, adhered branch") == 1 and said.count("  global") == 2
    assert "all assumptions hold in 0 of 2 states in contact" in said
    assert "validity     h/a" in said and "violated: h/a" in said


def test_options_reach_the_minimiser(written):
    options = 'method = "lattice"\nspacing = 3e-6\nbranch = "adhered"'
    record = study.run(load(written(("rtol = 1e-6", options))))
    assert {(state.method, state.spacing) for state in record.states} == {("lattice", 3e-6)}


def test_what_the_minimiser_refuses_names_file_and_depth(written):
    path = written(("rtol = 1e-6", 'method = "magic"'))
    with refused(path, "depth = 2e-06: method = 'magic'.*'lattice'"):
        study.run(load(path))


def test_the_worst_state_and_the_violations_are_those_in_contact(written):
    record = study.run(load(written()))
    assert [state.label == "detached" for state in record.states] == [False, False, True]
    assert record.worst is record.states[1]  # the narrower contact
    widest = {one.name: one.value for one, _ in study.violations(record.attached)}
    assert widest["h/a"] == 60e-6 / record.states[1].half_width


@pytest.mark.parametrize(
    ("indenter", "depths"),
    [
        (Plane(), [1e-6]),
        (Plane(), [1e-6, -1e-6, -1e-3]),
        (Parabola(0.1), [-1e-3]),
        (Parabola(0.1), [-1e-3, -2e-3]),
        (FlatPunch(1e-3), [0.0]),
        (Wedge(0.01).shifted(2e-4), [1e-6]),
    ],
)
def test_contacts_without_lines_or_width_are_drawn(indenter, depths):
    film = ElasticLayer(400.0, 0.31, 60e-6)
    surfaces = SurfaceEnergies.from_work(0.05, 1e-4)
    scene = replace(by_hand(indenter), layer=film, surfaces=surfaces)
    given = replace(load(SHIPPED[0]), scene=scene, depths=np.array(depths), options={}, title="a")
    figure = study.plot(study.run(given))
    figure.draw_without_rendering()
    surface = figure.axes[-2]
    bottom, top = surface.get_ylim()
    lowest = surface.collections[1].get_paths()[0].vertices[:, 1].max()  # the indenter is in sight
    assert top < lowest < bottom


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scenes_give_certified_states(path):
    given = load(path)
    assert given.source and given.title != path.stem
    depths = given.depths[:: max(1, given.depths.size // 8)]
    record = study.run(replace(given, depths=depths))
    assert record.attached
    for state in record.states:
        assert state.certificate.ok and max(state.error_estimate.values()) <= 1e-8
    assert ("VIOLATED" in path.read_text("utf-8")) == bool(study.violations(record.attached))


SAMPLES = "x = [-1e-3, 0, 2e-3]\nz = [1e-6, 0, 3e-6]"
SMOOTH = Sampled([-1e-3, 0, 2e-3], [1e-6, 0, 3e-6], kind="smooth")
TILTED = Parabola(2.0).tilted(1e-3).shifted(3e-4)


@pytest.mark.parametrize(
    ("text", "indenter"),
    [
        (INDENTER, Parabola(0.017)),
        ('shape = "plane"', Plane()),
        ('shape = "flat_punch"\nhalf_width = 3e-4', FlatPunch(3e-4)),
        ('shape = "wedge"\ndelta = 0.02', Wedge(0.02)),
        ('shape = "wedge"\ndelta_degrees = 9', Wedge(math.pi / 20)),
        ('shape = "power_law"\nc = 7.0\nn = 3', energy.PowerLaw(7.0, 3.0)),
        ('shape = "parabola"\nR = 2\nshifted = 3e-4\ntilted = 1e-3', TILTED),
        ('shape = "circle"\nR = 2', energy.Circle(2.0)),
        (f'shape = "sampled"\n{SAMPLES}', Sampled([-1e-3, 0, 2e-3], [1e-6, 0, 3e-6])),
        (f'shape = "sampled"\nkind = "smooth"\n{SAMPLES}', SMOOTH),
    ],
)
def test_every_shape_reaches_the_scene(written, text, indenter):
    given = load(written((INDENTER, text)))
    assert described(given.scene) == described(by_hand(indenter))
    assert given.depths.tolist() == [2e-6, 0.0, -4e-5]
    assert (given.title, given.source, given.options) == ("A test", "nowhere", {"rtol": 1e-6})


def test_the_response_of_the_layer_reaches_the_scene(written):
    given = load(written(("nu = 0.31", 'nu = 0.5\nresponse = "layer"')))
    layer = ElasticLayer(2e3, 0.5, 60e-6, response="layer")
    assert given.scene == by_hand(Parabola(0.017), layer=layer)


@pytest.mark.parametrize("option", [{"slopes": "finite"}, {"geometry": "axisymmetric"}])
def test_options_and_the_work_of_adhesion_reach_the_scene(written, option):
    ((name, value),) = option.items()
    given = load(written(("rtol = 1e-6", f'{name} = "{value}"'), (SURFACES, "w = 4e-4")))
    wanted = replace(by_hand(Parabola(0.017)), surfaces=SurfaceEnergies.from_work(0.05, 4e-4))
    assert (given.scene, given.options) == (replace(wanted, **option), {})


@pytest.mark.parametrize(
    ("text", "depths"),
    [
        ("depth = -3e-7", [-3e-7]),
        ("depth = 0", [0.0]),
        ("depth = [1e-6, 5e-7]", [1e-6, 5e-7]),
        ("depth = { from = 2, to = -1, steps = 4 }", [2.0, 1.0, 0.0, -1.0]),
    ],
)
def test_depth_is_a_number_a_list_or_a_range(written, text, depths):
    assert load(written((DEPTH, text))).depths.tolist() == depths


def test_title_source_and_options_may_be_left_out(written):
    cut = [('title = "A test"\n', ""), ('source = "nowhere"\n', ""), ("[options]\nrtol = 1e-6", "")]
    given = load(written(*cut))
    assert (given.title, given.options, given.scene.slopes) == ("tiny", {}, "small")


TOP = "title, source, depth, layer, surfaces, opening, indenter, path, measured, options"
LAYER = "E, nu, h, response"
STEPS = "from, to, steps, spacing"
ENERGIES = "gamma1, gamma2, gamma12, w"
PARABOLA = "shape, R, shifted, tilted"
WEDGE = "shape, delta, delta_degrees, shifted, tilted"
OPTIONS = "slopes, geometry, method, branch, spacing, rtol"
SHAPE = "indenter.shape = "
ANGLE = 'shape = "wedge"\ndelta'
SAMPLED = 'shape = "sampled"\nx = [0, 1]\nz = [0, 1]\nkind = '


BAD = [  # replaced, by, what is told, which keys are called known
    ("h = 60e-6", "h = 60e-6\nk = 3", "layer.k = 3 is unknown", LAYER),
    ("title", "titel", "titel = 'A test' is unknown", TOP),
    ("rtol", "tol", "options.tol = 1e-06 is unknown", OPTIONS),
    ("R = 0.017", "R = 0.017\ndelta = 1", "indenter.delta = 1 is unknown", PARABOLA),
    ("h = 60e-6", "h = 60e-6\ndepth = 1", "layer.depth = 1 is unknown here: write it above", LAYER),
    ("gamma2 = 0.03\n", "", "surfaces.gamma2 is missing", ENERGIES),
    ('shape = "parabola"\n', "", "indenter.shape is missing", ""),
    (DEPTH, "", "depth is missing", TOP),
    (f"[indenter]\n{INDENTER}", "", "indenter is missing", TOP),
    (DEPTH, "depth = {from = 1, to = 0}", "depth.steps is missing", STEPS),
    (INDENTER, 'shape = "wedge"', "indenter.delta is missing", WEDGE),
    ("h = 60e-6", 'h = "1 mm"', "layer.h = '1 mm' must be a number in SI units", LAYER),
    ("E = 2e3", "E = true", "layer.E = True must be a number", LAYER),
    ("E = 2e3", "E = nan", "layer.E = nan must be finite", LAYER),
    ('title = "A test"', "title = 7", "title = 7 must be a text in quotes", TOP),
    ("[options]\nrtol = 1e-6", "[[options]]", "options = [{}] must be a table", OPTIONS),
    ('"parabola"', '"ball"', f"{SHAPE}'ball' is unknown; known shapes: plane, flat", ""),
    ("rtol = 1e-6", 'geometry = "axi"', "geometry = 'axi' is unknown; choose one of 'line', ", ""),
    ("rtol = 1e-6", 'slopes = "big"', "slopes = 'big' is unknown; choose one of 'small', 'fin", ""),
    (INDENTER, SAMPLED + '"cubic"', "indenter.kind = 'cubic' is unknown; choose one of", ""),
    (SURFACES, "gamma2 = 1\nw = 1", "surfaces.gamma2 = 1 contradicts w", ENERGIES),
    (
        INDENTER,
        'shape = "wedge"\ndelta = 0.1\ndelta_degrees = 1',
        "indenter.delta_degrees stands beside",
        WEDGE,
    ),
    (
        INDENTER,
        'shape = "wedge"\ndelta_degrees = 90',
        "indenter.delta_degrees = 90 is outside",
        WEDGE,
    ),
    (INDENTER, 'shape = "wedge"\ndelta = 2', "indenter.delta = 2.0 is outside (0, π/2)", ""),
    (DEPTH, 'depth = [0, "1"]', "depth[1] = '1' must be a number", TOP),
    (DEPTH, "depth = []", "depth = [] must be a list of at least one number", TOP),
    (DEPTH, 'depth = "deep"', "depth = 'deep' must be a number", TOP),
    (DEPTH, "depth = {from = 1, to = 0, steps = 1}", "depth.steps = 1 must be a whole", STEPS),
    (DEPTH, "depth = {from = 1, to = 0, steps = 2.5}", "depth.steps = 2.5 must be a whole", STEPS),
    ("h = 60e-6", "h = 0", "layer.h = 0.0 must be positive", ""),
    ("gamma12 = 0.0791", "gamma12 = 1", "surfaces.gamma12 = 1.0 exceeds gamma1 + gamma2", ""),
    ("R = 0.017", "R = -1", "indenter.R = -1.0 must be positive", ""),
    ("E = 2e3", "E = ", "cannot be read as TOML: Invalid value (at line 7", ""),
]


@pytest.mark.parametrize(("old", "new", "told", "known"), BAD, ids=[case[2] for case in BAD])
def test_a_bad_file_is_refused_by_file_key_and_known_keys(written, old, new, told, known):
    path = written((old, new))
    with pytest.raises(ValueError, match="tiny") as caught:
        load(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ") and message.count(str(path)) == 1
    assert told in message
    assert message.endswith(f"; known keys: {known}") if known else "known keys: E" not in message


LINES = [  # replaced, by, the line that is told
    (DEPTH, "depth = '1e-6'", 4),
    ("h = 60e-6", "h = '6e-5'", 9),
    ("E = 2e3", "E = 2,5e3", 7),
    ("E = 2e3", "E = -3e3", 7),
    ("E = 2e3\n", "", 6),
    ("[surfaces]", "[surface]", 11),
    (SURFACES, "w = { from = 1e-5, to = 7e-5, steps = 5 }", 13),
    ("R = 0.017", "R = 0.017\nradius = 1", 19),
]


@pytest.mark.parametrize(("old", "new", "line"), LINES)
def test_what_is_wrong_in_a_scene_file_has_its_line(written, old, new, line):
    """Also behind a byte order mark."""
    path = written((old, new))
    for encoding, newline in (("utf-8", "\n"), ("utf-8-sig", "\n"), ("utf-8-sig", "\r\n")):
        path.write_text(path.read_text("utf-8-sig"), encoding, newline=newline)
        with refused(path, rf".*\(at line {line}\b"):
            load(path)
    path = written()
    path.write_text(path.read_text("utf-8"), "utf-8-sig", newline="\r\n")
    assert load(path).scene == by_hand(Parabola(0.017))


def test_spreading_is_refused_with_finite_slopes(written):
    path = written((SURFACES, "w = 0.2"), ("rtol = 1e-6", 'slopes = "finite"'))
    with refused(path, ".*exceeds 2 gamma1"):
        load(path)


def test_a_missing_file_a_folder_and_bytes_are_named(tmp_path):
    with pytest.raises(ValueError, match=r"none\.toml: No such file"):
        load(tmp_path / "none.toml")
    with pytest.raises(ValueError, match="directory"):
        load(tmp_path)
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match=r"bytes\.toml: cannot be read as TOML"):
        load(tmp_path / "bytes.toml")
