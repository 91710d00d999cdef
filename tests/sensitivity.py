"""How much the results depend on one constant of discretization/.

    python -m tests.sensitivity MODULE [NAME [FACTOR ...]]
    python -m tests.sensitivity --all FOLDER ...

MODULE is one like discretization.refine.settle. NAME is a constant of it (ROUNDS) or a field of a
record of constants (NewtonRules.near); without it every constant of the module is changed. FOLDER
is one of discretization/, or . for the modules beside the folders.

Random states and load paths that read the constant are solved with it as it is and with it times
each factor. The factors are 0.5 and 2 unless they are given; 0.1 and 10 for tolerances below 1e-4
and sizes above 1e5. What is within a twentieth of 1 is changed in its distance from 1, members of
tuples and arrays are changed together but for those that would be 0, and integers by at least 1.
0 and inf take a guard away.

A line for each factor says
    results      how many contacts, forces, energies, angles or events differ by more than 1e-9 of
                 their scale, the largest of these differences, and of how many results;
    estimates    how many error estimates differ by more than a tenth, where the results do not;
    outcomes     how many raise or warn where they did not, or no longer do;
    time         of the processor, relative to that without a change; 5 % is noise.

The constant is changed in the source before Python compiles it, so that what is computed from it at
import changes too; with one of surfaces/ the free surfaces in families.npz are solved for anew.
Reads are counted in one run of all scenes in the same manner. Each run is a process of its own.
"""

import ast
import builtins
import importlib
import importlib.machinery
import math
import multiprocessing
import sys
import time
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import scipy.optimize
import scipy.special  # noqa: F401  both loaded here, so that no run is timed with their import

from energy import ElasticLayer, Profile, Scene, SurfaceEnergies

ROOT = Path(__file__).parents[1]
CLASSES = {  # of scenes: how many, and about how long one takes [s]
    "convex": (96, 0.01),
    "convex paths": (16, 0.03),
    "layer": (10, 0.4),
    "layer paths": (2, 0.6),
    "several": (60, 0.08),
    "several on nodes": (48, 0.06),
    "paths": (24, 0.3),
    "paths on nodes": (24, 0.2),
    "many": (8, 0.02),
    "rings": (12, 0.2),
    "free branches": (8, 0.02),
    "free branches of layers": (2, 1.0),
    "layers on nodes": (4, 0.4),
}
FOLDERS = {  # whose constants only some classes read
    "refine": ("several", "paths"),
    "layer": ("layer", "layer paths", "free branches of layers", "layers on nodes"),
    "surfaces": ("convex", "convex paths", "several", "rings", "many"),
    "lattice": ("several on nodes", "paths on nodes"),
}
LONG_ENOUGH = 1.2  # times a class may take for one constant [s], but for its first scene
CHANGED = 1e-9  # of its scale: what counts as another result
ESTIMATES = 0.1
LONGEST = 10.0  # times the time without the change, after which a run is stopped
LARGEST_TOLERANCE = 1e-4
LARGEST_SIZE = 1e5


# Constants in the source.


def source(module):
    """The file of a module."""
    path = ROOT.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def assigned(node):
    """Name and value of an assignment to one name, or None."""
    if isinstance(node, ast.AnnAssign) and node.value is not None:
        target = node.target
    elif isinstance(node, ast.Assign) and len(node.targets) == 1:
        target = node.targets[0]
    else:
        return None
    return (target.id, node.value) if isinstance(target, ast.Name) else None


def numerical(node):
    """Whether an expression holds a number and no string."""
    values = [n.value for n in ast.walk(node) if isinstance(n, ast.Constant)]
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    return bool(numbers) and not any(isinstance(v, str) for v in values)


def constants_of(tree):
    """Assignments of constants of a module, and the class of each of its records, by name."""
    found = {}
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    records = {}
    for node in tree.body:
        pair = assigned(node)
        if pair is None:
            continue
        name, value = pair
        if isinstance(value, ast.Call) and getattr(value.func, "id", None) in classes:
            if not value.args and not value.keywords:
                records[name] = value.func.id
        elif name.isupper() and numerical(value):
            found[name] = node
    for kind in records.values():
        for node in classes[kind].body:
            pair = assigned(node)
            if pair is not None and numerical(pair[1]):
                found[f"{kind}.{pair[0]}"] = node
    return found, records


def parsed(module):
    return ast.parse(source(module).read_text("utf-8"))


def modules(folder):
    """Modules of a folder of discretization/, or with "." those beside the folders."""
    paths = sorted((ROOT / "discretization" / folder).glob("*.py"))
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts) for path in paths]
    return [name for name in names if not name.endswith("__init__")]


