"""Functions of module level for the sweeps of the tests, and how their results are compared."""

import json
import math
import os
import time
from concurrent.futures import Executor, Future
from pathlib import Path
from types import SimpleNamespace

from studies.scenes.grid import SolvedScene
from studies.scenes.sweep import batches
from studies.shared import batches as told

HELD_FROM = 30  # lines


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


def lines(path):
    """The results of a file in the order of the grid, as text."""
    text = path.read_text("utf-8").splitlines()[1:]
    return sorted(text, key=lambda line: json.loads(line)["at"])


def hold(path, count):
    """Wait while the file has at least that many lines: a sweep that does not end by itself."""
    while path.exists() and path.read_text("utf-8").count("\n") >= count:
        time.sleep(0.01)


def held(point):
    """cheap, in a sweep that stops where its environment says."""
    hold(Path(os.environ["HELD_BY"]), int(os.environ["HELD_FROM"]))
    return cheap(point)


class HeldScene(SolvedScene):
    """A point of a scene file, in a sweep that stops after 30 lines."""

    def __call__(self, point):
        hold(Path("results", f"{self.path.stem}_sweep.jsonl"), HELD_FROM)
        return super().__call__(point)


class Workers(Executor):
    """Workers in a time of their own, in which a point takes its cost and all else nothing."""

    def __init__(self, monkeypatch, count, cost):
        self.now, self.busy, self.cost = 0.0, 0.0, cost
        self.free, self.ends = [0.0] * count, {}
        monkeypatch.setattr(batches, "wait", self.wait)
        monkeypatch.setattr(told, "time", SimpleNamespace(monotonic=lambda: self.now))

    def submit(self, solve, function, points):
        """A batch, begun as soon as a worker is free."""
        seconds, first = sum(self.cost(point) for _, point in points), min(self.free)
        self.free.remove(first)
        self.free.append(max(first, self.now) + seconds)
        self.busy += seconds
        future = Future()
        future.set_result(solve(function, points)._replace(seconds=seconds))
        self.ends[future] = self.free[-1]
        return future

    def wait(self, pending, return_when):
        """The batch that ends first, at its end."""
        first = min(pending, key=self.ends.get)
        self.now = self.ends[first]
        return {first}, pending - {first}


def gone(group):
    """Whether no process of the group is left, waiting for it up to a minute."""
    for _ in range(1200):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False
