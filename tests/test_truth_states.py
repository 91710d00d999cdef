"""`minimise` on random profiles that are not convex, against the references of tests/truth.

A hundred states of each class, thirty of the two with slow references; ELASTOCAP_TRUTH=2000 asks
for as many of each.
python -m tests.truth CLASS 1 SEED.
"""

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import pytest
from truth.compare import verdict
from truth.scenes import KINDS

GIVEN = os.environ.get("ELASTOCAP_TRUTH")
FEWER = {"global": 30, "finite": 30}  # their references take seconds a state
REFUSED, SKIPPED = 0.02, 0.05  # of all states
COMPARED = 0.9  # at least


def judged(kind, seed):
    """The verdict in a word, and why; a state itself holds functions that no process can send."""
    found = verdict(kind, seed)
    return found.word, found.why


@pytest.mark.parametrize("kind", KINDS)
def test_states_are_right_or_refused(kind):
    asked = int(GIVEN or FEWER.get(kind, 100))
    with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("fork")) as pool:
        found = list(pool.map(partial(judged, kind), range(asked)))
    seeds = {word: {} for word in ("wrong", "refused", "skipped", "right", "warned")}
    for seed, (word, why) in enumerate(found):
        seeds.setdefault(word, {})[seed] = why
    assert not seeds["wrong"], f"{len(seeds['wrong'])} of {asked}: {seeds['wrong']}"
    assert len(seeds["refused"]) <= REFUSED * asked, seeds["refused"]
    assert len(seeds["skipped"]) <= SKIPPED * asked, seeds["skipped"]
    assert len(seeds["right"]) >= COMPARED * asked