def scaled(value, factor):
    """A constant times a factor; what is close to 1 in its distance from 1."""
    if isinstance(value, tuple):
        return tuple(scaled(v, factor) or v for v in value)
    if isinstance(value, dict):
        return {name: scaled(v, factor) for name, v in value.items()}
    if isinstance(value, np.ndarray):
        return value * factor
    if isinstance(value, int):
        other = math.inf if math.isinf(factor) else round(value * factor)
        return other if other != value or factor == 1 else value + (1 if factor > 1 else -1)
    if value and 0 < abs(value - 1) < 0.05:
        return 1 + (value - 1) * factor
    return value * factor if value or math.isfinite(factor) else value


def factors_of(value):
    """The factors by which a constant is changed where none are given."""
    if isinstance(value, tuple) and value:
        value = value[0]
    tiny = isinstance(value, float) and 0 < abs(value) < LARGEST_TOLERANCE
    large = isinstance(value, int | float) and abs(value) > LARGEST_SIZE
    return (0.1, 10.0) if tiny or large else (0.5, 2.0)


class Edited(importlib.machinery.SourceFileLoader):
    """Loads a module from a changed syntax tree."""

    edit = None

    def get_code(self, fullname):
        tree = type(self).edit(fullname, parsed(fullname))
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


def load_with(edit, only=None):
    """Have modules of discretization imported from trees that `edit` returns for them."""
    Edited.edit = staticmethod(edit)

    class Finder:
        @staticmethod
        def find_spec(name, path=None, target=None):
            if name.split(".")[0] != "discretization" or only not in (None, name):
                return None
            spec = importlib.machinery.PathFinder.find_spec(name, path)
            spec.loader = Edited(name, spec.origin)
            return spec

    sys.meta_path.insert(0, Finder)


def changed(module, name, factor):
    """Import discretization with one constant times a factor."""

    def edit(_, tree):
        node = constants_of(tree)[0][name]
        builtins.scaled_constant = scaled
        function = ast.Name("scaled_constant", ast.Load())
        node.value = ast.Call(function, [node.value, ast.Constant(factor)], [])
        return tree

    load_with(edit, only=module)


class Reads(ast.NodeTransformer):
    """Has every read of a constant in a module counted."""

    def __init__(self, module, tree, every):
        self.names = {name: f"{module} {name}" for name in every[module][0] if "." not in name}
        self.records = {name: f"{module} {kind}" for name, kind in every[module][1].items()}
        self.aliases = {}
        self.kinds = {kind: f"{module} {kind}" for kind in every[module][1].values()}
        self.inside = []
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(
                "discretization"
            ):
                for alias in node.names:
                    self._imported(node.module, alias.name, alias.asname or alias.name, every)

    def _imported(self, module, name, local, every):
        inner = f"{module}.{name}"
        if inner in every:
            self.aliases[local] = inner, every[inner]
        elif module in every and name in every[module][0]:
            self.names[local] = f"{module} {name}"
        elif module in every and name in every[module][1]:
            self.records[local] = f"{module} {every[module][1][name]}"

    def visit_ClassDef(self, node):
        self.inside.append(node.name)
        self.generic_visit(node)
        self.inside.pop()
        return node

    def visit_AnnAssign(self, node):
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def visit_Name(self, node):
        if isinstance(node.ctx, ast.Load) and node.id in self.names:
            return _counted(self.names[node.id], node)
        return node

    def visit_Attribute(self, node):
        if not isinstance(node.ctx, ast.Load) or not isinstance(node.value, ast.Name):
            self.generic_visit(node)
            return node
        name = node.value.id
        if name in self.records:
            return _counted(f"{self.records[name]}.{node.attr}", node)
        if name in self.aliases and node.attr in self.aliases[name][1][0]:
            return _counted(f"{self.aliases[name][0]} {node.attr}", node)
        if name == "self" and self.inside and self.inside[-1] in self.kinds:
            return _counted(f"{self.kinds[self.inside[-1]]}.{node.attr}", node)
        self.generic_visit(node)
        return node


def _counted(key, node):
    return ast.Call(ast.Name("counted_constant", ast.Load()), [ast.Constant(key), node], [])


