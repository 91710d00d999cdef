"""Files as instruments and spreadsheets write them: read right or refused, never read wrong."""

import itertools

import numpy as np
import pytest
from file_cases import DEPTH, FORCE, RIGHT, WRONG
from scene_files import refused

from energy import read_profile
from energy.text_table import Layout, read_table
from studies.scenes.curve_file import Reading, read_curve


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


def written(rng, depth, force, delimiter, decimal, encoding, style):
    """A file of depth in nm and force in mN/m in a random but unambiguous style."""
    digits = int(rng.integers(1, 7))
    rows = [
        delimiter.join(f"{v:.{digits}f}".replace(".", decimal) for v in row)
        for row in zip(depth, force, strict=True)
    ]
    names = [["depth [nm]", "force [mN/m]"], ["Depth (nm)", "Force (mN/m)"]][rng.integers(2)]
    header = [delimiter.join(names)]
    if style == "units":
        header = [delimiter.join(["depth", "force"]), delimiter.join(["nm", "mN/m"])]
    preamble = ["Versuch 12", "Datum: 3.4.2024", ""][: int(rng.integers(4))]
    if style == "comments":
        preamble = [f"# {line}" for line in preamble]
    end = "\r\n" if rng.integers(2) else "\n"
    text = end.join([*preamble, *header, *rows]) + end * int(rng.integers(3))
    return text.encode(encoding), digits


def test_random_files_are_read_right_or_refused(tmp_path):
    rng, path, said = np.random.default_rng(4), tmp_path / "curve.txt", []
    styles = itertools.product(
        ("\t", ";", ",", "   "), ".,", ("utf-8", "cp1252", "utf-16"), ("plain", "units", "comments")
    )
    cases = [case for case in styles if case[:2] != (",", ",")]
    for case in cases * 3:
        depth, force = rng.uniform(-3000, 3000, (2, int(rng.integers(1, 9))))
        data, digits = written(rng, depth, force, *case)
        path.write_bytes(data)
        try:
            found = read_curve(path)
        except ValueError as error:
            said.append(str(error))
            continue
        assert found.depth == pytest.approx(1e-9 * depth.round(digits), rel=1e-12, abs=1e-24)
        assert found.force == pytest.approx(1e-3 * force.round(digits), rel=1e-12, abs=1e-18)
    assert len(said) < 0.1 * 3 * len(cases)
    assert all("may be a number with three decimals or one in thousands" in one for one in said)


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
