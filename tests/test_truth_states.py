"""`minimise` on random profiles that are not convex, against the references of tests/truth.

A hundred states of each class; ELASTOCAP_TRUTH=2000 asks for as many of each.
python -m tests.truth CLASS 1 SEED.
"""

import os

import pytest
from truth.compare import verdict
from truth.scenes import KINDS

ASKED = int(os.environ.get("ELASTOCAP_TRUTH", "100"))
PARTS = 4  # of each class, so that several processes share them
REFUSED, SKIPPED = 0.02, 0.05  # of all states, or one of a part
COMPARED = 0.9  # at least


@pytest.mark.parametrize("part", range(PARTS))
@pytest.mark.parametrize("kind", KINDS)
def test_states_are_right_or_refused(kind, part):
    words = ("wrong", "refused", "skipped", "right", "warned")
    seeds, asked = {word: {} for word in words}, range(part, ASKED, PARTS)
    for seed in asked:
        found = verdict(kind, seed)
        seeds.setdefault(found.word, {})[seed] = found.why
    assert not seeds["wrong"], f"{len(seeds['wrong'])} of {len(asked)}: {seeds['wrong']}"
    assert len(seeds["refused"]) <= max(1, REFUSED * len(asked)), seeds["refused"]
    assert len(seeds["skipped"]) <= max(1, SKIPPED * len(asked)), seeds["skipped"]
    assert len(seeds["right"]) >= COMPARED * len(asked)
