"""Files as instruments and spreadsheets write them: read right or refused, never read wrong."""

import numpy as np
import pytest
from support.measured_curves import written
from support.scene_files import SPHERE, refused

from energy import Circle, read_profile
from energy.files.text_table import Layout, read_table
from studies.scenes.curve_file import Reading, read_curve
from studies.scenes.file import load
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.many import curves

DEPTH = np.array([-0.125, 0.25, 1.5, 0.75]) * 1e-6
FORCE = np.array([0.0615, -0.25, 1000.5, 1e-3]) * 1e-3


def rows(between, mark=".", end="\n"):
    """DEPTH in µm and FORCE in mN/m, as columns."""
    columns = zip((-0.125, 0.25, 1.5, 0.75), (0.0615, -0.25, 1000.5, 0.001), strict=True)
    lines = [f"{depth:g}{between}{force:g}" for depth, force in columns]
    return end.join(lines).replace(".", mark) + end


HEAD = "depth [µm];force [mN/m]\n"
RIGHT = [  # name, text, encoding
    (
        "semicolons and decimal commas",
        HEAD + "-0,1250;0,06150\n0,25;-0,25\n1,5;1000,5\n0,75;1,0E-03\n",
        "utf-8",
    ),
    (
        "tabs, carriage returns, Windows's encoding",
        "Depth (µm)\tForce (mN/m)\r\n-0.125\t.0615\r\n0.25\t-0.25\r\n1.5\t1000.5\r\n0.75\t1e-3\r\n",
        "cp1252",
    ),
    (
        "tabs and decimal commas in UTF-16, as Excel saves Unicode text",
        "depth [µm]\tforce [mN/m]\r\n" + rows("\t", ",", "\r\n"),
        "utf-16",
    ),
    ("UTF-16 without a mark", HEAD.replace(";", ",") + rows(","), "utf-16-le"),
    (
        "quoted decimal commas between commas",
        '"depth [µm]","force [mN/m]"\n"'
        + rows(";", ",").replace(";", '","').replace("\n", '"\n"')[:-1],
        "utf-8-sig",
    ),
    (
        "a preamble of words and numbers",
        f"Instrument: 7;\nDate;12.03.2024\nPoints;4\n\n{HEAD}{rows(';')}",
        "latin-1",
    ),
    (
        "units in a second row",
        "Time;Depth;Force\ns;µm;mN/m\n0;" + rows(";", ",").replace("\n", "\n0;")[:-2],
        "cp1252",
    ),
    (
        "units in brackets in a second row, blanks in columns",
        "  depth      force\n  [µm]      [mN/m]\n" + rows("     "),
        "utf-8",
    ),
    (
        "three columns, the first of clock times",
        "Zeit;depth [nm];force [µN/mm]\n12:00:01,5;-125;0,0615\n12:00:02,5;250;-0,25\n"
        "12:00:03,5;1500;1000,5\n12:00:04,5;750;0,001\n",
        "utf-8",
    ),
    (
        "a delimiter behind the last cell",
        HEAD[:-1] + ";\n" + rows(";", end=";\n") + ";;\n",
        "utf-8",
    ),
    (
        "names in a comment, as numpy.savetxt writes them",
        "# depth [µm],force [N/m]\n-1.25e-01,6.15e-05\n2.5e-01,-2.5e-04\n1.5e+00,1.0005e+00\n"
        "7.5e-01,1e-06\n",
        "utf-8",
    ),
    (
        "a spreadsheet's note of its delimiter, a true minus",
        "sep=;\r\ndepth / µm;force / mN/m\r\n" + rows(";", ",", "\r\n").replace("-", "\u2212"),
        "utf-8",
    ),
    ("old Macintosh line ends", "depth in µm,force in mN/m\r" + rows(",", end="\r")[:-1], "utf-8"),
]


