"""Scene files and curves as they may be measured, for the tests."""

import json
import math
import os
import re
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies.scenes.fit.force_curve import Curve
from studies.scenes.grid import SolvedScene

SCENE = Scene(  # a very soft film, whose tension is felt: l = 43 µm, a(0) = 140 µm, δ₀ = 0.32 µm
    ElasticLayer(E=50.0, nu=0.45, h=5e-6),
    SurfaceEnergies.from_work(gamma1=0.07, w=2e-6),
    Parabola(R=0.05),
)
HELD_FROM = 30  # lines


def cheap(point):
    """Numbers that need all their digits; one point fails."""
    x = point["x"]
    y = point["y"]
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


def gone(group):
    """Whether no process of the group is left, waiting for it up to a minute."""
    for _ in range(1200):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


TEXT = """
title = "A test"
source = "nowhere"
depth = [2e-6, 0.0, -4e-5]

[layer]
E = 2e3
nu = 0.31
h = 60e-6

[surfaces]
gamma1 = 0.05
gamma2 = 0.03
gamma12 = 0.0791

[indenter]
shape = "parabola"
R = 0.017

[options]
rtol = 1e-6
"""
INDENTER = 'shape = "parabola"\nR = 0.017'
SURFACES = "gamma2 = 0.03\ngamma12 = 0.0791"
DEPTH = "depth = [2e-6, 0.0, -4e-5]"


def writer(path, text=TEXT):
    """A function that writes the text with replacements (old, new) to the file; its path."""

    def write(*changes):
        changed = text
        for old, new in changes:
            assert changed.count(old) == 1, old
            changed = changed.replace(old, new)
        path.write_text(changed, "utf-8")
        return path

    return write


def refused(path, told):
    """pytest.raises of a ValueError that begins with the file and goes on with a pattern."""
    return pytest.raises(ValueError, match=f"^{re.escape(str(path))}: {told}")


def by_hand(indenter, layer=None, **options):
    surfaces = SurfaceEnergies(0.05, 0.03, 0.0791)
    return Scene(layer or ElasticLayer(2e3, 0.31, 60e-6), surfaces, indenter, **options)


FIT_SCENE = """
depth = 0
[layer]
E = 50.0
nu = 0.45
h = 5e-6
[surfaces]
gamma1 = 0.1
w = 1.5e-6
[indenter]
shape = "parabola"
R = 0.05
"""
LIFT = SCENE.critical_separation


def measured(scene, turns, share=0.0, steps=40, seed=3):
    """A simulated curve through turning points in units of LIFT, with noise."""
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turns)]
    depth = LIFT * np.concatenate([turns[:1], *legs])
    force = load_path(scene, depths=depth).force
    noise = np.random.default_rng(seed).standard_normal(depth.size)
    return Curve(depth, force + share * np.abs(force).max() * noise)


SPHERE = """
depth = 50e-9
[layer]
E = 30e3
nu = 0.45
h = 0.3e-6
[surfaces]
gamma1 = 0.045
w = 0.7e-4
[indenter]
shape = "sphere"
R = 5e-6
[options]
geometry = "axisymmetric"
"""


def written(path, curve, head="depth [nm];force [nN]"):
    """A curve in a file of text."""
    rows = [f"{1e9 * d:.6f};{1e9 * p:.7f}" for d, p in zip(*curve[:2], strict=True)]
    path.write_text("\n".join([head, *rows]), "utf-8")
    return path
