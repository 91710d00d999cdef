"""Layouts of files that instruments write, each made up and small: read right, or refused in words.

Every case names the layout it has.
"""

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from support.scene_files import refused

from energy import Sampled, read_profile
from studies.scenes.curve_file import Reading, count, read_curve
from studies.scenes.fit.many import curves
from studies.shared.batches import each, silent

SPRING = 0.08  # N/m
SENSITIVITY = 50e-9  # m/V
PIEZO = np.array([-30.5, 10.0, 40.0, 12.0]) * 1e-9
VOLTS = np.array([0.1, -0.05, 0.3, -0.2])
DEFLECTION = SENSITIVITY * VOLTS
FORCE = SPRING * DEFLECTION
ON_A_CANTILEVER = Reading(width=1.0, spring_constant=SPRING, sensitivity=SENSITIVITY)


def write(path, header, *columns):
    """A text file with these columns between tabs below a header."""
    rows = ["\t".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text(header + "\n" + "\n".join(rows) + "\n", "utf-8")
    return path


def assert_close(found, expected):
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("names", [("Depth (nm)", "Load (nN)"), ("depth", "load"), None])
def test_columns_of_one_name_by_their_units(tmp_path, names):
    """A nanoindenter's file with each signal in volts, too: the unit of a length decides."""
    header = "Depth (nm)\tLoad (nN)\tDepth (V)\tLoad (V)"
    path = write(tmp_path / "a.txt", header, PIEZO * 1e9, FORCE * 1e9, VOLTS, VOLTS)
    found = read_curve(path, Reading(names, width=1.0))
    assert_close(found.depth, PIEZO)
    assert_close(found.force, FORCE)


def test_columns_of_one_name_and_kind_are_refused(tmp_path):
    path = write(tmp_path / "a.txt", "Depth (nm)\tDepth (µm)\tLoad (nN)", PIEZO, PIEZO, FORCE)
    with refused(path, "2 columns 'depth'"):
        read_curve(path, Reading(("depth", "load"), width=1.0))


@pytest.mark.parametrize("end", ["eoh", "[Data]", "Data points:", "eoh\n# begin"])
def test_a_line_without_numbers_below_the_header(tmp_path, end):
    """The mark that ends a header, as in files of Hysitron and of Optics11 instruments."""
    path = tmp_path / "a.txt"
    path.write_text(f"Piezo [nm]\tForce [nN]\n{end}\n-30,5\t0,1\n-20,5\t0,3\n", "utf-8")
    found = read_curve(path, Reading(width=1.0, spring_constant=SPRING))
    assert_close(found.drive, np.array([-30.5e-9, -20.5e-9]))


def test_a_line_with_a_number_below_the_header_is_refused(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("Depth [nm]\tForce [nN]\n12\n-30,5\t0,1\n-20,5\t0,3\n", "utf-8")
    with refused(path, "line 2: 1 cell where line 3 has 2"):
        read_curve(path, Reading(width=1.0))


def test_names_units_and_comments_in_three_rows(tmp_path):
    """The columns of a plotting program: long names, units, comments."""
    path = tmp_path / "a.txt"
    path.write_text("Depth\tForce\nµm\tmN/m\nSample A\tSample A\n1\t2\n3\t4\n", "utf-8")
    assert_close(read_curve(path).force, np.array([2e-3, 4e-3]))


@pytest.mark.parametrize("row_end", ["", ",", ",,"])
def test_empty_columns_at_the_end_are_dropped(tmp_path, row_end):
    """A profilometer's spreadsheet with more columns than it fills."""
    path = tmp_path / "a.csv"
    rows = "".join(f"{x},{z}{row_end}\n" for x, z in ((0, 3), (1, 0), (2.5, 2)))
    path.write_text("Lateral um,Raw Micrometer,,\n" + rows, "utf-8")
    body = read_profile(path)
    assert_close(body.x, np.array([0, 1e-6, 2.5e-6]))
    assert_close(body.z, np.array([3e-6, 0, 2e-6]))


@pytest.mark.parametrize(
    ("unit", "size"),
    [("microns", 1e-6), ("Micrometer", 1e-6), ("nanometers", 1e-9), ("metres", 1.0), ("mm", 1e-3)],
)
def test_units_are_known_as_words(tmp_path, unit, size):
    path = tmp_path / "a.txt"
    path.write_text(f"x [{unit}]\tz [{unit}]\n0\t3\n1\t0\n2\t2\n", "utf-8")
    assert_close(read_profile(path).x, size * np.array([0, 1.0, 2.0]))


def test_a_profile_without_units_is_refused(tmp_path):
    """Two columns of a profilometer without a header."""
    path = tmp_path / "a.txt"
    path.write_text("0.000\t-16.0\n0.001\t-18.9\n0.002\t-15.9\n", "utf-8")
    with refused(path, r"column 1 has no unit: .*columns=\(.*or give unit=1e-6"):
        read_profile(path)
    assert read_profile(path, unit=1e-3).x[1] == pytest.approx(1e-6)
    assert read_profile(path, columns=("1 [mm]", "2 [nm]")).z[1] == pytest.approx(-18.9e-9)


@pytest.mark.parametrize("unit", ["nm", "V"])
@pytest.mark.parametrize("name", ["Piezo", "Height"])
def test_forces_from_deflections(tmp_path, name, unit):
    """A deflection over the piezo position or over a height, which falls on approach."""
    position = PIEZO if name == "Piezo" else -PIEZO
    signal = DEFLECTION * 1e9 if unit == "nm" else VOLTS
    path = write(tmp_path / "a.txt", f"{name} [nm]\tDeflection [{unit}]", position * 1e9, signal)
    found = read_curve(path, ON_A_CANTILEVER)
    assert_close(found.force, FORCE)
    assert_close(found.drive, PIEZO)
    assert_close(found.depth, PIEZO - DEFLECTION)
    assert found.machine_stiffness == SPRING


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "'Deflection' in V is a deflection; .*--spring-constant"),
        ({"spring_constant": SPRING}, "'Deflection' is a signal in V; .*--sensitivity"),
        ({"spring_constant": SPRING, "sensitivity": 1.0}, "the force is in newtons"),
    ],
)
def test_deflections_need_their_calibration(tmp_path, given, message):
    path = write(tmp_path / "a.txt", "Piezo [nm]\tDeflection [V]", PIEZO, VOLTS)
    with refused(path, message):
        read_curve(path, Reading(("Piezo", "Deflection"), **given))


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("names", ["twice", "extend", "retract first"])
def test_pairs_of_columns_make_one_loop(tmp_path, names, reverse):
    """Extending and retracting side by side, the latter shorter and perhaps in the other order."""
    depth_in = np.array([-20.0, 0, 20, 40])
    force_in = np.array([0.0, 0, 1, 2])
    depth_out = np.array([40.0, 10, -20])
    force_out = np.array([2.0, -0.5, 0])
    if reverse:
        depth_out = depth_out[::-1]
        force_out = force_out[::-1]
    out = [f"{depth:g}\t{force:g}" for depth, force in zip(depth_out, force_out, strict=True)]
    inwards = [f"{depth:g}\t{force:g}" for depth, force in zip(depth_in, force_in, strict=True)]
    out.append("\t")
    pairs = [inwards, out]
    columns = None
    header = ["Depth (nm)\tForce (nN)", "Depth (nm)\tForce (nN)"]
    if names != "twice":
        header = ["Depth Ex (nm)\tForce Ex (nN)", "Depth Rt (nm)\tForce retract (nN)"]
        columns = ("Depth Ex", "Force Ex", "Depth Rt", "Force retract")
    if names == "retract first":
        columns = columns[2:] + columns[:2]
    lines = ["\t".join(header)] + ["\t".join(row) for row in zip(*pairs, strict=True)]
    path = tmp_path / "a.txt"
    path.write_text("\n".join(lines) + "\n", "utf-8")
    found = read_curve(path, Reading(columns, width=1.0))
    assert_close(found.depth, np.array([-20, 0, 20, 40, 40, 10, -20]) * 1e-9)
    assert_close(found.force, np.array([0, 0, 1, 2, 2, -0.5, 0]) * 1e-9)