def counting():
    """Import discretization so that reads of its constants are counted; returns the counter."""
    reads = Counter()
    folders = [".", *(p.name for p in (ROOT / "discretization").iterdir() if p.is_dir())]
    every = {m: constants_of(parsed(m)) for folder in folders for m in modules(folder)}

    def count(key, value):
        reads[key] += 1
        return value

    builtins.counted_constant = count

    def edit(module, tree):
        return Reads(module, tree, every).visit(tree) if module in every else tree

    load_with(edit)
    return reads


# Scenes and their results. These import discretization, and run in a child of this process.


def scenes(folder):
    """(class, number) of every scene that may read constants of a folder."""
    classes = FOLDERS.get(folder, tuple(CLASSES))
    return [(name, number) for name in classes for number in range(CLASSES[name][0])]


def some_of(readers):
    """The first ones of each class, as many as its share of the time allows."""
    chosen = []
    for name in dict.fromkeys(name for name, _ in readers):
        own = [scene for scene in readers if scene[0] == name]
        chosen += own[: max(1, round(LONG_ENOUGH / CLASSES[name][1]))]
    return chosen


def state_numbers(state):
    scales = state.scales
    return {
        "results": {
            "contacts": (state.contacts, np.abs(state.contacts).max(initial=0.0)),
            "force": (state.force, scales["force"]),
            "energy": (state.energy, scales["energy"]),
            "angles": (state.contact_angles, 1.0),
        },
        "estimates": np.array(list(state.error_estimate.values())),
    }


def path_numbers(path):
    """Events have the scales of the whole path, or rounding of a first touch at 0 would count."""
    arrays = {"depth": path.depth, "force": path.force, "energy": path.energy}
    scales = {name: np.nanmax(np.abs(v), initial=0.0) for name, v in arrays.items()}
    results = {name: (v, scales[name]) for name, v in arrays.items()}
    widths = path.half_width
    results["half width"] = (widths, np.nanmax(np.abs(widths), initial=0.0))
    for name, field in (("depth", "depth"), ("force", "force"), ("energy", "energy_released")):
        of_events = np.array([getattr(event, field) for event in path.events])
        results[f"{name} of events"] = (of_events, scales[name])
    return {"results": results, "estimates": np.empty(0)}


def arrays_numbers(states):
    arrays = {name: getattr(states, name) for name in ("half_width", "force", "energy")}
    results = {name: (v, np.nanmax(np.abs(v), initial=0.0)) for name, v in arrays.items()}
    return {"results": results, "estimates": np.ravel(list(states.uncertainty.values()))}


def branch_numbers(branch):
    arrays = {} if branch is None else branch._asdict()
    results = {name: (v, np.abs(v).max()) for name, v in arrays.items()}
    return {"results": results, "estimates": np.empty(0)}