D = b"depth [m];force [N/m]\n"
N = b"depth [m]\tforce [N/m]\n"
WRONG = [  # bytes, what is said
    (b" \r\n", "is empty; give a file with columns of numbers"),
    (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\2\3", "is no text"),
    (b"depth [m], force [N/m]\nsee the other file\n", "no line has two numbers"),
    (D + b"1,5;2\n2,5;3;4\n3,5;4\n", "line 3: 3 cells where line 1 has 2; .*'2,5;3;4'"),
    (b"depth [m],force [N/m]\n1,5,2,5\n2,5,3,5\n", "line 1: 2 cells where line 2 has 4"),
    (D + b"1\n2;3\n3;4\n", "line 2: 1 cell where line 3 has 2"),
    (b"no;" + D + b"1;1,5;2.5\n2;2,5;3.5\n", "line 2: '.*' has the mark '.', other cells have"),
    (D + b"-1,250;2,500\n-2,250;3,500\n", "line 2: '-1,250' may be .* decimals or .*thousands"),
    (D + b"1.234,5;2,5\n2,5;3,5\n3,5;4,5\n", "line 2: '1.234,5' must be .* the decimal mark ','"),
    (N + b"1\t2\n2\toverload\n3\t4\n", "line 3: force = 'overload' must be a finite number"),
    (N + b"1\t2\n2\t\n3\t4\n", "line 3: force = '' must be a finite number"),
    (N + b"1\t2\n2\t1e999\n3\t4\n", "line 3: force = '1e999' must be a finite number"),
    (D + b"1;2\n2;3\nunloading\n1;1\n0;0\n", "line 4: 1 cell where line 1 has 2; .*'unloading'"),
    (D[:-1] + b";force [N/m]\n1;2;3\n2;3;4\n", "2 columns 'force': its line 1 names 3 columns"),
    (b"1;2\n2;3\n", "no column 'depth': it has 2 columns without names"),
    (b"depth;force\n1;2\n2;3\n", "column 'depth' has no unit"),
    (b"depth [Mm];force [N/m]\n1;2\n2;3\n", "the unit 'Mm' of the depth"),
    (b"depth [m];force [N]\n1;2\n2;3\n", "the force is in newtons.*--width"),
]


@pytest.mark.parametrize(("text", "encoding"), [c[1:] for c in RIGHT], ids=[c[0] for c in RIGHT])
def test_what_instruments_and_spreadsheets_write_is_read(tmp_path, text, encoding):
    path = tmp_path / "curve.csv"
    path.write_bytes(text.encode(encoding))
    found = read_curve(path)
    assert found.depth == pytest.approx(DEPTH, rel=1e-14, abs=0)
    assert found.force == pytest.approx(FORCE, rel=1e-14, abs=0)


@pytest.mark.parametrize(("data", "told"), WRONG, ids=[told for _, told in WRONG])
def test_what_is_not_clear_is_refused(tmp_path, data, told):
    path = tmp_path / "curve.csv"
    path.write_bytes(data)
    with refused(path, told):
        read_curve(path)


def test_damaged_files_are_never_read_wrong(tmp_path):
    """A character of the numbers deleted, doubled or replaced: the other rows stay as they are."""
    rng = np.random.default_rng(8)
    path = tmp_path / "curve.csv"
    depth = np.linspace(-2, 2, 9) + 0.25
    force = np.linspace(-1, 3, 9) - 0.125
    whole = [f"{d:.4f};{p:.4f}\n" for d, p in zip(depth, force, strict=True)]
    text = D.decode() + "".join(whole).replace(".", ",")
    refusals = 0
    for _ in range(300):
        at = int(rng.integers(len(D), len(text)))
        new = ["", text[at] * 2, *"; \t.,x\n"][rng.integers(9)]
        path.write_text(text[:at] + new + text[at + 1 :], "utf-8")
        try:
            found = read_curve(path)
        except ValueError:
            refusals += 1
            continue
        off = np.abs(np.subtract.outer(depth, found.depth)).min(axis=1)
        off = np.maximum(off, np.abs(np.subtract.outer(force, found.force)).min(axis=1))
        assert (off < 1e-12).sum() >= 8 - (new == "\n"), text[at - 5 : at + 5]
        assert 9 <= found.depth.size <= 10
    assert 100 < refusals < 300


def test_columns_and_units_can_be_given(tmp_path):
    path = tmp_path / "curve.dat"
    path.write_text("0 1.5 2.5 9\n1 2.5 4.5 9\n", "utf-8")
    found = read_curve(path, Reading(("2 [µm]", "3 [mN]"), width=0.5))
    assert found.depth == pytest.approx([1.5e-6, 2.5e-6], rel=1e-14, abs=0)
    assert found.force == pytest.approx([5e-3, 9e-3], rel=1e-14, abs=0)
    path.write_text("Weg [mm]\tKraft [N/m]\n1\t2\n2\t4\n", "utf-8")
    assert read_curve(path, Reading(("weg", "Kraft"))).depth == pytest.approx([1e-3, 2e-3])
    for reading, told in (
        (Reading(("Weg [µm]", "Kraft")), "unit 'µm' of column 'Weg' contradicts the file's own"),
        (Reading(("Weg", "Kraft"), width=1.0), r"width = 1.0 with a force in N/m"),
        (Reading(("Weg", "3")), "no column '3'"),
        (Reading(number=2), "curve = 2: text has one"),
    ):
        with refused(path, told):
            read_curve(path, reading)
    with pytest.raises(ValueError, match=r"width = -1\.0 must be positive"):
        Reading(width=-1.0)


def test_the_layout_can_be_given(tmp_path):
    path = tmp_path / "curve.txt"
    path.write_bytes("1;2\n3;4\ndepth [µm];force [mN/m]\n1,250;2,500\n".encode("utf-16-be"))
    layout = Layout(";", ",", "utf-16-be", skip=2)
    assert read_curve(path, Reading(layout=layout)).force == pytest.approx([2.5e-3])
    with pytest.raises(ValueError, match="is no text in ascii"):
        read_table(path, Layout(encoding="ascii", delimiter=";"))
    for wrong, told in (
        ({"delimiter": ":"}, "delimiter = ':' is unknown; choose one of 'tab'"),
        ({"decimal": "x"}, "decimal = 'x' is unknown"),
        ({"encoding": "morse"}, "encoding = 'morse' is unknown"),
        ({"skip": -1}, "skip = -1 must be a whole number"),
        ({"skip": True}, "skip = True must be a whole number"),
    ):
        with pytest.raises(ValueError, match=told):
            Layout(**wrong)


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("x [µm];z [nm]\n-2,0;4\n-0,5;0,25\n1;1\n", {}),
        ("x [µm];z [nm]\n-2;4;\n-0.5;0.25;\n1;1;\n", {}),
        ("x [µm];z [nm];note\n-2;4;\n-0.5;0.25;\n1;1;\n", {}),
        ("t,z [nm],x [µm]\n7,4,-2\n7,.25,-.5\n7,1,1\n", {}),
        ("Profil 7\nWeg\tHöhe\nµm\tnm\n-2\t4\n-0,5\t0,25\n1\t1\n", {"encoding": "cp1252"}),
        ("9 -2 4\n9 -0.5 0.25\n9 1 1\n", {"columns": ("2 [µm]", "3 [nm]")}),
        ("1 2\n-2 4\n-0.5 0.25\n1 1\n", {"columns": ("1 [µm]", "2 [nm]"), "skip": 1}),
        ("z,x\n4,-2\n.25,-.5\n1,1\n", {"columns": ("x [µm]", "z [nm]")}),
        ("\ufeff-2 .004\n\n-0.5 .00025  # note\n1 .001", {"unit": 1e-6}),
    ],
)
def test_profiles_are_read_by_the_same_reader(tmp_path, text, given):
    path = tmp_path / "scan.txt"
    path.write_bytes(text.encode(given.get("encoding", "utf-8")))
    body = read_profile(path, **given)
    assert body.x == pytest.approx([-2e-6, -0.5e-6, 1e-6], rel=1e-14, abs=0)
    assert body.z == pytest.approx([4e-9, 0.25e-9, 1e-9], rel=1e-14, abs=0)


