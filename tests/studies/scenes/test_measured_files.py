"""Files as instruments and spreadsheets write them: read right or refused, never read wrong."""

import numpy as np
import pytest
from scene_files import refused

from energy import read_profile
from energy.text_table import Layout, read_table
from studies.scenes.curve_file import Reading, read_curve

DEPTH = np.array([-0.125, 0.25, 1.5, 0.75]) * 1e-6


FORCE = np.array([0.0615, -0.25, 1000.5, 1e-3]) * 1e-3


RIGHT = [  # name, text, encoding: DEPTH in µm and FORCE in mN/m
    (
        "semicolons and decimal commas",
        "depth [µm];force [mN/m]\n-0,1250;0,06150\n0,25;-0,25\n1,5;1000,5\n0,75;1,0E-03\n",
        "utf-8",
    ),
    (
        "tabs, carriage returns, Windows's encoding",
        "Depth (µm)\tForce (mN/m)\r\n-0.125\t.0615\r\n0.25\t-0.25\r\n1.5\t1000.5\r\n0.75\t1e-3\r\n",
        "cp1252",
    ),
    (
        "tabs and decimal commas in UTF-16, as Excel saves Unicode text",
        "depth [µm]\tforce [mN/m]\r\n-0,125\t0,0615\r\n0,25\t-0,25\r\n1,5\t1000,5\r\n"
        "0,75\t0,001\r\n",
        "utf-16",
    ),
    (
        "UTF-16 without a mark",
        "depth [µm],force [mN/m]\n-0.125,0.0615\n0.25,-0.25\n1.5,1000.5\n0.75,0.001\n",
        "utf-16-le",
    ),
    (
        "quoted decimal commas between commas",
        '"depth [µm]","force [mN/m]"\n"-0,125","0,0615"\n'
        '"0,25","-0,25"\n"1,5","1000,5"\n"0,75","0,001"\n',
        "utf-8-sig",
    ),
    (
        "a preamble of words and numbers",
        "Instrument: 7;\nDate;12.03.2024\nPoints;4\n\ndepth [µm];force [mN/m]\n"
        "-0.125;0.0615\n0.25;-0.25\n1.5;1000.5\n0.75;0.001\n",
        "latin-1",
    ),
    (
        "units in a second row",
        "Time;Depth;Force\ns;µm;mN/m\n0;-0,125;0,0615\n1;0,25;-0,25\n2;1,5;1000,5\n3;0,75;0,001\n",
        "cp1252",
    ),
    (
        "units in brackets in a second row, blanks in columns",
        "  depth      force\n  [µm]      [mN/m]\n -0.125     0.0615\n  0.25     -0.25\n"
        "  1.5    1000.5\n  0.75      0.001\n",
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
        "depth [µm];force [mN/m];\n-0.125;0.0615;\n0.25;-0.25;\n1.5;1000.5;\n0.75;0.001;\n;;\n",
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
        "sep=;\r\ndepth / µm;force / mN/m\r\n\u22120,125;0,0615\r\n0,25;\u22120,25\r\n"
        "1,5;1000,5\r\n0,75;0,001\r\n",
        "utf-8",
    ),
    (
        "old Macintosh line ends",
        "depth in µm,force in mN/m\r-0.125,0.0615\r0.25,-0.25\r1.5,1000.5\r0.75,0.001",
        "utf-8",
    ),
]


