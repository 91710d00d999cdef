"""Files of profiles and of force curves, and what scene files and options say of them."""

import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from support.measured_curves import SCENE, measured
from support.scene_files import FIT_SCENE, refused

from energy import read_profile
from studies import __main__ as command_line
from studies.scenes.curve_file import Reading, read_curve
from studies.scenes.file import load

X = np.array([-2.0, -0.5, 1.0, 3.0])
Z = np.array([4.0, 0.25, 1.0, 9.0])


def test_arrays(tmp_path):
    np.savez(tmp_path / "a.npz", x=X, z=Z)
    (tmp_path / "a.npz").rename(tmp_path / "a.NPZ")
    assert np.array_equal(read_profile(tmp_path / "a.NPZ", kind="smooth").z, Z)
    np.savez(tmp_path / "b.npz", position=X)
    with pytest.raises(ValueError, match=r"holds the arrays \['position'\]; name them x and z"):
        read_profile(tmp_path / "b.npz")


def test_instrument_files_need_their_library(tmp_path, monkeypatch):
    (tmp_path / "scan.opd").write_bytes(b"\0")
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    with pytest.raises(ValueError, match=r"install elastocap\[topography\]"):
        read_profile(tmp_path / "scan.opd")

    def scan(dim, unit="µm"):
        found = SimpleNamespace(dim=dim, unit=unit, positions_and_heights=lambda: (X * 1e-6, Z))
        found.to_unit = lambda unit: found
        return SimpleNamespace(read_topography=lambda path: found)

    monkeypatch.setitem(sys.modules, "SurfaceTopography", scan(1))
    for given in (1.0, 1e-3):  # its own unit counts
        assert np.array_equal(read_profile(tmp_path / "scan.opd", unit=given).x, X * 1e-6)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", scan(1, unit=None))
    assert np.array_equal(read_profile(tmp_path / "scan.opd", unit=2.0).x, 2 * X * 1e-6)
    with pytest.raises(ValueError, match="is no file"):
        read_profile(tmp_path / "none.txt")
    with pytest.raises(ValueError, match=r"unit = 0.0 must be positive"):
        read_profile(tmp_path / "scan.opd", unit=0.0)


def instrument_file(path, library, n=50):
    """A force-distance curve of approach and retraction; its depth and force."""
    way = np.concatenate([np.linspace(5e-6, 1e-6, n), np.linspace(1e-6, 5e-6, n)])
    force = np.maximum(2e-6 - way, 0.0) * 0.02
    data = {
        "force": force,
        "height (measured)": way,
        "segment": np.repeat([0, 1], n).astype(np.uint8),
    }
    own = {"spring constant": 0.05, "enum": 0, "path": str(path), "imaging mode": "force-distance"}
    curve = library.AFMForceDistance(data=data, metadata=own)
    kept = ["spring constant", "enum", "imaging mode"]
    curve.export_data(path, metadata=kept, fmt="tab" if path.suffix == ".tab" else "hdf5")
    return -(way + force / 0.05), force


@pytest.mark.parametrize("ending", ["tab", "h5"])
def test_instrument_files_are_read_by_their_library(tmp_path, ending):
    library = pytest.importorskip("afmformats", reason="the extra elastocap[afm] is not installed")
    path = tmp_path / f"curve.{ending}"
    depth, force = instrument_file(path, library)
    found = read_curve(path, Reading(width=1e-3))
    assert found.depth == pytest.approx(depth, rel=1e-6, abs=0)
    assert found.force == pytest.approx(force / 1e-3, rel=1e-6, abs=0)
    with refused(path, "the force is in newtons"):
        read_curve(path)
    with refused(path, "curve = 2, but it holds 1 force-distance curves"):
        read_curve(path, Reading(width=1e-3, number=2))
    path.write_bytes(b"no such thing")
    with refused(path, "afmformats cannot read it"):
        read_curve(path, Reading(width=1e-3))


class Missing(BaseException):
    """What afmformats raises."""


class Data(dict):
    """A curve of afmformats."""

    columns = property(list)
    metadata = {"spring constant": 4.0}  # noqa: RUF012


def test_instrument_files_say_what_they_lack(tmp_path, monkeypatch):
    path = tmp_path / "curve.jpk-force"
    given = Reading(width=0.5)
    held = []
    with refused(path, "is no file"):
        read_curve(path, given)
    path.write_bytes(b"")
    monkeypatch.setitem(sys.modules, "afmformats", None)
    with refused(path, r"an instrument file; install elastocap\[afm\]"):
        read_curve(path, given)

    def load_data(path, modality):
        assert modality == "force-distance"
        if not held:
            raise Missing("no sensitivity")
        return held

    monkeypatch.setitem(sys.modules, "afmformats", SimpleNamespace(load_data=load_data))
    with refused(path, "afmformats cannot read it: Missing: no sensitivity"):
        read_curve(path, given)
    held[:] = [Data({"force": [1.0, 2.0], "height (piezo)": [0.5, 0.25]})]
    found = read_curve(path, given)
    assert found.depth.tolist() == [-0.75, -0.75] and found.force.tolist() == [2.0, 4.0]
    held[0].metadata = {}
    with refused(path, "states no spring constant"):
        read_curve(path, given)
    held[:] = [Data({"force": [1.0]}), Data({"force": [3.0], "tip position": [-0.5]})]
    with refused(path, "curve = None, but it holds 2 force-distance curves; give one of 1 to 2"):
        read_curve(path, given)
    assert read_curve(path, Reading(width=0.5, number=2)).depth.tolist() == [0.5]
    with refused(path, "states no heights"):
        read_curve(path, Reading(width=0.5, number=1))
    with refused(path, "columns and layout are for text"):
        read_curve(path, Reading(("1", "2"), width=0.5))