@pytest.mark.parametrize(
    ("text", "given", "told"),
    [
        ("-1,25;0,5;3\n2,5;3,5;4\n", {}, "3 columns without names; give a file with two"),
        ("1 2\n2 three\n", {"unit": 1.0}, "line 2: column 2 = 'three' must be a finite number"),
        ("1 2\n", {"unit": 1.0}, "at least 2 samples"),
        ("2 0\n1 0\n", {"unit": 1.0}, r"scan.txt'?: x\[1\] = 1.0 does not exceed"),
        ("z [m];x [m]\n1;2\n2;3\n", {"columns": (1,)}, "columns = .* must be two"),
        ("x [mm];z [mm]\n1;2\n2;3\n", {"unit": 1e-6}, "unit = 1e-06 contradicts the file's own"),
        ("x [px];z [m]\n1;2\n2;3\n", {}, "the unit 'px' of column 'x' is no length"),
        ("height (inch);way (inch)\n1;2\n2;3\n", {}, "the unit 'inch' .* is no length"),
        ("way\tx\n1\t2\n2\t3\n", {}, "give a file with two columns, x and z, or their names"),
        ("1,5,2,5\n2,5,3,5\n", {"columns": (1, 2)}, "the commas may separate columns or decimals"),
        ("# x z\n1 2 3\n4 5\n5 6\n", {}, "line 2: 3 cells where line 3 has 2"),
    ],
)
def test_profiles_that_are_not_clear_are_refused(tmp_path, text, given, told):
    path = tmp_path / "scan.txt"
    path.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=told):
        read_profile(path, **given)


