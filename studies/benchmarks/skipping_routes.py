"""The pairs of routes that `skipping` times: a call that skips, and the general one.

Each returns numbers that must agree. A profile is made general by declaring it without what it is:
`declared(Parabola(R), symmetric=False)` has the same heights.

The film is thicker than springs allow beside the contact, h > l: times and digits are those of the
model, in which only k, γ₁ and w of a film enter.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from discretization import AccuracyWarning, Lattice, NodalEnergy, load_path, minimise
from discretization.inside import (
    ContactSet,
    Ground,
    adhered,
    forget,
    global_minimum,
    heights,
    obstacle,
    region,
    totals,
    window,
)
from energy import ElasticLayer, FlatPunch, Indenter, Parabola, Profile, Scene, SurfaceEnergies
from studies.benchmarks.rivals.active_set import held_at, solved
from studies.benchmarks.rivals.problem import Grid

Numbers = Sequence[float]
Route = Callable[[], Numbers]
Pair = tuple[Route, Route]
LAYER = ElasticLayer(3e3, 0.45, 50e-6)  # Pa, 1, m
GAMMA1, W, RADIUS, DEPTH = 0.07, 3e-4, 0.1, 2e-6  # N/m, J/m², m, m
STEEP = 0.035  # J/m²
STEPS = np.linspace(DEPTH, 1.1 * DEPTH, 50)  # of a load path
FAR, POINTS = 40, 10_000  # elastocapillary lengths, of fields


def scene(
    indenter: Indenter | None = None, gamma1: float = GAMMA1, w: float = W, slopes: str = "small"
) -> Scene:
    """A parabola if nothing else is given."""
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    return Scene(LAYER, surfaces, indenter or Parabola(RADIUS), slopes=slopes)


def declared(indenter: Indenter, **attributes: Any) -> Indenter:
    """The same profile that says something else of itself."""
    kind = type("Declared", (type(indenter),), attributes)
    found: Indenter = object.__new__(kind)
    vars(found).update(vars(indenter))
    return found


def numbers(state: Any) -> Numbers:
    """a, P, U."""
    return state.half_width, state.force, state.energy


def _solve(own: Scene, depth: float = DEPTH, **options: Any) -> Route:
    return lambda: numbers(minimise(own, depth, **options))


def _lattice(own: Scene, nodes: int) -> dict[str, Any]:
    """Options of `minimise` for as many nodes in contact."""
    return {"method": "lattice", "spacing": 2 * minimise(own, DEPTH).half_width / nodes}


def _forgetting(work: Route) -> Route:
    """As in a fresh process: no surface is known."""

    def fresh() -> Numbers:
        forget()
        return work()

    return fresh


def no_tension() -> Pair:
    """γ₁ = 0 against 10⁻⁴⁰ N/m, both as in a fresh process."""
    without, little = scene(gamma1=0.0, w=0.0), scene(gamma1=1e-40, w=0.0)
    return _forgetting(_solve(without)), _forgetting(_solve(little))


def no_adhesion() -> Pair:
    """Rough, w = 0, some 10⁴ nodes: a convex problem, against the search over all contact sets."""
    own = scene(rough(), w=0.0)
    lattice = Lattice.of(own, own.elastocapillary_length / 100)
    _, g = window(lattice, own.indenter, DEPTH)

    def skips() -> Numbers:
        found = obstacle(lattice, g)
        return float(np.count_nonzero(found.contact)), found.energy

    def general() -> Numbers:
        contacts, proof = global_minimum(lattice, g)
        return float(np.sum(np.diff(contacts) + 1)), proof.attained

    return skips, general


def rough() -> Profile:
    """A parabola with ripples, not convex."""
    size, wave = 1e-7, 1e-4 / (2 * np.pi)
    return Profile(
        lambda x: np.square(x) / (2 * RADIUS) + size * np.cos(np.asarray(x) / wave),
        lambda x: np.asarray(x) / RADIUS - size / wave * np.sin(np.asarray(x) / wave),
    )


def symmetric() -> Pair:
    """One line found, against both."""
    return _solve(scene()), _solve(scene(declared(Parabola(RADIUS), symmetric=False)))


def symmetric_nodes() -> Pair:
    """200 000 nodes."""
    own, general = scene(), scene(declared(Parabola(RADIUS), symmetric=False))
    options = _lattice(own, 200_000)
    return _solve(own, **options), _solve(general, **options)


def punch() -> Pair:
    """An edge, against a face that rises beyond it without being told to have corners."""
    a, rise = 6e-4, 0.2
    blunt = Profile(
        lambda x: rise * np.maximum(0.0, np.abs(x) - a),
        lambda x: rise * np.sign(x) * (np.abs(x) > a),
        convex=True,
    )
    own = scene(FlatPunch(a))
    depth = -0.5 * own.critical_separation
    sought = _solve(scene(declared(blunt, apex=0.0, symmetric=True)), depth)

    def general() -> Numbers:
        with warnings.catch_warnings():  # of a line at a kink the estimate knows no condition
            warnings.simplefilter("ignore", AccuracyWarning)
            return sought()

    return _solve(own, depth), general


def detached() -> Pair:
    """Beyond detachment, against a solve of all nodes of the surface."""
    own = scene()
    depth, width = -2 * own.critical_separation, minimise(own, DEPTH).half_width
    grid = Grid(own, depth, 10_001, width + FAR * own.elastocapillary_length)

    def general() -> Numbers:
        u, multipliers, held = solved(grid.g, grid.g > 0, lambda held: held_at(grid, held))
        energy = float(u @ grid.pushed(u)) / 2
        return float(held.sum()) * grid.spacing, float(multipliers.sum()), energy

    return _solve(own, depth), general


def far_field() -> Pair:
    """Sums over one contact set with exact ends, against nodes out to 40 l."""
    own = scene(w=0.0)
    lattice = Lattice.of(own, own.elastocapillary_length / 50)
    ground = Ground.of(lattice, own.indenter, DEPTH)
    contact = adhered(lattice, own.indenter, DEPTH, ground.where)
    assert contact is not None
    n = 2 * (contact[1] + FAR * 50) + 1
    grid = Grid(own, DEPTH, n, lattice.spacing * (n // 2))
    held = np.zeros(n, bool)
    held[n // 2 + contact[0] : n // 2 + contact[1] + 1] = True

    def skips() -> Numbers:
        found = totals(ContactSet(ground, (contact,), DEPTH))
        return found.force, found.energy

    def general() -> Numbers:
        u, _ = held_at(grid, held)
        return float(lattice.spring * u.sum()), float(NodalEnergy(grid.lattice, held).value(u))

    return skips, general


def convex() -> Pair:
    """One contact, against a profile that is resolved and looked at for others."""
    general = Profile(Parabola(RADIUS).height, Parabola(RADIUS).slope)
    return _solve(scene()), _solve(scene(declared(general, apex=0.0, symmetric=True)))


def convex_nodes() -> Pair:
    """The last contact node of 200 000 bracketed, against a walk there."""
    own = scene()
    lattice = Lattice.of(own, _lattice(own, 200_000)["spacing"])
    where = region(lattice, own.indenter, DEPTH)

    def bracketed() -> Numbers:
        return adhered(lattice, own.indenter, DEPTH, where) or (0, 0)

    def walked() -> Numbers:
        count, links = 0, 1 << 14
        while count % links == 0:
            nodes = np.arange(float(count), count + links + 1)
            f = heights(lattice, own.indenter, nodes)
            holds = lattice.gap(f[:-1], f[1:], DEPTH) <= lattice.critical_gap
            count += int(links if holds.all() else np.argmin(holds))
        return -count, count

    return bracketed, walked


def small_slopes() -> Pair:
    """Slopes below 10⁻⁸, where true lengths are the same to rounding."""
    own = scene(Parabola(1e6 * RADIUS), w=0.0)
    depth = 1e-6 * DEPTH
    return _solve(own, depth), _solve(replace(own, slopes="finite"), depth)


def known_surfaces() -> Pair:
    """Finite slopes: read from a family, against solved as in a fresh process."""
    work = _solve(scene(w=STEEP, slopes="finite"))
    return work, _forgetting(work)


def fields() -> Pair:
    """u and p at 10 000 points as well."""
    own = scene()
    x = np.linspace(-1e-3, 1e-3, POINTS)

    def general() -> Numbers:
        state = minimise(own, DEPTH)
        state.displacement(x)
        state.pressure(x)
        return numbers(state)

    return _solve(own), general


def estimate() -> Pair:
    """The error estimate of 20 000 nodes as well."""
    own = scene()
    options = _lattice(own, 20_000)

    def general() -> Numbers:
        state = minimise(own, DEPTH, **options)
        return numbers(state) if state.error_estimate else ()

    return _solve(own, **options), general


def warm_start() -> Pair:
    """Lines of 50 load steps, each from the last, against each by itself."""
    own = scene()
    return (
        lambda: load_path(own, depths=STEPS).half_width.tolist(),
        lambda: [minimise(own, depth).half_width for depth in STEPS.tolist()],
    )


ROUTES: dict[str, Callable[[], Pair]] = {
    "surface tension": no_tension,
    "adhesion": no_adhesion,
    "second side, fitted": symmetric,
    "second side, lattice": symmetric_nodes,
    "line of a punch": punch,
    "contact": detached,
    "far field": far_field,
    "other contacts": convex,
    "links in between": convex_nodes,
    "true lengths": small_slopes,
    "known surfaces": known_surfaces,
    "fields": fields,
    "error estimate": estimate,
    "search for the line": warm_start,
}
