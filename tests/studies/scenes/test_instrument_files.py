"""Force curves in instrument files: read by their library, or refused with what they lack."""

import sys

import numpy as np
import pytest
from scene_files import refused

from studies.scenes.curve_file import Reading, read_curve


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


def test_instrument_files_say_what_they_lack(tmp_path, monkeypatch):
    path = tmp_path / "curve.jpk-force"
    with refused(path, "is no file"):
        read_curve(path, Reading(width=1.0))
    path.write_bytes(b"")
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "afmformats", None)
        with refused(path, r"an instrument file; install elastocap\[afm\]"):
            read_curve(path, Reading(width=1.0))

    class Missing(BaseException):
        pass

    class Data(dict):
        columns = property(list)
        metadata = {}  # noqa: RUF012

    class Library:
        data = ()

        def load_data(self, path, modality):
            assert modality == "force-distance"
            if not self.data:
                raise Missing("no sensitivity")
            return self.data

    library = Library()
    monkeypatch.setitem(sys.modules, "afmformats", library)
    with refused(path, "afmformats cannot read it: Missing: no sensitivity"):
        read_curve(path, Reading(width=1.0))
    one = Data({"force": [1.0, 2.0], "height (piezo)": [0.5, 0.25]})
    library.data = (one,)
    with refused(path, "states no spring constant"):
        read_curve(path, Reading(width=1.0))
    one.metadata = {"spring constant": 4.0}
    found = read_curve(path, Reading(width=0.5))
    assert found.depth.tolist() == [-0.75, -0.75] and found.force.tolist() == [2.0, 4.0]
    library.data = (Data({"force": [1.0]}), Data({"force": [3.0], "tip position": [-0.5]}))
    with refused(path, "curve = None, but it holds 2 force-distance curves; give one of 1 to 2"):
        read_curve(path, Reading(width=0.5))
    assert read_curve(path, Reading(width=0.5, number=2)).depth.tolist() == [0.5]
    with refused(path, "states no heights"):
        read_curve(path, Reading(width=0.5, number=1))
    with refused(path, "columns and layout are for text"):
        read_curve(path, Reading(("1", "2"), width=0.5))
