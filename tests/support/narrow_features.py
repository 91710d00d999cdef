"""Random scenes whose profiles have a feature of 0.1 to 10 times the spacing, and who is right.

    python -m tests.support.narrow_features states N SEED
    python -m tests.support.narrow_features paths N SEED

count how many of N scenes from SEED on are right on nodes, warned of, or wrong without a word. The
truth is the fitted mesh, with much finer nodes that have to agree with it.

Lengths are in units of l along the surface, of α l upwards, α = √(2w/γ₁), so that δ₀ is 1.
"""

import math
import sys
import warnings
from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from discretization import AccuracyWarning, NotCertifiedError, load_path, minimise
from energy import (
    ElasticLayer,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

CONVEX = ("needle", "power", "polygon")
ROUGH = ("flank", "tip", "spike", "groove", "bumps", "step")
TIMES = 3  # of the estimates
AGREE = 0.02  # of the scales: what mesh and fine nodes may differ by
FINER = 12  # nodes in the shorter of spacing and feature
MOST = 30_000  # fine nodes
ENDS = 5.0  # l
STEPS = 24  # of a path up and down


class Case(NamedTuple):
    """A scene at a depth, its spacing, the width of its feature, and the branch."""

    kind: str
    scene: Scene
    depth: float
    spacing: float
    feature: float
    branch: str


class Outcome(NamedTuple):
    """right, wrong, warned, refused or skipped; why."""

    word: str
    why: str


def _dent(shape, x0, s, h):
    """A dent of depth h and width s at x0, and its slope; of triangular or of smooth shape."""

    def height(x):
        t = (x - x0) / s
        return -h * (np.maximum(0.0, 1 - np.abs(t)) if shape == "tent" else np.exp(-t * t))

    def slope(x):
        t = (x - x0) / s
        if shape == "tent":
            return h / s * np.sign(t) * (np.abs(t) < 1)
        return 2 * h / s * t * np.exp(-t * t)

    return height, slope


def _rise(x0, s, h):
    """A smooth step of height h over a width s at x0, upwards to the right, and its slope."""
    return (
        lambda x: h / 2 * (1 + np.tanh((x - x0) / s)),
        lambda x: h / (2 * s) / np.cosh(np.clip((x - x0) / s, -300, 300)) ** 2,
    )


def _rough(rng, kind, spacing, s):
    """A profile that is not convex, as functions in these units, its corners, and its knots."""
    h = s * 10 ** rng.uniform(-1, 1)
    x0 = rng.uniform(-1.5, 1.5)
    if kind == "flank":
        half = rng.uniform(0.2, 1.5)
        x = np.array([-ENDS, -half - s, -half, half, half + s, ENDS])
        z = np.array([h + 2.5, h, 0, 0, h, h + 2.5])
        return Sampled(x + rng.uniform(0, spacing), z), 1.0
    rho = 10 ** rng.uniform(-0.3, 0.7)
    parts = []
    corners = []
    knots = []
    if kind == "tip":
        parts = [_dent("tent", x0, s, h)]
        corners = [x0 - s, x0, x0 + s]
    elif kind == "groove":
        parts = [_dent("tent", x0, s, -h)]
        corners = [x0 - s, x0, x0 + s]
    elif kind == "spike":
        parts = [_dent("smooth", x0, s, h)]
        knots = [x0]
    elif kind == "step":
        parts = [_rise(x0, s, h)]
        knots = [x0]
    else:
        places = np.sort(rng.uniform(-2, 2, 4)).tolist()
        parts = [_dent("smooth", x, s, h * rng.uniform(-1, 1)) for x in places]
        knots = places
    height = lambda x: x * x / (2 * rho) + sum(part[0](x) for part in parts)  # noqa: E731
    slope = lambda x: x / rho + sum(part[1](x) for part in parts)  # noqa: E731
    return (height, slope, corners, knots), rho


def _convex(rng, kind, alpha, s, slopes):
    """A convex indenter for l = 1; α is small for small slopes only."""
    if kind == "needle":
        return Wedge(math.atan(alpha * 10 ** rng.uniform(-0.5, 1.5)))
    if kind == "power":
        n = 1 + 10 ** rng.uniform(-1.3, 0)
        return PowerLaw(alpha * 10 ** rng.uniform(-1, 0.3) / (n * s ** (n - 1)), n)
    # a polygon whose slopes grow from left to right
    steps = np.cumsum(np.append(0.0, s * rng.uniform(0.3, 2, 4)))
    x = np.concatenate([-steps[:0:-1], steps, [ENDS]])
    x[0] = -ENDS
    right = np.sort(alpha * rng.uniform(0, 1, x.size - 5) * 10 ** rng.uniform(-0.5, 0.7))
    left = -np.sort(alpha * rng.uniform(0, 1, 4) * 10 ** rng.uniform(-0.5, 0.7))[::-1]
    slopes = np.append(left, right)
    z = np.append(0.0, np.cumsum(slopes * np.diff(x)))
    shift = rng.uniform(-1, 1) * s
    return Sampled(x + shift, z - z.min())


def case_of(seed, *, paths=False):
    """A random case."""
    rng = np.random.default_rng(seed)
    finite = not paths and rng.random() < 0.2
    kind = str(rng.choice(CONVEX if finite or rng.random() < 0.25 else ROUGH))
    alpha = 10 ** rng.uniform(-0.7, 0.1) if finite else 10 ** rng.uniform(-2, -0.3)
    spacing = 10 ** rng.uniform(-1.7, -0.8)
    s = spacing * 10 ** rng.uniform(-1, 1)
    if kind in CONVEX:
        body = _convex(rng, kind, alpha, s, finite)
    else:
        given, _ = _rough(rng, kind, spacing, s)
        if kind == "flank":
            body = Sampled(given.x, alpha * given.z)
        else:
            height, slope, corners, knots = given
            body = Profile(
                lambda x: alpha * height(np.asarray(x)),
                lambda x: alpha * slope(np.asarray(x)),
                (-ENDS, ENDS),
                corners,
                knots=knots,
            )
    scene = Scene(
        ElasticLayer(1.0, 0.0, 1.0),
        SurfaceEnergies.from_work(1.0, alpha**2 / 2),
        body,
        "finite" if finite else "small",
    )
    low = float(np.min(body.height(np.append(np.linspace(-3, 3, 6001), body.corners))))
    depth = low + alpha * rng.uniform(-0.97, 1.2)
    search = kind not in CONVEX and not finite and rng.random() < 0.15
    return Case(kind, scene, depth, spacing, s, "global" if search else "adhered")


def fine(case):
    """The spacing of the nodes that have to agree with the mesh."""
    best = min(case.feature, case.spacing) / FINER
    return max(best, 2 * ENDS / MOST)


def _solved(call):
    """What a call gives, or the error that it raises, and whether there was a warning."""
    with warnings.catch_warnings(record=True) as warnings_given:
        warnings.simplefilter("always", AccuracyWarning)
        try:
            return call(), bool(warnings_given)
        except (ValueError, NotCertifiedError) as problem:
            return problem, True


def _numbers(state):
    return np.array([state.half_width, state.force, state.energy])


def truth(case):
    """a, P, U and how far they may be off, or None where mesh and fine nodes do not agree."""
    mesh, _ = _solved(lambda: minimise(case.scene, case.depth, branch=case.branch, rtol=1e-6))
    if isinstance(mesh, Exception):
        return None
    found = _numbers(mesh)
    off = np.zeros(3)
    if case.scene.slopes == "finite":
        return found, off
    nodes, _ = _solved(
        lambda: minimise(
            case.scene, case.depth, method="lattice", spacing=fine(case), branch=case.branch
        )
    )
    if isinstance(nodes, Exception):
        return None
    off = np.abs(_numbers(nodes) - found)
    alpha = case.scene.critical_separation
    scale = np.array([1.0, alpha, alpha**2]) * np.maximum(mesh.half_width, 0.05)
    return (found, off) if (off <= AGREE * scale).all() else None


def outcome(case):
    """What nodes say of a case."""
    given: Any = {"method": "lattice", "spacing": case.spacing, "branch": case.branch}
    state, warned = _solved(lambda: minimise(case.scene, case.depth, **given))
    if isinstance(state, Exception):
        return Outcome("refused", str(state)[:60])
    known = truth(case)
    if known is None:
        return Outcome("skipped", "mesh and fine nodes differ")
    error = np.abs(_numbers(state) - known[0])
    estimate = np.array([*state.uncertainty.values()])
    alpha = case.scene.critical_separation
    scale = np.array([1.0, alpha, alpha**2]) * np.maximum(state.half_width, case.spacing)
    off = error > TIMES * estimate + 2 * known[1] + 1e-9 * scale
    why = f"{_numbers(state)} for {known[0]}, estimates {estimate}"
    if warned:
        return Outcome("warned" if off.any() else "warned, though right", why)
    if not np.isfinite(estimate).all():
        return Outcome("not resolved", why)
    return Outcome("wrong" if off.any() else "right", why)


def path_outcome(case):
    """What nodes say of a load path down and up again."""
    alpha = case.scene.critical_separation
    deep = abs(case.depth) + 0.3 * alpha
    depths = np.append(np.linspace(0, deep, STEPS // 3), np.linspace(deep, -1.1 * alpha, STEPS))
    ask = lambda **given: load_path(case.scene, depths=depths, **given)  # noqa: E731
    path, warned = _solved(lambda: ask(method="lattice", spacing=case.spacing))
    if isinstance(path, Exception):
        return Outcome("refused", str(path)[:60])
    mesh, _ = _solved(ask)
    nodes, _ = _solved(lambda: ask(method="lattice", spacing=fine(case)))
    if isinstance(mesh, Exception) or isinstance(nodes, Exception):
        return Outcome("skipped", f"{mesh!r:.60}")
    scale = alpha * (1 + mesh.half_width)
    apart = np.abs(mesh.force - nodes.force) > AGREE * scale
    off = (np.abs(path.force - mesh.force) > 0.1 * scale) & ~apart
    wrong = (off[1:] & off[:-1]).any()
    worst = int(np.argmax(np.abs(path.force - mesh.force) / scale))
    why = f"P[{worst}] = {path.force[worst]:.4g} for {mesh.force[worst]:.4g} at {depths[worst]:.4g}"
    if apart.sum() > 6:
        return Outcome("skipped", "mesh and fine nodes differ")
    if warned:
        return Outcome("warned" if wrong else "warned, though right", why)
    return Outcome("wrong" if wrong else "right", why)


def main(what, count, seed):
    """Print what is wrong, and how many are what."""
    counted = Counter()
    for one in range(seed, seed + count):
        case = case_of(one, paths=what == "paths")
        found = (path_outcome if what == "paths" else outcome)(case)
        counted[found.word] += 1
        if found.word in ("wrong", "warned, though right") or count == 1:
            ratio = case.feature / case.spacing
            steep = case.scene.slopes
            print(
                f"{one} {case.kind} {steep} {case.branch} s/Δx = {ratio:.2g}: {found}", flush=True
            )
    print(what, dict(counted))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
