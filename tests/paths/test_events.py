"""What an event of a path says of the contacts before and after it."""

from itertools import pairwise

import numpy as np
import pytest
from scenes import DELTA0, L, wavy

from discretization import load_path

LOOP = np.r_[-0.1, 0.6, 1.485, 1.8, np.linspace(1.2, -0.9, 6)] * DELTA0
MORE = {  # lines after an event less those before it; a jump keeps them or joins contacts
    "touch": (2,),
    "jump-in": (2,),
    "nucleation": (2,),
    "splitting": (2,),
    "jump": (0, -2, -4),
    "closing": (-2,),
    "coalescence": (-2,),
}


@pytest.fixture(scope="module", params=[{}, {"method": "lattice", "spacing": L / 64}], ids=str)
def path(request):
    return load_path(wavy(crests=3), depths=LOOP, **request.param)


def test_an_event_has_the_contacts_its_kind_says(path):
    for event in path.events:
        before, after = (
            [x for x in state.lines if np.isfinite(x)] for state in (event.before, event.after)
        )
        assert before == sorted(before) and after == sorted(after)
        if event.kind == "detachment":
            assert len(before) >= 2 and not after
        else:
            assert len(after) - len(before) in MORE[event.kind], event.kind


def test_no_contact_is_lost_between_two_events_or_an_event_and_a_step(path):
    """Only an event changes their number, and where it happens it is the number of that state."""
    counts, number = [], 0
    for step in range(len(path)):
        for event in path.events:
            if event.step == step:
                counts.append((lines(event.before), lines(event.after)))
                assert counts[-1][0] == number, event.kind
                number = counts[-1][1]
        assert lines(path.at(step)) == number, step
    assert len({number for pair in counts for number in pair}) >= 4
    assert all(one[1] == other[0] for one, other in pairwise(counts))


def lines(state):
    """How many contact lines a state has."""
    return sum(map(np.isfinite, state.lines))
