"""Functions of module level for the sweeps of the tests, and how their results are compared."""

import json
import math
import os
import time


def cheap(point):
    """Numbers that need all their digits; one point fails."""
    x, y = point["x"], point["y"]
    if (x, y) == (2.0, 3.0):
        raise ValueError("no state\nhere")
    return {"sum": math.sqrt(x) + y / 3, "none": math.nan, "label": "µ"}


def slow(point):
    """cheap in 20 ms."""
    time.sleep(0.02)
    return cheap(point)


def nap(point):
    """4 ms without work."""
    time.sleep(4e-3)
    return {"x": point["x"]}


def lines(path):
    """The results of a file in the order of the grid, as text."""
    text = path.read_text("utf-8").splitlines()[1:]
    return sorted(text, key=lambda line: json.loads(line)["at"])


def dearer(point):
    """1 to 20 ms without work, more for each x."""
    time.sleep(1e-3 + 1e-4 * point["x"])
    return {"x": point["x"]}


def gone(group):
    """Whether no process of the group is left, waiting for it up to 5 s."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False