@pytest.mark.parametrize("given", [{"flip": True}, {"flip": False}, {"level": "tilt"}, {}])
def test_a_scan_that_may_be_upside_down(tmp_path, given):
    """A profilometer's bump: its ends are its lowest points."""
    path = tmp_path / "a.txt"
    x = np.linspace(-5, 5, 11)
    z = 10 - 0.3 * x**2
    path.write_text("x [µm]\tz [µm]\n" + "".join(map("{:g}\t{:g}\n".format, x, z)), "utf-8")
    if "flip" not in given:
        with pytest.raises(
            ValueError, match=r"is at an end of the scan, .*upside down \(flip=True\)"
        ):
            read_profile(path, **given)
        return
    body = read_profile(path, **given)
    assert_close(body.z, (-1e-6 if given["flip"] else 1e-6) * z)


def test_tilt_and_curvature_are_removed(tmp_path):
    path = tmp_path / "a.txt"
    x = np.linspace(0, 9, 31)
    waves = np.cos(4 * np.pi * x / 9)
    tilted = waves + 3 * x - 7
    curved = tilted + 0.5 * x**2
    path.write_text("x [m]\tz [m]\tc [m]\n", "utf-8")
    with path.open("a", encoding="utf-8") as file:
        np.savetxt(file, np.stack([x, tilted, curved], axis=1), delimiter="\t")
    level = read_profile(path, columns=("x", "z"), level="tilt", flip=False)
    bowl = read_profile(path, columns=("x", "c"), level="curvature", flip=False)
    for body, degree in ((level, 1), (bowl, 2)):
        rest = np.polynomial.Polynomial.fit(body.x, body.z - waves, degree)
        assert_close(body.z - waves, rest(x))
        assert np.abs(np.polynomial.Polynomial.fit(x, body.z, degree).coef).max() < 1e-12


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"level": "plane"}, "level = 'plane' is unknown"),
        ({"flip": 1}, "flip = 1 must be True, False or None"),
        ({"line": 2}, "line = 2 is for area scans"),
        ({"cutoff": -1.0}, r"cutoff = -1\.0 must be positive"),
        ({"cutoff": 1.0}, r"cutoff = 1\.0 is shorter than two spacings"),
        ({"cutoff": 7.0}, r"cutoff = 7\.0: .*a cut-off at each end is lost"),
    ],
)
def test_options_of_profiles_are_checked(tmp_path, given, message):
    path = tmp_path / "a.txt"
    path.write_text("x [m]\tz [m]\n0\t3\n1\t0\n2\t0\n3\t1\n4\t5\n", "utf-8")
    with pytest.raises(ValueError, match=message):
        read_profile(path, **given)


