"""One BLAS thread per process, an end for a test that hangs, a look at every figure drawn."""

import gc
import os
import signal

# tests run on all cores: threads of one would wait for those of another
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read by numpy when it is imported

import numpy as np
import pytest

from studies.shared import figures

EDGE = 0.02  # inches that lines may be wide
LONGEST = 600
HANGS = 7200  # seconds of the processor, and of waiting beside whatever else runs


def pytest_collection_finish():
    """What is collected stays: the garbage collector need not look through thousands of tests."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _ends():
    """A limit for every test, where the system has such timers."""

    def late(*_):
        raise TimeoutError(f"the test has not ended in {LONGEST} s of processor time")

    signals = signal.SIGVTALRM, signal.SIGALRM
    before = [signal.signal(each, late) for each in signals]
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    signal.setitimer(signal.ITIMER_REAL, HANGS)
    yield
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    signal.setitimer(signal.ITIMER_REAL, 0)
    for each, one in zip(signals, before, strict=True):
        signal.signal(each, one)


@pytest.fixture(autouse=True)
def _figures_are_whole(monkeypatch):
    written = figures.save

    def save(figure, path, *pdf):
        found = written(figure, path, *pdf)
        check(figure, path.name)
        return found

    monkeypatch.setattr(figures, "save", save)


def check(figure, name):
    """AssertionError for a figure without a title, a text beyond its edge, a point that is cut."""
    assert figures.title(figure), f"{name} has no title"
    box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert box.x0 > -EDGE and box.x1 < width + EDGE, f"{name} is cut at a side: {box}"
    assert box.y0 > -EDGE and box.y1 < height + EDGE, f"{name} is cut above or below: {box}"
    for axes in figure.axes:
        lines = [line for line in axes.lines if line.get_marker() not in ("None", "", " ", None)]
        for line in lines:
            if line.get_clip_on() and line.get_visible():
                at = line.get_transform().transform(line.get_xydata()).reshape(-1, 2)
                at = at[np.isfinite(at).all(axis=1)]
                low = np.array(axes.bbox.min) - 1
                high = np.array(axes.bbox.max) + 1
                inside = ((at > low) & (at < high)).all(axis=1)
                assert inside.all(), f"{name}: {line.get_label()} has points outside its frame"
