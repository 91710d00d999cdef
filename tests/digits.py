"""Whether two versions of the code give the same digits on random states and load paths.

    python -m tests.digits record FILE [STATES PATHS]     in one checkout
    python -m tests.digits compare FILE                   in another one

`record` writes the results of as many random scenes as asked for, `compare` repeats them and lists
those that are not bit for bit the same, each with its largest difference relative to the size of
the array that it stands in. A change of the text alone leaves that list empty.
"""

import pickle
import sys
import warnings
from pathlib import Path

import numpy as np

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, PowerLaw, Scene, SurfaceEnergies, Wedge

from .truth.paths.random_paths import PATH_KINDS, path_case
from .truth.random_states import KINDS, case_of

SEED = 500_000  # apart from the seeds that the tests use
CONVEX = ("line", "finite", "axisymmetric", "axisymmetric finite", "layer")
NODES_PER_LENGTH = 16  # of l and of the shortest length on which the profile varies
STEPS = 15  # values of a programme in each direction


def convex_case(kind, seed):
    """A random convex scene of this kind, and a depth."""
    rng = np.random.default_rng([CONVEX.index(kind), seed])
    length = 10 ** rng.uniform(-6, 0)
    alpha = 10 ** rng.uniform(-2, -0.5)
    scale = alpha * length
    response = "layer" if kind == "layer" else "springs"
    layer = ElasticLayer(10 ** rng.uniform(-3, 5), 0.3, length, response=response)
    gamma1 = layer.stiffness * length**2
    radius = length / alpha * 10 ** rng.uniform(-1, 2)
    bodies = (
        Parabola(radius),
        Wedge(np.arctan(alpha * rng.uniform(0.1, 0.9))),
        PowerLaw(scale / length**3, 3.0),
    )
    scene = Scene(
        layer,
        SurfaceEnergies.from_work(gamma1, gamma1 * alpha**2 / 2),
        bodies[rng.integers(2 if kind == "layer" else 3)],
        slopes="finite" if "finite" in kind else "small",
        geometry="axisymmetric" if "axisymmetric" in kind else "line",
    )
    return scene, scale * rng.uniform(-0.5, 3.0)


def numbers_of_state(state):
    """What is compared of a state."""
    return {
        "contacts": state.contacts,
        "force": np.array(state.force),
        "energy": np.array(state.energy),
        "angles": state.contact_angles,
        "errors": np.array(list(state.error_estimate.values())),
    }


def numbers_of_path(path):
    """What is compared of a load path."""
    events = [(event.depth, event.force, event.energy_released) for event in path.events]
    return {
        "depth": path.depth,
        "force": path.force,
        "half_width": path.half_width,
        "energy": path.energy,
        "events": np.array(events),
    }


def outcome(call, read):
    """The numbers of a result, or the error that was raised in its place."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return read(call())
        except Exception as problem:
            return {type(problem).__name__: np.array(len(str(problem)))}


def state_results(seed):
    """The states of one seed: a scene that may not be convex, on both meshes, and a convex one."""
    case = case_of(KINDS[seed % len(KINDS)], SEED + seed)
    branch = "global" if case.kind == "global" else "adhered"
    scene = case.scene
    shortest = min(scene.elastocapillary_length or case.feature, case.feature)
    spacing = shortest / NODES_PER_LENGTH
    convex, depth = convex_case(CONVEX[seed % len(CONVEX)], SEED + seed)
    return {
        f"{case.kind} fitted": outcome(
            lambda: minimise(scene, case.depth, branch=branch), numbers_of_state
        ),
        f"{case.kind} lattice": outcome(
            lambda: minimise(scene, case.depth, branch=branch, method="lattice", spacing=spacing),
            numbers_of_state,
        ),
        "convex": outcome(lambda: minimise(convex, depth), numbers_of_state),
    }


def path_results(seed):
    """The load paths of one seed, on both meshes: in depth, and under a load or a machine."""
    case = path_case(PATH_KINDS[seed % len(PATH_KINDS)], SEED + seed)
    scene = case.scene
    x = np.linspace(*scene.indenter.extent, 20001)
    touch = float(np.min(scene.indenter.height(x)))
    top = touch + case.deep * case.scale
    low = touch - 1.5 * case.scale
    depths = np.r_[np.linspace(touch, top, STEPS), np.linspace(top, low, 2 * STEPS)]
    spacing = min(case.length, case.feature) / NODES_PER_LENGTH
    results = {}
    for method, options in (("fitted", {}), ("lattice", {"spacing": spacing})):
        options["method"] = method
        in_depth = outcome(lambda o=options: load_path(scene, depths=depths, **o), numbers_of_path)
        results[f"{case.kind} depths {method}"] = in_depth
        if "force" not in in_depth:
            continue
        most = in_depth["force"].max()
        least = in_depth["force"].min()
        forces = np.r_[np.linspace(0, most, STEPS), np.linspace(most, 0.9 * least, STEPS)]
        if case.stiffness:
            programme = {
                "drives": np.r_[depths[:STEPS], depths[STEPS:] + 0.5 * least / case.stiffness],
                "machine_stiffness": case.stiffness,
            }
        else:
            programme = {"forces": forces}
        results[f"{case.kind} {method}"] = outcome(
            lambda o=options, p=programme: load_path(scene, **p, **o), numbers_of_path
        )
    return results


def difference(one, other):
    """The largest difference of two results relative to the size of the arrays, or a word."""
    if set(one) != set(other):
        return f"{sorted(one)} became {sorted(other)}"
    worst = 0.0
    for name, before in one.items():
        after = other[name]
        if np.shape(before) != np.shape(after):
            return f"{name}: shape {np.shape(before)} became {np.shape(after)}"
        if np.array_equal(before, after, equal_nan=True):
            continue
        finite = np.isfinite(before) & np.isfinite(after)
        same = (before == after) | (np.isnan(before) & np.isnan(after))
        if not (finite | same).all():
            return f"{name}: other values are not finite"
        size = np.abs(before[finite]).max(initial=0.0)
        worst = max(worst, float(np.abs((after - before)[finite]).max() / (size or 1.0)))
    return f"{worst:.1e}" if worst else ""


def main(action, file, states="500", paths="200"):
    """Record or compare; see the module."""
    if action == "record":
        cases = [("state", seed) for seed in range(int(states))]
        cases += [("path", seed) for seed in range(int(paths))]
        known = {}
    else:
        known = pickle.loads(Path(file).read_bytes())
        cases = list(known)
    results = {}
    different = 0
    count = 0
    for case in cases:
        kind, seed = case
        results[case] = state_results(seed) if kind == "state" else path_results(seed)
        for name, numbers in results[case].items():
            if action == "record":
                continue
            count += 1
            changed = difference(known[case].get(name, {}), numbers)
            if changed:
                different += 1
                print(f"{kind} {seed} {name}: {changed}", flush=True)
    if action == "record":
        Path(file).write_bytes(pickle.dumps(results))
        print(f"{len(results)} cases recorded in {file}")
    else:
        print(f"{different} of {count} results differ")


if __name__ == "__main__":
    main(*sys.argv[1:])