@pytest.mark.parametrize("wave", [0.25, 0.5, 1.0, 2.0, 8.0])
def test_the_filter_passes_waves_as_the_standard_says(wave):
    """ISO 16610-21: amplitude exp(-π (α λc/λ)²), which is ½ at the cut-off."""
    x = np.linspace(0, 20, 4001)
    body = Sampled(x, np.cos(2 * np.pi * x / wave)).filtered(1.0)
    passed = np.exp(-math.log(2) / wave**2)
    assert body.extent == pytest.approx((1.0, 19.0), abs=1e-9)
    assert body.z == pytest.approx(passed * np.cos(2 * np.pi * body.x / wave), abs=2e-4)


def test_filter_of_straight_lines_and_uneven_samples():
    """The filter keeps straight lines and takes uneven samples."""
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(0, 20, 2000))
    body = Sampled(x, 3 * x - 2, "smooth").filtered(2.0)
    assert body.kind == "smooth"
    assert body.z == pytest.approx(3 * body.x - 2, abs=1e-9)
    assert np.ptp(np.diff(body.x)) < 1e-9


def test_an_area_scan_gives_one_line_or_the_mean(tmp_path, monkeypatch):
    heights = np.array([[3.0, 5.0], [0.0, 1.0], [4.0, 2.0]])
    x, y = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], indexing="ij")
    scan = SimpleNamespace(dim=2, unit="m", positions_and_heights=lambda: (x, y, heights))
    scan.to_unit = lambda unit: scan
    library = SimpleNamespace(read_topography=lambda path: scan)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", library)
    path = tmp_path / "a.opd"
    path.write_bytes(b"\0")
    assert_close(read_profile(path, line=2).z, heights[:, 1])
    assert_close(read_profile(path, line="mean").z, heights.mean(axis=1))
    for line in (None, 0, 3, "first"):
        with pytest.raises(
            ValueError, match="is an area scan; give the number of one of its 2 lines"
        ):
            read_profile(path, line=line)


LIBRARY = """
import os
import numpy as np

class Archive:
    handle = None

class Curve:
    columns = ("force", "height (measured)")
    metadata = {"spring constant": 0.08}

    def __init__(self, number):
        self.number = number

    def __getitem__(self, name):
        values = []
        for i in range(SIZE):
            os.lseek(Archive.handle, 8 * (self.number * SIZE + i), os.SEEK_SET)
            values.append(np.frombuffer(os.read(Archive.handle, 8))[0])
        return np.array(values)

def load_data(path, modality):
    if Archive.handle is None:
        Archive.handle = os.open(path, os.O_RDONLY)
    return [Curve(number) for number in range(COUNT)]
"""


@pytest.fixture
def library(tmp_path, monkeypatch):
    """A library that keeps an archive open and reads every curve at one position in the file.

    It is a module in a file, so that processes find it however they are started.
    """

    def installed(count, size=0):
        folder = tmp_path / "library"
        folder.mkdir()
        text = LIBRARY.replace("SIZE", str(size)).replace("COUNT", str(count))
        (folder / "afmformats.py").write_text(text, "utf-8")
        monkeypatch.delitem(sys.modules, "afmformats", raising=False)
        monkeypatch.syspath_prepend(folder)

    yield installed
    sys.modules.pop("afmformats", None)


def depth_of(case):
    """The depth of one curve of a map, in any process."""
    path, number = case
    return read_curve(path, Reading(width=1.0, number=number)).depth


