"""Scene files and curves as they may be measured, for the tests."""

import re
from itertools import pairwise

import numpy as np
import pytest

from discretization import load_path
from energy import ElasticLayer, Scene, SurfaceEnergies
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.trials import SCENE

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


def by_hand(indenter, **options):
    surfaces = SurfaceEnergies(0.05, 0.03, 0.0791)
    return Scene(ElasticLayer(2e3, 0.31, 60e-6), surfaces, indenter, **options)


LIFT = SCENE.critical_separation


def measured(scene, turns, share=0.0, steps=40, seed=3):
    """A simulated curve through turning points in units of LIFT, with noise."""
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turns)]
    depth = LIFT * np.concatenate([turns[:1], *legs])
    force = load_path(scene, depths=depth).force
    noise = np.random.default_rng(seed).standard_normal(depth.size)
    return Curve(depth, force + share * np.abs(force).max() * noise)
