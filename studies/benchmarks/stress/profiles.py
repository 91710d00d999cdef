"""Odd profiles of the stress study: the same question in other units and on the lattice."""

from __future__ import annotations

import functools
import math

import numpy as np

import energy
from discretization import Equilibrium, minimise
from energy import ElasticLayer, Indenter, Scene, SurfaceEnergies
from studies.benchmarks.stress.verdicts import Judgement

NAMES = ("kink", "double kink", "plateau", "jump", "noise", "smooth noise", "tilted", "edge")
ALIKE, CLOSE = 1e-9, 2e-3


def profile(name: str, unit: float) -> Indenter:
    """A profile of some micrometres, in another unit of length."""
    x = np.linspace(-12, 12, 481)
    rng = np.random.default_rng(7)
    slopes = {
        "double kink": np.maximum(0.1 * abs(x), 0.4 * abs(x) - 0.9),
        "plateau": np.maximum(0.0, 0.15 * (abs(x) - 1)),
        "jump": x * x / 20 + 0.3 * (abs(x) > 2),
        "noise": x * x / 20 + 1e-5 * rng.normal(size=x.size),
        "smooth noise": x * x / 20 + 1e-5 * rng.normal(size=x.size),
    }
    if name in slopes:
        kind = "smooth" if name == "smooth noise" else "linear"
        return energy.Sampled(x * unit, slopes[name] * unit, kind=kind)
    if name == "kink":
        return energy.Parabola(10 * unit) + energy.Wedge(0.1)
    if name == "tilted":
        return energy.Parabola(10 * unit).shifted(0.3 * unit).tilted(0.03)
    return energy.FlatPunch(1.5 * unit) + energy.Parabola(10 * unit)


def scene(name: str, unit: float) -> Scene:
    """k = γ₁ = 1, w = 0.02 in the unit 1."""
    surfaces = SurfaceEnergies.from_work(1.0 * unit**2, 0.02 * unit**2)
    return Scene(ElasticLayer(1.0 * unit, 0.0, unit), surfaces, profile(name, unit))


def _numbers(state: Equilibrium, unit: float) -> np.ndarray:
    ends = (state.contacts / unit).ravel() if state.contacts.size else np.full(2, math.nan)
    return np.array([*ends, state.force / unit**2, state.energy / unit**3])


@functools.lru_cache(maxsize=64)
def _plain(name: str, depth: float) -> tuple[Equilibrium, Equilibrium]:
    own = scene(name, 1.0)
    return minimise(own, depth), minimise(own, depth, method="lattice", spacing=1 / 400)


def compare(name: str, depth: float, unit: float) -> Judgement:
    """Digits on which two units agree; the lattice close to the default method."""
    here, nodes = _plain(name, depth)
    there = minimise(scene(name, unit), depth * unit)
    size = max(1.0, np.abs(np.nan_to_num(_numbers(here, 1.0))).max())
    apart = np.abs(np.nan_to_num(_numbers(there, unit) - _numbers(here, 1.0))) / size
    if here.contacts.shape != there.contacts.shape:
        apart[:] = 1.0
    off = float(np.nan_to_num(np.abs(_numbers(nodes, 1.0) - _numbers(here, 1.0))).max() / size)
    certified = here.certificate.ok and there.certificate.ok and nodes.certificate.ok
    a, force, energy = (-math.log10(max(e, 1e-16)) for e in (apart[:2].max(), *apart[2:]))
    word = "ok" if apart.max() <= ALIKE and off <= CLOSE and certified else "lost"
    note = "" if word == "ok" else f"units differ by {apart.max():.1e}, lattice by {off:.1e}"
    return (a, force, energy), float(apart.max()), word, note
