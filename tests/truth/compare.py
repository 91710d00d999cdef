"""Compare `minimise` with the reference, case by case."""

import itertools
import time
import warnings
from typing import NamedTuple

import numpy as np

from discretization import AccuracyWarning, NotCertifiedError, minimise

from .ground import Ground, Outside, refined_minima
from .obstacle import obstacle, springs
from .random_states import case_of
from .sets import lowest
from .totals import adhered
from .walk import Walk

IN_WORDS = " = "  # a refusal names what it refuses and its value
TIMES = 10  # an error may be so many times its estimate
LEAST = 1e-9  # or this of the scales
AWAY = 1e-6  # of δ₀: a depth this near to a jump of the reference is not compared
JUMP = 1e-2  # of the half-width: where it changes by more, the reference jumps


def walked(case, depths):
    """The adhered states of a case at increasing depths, all above first touch or all below."""
    walk = Walk(case.scene, case.feature)
    if depths[0] < walk.touch <= depths[-1]:
        raise Outside("next to first touch")
    if depths[0] < walk.touch:
        return [adhered(walk, depth) for depth in depths[::-1]][::-1]
    return [adhered(walk, depth) for depth in depths]


def alone(solve):
    """The states of a case at depths that do not follow from each other."""

    def states(case, depths):
        return [solve(case.scene, case.feature, depth) for depth in depths]

    return states


REFERENCE = {
    "small": walked,
    "finite": walked,
    "no_adhesion": alone(obstacle),
    "no_tension": alone(springs),
    "global": alone(lowest),
    "edges": walked,
}


class Verdict(NamedTuple):
    """right, wrong, refused, warned or skipped; why; the answer, and the seconds of both."""

    word: str
    why: str
    answer: object
    truth: object
    seconds: float
    reference_seconds: float


def verdict(kind, seed):
    """What `minimise` says about a random case, judged by the reference."""
    case = case_of(kind, seed)
    start = time.process_time()
    truth, why = reference(case)
    middle = time.process_time()
    if truth is None:
        return Verdict("skipped", why, None, None, 0.0, middle - start)
    branch = "global" if kind == "global" else "adhered"
    state, word, why = asked(minimise, case.scene, case.depth, branch=branch)
    seconds = time.process_time() - middle
    if word == "refused" and IN_WORDS not in why:
        word = "wrong"
    if word == "right" and (faults := differences(case, state, truth)):
        word = "wrong"
        why = "; ".join(faults)
    if word != "right" and (near := next_to_an_event(case)):
        word = "skipped"
        why = near
    return Verdict(word, why, state, truth, seconds, middle - start)


def reference(case):
    """The reference state, or None and why the case is not asked for."""
    try:
        (truth,) = REFERENCE[case.kind](case, [case.depth])
    except Outside as problem:
        return None, str(problem)
    return truth, ""


def next_to_an_event(case):
    """Why a case that is not right is not asked for, or nothing."""
    away = AWAY * min(case.scale, abs(case.above) / 10)
    try:
        near = REFERENCE[case.kind](case, [case.depth + s * away for s in (-1, 0, 1)])
    except Outside as problem:
        return str(problem)
    for one, other in itertools.pairwise(near):
        apart = abs(one.half_width - other.half_width)
        if len(one.contacts) != len(other.contacts) or apart > JUMP * near[1].half_width:
            return "next to a jump"
    return ""


def asked(solve, *given, **options):
    """An answer, one word and its explanation."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "the pull-off force")  # of a path, where it differs
        try:
            return solve(*given, **options), "right", ""
        except AccuracyWarning as warning:
            return None, "warned", str(warning)
        except (ValueError, NotCertifiedError) as problem:
            return None, "refused", f"{type(problem).__name__}: {problem}"
        except Exception as problem:  # whatever else is not an answer
            return None, "wrong", f"{type(problem).__name__}: {problem}"


def differences(case, state, truth):
    """What is wrong with a state, in words."""
    deep = penetration(state, case.feature)
    if deep > LEAST * (case.scale + abs(case.depth)):
        return [f"penetrates by {deep / case.scale:.2g} of the depth scale"]
    if case.kind == "global" and state.energy < truth.energy - LEAST * truth.energy_scale:
        return []  # the reference has not found the lowest
    contacts = state.contacts
    length = case.scene.elastocapillary_length or case.feature
    if case.kind == "no_tension":  # single springs count for nothing
        contacts = contacts[contacts[:, 1] - contacts[:, 0] > LEAST * case.feature]
    if len(contacts) != len(truth.contacts):
        return [
            f"{len(contacts)} contacts instead of {len(truth.contacts)}, "
            f"force {state.force:.9g} instead of {truth.force:.9g}"
        ]
    width = truth.half_width + 1e-3 * length
    scales = (width, truth.force_scale or 1.0, truth.energy_scale or 1.0)
    found = [
        (name, abs(getattr(state, name) - getattr(truth, name)) / scale, name)
        for name, scale in zip(("half_width", "force", "energy"), scales, strict=True)
    ]
    if truth.contacts.size:
        off = np.abs(contacts - truth.contacts).max() / width
        found.append(("contacts", float(off), "half_width"))
    return [
        f"{name} off by {error:.2g}, estimated {state.error_estimate[estimate]:.2g}"
        for name, error, estimate in found
        if not error <= max(TIMES * state.error_estimate[estimate], LEAST)
    ]


def penetration(state, feature):
    """Largest g - u >= 0 [length] of an Equilibrium, from its u, contacts and profile."""
    ground = Ground(state.scene.indenter, feature)
    step = ground.step
    lines = state.contacts.ravel()
    close = step * 0.5 ** np.arange(0.0, 30.0)
    near = [x + side * close for x in lines for side in (-1, 1)]
    x = np.unique(np.concatenate([ground.nodes, lines, *near]))
    x = x[(x >= ground.lo) & (x <= ground.hi)]

    left, right = state.contacts.T

    def v(at):
        inside = left.searchsorted(at, "right") > right.searchsorted(at, "left")
        return np.where(inside, 0.0, state.displacement(at) - (state.depth - ground.height(at)))

    found = [value for _, value in refined_minima(v, x, v(x), 0.0)]
    return max(0.0, -min(found, default=0.0))
