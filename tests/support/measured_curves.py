"""Curves of force against depth as an instrument would record them."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.trials import SCENE as SPHERE_SCENE
from studies.scenes.fit.trials import simulated

SCENE = Scene(  # a very soft film, whose tension is felt: l = 43 µm, a(0) = 140 µm, δ₀ = 0.32 µm
    ElasticLayer(E=50.0, nu=0.45, h=5e-6),
    SurfaceEnergies.from_work(gamma1=0.07, w=2e-6),
    Parabola(R=0.05),
)
LIFT = SCENE.critical_separation


def measured(scene, turns, share=0.0, steps=40, seed=3):
    """A simulated curve through turning points in units of LIFT, with noise."""
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turns)]
    depth = LIFT * np.concatenate([turns[:1], *legs])
    force = load_path(scene, depths=depth).force
    noise = np.random.default_rng(seed).standard_normal(depth.size)
    return Curve(depth, force + share * np.abs(force).max() * noise)


def written(path, curve, head="depth [nm];force [nN]"):
    """A curve in a file of text."""
    rows = [f"{1e9 * d:.6f};{1e9 * p:.7f}" for d, p in zip(*curve[:2], strict=True)]
    path.write_text("\n".join([head, *rows]), "utf-8")
    return path


START = replace(SPHERE_SCENE, surfaces=SurfaceEnergies.from_work(0.045, 0.7e-4))


def sphere(stiffness=math.inf, seed=1, noise=20e-12, n=90, zero=0.0, level=0.0, slope=0.0):
    """A curve of SPHERE_SCENE, 150 nm above to 60 nm deep, with a baseline and a noise of force."""
    way = np.linspace(-150.7e-9, 60e-9, n)
    drive = np.concatenate([way, way[::-1]])
    force = simulated(SPHERE_SCENE, drive, stiffness) + level + slope * drive
    force = force + noise * np.random.default_rng(seed).standard_normal(drive.size)
    return Curve(drive + zero - force / stiffness, force, stiffness)
