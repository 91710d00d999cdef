"""Loops over a smooth rough profile with many contacts, for path_speed.

Waves between 3 l and 12 l long of random phases, in a trough whose walls end the profile. The
indenter is pressed in and pulled off in 150 steps, on the lattice with 25 nodes per l and on the
fitted mesh; the time counts `History.work()`, too.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from discretization import load_path
from energy import ElasticLayer, Sampled, Scene, SurfaceEnergies

PER_LENGTH = 25  # nodes in an elastocapillary length
BARS = {"lattice": {10: 0.2, 30: 0.5, 100: 2.0}, "fitted": {10: 1.5, 30: 5.0, 100: 20.0}}
_STEPS, _DEEPEST, _FARTHEST = 75, 3.0, -2.5  # steps in and out; rms heights above the lowest point


class RoughRow(NamedTuple):
    """One loop: contacts at its deepest, events, processor time and its bar [s], energy balance."""

    method: str
    contacts: int
    events: int
    seconds: float
    bar: float
    ledger: float


def scene_of(contacts: int, seed: int = 1) -> Scene:
    """A scene with l = 1 and about so many contacts."""
    half, rng = 4.0 * contacts + 20, np.random.default_rng(seed)
    x = np.arange(-round(half * PER_LENGTH), round(half * PER_LENGTH) + 1) / PER_LENGTH
    z = np.zeros_like(x)
    for wave in np.linspace(3, 12, 30):
        z += wave * np.cos(2 * math.pi * x / wave + rng.uniform(0, 2 * math.pi))
    z = z / z.std() + 0.3 * np.maximum(np.abs(x) - half + 15, 0) ** 2
    layer, surfaces = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(1.0, 0.3)
    return Scene(layer, surfaces, Sampled(x, z - z.min(), kind="smooth"))


def measured(method: str, contacts: int) -> RoughRow:
    """The loop with about so many contacts."""
    scene, given = scene_of(contacts), {"method": method}
    if method == "lattice":
        given["spacing"] = 1 / PER_LENGTH  # type: ignore[assignment]
    depths = np.r_[np.linspace(0, _DEEPEST, _STEPS), np.linspace(_DEEPEST, _FARTHEST, _STEPS)]
    start = time.process_time()
    path = load_path(scene, depths=depths, **given)  # type: ignore[arg-type]
    balance = abs(path.work() / path.dissipated - 1)
    seconds = time.process_time() - start
    found = len(path.inner[_STEPS - 1]) // 2 + 1
    return RoughRow(method, found, len(path.events), seconds, BARS[method][contacts], balance)


def line(row: RoughRow) -> str:
    """A line for a loop."""
    word = "ok" if row.ledger <= 1e-9 else "MISSED"
    return (
        f"{row.method:8s} {row.contacts:4d} contacts {row.events:4d} events "
        f"{row.seconds:7.2f} s (bar {row.bar:g} s)  balance {row.ledger:.0e} {word}"
    )
