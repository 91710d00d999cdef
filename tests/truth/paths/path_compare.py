"""Compare `load_path` under a dead load or a machine with the reference, case by case.

fitted: to rounding, but for tops of the reference. lattice: to second order, but close to jumps.
"""

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from discretization import load_path
from discretization.nodes.lattice import Lattice
from energy import FlatPunch, Profile

from ..compare import Verdict, asked
from ..ground import Outside
from .controls import Control, reading_of
from .depth_paths import depth_path_of
from .random_paths import path_case, programme

EXACT = 1e-7  # of the scales: states on the mesh
TOPS = 1e-4  # of the scales: tops of C, where it is flat
BALANCED = 1e-10  # of the range of the control: C after jumps
AWAY = 1e-6  # of the range of the control: values so near to a jump are not asked for
LOST = 1e-5  # of the energies: jumps that lose less are not asked for
NODES = (30, 90)  # per least length: only if neither agrees is a path on nodes looked at closer
CLOSER = 8  # times as many nodes must then agree as well as NODES[1] should have: it converges
SURER = (4.0, 16.0)  # times as many steps of the reference, where it differs
FEWEST = 10
FINEST = 400  # nodes per least length that say something, and the most per l
SECOND = 4.0  # times (spacing/length)², of the scales
METHODS = ("fitted", "lattice")
FIRST = 0.3  # times spacing/length: jumps on nodes, and lines at corners and edges between them


class Truth(NamedTuple):
    """The programme (n,), the depth and state at each value, the jumps, and first touch.

    turns: (step, value) of jumps just beyond the values at which the programme turns, or ends.
    """

    values: np.ndarray
    places: list
    states: list
    jumps: list
    turns: list
    touch: float


def path_verdicts(kind, seed, methods=METHODS):
    """{method: verdict} on a random path, judged by one reference."""
    case = path_case(kind, seed)
    found = {}
    scene = case.scene
    several = scene.axisymmetric and (scene.pattern is not None or not scene.indenter.convex)
    if several or not scene.gamma1 or resolved(case, NODES[0]) < FEWEST:
        methods = [method for method in methods if method != "lattice"]
    if (
        scene.gamma1
        and scene.pattern is not None
        and not (scene.axisymmetric or scene.indenter.convex)
    ):
        methods = [method for method in methods if method != "fitted"]  # followed on nodes alone
    start = time.process_time()
    try:
        reading = _reading(case)
        values = programme(case, reading)
        answers = {method: answer(case, values, nodes_of(case, method)) for method in methods}
        guesses = next((a[0].depth for a in answers.values() if a[0] is not None), None)
        truth = reference(case, values, guesses)
    except Outside as problem:
        return {m: Verdict("skipped", str(problem), None, None, 0.0, 0.0) for m in methods}
    other = time.process_time() - start - sum(a[-1] for a in answers.values())
    surer = 1.0
    for method, (history, word, why, seconds) in answers.items():
        nodes = nodes_of(case, method)
        faults = _faults(case, values, history, truth, nodes, nodes) if word == "right" else []
        for steps in SURER:
            if faults and steps > surer:
                jumps = [(e.before.depth, e.after.depth) for e in history.events]
                marks = [at for one, other in jumps for at in (one, (one + other) / 2, other)]
                truth = reference(case, values, guesses, steps, marks)
                surer = steps
                faults = differences(case, history, truth, nodes)
        asked = resolved(case, NODES[1])
        told = history.unresolved() if faults else ""
        if word == "warned":  # nodes this far apart do not resolve the profile: closer ones may
            told = why
            faults = [why]
        for finer in (1, CLOSER):
            if faults and nodes:
                history, word, why, seconds = answer(case, values, finer * asked)
                faults = []
                if word == "right":
                    faults = _faults(case, values, history, truth, finer * asked, asked)
                elif word == "warned":
                    faults = [why]
        if faults:
            word, why = ("refused", told) if told else ("wrong", "; ".join(faults))
        found[method] = Verdict(word, why, history, truth, seconds, other)
    return found


def _faults(case, values, history, truth, nodes, asked):
    """What is wrong with a path, on nodes by the profile that they see as well."""
    found = differences(case, history, truth, asked)
    faceted = seen(case, least_length(case) / nodes) if found and nodes else None
    if faceted:
        return differences(case, history, reference(faceted, values, history.depth), asked)
    return found


def nodes_of(case, method):
    """Of a first answer: None on the fitted mesh."""
    return resolved(case, NODES[0]) if method == "lattice" else None


def _reading(case, *given):
    path = depth_path_of(case.scene, case.feature)
    return reading_of(path, Control(case.stiffness), case.scale, *given)


