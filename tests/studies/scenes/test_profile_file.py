"""Profiles from files: the plain formats, and clear words for the rest."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from energy import Sampled, read_profile

X, Z = np.array([-2.0, -0.5, 1.0, 3.0]), np.array([4.0, 0.25, 1.0, 9.0])
ROWS = list(zip(X.tolist(), Z.tolist(), strict=True))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.txt", "\n".join(f"{x} {z}" for x, z in ROWS)),
        ("a.csv", "x,z\n" + "\n".join(f"{x},{z}" for x, z in ROWS) + "\n"),
        ("a.csv", "# measured\nx [µm]; z [µm]\n" + "\n".join(f"{x};{z}" for x, z in ROWS)),
        ("a.dat", "\ufeff" + "\n\n".join(f"{x}\t{z}  # note" for x, z in ROWS)),
    ],
)
def test_two_columns_of_text(name, text, tmp_path):
    (tmp_path / name).write_text(text, "utf-8")
    body = read_profile(tmp_path / name, unit=1e-6)
    assert isinstance(body, Sampled) and body.kind == "linear"
    assert np.array_equal(body.x, X * 1e-6) and np.array_equal(body.z, Z * 1e-6)


def test_arrays(tmp_path):
    np.savez(tmp_path / "a.npz", x=X, z=Z)
    (tmp_path / "a.npz").rename(tmp_path / "a.NPZ")
    assert np.array_equal(read_profile(tmp_path / "a.NPZ", kind="smooth").z, Z)
    np.savez(tmp_path / "b.npz", position=X)
    with pytest.raises(ValueError, match=r"holds the arrays \['position'\]; name them x and z"):
        read_profile(tmp_path / "b.npz")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2\n2 three\n", "line 2: column 2 = 'three' must be a finite number"),
        ("1 2 3\n", "3 columns without names; give a file with two columns"),
        ("x z\n", "no line has two numbers"),
        ("1 2\n", "at least 2 samples"),
        ("2 0\n1 0\n", r"a.txt'?: x\[1\] = 1.0 does not exceed"),
        ("0 0\n1 nan\n", "line 2: column 2 = 'nan' must be a finite number"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(text, message, tmp_path):
    (tmp_path / "a.txt").write_text(text, "utf-8")
    with pytest.raises(ValueError, match=message):
        read_profile(tmp_path / "a.txt")


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
    monkeypatch.setitem(sys.modules, "SurfaceTopography", scan(2))
    with pytest.raises(ValueError, match="area scan; give a line scan"):
        read_profile(tmp_path / "scan.opd")
    with pytest.raises(ValueError, match="is no file"):
        read_profile(tmp_path / "none.txt")
    with pytest.raises(ValueError, match=r"unit = 0.0 must be positive"):
        read_profile(tmp_path / "scan.opd", unit=0.0)