TABLE = """[measured]
columns = ["Weg [µm]", "2 [mN]"]
width = 0.01
skip = 1
"""


@pytest.mark.slow
def test_scene_files_and_options_say_how_a_curve_is_read(tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    data = tmp_path / "kurve.csv"
    scene.write_text(FIT_SCENE + TABLE, "utf-8")
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.01)
    rows = [f"{1e6 * d:.9f};{1e3 * 0.01 * p:.9f}" for d, p in zip(*curve[:2], strict=True)]
    data.write_text("1;2\nWeg;Kraft\n" + "\n".join(rows).replace(".", ","), "utf-8")
    arguments = ["fit", str(data), "--scene", str(scene), "--out", str(tmp_path), "--quick"]
    assert command_line.main(arguments) == 0
    assert "not computed" in capsys.readouterr().out
    lines = (tmp_path / "kurve_fit.csv").read_text("utf-8").splitlines()
    table = np.array([row.split(",") for row in lines if not row.startswith(("#", "d"))], float)
    assert table[:, 0] == pytest.approx(curve.depth, abs=1e-15)
    assert table[:, 1] == pytest.approx(curve.force, abs=1e-10)
    for given, told in (
        (["--columns", "Zug [m]", "2 [mN]"], "no column 'Zug'"),
        (["--width", "-1"], "width = -1.0 must be positive"),
        (["--skip", "400"], "no line has two numbers"),
        (["--decimal", "."], "line 2: 1 cell|no line has two numbers|must be a finite number"),
        (["--encoding", "utf-16"], "is no text in utf-16|no line has two numbers"),
        (["--delimiter", "tab"], "no line has two numbers"),
        (["--curve", "2"], "curve = 2: text has one"),
    ):
        assert command_line.main([*arguments, *given]) == 2
        assert re.search(told, capsys.readouterr().err), given


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("skip = 1", "skip = -1", "measured.skip = -1 must be a whole number"),
        ("skip = 1", 'decimal = "x"', "measured.decimal = 'x' is unknown"),
        ("width = 0.01", "width = 0", "measured.width = 0.0 must be positive"),
        ('"2 [mN]"', "", "measured.columns = .* must be a list of two"),
        ("skip = 1", "lines = 1", "measured.lines = 1 is unknown"),
    ],
)
def test_wrong_tables_of_measured_data_are_refused(tmp_path, old, new, told):
    path = tmp_path / "scene.toml"
    path.write_text(FIT_SCENE + TABLE.replace(old, new), "utf-8")
    with refused(path, f".*{told}"):
        load(path)


def test_a_scene_file_takes_a_profile_from_a_file(tmp_path):
    path = tmp_path / "scene.toml"
    body = 'shape = "sampled"\nfile = "scan.csv"\nkind = "smooth"'
    x = np.linspace(-1, 1, 9)
    rows = "\n".join(f"{a:.4f};{500 * a * a:.4f}" for a in x).replace(".", ",")
    (tmp_path / "scan.csv").write_text(f"Profil\nlateral;up\n{rows}\n", "utf-8")
    text = FIT_SCENE
    old = 'shape = "parabola"\nR = 0.05'
    path.write_text(text.replace(old, f'{body}\ncolumns = ["lateral [mm]", "2 [nm]"]'), "utf-8")
    indenter = load(path).scene.indenter
    assert indenter.kind == "smooth"
    assert indenter.x == pytest.approx(1e-3 * x, abs=1e-18)
    assert indenter.z == pytest.approx(500e-9 * x**2, abs=1e-20)
    for extra, told in (
        ("x = [1.0]", r"indenter.x = \[1.0\] stands beside file"),
        ("skip = 40", "indenter.*no line has two numbers"),
        ('columns = "x"', "indenter.columns = 'x' must be a list of two"),
    ):
        path.write_text(text.replace(old, f"{body}\n{extra}"), "utf-8")
        with pytest.raises(ValueError, match=told):
            load(path)
    path.write_text(text.replace(old, 'shape = "sampled"\nunit = 1e-3\nx = [0]\nz = [0]'), "utf-8")
    with pytest.raises(ValueError, match=r"indenter\.unit = 0\.001 needs file"):
        load(path)
