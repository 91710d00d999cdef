"""The first term of an increasing sequence that is above a level."""

import math

import numpy as np
import pytest

from discretization.lattice.fronts import first_above


def searched(term, count, level=0.0):
    rounds = []

    def excess(numbers):
        assert numbers.min() >= 0
        assert numbers.max() < count
        assert (np.diff(numbers) >= 0).all()
        rounds.append(numbers.size)
        with np.errstate(over="ignore"):
            return level + term(numbers)

    return first_above(level, excess, count), rounds


@pytest.mark.parametrize("level", [0.0, 0.5, -3.0])
@pytest.mark.parametrize("shape", [1, 2, 3, 0.3, 40])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 100, 2**31])
def test_it_is_the_first_one_above(count, shape, level):
    for zero in {-1, 0, 1, 2, 63, 99, 100, 12_345_678, count - 1, count, count + 5}:
        found, rounds = searched(
            lambda x, zero=zero: np.sign(x - zero) * np.abs(x - zero) ** shape, count, level
        )
        assert found == min(max(zero + 1, 0), count)
        assert len(rounds) <= 9


@pytest.mark.parametrize("far", [math.inf, math.nan])
def test_what_is_not_finite_is_beyond(far):
    found, _ = searched(lambda x: np.where(x < 700, -1.0, far), 2**31)
    assert found == 700
    found, _ = searched(lambda x: np.where(x < 900, x - 700.5, far), 2**31)
    assert found == 701


def test_a_step_is_found_in_few_rounds():
    found, rounds = searched(lambda x: np.where(x < 98_765_432, -1.0, 1e-9), 2**31)
    assert found == 98_765_432
    assert len(rounds) <= 9
