"""How long does a 1000-step loop take, against one tridiagonal solve, and how wrong is it?

A parabola is pressed in and pulled off under imposed depth, dead load and a machine on the fitted
mesh, and under imposed depth on a lattice with 10⁵ nodes in the largest contact; wall time over
that of one LAPACK `dptsv` with 10⁵ unknowns in the same process (median of several). Next to it the
error of the loop area against energy.cards, ∮P dd, and the imbalance of the ledger.

Output: a line per loop, path_speed.csv. Exit status 1 if an error misses its bar, with --strict
also if a time misses 150 dptsv.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from discretization import History, load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies.lattice_speed import median_seconds, tridiagonal_seconds

TIME_BAR = 150.0


@dataclass(frozen=True)
class Parameters:
    """Scene [SI], steps of the loop, nodes of the lattice, unknowns of dptsv, repetitions."""

    E: float = 3e3
    nu: float = 0.45
    h: float = 50e-6
    gamma1: float = 0.07
    w: float = 3e-4
    R: float = 0.1
    steps: int = 1000
    nodes: int = 10**5
    unknowns: int = 10**5
    repeats: int = 5

    @property
    def scene(self) -> Scene:
        """The scene."""
        surfaces = SurfaceEnergies.from_work(self.gamma1, self.w)
        return Scene(ElasticLayer(self.E, self.nu, self.h), surfaces, Parabola(self.R))


class Row(NamedTuple):
    """One kind of loop: time in dptsv, relative error of the loop area, imbalance of the ledger."""

    name: str
    ratio: float
    error: float
    ledger: float
    bar: float

    @property
    def accurate(self) -> bool:
        """Whether loop area and ledger meet their bars."""
        return self.error <= self.bar and self.ledger <= 1e-9


def loops(params: Parameters) -> dict[str, tuple[dict[str, Any], float, float]]:
    """Arguments of load_path, loop area of the cards, and error bar of each loop."""
    scene, half = params.scene, params.steps // 2
    k, delta0 = scene.stiffness, scene.critical_separation
    given = {"R": params.R, "k": k, "gamma1": params.gamma1, "w": params.w}
    force = float(cards.parabola.force(3 * delta0, **given))
    stiffness = k * scene.elastocapillary_length
    depths = np.r_[np.linspace(-1, 3, half), np.linspace(3, -1.2, half)] * delta0
    forces = np.r_[np.linspace(0, force, half), np.linspace(force, -force, half)]
    far = 3 * delta0 + force / stiffness
    drives = np.r_[np.linspace(0, far, half), np.linspace(far, -far, half)]
    spacing = 2 * minimise(scene, 3 * delta0).half_width / params.nodes
    area = float(cards.displacement_control.parabola_loop_area(**given))
    dead = float(cards.load_control.parabola_loop_area(**given))
    machine = float(cards.machine_control.parabola_loop_area(**given, K=stiffness))
    return {
        "imposed depth": ({"depths": depths}, area, 1e-8),
        "dead load": ({"forces": forces}, dead, 1e-8),
        "machine": ({"drives": drives, "machine_stiffness": stiffness}, machine, 1e-8),
        f"lattice, {params.nodes:.0e} nodes": (
            {"depths": depths, "method": "lattice", "spacing": spacing},
            area,
            1e-3,  # the last link lets go early: first order
        ),
    }


def run(params: Parameters) -> list[Row]:
    """A row per loop."""
    rows, scene = [], params.scene
    for name, (arguments, area, bar) in loops(params).items():
        path: History = load_path(scene, **arguments)

        def loop(given: dict[str, Any] = arguments) -> object:
            return load_path(scene, **given)

        ratios = [
            median_seconds(loop, 1) / tridiagonal_seconds(params.unknowns)
            for _ in range(params.repeats)
        ]
        error = abs(path.dissipated / area - 1)
        ledger = abs(path.work() / path.dissipated - 1)
        rows.append(Row(name, float(np.median(ratios)), error, ledger, bar))
    return rows


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    parser = argparse.ArgumentParser(prog="python -m studies path_speed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="100 steps, 10⁴ nodes")
    parser.add_argument("--strict", action="store_true", help="judge the times too")
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder of the results")
    options = parser.parse_args(argv)
    params = Parameters(steps=100, nodes=10**4, repeats=1) if options.quick else Parameters()
    rows = run(params)
    print(
        f"{params.steps} steps            dptsv({params.unknowns:.0e})  error of the area  ledger"
    )
    for row in rows:
        verdict = "ok" if row.accurate else "MISSED"
        print(f"{row.name:24s} {row.ratio:8.1f}  {row.error:18.1e}  {row.ledger:.1e}  {verdict}")
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "path_speed.csv").open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(Row._fields)
        out.writerows(rows)
    slow = options.strict and any(row.ratio > TIME_BAR for row in rows)
    return 0 if all(row.accurate for row in rows) and not slow else 1
