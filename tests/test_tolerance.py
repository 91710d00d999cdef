"""rtol is honoured and error_estimate can be trusted."""

import pytest

from studies import tolerance


@pytest.fixture(scope="module")
def trials():
    return tolerance.run(tolerance.Parameters())


def test_rtol_is_honoured_in_99_of_100_scenes(trials):
    assert len(trials) == 500
    assert sum(trial.honoured for trial in trials) >= 495


def test_no_estimate_is_below_a_tenth_of_the_error(trials):
    assert [trial for trial in trials if not trial.trusted] == []


def test_a_loose_tolerance_is_used(trials):
    """Errors do grow with rtol: the mesh is not simply the finest one always."""
    worst = {
        loose: max(max(t.errors) for t in trials if (t.rtol > 1e-4) == loose)
        for loose in (True, False)
    }
    assert worst[True] > 30 * worst[False]


def test_the_study_fails_when_an_estimate_or_an_error_is_off(trials):
    assert tolerance.passed(trials)
    first = trials[0]
    bold = first._replace(errors=(1e-8, 0.0, 0.0), estimates=(9e-10, 1.0, 1.0))
    assert not bold.trusted
    assert not tolerance.passed([bold, *trials])
    wrong = first._replace(errors=(2 * first.rtol + 1e-11,) * 3, estimates=(1.0,) * 3)
    assert wrong.trusted and not wrong.honoured
    assert not tolerance.passed([*trials, *[wrong] * 7])