def test_springs_and_positions_of_a_piezo_are_read(tmp_path):
    force = 1e-9 * np.linspace(-0.4, 1.0, 20)
    curve = Curve(np.linspace(-20e-9, 60e-9, 20) - force / 0.08, force, 0.08)
    path = written(tmp_path / "a.csv", curve, "Weg [nm];Kraft [nN]")
    found = read_curve(path, Reading(width=1.0, spring_constant=0.08))
    assert found.machine_stiffness == 0.08
    assert found.drive == pytest.approx(curve.drive, abs=1e-14)
    drives = Curve(curve.drive, curve.force)
    path = written(tmp_path / "b.csv", drives, "Piezo [nm];Last [nN]")
    found = read_curve(path, Reading(width=1.0, spring_constant=0.08))
    assert found.depth == pytest.approx(curve.depth, abs=1e-14)
    with refused(path, "'piezo' is the position of the piezo.*--spring-constant"):
        read_curve(path, Reading(width=1.0))
    with refused(path, 'the force is in newtons: .* set geometry = "axisymmetric"'):
        read_curve(path)
    with pytest.raises(ValueError, match=r"spring_constant = 0\.0 must be positive"):
        Reading(spring_constant=0.0)
    scene = tmp_path / "s.toml"
    scene.write_text(SPHERE + "[measured]\nspring_constant = 0.08\n", "utf-8")
    assert load(scene).measured.spring_constant == 0.08


def test_plain_hdf5_files_are_read(tmp_path):
    library = pytest.importorskip("h5py", reason="the extra elastocap[afm] is not installed")
    path = tmp_path / "one.h5"
    with library.File(path, "w") as file:
        for name, values, unit in (("depth", [1.0, 2.0], "nm"), ("Force", [3.0, 4.5], "nN")):
            file.create_dataset(f"segment/{name}", data=values).attrs["unit"] = unit
    found = read_curve(path, Reading(width=1.0))
    assert found.depth == pytest.approx([1e-9, 2e-9]) and found.force == pytest.approx(
        [3e-9, 4.5e-9]
    )
    assert curves(path, Reading()) == [str(path)]
    with library.File(path, "a") as file:
        file["more"] = [1.0]
    with refused(path, "must hold data sets of one length"):
        read_curve(path, Reading(width=1.0))


def test_a_sphere_is_a_turned_circle(tmp_path):
    scene = tmp_path / "s.toml"
    scene.write_text(SPHERE, "utf-8")
    assert load(scene).scene.indenter == Circle(5e-6)
    scene.write_text(SPHERE.replace("axisymmetric", "line"), "utf-8")
    with refused(scene, 'indenter.shape = "sphere" is a turned body: set geometry'):
        load(scene)
