"""The study of a rough cylinder: tension breaks the contact up, the global state is the lowest."""

import numpy as np
import pytest

from studies import rough


@pytest.fixture(scope="module")
def loops():
    return rough.run(rough.Parameters(nodes=1001, steps=15, compared=3))


def test_tension_breaks_the_contact_up_into_spots(loops):
    assert [loop.tension for loop in loops] == [0.25, 1.0, 4.0]
    spots = [int(loop.contacts.max()) for loop in loops]
    assert spots[0] < spots[-1] and spots[-1] >= 8
    deepest = [loop.fraction[14] for loop in loops]
    assert deepest[0] == pytest.approx(1.0, abs=1e-13) and deepest[-1] < 0.6


def test_energies_balance_and_contacts_are_lost(loops):
    for loop in loops:
        assert loop.path.work() == pytest.approx(loop.path.dissipated, rel=1e-11, abs=0)
        assert np.isnan(loop.path.contacts[-1]).all()


def test_no_metastable_state_lies_below_the_global_one(loops):
    assert all(rough.lowest_is_lowest(loop) for loop in loops)
    below = [s.energy < loop.path.energy[i] for loop in loops for i, s in loop.lowest.items()]
    assert any(below)


def test_weak_adhesion_comes_to_rest():
    """Lone nodes that have just touched do not let go again by rounding."""
    params = rough.Parameters(w=2e-7, compared=0, tensions=(4.0,))
    (loop,) = rough.run(params)
    assert loop.contacts.max() >= 10
    assert loop.path.work() == pytest.approx(loop.path.dissipated, rel=1e-11, abs=0)