def reference(case, values, guesses=None, *given):
    """What the reference makes of a programme. Outside if it leaves the profile."""
    reading = _reading(case, *given)
    places = []
    turns = []
    guesses = values * math.nan if guesses is None else guesses
    window = FIRST / NODES[0] * float(np.ptp(values))
    for i, (value, guess) in enumerate(zip(values, guesses.tolist(), strict=True)):
        places.append(reading.go(float(value), guess))
        last = i == len(values) - 1
        if i and (last or (values[i + 1] - value) * (value - values[i - 1]) < 0):
            on = math.copysign(window, value - values[i - 1])
            turns += [(i, at) for at in reading.beyond(value, on)]
    states = [reading.state(place) for place in places]
    return Truth(values, places, states, reading.jumps, turns, reading.path.touch)


def least_length(case):
    """The shortest of l, what the profile or a pattern varies on, and a contact at a sharp tip.

    A line at a tip of radius R recedes from a to 0 over a l/R of depth: the scale at a = R/l of it.
    """
    indenter = case.scene.indenter
    x = np.union1d(np.linspace(*indenter.extent, 4001), indenter.corners)
    middle = (x[1:] + x[:-1]) / 2
    near = np.diff(x) / 4
    rise = np.asarray(indenter.slope(middle + near)) - np.asarray(indenter.slope(middle - near))
    sharp = float((rise[near > 0] / (2 * near[near > 0])).max())
    wide = case.scale / (case.length * sharp) if sharp > 0 else math.inf
    pattern = case.scene.pattern
    marks = np.union1d(indenter.corners, () if pattern is None else pattern.edges)
    narrow = math.inf if pattern is None else float(np.diff(marks).min(initial=math.inf))
    return min(case.length, case.feature, wide, narrow)


def resolved(case, nodes):
    """How many of so many nodes per least length there may be."""
    return min(nodes, FINEST * least_length(case) / case.length)


def answer(case, values, nodes):
    """The history of `load_path`, one word, its explanation, and the seconds.

    nodes: per least length, None on the fitted mesh.
    """
    given = {"drives": values, "machine_stiffness": case.stiffness}
    if not case.stiffness:
        given = {"forces": values}
    given["method"] = "lattice" if nodes else "fitted"
    if nodes:
        given["spacing"] = least_length(case) / nodes
    start = time.process_time()
    history, word, why = asked(load_path, case.scene, **given)
    word = "refused" if word == "warned" and not nodes else word
    return history, word, why, time.process_time() - start


def differences(case, history, truth, nodes):
    """What is wrong with a path, in words."""
    span = float(np.ptp(truth.values))
    scene = case.scene
    window = AWAY * span
    tolerance = EXACT
    if nodes:
        window = FIRST / nodes * span
        tolerance = SECOND / nodes**2
        if len(scene.indenter.corners) or scene.pattern is not None:
            tolerance += FIRST / nodes
    end = _unsure(truth, window)
    at = [jump.value for jump in truth.jumps]
    faults = []
    for i in range(end):
        if min((abs(truth.values[i] - value) for value in at), default=math.inf) > window:
            found = _step(case, history, truth, i, tolerance, nodes)
            faults += [f"step {i}: {fault}" for fault in found]
    return faults[:3] + _jumps(case, history, truth, end, nodes)


def _unsure(truth, window):
    """The first step, where the programme turns or ends, so close to a jump that it may happen."""
    values = truth.values
    end = len(truth.values)
    for i, beyond in truth.turns:
        if abs(beyond - values[i]) <= window:
            end = min(end, i)
    way = np.sign(np.diff(values))
    for i in np.flatnonzero(way[1:] != way[:-1]) + 1:
        if any(j.step == i and abs(values[i] - j.value) <= window for j in truth.jumps):
            end = min(end, int(i))
    return end


