"""`minimise` on random profiles that are not convex, against the references of tests/truth.

Five states of each class, 60 with `-m slow`, and with ELASTOCAP_TRUTH=2000 as many of each.
python -m tests.truth CLASS 1 SEED prints one.
"""

import os

import pytest
from truth.compare import verdict
from truth.scenes import KINDS

FEW, MANY = 5, int(os.environ.get("ELASTOCAP_TRUTH", "60"))
REFUSED, SKIPPED = 0.02, 0.05  # of all states, or one of a few
COMPARED = 0.8  # at least


@pytest.mark.parametrize("kind", KINDS)
def test_a_few_states_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_many_states_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW, MANY))


def assert_right_or_refused(kind, asked):
    """None of the states of these seeds is wrong, and few are refused or skipped."""
    words = ("wrong", "refused", "skipped", "right", "warned")
    seeds = {word: {} for word in words}
    for seed in asked:
        found = verdict(kind, seed)
        seeds.setdefault(found.word, {})[seed] = found.why
    assert not seeds["wrong"], f"{len(seeds['wrong'])} of {len(asked)}: {seeds['wrong']}"
    assert len(seeds["refused"]) <= max(1, REFUSED * len(asked)), seeds["refused"]
    assert len(seeds["skipped"]) <= max(1, SKIPPED * len(asked)), seeds["skipped"]
    assert len(seeds["right"]) >= COMPARED * len(asked)