def test_every_process_opens_a_map_of_its_own(tmp_path, library):
    """The count of curves must leave no archive open that processes would share."""
    size = 2000
    library(4, size)
    path = tmp_path / "map.jpk-force-map"
    numbers = np.arange(4.0 * size)
    path.write_bytes(numbers.tobytes())
    expected = -(1 + 1 / SPRING) * numbers.reshape(4, size)
    assert count(path) == 4
    assert "afmformats" not in sys.modules
    found = list(each(depth_of, [(path, n) for n in range(1, 5)], 2, show=silent))
    assert np.array_equal(np.array(found), expected)


def test_a_creep_curve_is_no_load_path(tmp_path, library):
    library(0)
    path = tmp_path / "creep.jpk-force"
    path.write_bytes(b"\0")
    with refused(path, "holds no force-distance curve: a creep or relaxation curve"):
        curves(path, Reading())


def instrument(monkeypatch, metadata, **columns):
    """An instrument file of one curve with these columns."""
    data = {name.replace("_", " "): np.array(values) for name, values in columns.items()}
    data = {name.replace("height", "height (measured)"): values for name, values in data.items()}
    curve = SimpleNamespace(columns=list(data), metadata=metadata)
    kind = type("Data", (), {"__getitem__": lambda self, name: data[name]})
    found = kind()
    found.columns = curve.columns
    found.metadata = metadata
    library = SimpleNamespace(load_data=lambda path, modality: [found])
    monkeypatch.setitem(sys.modules, "afmformats", library)


def test_spring_constant_supplied_or_replaced(tmp_path, monkeypatch):
    """A spring constant supplies or replaces that of an instrument."""
    path = tmp_path / "a.jpk-force"
    path.write_bytes(b"\0")
    for stated in (None, 0.04):
        instrument(monkeypatch, {"spring constant": stated}, force=FORCE, height=-PIEZO)
        found = read_curve(path, Reading(width=1.0, spring_constant=SPRING))
        force = FORCE * (1.0 if stated is None else SPRING / stated)
        assert_close(found.force, force)
        assert_close(found.drive, PIEZO)
        assert found.machine_stiffness == SPRING
    instrument(monkeypatch, {}, force=FORCE, height=-PIEZO)
    with refused(path, "states no spring constant .*--spring-constant"):
        read_curve(path, Reading(width=1.0))


def test_a_sensitivity_replaces_that_of_an_instrument(tmp_path, monkeypatch):
    path = tmp_path / "a.jpk-force"
    path.write_bytes(b"\0")
    metadata = {"spring constant": SPRING, "sensitivity": 2 * SENSITIVITY}
    instrument(monkeypatch, metadata, force=2 * FORCE, height=-PIEZO)
    found = read_curve(path, Reading(width=1.0, sensitivity=SENSITIVITY))
    assert_close(found.force, FORCE)
    assert_close(found.depth, PIEZO - DEFLECTION)
    instrument(monkeypatch, {"spring constant": SPRING}, force=FORCE, height=-PIEZO)
    with refused(path, "sensitivity = .* the file states none that it could replace"):
        read_curve(path, Reading(width=1.0, sensitivity=SENSITIVITY))


def test_paths_may_be_text(tmp_path):
    path = write(tmp_path / "a.csv", "depth [m]\tforce [N/m]", PIEZO, FORCE)
    assert_close(read_curve(str(path)).depth, PIEZO)


@pytest.mark.parametrize("own_tip", [False, True])
def test_an_instrument_whose_height_rises_towards_the_layer(tmp_path, monkeypatch, own_tip):
    """Its sign is reversed, and said so; a position of the tip made of that height is not taken."""
    path = tmp_path / "a.jpk-force"
    path.write_bytes(b"\0")
    way = np.linspace(-300e-9, 60e-9, 60)
    drive = np.concatenate([way, way[::-1]])
    force = np.maximum(drive, 0.0) * SPRING / 2
    metadata = {"spring constant": SPRING}
    for height, said in ((-drive, False), (drive, True)):
        columns = {"force": force, "height": height}
        if own_tip:
            columns["tip_position"] = height + force / SPRING
        instrument(monkeypatch, metadata, **columns)
        found = read_curve(path, Reading(width=1.0))
        assert_close(found.drive, drive)
        assert_close(found.force, force)
        assert bool(found.notes) == said
    assert found.notes[0].startswith("the layer is where 'height (measured)' is larger, against")


def test_a_deflection_in_nm_before_its_signal(tmp_path):
    """Of two columns of one name that in volts needs a sensitivity, too."""
    header = "Piezo (nm)\tDeflection (V)\tDeflection (nm)"
    path = write(tmp_path / "a.txt", header, PIEZO * 1e9, VOLTS, DEFLECTION * 1e9)
    found = read_curve(path, Reading(width=1.0, spring_constant=SPRING))
    assert_close(found.force, FORCE)
