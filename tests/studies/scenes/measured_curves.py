"""Curves as they may be measured: simulated, with noise."""

from itertools import pairwise

import numpy as np

from discretization import load_path
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.trials import SCENE

LIFT = SCENE.critical_separation


def measured(scene, turns, share=0.0, steps=40, seed=3):
    """A simulated curve through turning points in units of LIFT, with noise."""
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turns)]
    depth = LIFT * np.concatenate([turns[:1], *legs])
    force = load_path(scene, depths=depth).force
    noise = np.random.default_rng(seed).standard_normal(depth.size)
    return Curve(depth, force + share * np.abs(force).max() * noise)