def seen(case, spacing):
    """The case with the profile that nodes see, straight where there is a corner between two.

    None if there is no such corner. However close nodes are, a facet may hold longer than a corner.
    """
    body = case.scene.indenter
    lattice = Lattice.of(case.scene, spacing)
    spacing = lattice.spacing
    places = (np.asarray(body.corners, float) - lattice.origin) / spacing
    between_nodes = np.abs(places - np.round(places)) > 1e-9
    nodes_before = lattice.x(np.floor(places[between_nodes]))
    left = np.array(
        [x for x in nodes_before if body.extent[0] <= x and x + spacing <= body.extent[1]]
    )
    if not left.size:
        return None
    right = left + spacing
    middle = np.array([left, right]).mean(axis=0)
    f_left = body.height(left)
    f_right = body.height(right)
    rise = f_right - f_left

    def on_facets(x, on_facet, elsewhere):
        """The one function of x and the facet on facets, the other one of x elsewhere."""
        facet = np.abs(middle - np.asarray(x, float)[..., None]).argmin(axis=-1)
        inside = np.abs(x - middle[facet]) <= spacing / 2
        return np.where(inside, on_facet(x, facet), elsewhere(x))

    def height_of_facet(x, facet):
        return f_left[facet] + rise[facet] * (x - left[facet]) / spacing

    def slope_of_facet(x, facet):
        return rise[facet] / spacing

    def height(x):
        return on_facets(x, height_of_facet, body.height)

    def slope(x):
        return on_facets(x, slope_of_facet, body.slope)

    kept = [x for x in body.corners if not (np.abs(middle - x) <= spacing / 2).any()]
    faceted = Profile(height, slope, body.extent, sorted({*kept, *left, *right}))
    if body.walls:
        faceted = faceted + FlatPunch(body.walls[1])  # whose ends are those of the body
    return case._replace(scene=replace(case.scene, indenter=faceted))


def _step(case, history, truth, i, tolerance, nodes):
    """What is wrong with one step."""
    place = truth.places[i]
    state = truth.states[i]
    scene = case.scene
    held = not math.isnan(history.contacts[i, 0])
    if not place.lines:
        if held or history.depth[i] != place.depth:
            yield f"in contact at {history.depth[i]:.9g}, should have let go"
        return
    if not held:
        yield f"out of contact, should be at {place.depth:.9g}"
        return
    deep = case.scale + abs(place.depth - truth.touch)
    length = case.length + state.half_width
    size = scene.stiffness * deep * length
    lines = len(place.lines) * least_length(case) / nodes if nodes else 0.0
    for name, own, other, scale in (
        ("depth", history.depth[i], place.depth, deep),
        ("force", history.force[i], state.force, size),
        ("half_width", history.half_width[i], state.half_width, length + lines / tolerance),
        ("energy", history.energy[i], state.energy, size * deep),
    ):
        if not abs(own - other) <= tolerance * scale:
            yield f"{name} {own:.9g} instead of {other:.9g}, off by {abs(own - other) / scale:.2g}"


def _jumps(case, history, truth, end, nodes):
    """What is wrong with the jumps before a step."""
    lost = [abs(jump.released) for jump in truth.jumps]
    largest = max([state.energy_scale for state in truth.states] + lost)
    least = largest / nodes if nodes else LOST * largest
    events = [e for e in history.events if e.step < end and not abs(e.energy_released) <= least]
    jumps = [j for j in truth.jumps if j.step < end and j.released > least]
    if any(event.energy_released < 0 for event in events):
        return [f"an event releases {min(e.energy_released for e in events) / largest:.2g}"]
    if nodes:
        window = FIRST / nodes * float(np.ptp(truth.values))
        bound = 3 * FIRST / nodes * largest * (1 + len(jumps))
        own = sum(e.energy_released for e in events)
        other = sum(j.released for j in jumps)
        if abs(own - other) > bound:  # of all, as one that is just lost may be two
            return [f"jumps release {own:.6g} instead of {other:.6g}"]
        return list(_missed(events, jumps, window))
    if len(events) != len(jumps):
        return [f"{len(events)} jumps instead of {len(jumps)}"]
    faults = [*_unbalanced(case, history, BALANCED * float(np.ptp(truth.values)))]
    for event, jump in zip(events, jumps, strict=True):
        deep = case.scale + abs(jump.before.depth - truth.touch) + abs(jump.after.depth)
        for name, own, other, bound in (
            ("before", event.before.depth, jump.before.depth, TOPS * deep),
            ("after", event.after.depth, jump.after.depth, TOPS * deep),
            ("released", event.energy_released, jump.released, LOST * largest),
        ):
            if not abs(own - other) <= bound:
                faults.append(f"jump at {jump.value:.6g}: {name} {own:.9g} instead of {other:.9g}")
    return faults[:3]


def _unbalanced(case, history, bound):
    """Events, however small, after which the load does not balance."""
    for event in history.events:
        if not math.isnan(event.after.left):
            depth = event.after.depth
            force = event.after.force
            found = depth + force / case.stiffness if case.stiffness else force
            if not abs(found - event.control) <= bound:
                yield f"jump at {event.control:.9g}: lands at {found:.9g}"


def _missed(events, jumps, window):
    """On nodes: jumps that lose much, at a value where there is none."""
    largest = max((jump.released for jump in jumps), default=0.0)
    for jump in jumps:
        off = min((abs(event.control - jump.value) for event in events), default=math.inf)
        if jump.released > largest / 3 and off > window:
            yield f"no jump within {window:.3g} of {jump.value:.6g}: off by {off:.3g}"