def states_and_paths(digits, name, number):
    """Calls that solve the scene of this class and number, and functions that read the results."""
    from discretization import load_path, minimise, minimise_many

    if name.startswith("free branches"):
        return [_free_branch(digits, name, number)]
    if name in ("convex", "convex paths", "layer", "layer paths", "many"):
        springs = digits.CONVEX[:4]
        kind = "layer" if name.startswith("layer") else springs[number % 4]
        scene, depth = digits.convex_case(kind, digits.SEED + 100_000 + number // 4)
        if "layer" in name:
            scene, depth = digits.convex_case(kind, digits.SEED + 100_000 + number)
        if name in ("convex", "layer"):
            return [(lambda: minimise(scene, depth), state_numbers)]
        scale = abs(depth) or 1e-3
        depths = np.linspace(-scale, 3 * scale, 12 if name != "layer paths" else 5)
        if name == "many":
            return [(lambda: minimise_many(scene, depths), arrays_numbers)]
        there_and_back = np.r_[depths, depths[::-1]]
        return [(lambda: load_path(scene, depths=there_and_back), path_numbers)]
    if name == "layers on nodes":
        seed = (0, 1, 4, 5)[number]  # those that need few nodes
        scene, depth = digits.convex_case("layer", digits.SEED + 100_000 + seed)
        spacing = scene.elastocapillary_length / 8
        solve_on_nodes = lambda: minimise(scene, depth, method="lattice", spacing=spacing)  # noqa: E731
        return [(solve_on_nodes, state_numbers)]
    if name == "rings":
        scene, depth = ring_case(digits.SEED + number)
        branch = ("adhered", "global")[number % 2]
        return [(lambda: minimise(scene, depth, branch=branch), state_numbers)]
    if name in ("several", "several on nodes"):
        case = digits.case_of(
            digits.KINDS[number % len(digits.KINDS)], digits.SEED + 200_000 + number
        )
        branch = "global" if case.kind == "global" else "adhered"
        options = {"branch": branch}
        if name == "several on nodes":
            shortest = min(case.scene.elastocapillary_length or case.feature, case.feature)
            options |= {"method": "lattice", "spacing": shortest / digits.NODES_PER_LENGTH}
        return [(lambda: minimise(case.scene, case.depth, **options), state_numbers)]
    return _paths(digits, name, number, load_path)


def ring_case(seed):
    """A random profile about an axis with concentric waves, and a depth."""
    rng = np.random.default_rng(seed)
    alpha = 10 ** rng.uniform(-2, -0.5)
    radius = 10 ** rng.uniform(0.0, 0.7)
    wave = 2 * math.pi / 10 ** rng.uniform(-0.3, 0.4)
    rise = alpha * rng.uniform(0.1, 1.0) / wave
    layer = ElasticLayer(1.0, 0.3, 1.0)
    gamma1 = layer.stiffness
    profile = Profile(
        lambda r: alpha * np.square(r) / (2 * radius) + rise * (1 - np.cos(wave * np.asarray(r))),
        lambda r: alpha * np.asarray(r) / radius + rise * wave * np.sin(wave * np.asarray(r)),
        extent=(0.0, 4 * math.sqrt(2 * radius)),
    )
    surfaces = SurfaceEnergies.from_work(gamma1, gamma1 * alpha**2 / 2)
    return Scene(layer, surfaces, profile, geometry="axisymmetric"), alpha * rng.uniform(-0.5, 2.0)


def _free_branch(digits, name, number):
    from discretization.fitted import free_branch as springs
    from discretization.layer import free_branch as layer

    kinds = ("layer",) if "layers" in name else digits.CONVEX[:4]
    module, more = (layer, (1e-6,)) if "layers" in name else (springs, ())
    scenes_of_seeds = (
        digits.convex_case(kinds[number % len(kinds)], digits.SEED + seed)
        for seed in range(500_000 + 1000 * number, 500_000 + 1000 * (number + 1))
    )
    scene, depth = next(case for case in scenes_of_seeds if module.applies(case[0]))
    deepest = abs(depth) + scene.critical_separation
    return lambda: module.free_branch(scene, deepest, 50, *more), branch_numbers


def _paths(digits, name, number, load_path):
    case = digits.path_case(
        digits.PATH_KINDS[number % len(digits.PATH_KINDS)], digits.SEED + 300_000 + number
    )
    scene = case.scene
    x = np.linspace(*scene.indenter.extent, 20001)
    touch = float(np.min(scene.indenter.height(x)))
    top = touch + case.deep * case.scale
    low = touch - 1.5 * case.scale
    depths = np.r_[np.linspace(touch, top, 12), np.linspace(top, low, 18)]
    options = {}
    if name == "paths on nodes":
        spacing = min(case.length, case.feature) / digits.NODES_PER_LENGTH
        options = {"method": "lattice", "spacing": spacing}
    force = scene.stiffness * case.length * case.scale
    if case.stiffness:
        programme = {"drives": depths, "machine_stiffness": case.stiffness}
    else:
        programme = {"forces": np.r_[np.linspace(0, force, 9), np.linspace(force, -force / 2, 9)]}
    return [
        (lambda: load_path(scene, depths=depths, **options), path_numbers),
        (lambda: load_path(scene, **programme, **options), path_numbers),
    ]


def solve(chosen, reads=None):
    """Results, outcome, time and reads of some scenes, by scene.

    Each scene has a list of dictionaries, one for each of its states and paths.
    """
    digits = importlib.import_module("tests.digits")
    found = {}
    at_import = Counter(reads or ())
    for number in range(4):  # so that no scene is the first one and pays for what is kept
        for call, _ in states_and_paths(digits, "convex", number):
            call()
    for scene in chosen:
        before = Counter(reads or ())
        began = time.process_time()
        results = []
        for call, numbers in states_and_paths(digits, *scene):
            with warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                try:
                    result = numbers(call())
                except Exception as problem:
                    result = {"results": {}, "estimates": np.empty(0)}
                    result["raised"] = type(problem).__name__
            words = sorted({f"{w.category.__name__} {str(w.message)[:40]}" for w in warned})
            result["outcome"] = (result.pop("raised", ""), *words)
            results.append(result)
        spent = time.process_time() - began
        counts = Counter(reads or ()) - before
        found[scene] = {"results": results, "time": spent, "reads": counts}
    return found, at_import


def child(function, *arguments, limit=None):
    """What a function returns in a process of its own, or None if it does not end or fails."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)

    def run():
        try:
            sender.send(function(*arguments))
        except BaseException as problem:
            sender.send(f"{type(problem).__name__}: {problem}"[:100])

    process = context.Process(target=run)
    process.start()
    result = "does not end"
    if receiver.poll(limit):
        result = receiver.recv()
    process.kill()
    process.join()
    return result


def count_reads(chosen):
    return solve(chosen, counting())


def solve_changed(module, name, factor, chosen):
    changed(module, name, factor)
    if module.startswith("discretization.surfaces"):
        for family in importlib.import_module("discretization.surfaces.tables").FAMILIES:
            object.__setattr__(family, "shipped", dict.fromkeys(family.shipped, ()))
    return solve(chosen)


def value_of(module, name):
    """The value of a constant."""
    holder = importlib.import_module(module)
    for part in name.split("."):
        holder = holder._field_defaults if hasattr(holder, "_field_defaults") else holder
        holder = holder[part] if isinstance(holder, dict) else getattr(holder, part)
    return holder


# Comparison.


def difference(one, other):
    """The largest difference of two results in their scales."""
    worst = 0.0
    if one.keys() != other.keys():
        return math.inf
    for name, (before, scale) in one.items():
        after = np.asarray(other[name][0])
        before = np.asarray(before)
        if before.shape != after.shape:
            return math.inf
        same = (before == after) | (np.isnan(before) & np.isnan(after))
        if same.all():
            continue
        gap = np.abs(np.where(same, 0.0, after) - np.where(same, 0.0, before))
        if not np.isfinite(gap).all():
            return math.inf
        worst = max(worst, float(gap.max() / (scale or 1.0)))
    return worst


def compared(before, after):
    """One line on what a change has done."""
    total = 0
    count = 0
    outcomes = 0
    estimates = 0
    worst = 0.0
    for scene, result in after.items():
        for one, other in zip(before[scene]["results"], result["results"], strict=True):
            total += 1
            if one["outcome"] != other["outcome"]:
                outcomes += 1
                continue
            gap = difference(one["results"], other["results"])
            if gap > CHANGED:
                count += 1
                worst = max(worst, gap)
            elif one["estimates"].shape == other["estimates"].shape:
                with np.errstate(invalid="ignore"):
                    change = np.abs(other["estimates"] - one["estimates"])
                    estimates += bool((change > ESTIMATES * np.abs(one["estimates"])).any())
    spent = sum(r["time"] for r in after.values())
    ratio = spent / (sum(before[scene]["time"] for scene in after) or 1.0)
    largest = f" (up to {worst:.1e})" if count else ""
    return (
        f"results {count}{largest} of {total}, estimates {estimates}, outcomes {outcomes}, "
        f"time {ratio:.2f}"
    )


class Measurement:
    """The scenes for a folder solved as they are, once, to compare with."""

    def __init__(self, folder):
        self.scenes = scenes(folder)
        self.counted, self.at_import = child(count_reads, self.scenes)
        self.before = child(solve, self.scenes)[0]

    def lines(self, module, name, factors=()):
        """Lines of text on one constant."""
        key = f"{module} {name}"
        value = child(value_of, module, name)
        readers = [s for s in self.scenes if self.counted[s]["reads"][key]]
        count = sum(self.counted[s]["reads"][key] for s in readers)
        derived = self.at_import[key]
        text = np.array2string(value, threshold=4) if isinstance(value, np.ndarray) else str(value)
        yield (
            f"{key} = {text}: read {count} times in {len(readers)} of {len(self.scenes)} scenes"
            + (f", {derived} times at import" if derived else "")
        )
        chosen = some_of(self.scenes if derived else readers)
        if not chosen:
            return
        limit = LONGEST * sum(self.before[s]["time"] for s in chosen) + 60
        for factor in factors or factors_of(value):
            after = child(solve_changed, module, name, factor, chosen, limit=limit)
            word = after if isinstance(after, str) else compared(self.before, after[0])
            yield f"    times {factor:g}: {word}"


def main(*arguments):
    """Measure one constant, or all of some modules; see the module."""
    names = ()
    factors = ()
    if arguments[0] == "--all":
        wanted = [modules(folder) for folder in arguments[1:]]
    else:
        wanted = [[arguments[0]]]
        names = arguments[1:2]
        factors = tuple(float(factor) for factor in arguments[2:])
    for group in wanted:
        measurement = Measurement(group[0].split(".")[1])
        for module in group:
            for name in names or constants_of(parsed(module))[0]:
                for line in measurement.lines(module, name, factors):
                    print(line, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