WRONG = [  # name, bytes, what is said
    ("empty", b" \r\n", "is empty; give a file with columns of numbers"),
    ("binary", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\2\3", "is no text"),
    ("words", b"depth [m], force [N/m]\nsee the other file\n", "no line has two numbers"),
    (
        "ragged",
        b"depth [m];force [N/m]\n1,5;2\n2,5;3;4\n3,5;4\n",
        "line 3: 3 cells where line 1 has 2; .*'2,5;3;4'",
    ),
    (
        "a decimal comma between commas",
        b"depth [m],force [N/m]\n1,5,2,5\n2,5,3,5\n",
        "line 1: 2 cells where line 2 has 4",
    ),
    (
        "first row ragged",
        b"depth [m];force [N/m]\n1\n2;3\n3;4\n",
        "line 2: 1 cell where line 3 has 2",
    ),
    (
        "both decimal marks",
        b"no;depth [m];force [N/m]\n1;1,5;2.5\n2;2,5;3.5\n",
        "line 2: '.*' has the mark '.', other cells have",
    ),
    (
        "thousands or decimals",
        b"depth [nm];force [N/m]\n-1,250;2,500\n-2,250;3,500\n",
        "line 2: '-1,250' may be a number with three decimals or one in thousands",
    ),
    (
        "thousands and decimals",
        b"depth [nm];force [N/m]\n1.234,5;2,5\n2,5;3,5\n3,5;4,5\n",
        "line 2: '1.234,5' must be a number with the decimal mark ','",
    ),
    (
        "a word among the numbers",
        b"depth [m]\tforce [N/m]\n1\t2\n2\toverload\n3\t4\n",
        "line 3: force = 'overload' must be a finite number",
    ),
    (
        "a missing cell",
        b"depth [m]\tforce [N/m]\n1\t2\n2\t\n3\t4\n",
        "line 3: force = '' must be a finite number",
    ),
    (
        "not finite",
        b"depth [m]\tforce [N/m]\n1\t2\n2\t1e999\n3\t4\n",
        "line 3: force = '1e999' must be a finite number",
    ),
    (
        "two blocks",
        b"depth [m];force [N/m]\n1;2\n2;3\nunloading\n1;1\n0;0\n",
        "line 4: 1 cell where line 1 has 2; .*'unloading'",
    ),
    (
        "two forces",
        b"depth [m];force [N/m];force [N/m]\n1;2;3\n2;3;4\n",
        "2 columns 'force': its line 1 names 3 columns",
    ),
    ("no names", b"1;2\n2;3\n", "no column 'depth': it has 2 columns without names"),
    ("no units", b"depth;force\n1;2\n2;3\n", "column 'depth' has no unit"),
    ("megametres", b"depth [Mm];force [N/m]\n1;2\n2;3\n", "the unit 'Mm' of the depth"),
    ("newtons", b"depth [m];force [N]\n1;2\n2;3\n", "the force is in newtons.*--width"),
]


@pytest.mark.parametrize(("text", "encoding"), [c[1:] for c in RIGHT], ids=[c[0] for c in RIGHT])
def test_what_instruments_and_spreadsheets_write_is_read(tmp_path, text, encoding):
    path = tmp_path / "curve.csv"
    path.write_bytes(text.encode(encoding))
    found = read_curve(path)
    assert found.depth == pytest.approx(DEPTH, rel=1e-14, abs=0)
    assert found.force == pytest.approx(FORCE, rel=1e-14, abs=0)


@pytest.mark.parametrize(("data", "told"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_what_is_not_clear_is_refused(tmp_path, data, told):
    path = tmp_path / "curve.csv"
    path.write_bytes(data)
    with refused(path, told):
        read_curve(path)


def test_damaged_files_are_never_read_wrong(tmp_path):
    """A character of the numbers deleted, doubled or replaced: the other rows stay as they are."""
    rng, path = np.random.default_rng(8), tmp_path / "curve.csv"
    depth, force = np.linspace(-2, 2, 9) + 0.25, np.linspace(-1, 3, 9) - 0.125
    rows = [f"{d:.4f};{p:.4f}".replace(".", ",") for d, p in zip(depth, force, strict=True)]
    head = "depth [m];force [N/m]\n"
    text = head + "\n".join(rows) + "\n"
    refusals = 0
    for _ in range(300):
        at = int(rng.integers(len(head), len(text)))
        new = ["", text[at] * 2, *"; \t.,x\n"][rng.integers(9)]
        path.write_text(text[:at] + new + text[at + 1 :], "utf-8")
        try:
            found = read_curve(path)
        except ValueError:
            refusals += 1
            continue
        same = [
            abs(found.depth - d).min() < 1e-12 and abs(found.force - p).min() < 1e-12
            for d, p in zip(depth, force, strict=True)
        ]
        assert sum(same) >= 8 - (new == "\n"), text[at - 5 : at + 5]
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
        ("1 2\n2 three\n", {}, "line 2: column 2 = 'three' must be a finite number"),
        ("0 0\n1 nan\n", {}, "line 2: column 2 = 'nan' must be a finite number"),
        ("x z\n", {}, "no line has two numbers"),
        ("1 2\n", {}, "at least 2 samples"),
        ("2 0\n1 0\n", {}, r"scan.txt'?: x\[1\] = 1.0 does not exceed"),
        ("x;z\n0,5;1,25;3\n1,5;2,25;4\n", {}, "line 2: 3 cells|line 1: 2 cells"),
        ("z [m];x [m]\n1;2\n2;3\n", {"columns": (1,)}, "columns = .* must be two"),
        ("x [mm];z [mm]\n1;2\n2;3\n", {"unit": 1e-6}, "unit = 1e-06 contradicts the file's own"),
        ("x [px];z [m]\n1;2\n2;3\n", {}, "the unit 'px' of column 'x' is no length"),
        ("height (inch);way (inch)\n1;2\n2;3\n", {}, "the unit 'inch' .* is no length"),
        ("way\tx\n1\t2\n2\t3\n", {}, "give a file with two columns, x and z, or their names"),
        ("z\tway\n1\t2\n2\t3\n", {}, "give a file with two columns, x and z, or their names"),
        ("x;z\n1,5\n2,5\n", {}, "line 1: 1 cell where line 2 has 2"),
        ("1,5,2,5\n2,5,3,5\n", {"columns": (1, 2)}, "the commas may separate columns or decimals"),
        ("# x z\n1 2 3\n4 5\n5 6\n", {}, "line 2: 3 cells where line 3 has 2"),
    ],
)
def test_profiles_that_are_not_clear_are_refused(tmp_path, text, given, told):
    path = tmp_path / "scan.txt"
    path.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=told):
        read_profile(path, **given)
