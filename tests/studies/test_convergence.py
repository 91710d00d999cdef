"""The engine of the checks: errors, orders, both discretisations, failures."""

import math

import pytest

from studies.verify import convergence, mesh
from studies.verify import study as verify
from studies.verify.convergence import EXACT, FIRST, SECOND, Comparison, check, refine

CELLS = (50, 100, 200, 400)


CELLS = (50, 100, 200, 400)


def artificial(error, order=SECOND, **options):
    """A check on lattices whose simulated value is off by error(cells)."""

    @check(what="artificial", order=order, lattice_only="artificial", **options)
    def measure(grid):
        return Comparison(2.5 * (1 + error(grid.cells)), 2.5)

    return refine(measure, CELLS, (0.0,))


def test_the_engine_wants_the_order_as_well_as_the_error():
    assert artificial(lambda n: n**-2.0, bar=1e-5).passed
    assert not artificial(lambda n: n**-2.0, bar=1e-6).passed
    first = artificial(lambda n: 1e-3 / n, bar=1e-5)
    assert first.error < 1e-5
    assert first.observed_order == pytest.approx(1, abs=1e-9)
    assert not first.passed
    assert artificial(lambda n: 1e-3 / n, order=FIRST, bar=1e-5).passed
    assert not artificial(lambda n: 1e-7 + n**-2.0 / 1e3, bar=1e-5).passed
    assert not artificial(lambda n: n**-3.0, bar=1e-5).passed


def test_the_engine_judges_an_exact_quantity_on_every_grid():
    assert artificial(lambda n: 1e-15, order=EXACT).passed
    assert not artificial(lambda n: 1e-3 if n == CELLS[0] else 0.0, order=EXACT).passed


def test_the_engine_takes_the_worst_shift():
    @check(what="sawtooth", lattice_only="artificial")
    def measure(grid):
        return Comparison(1 + (grid.offset + 1) / grid.cells**2, 1.0)

    result = refine(measure, CELLS, (0.0, 0.5, 0.25))
    assert result.errors == pytest.approx([1.5 / n**2 for n in CELLS], rel=1e-9, abs=0)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_value_that_is_no_number_fails(value):
    result = artificial(lambda n: value)
    assert result.error == math.inf
    assert not result.passed


def fitted_only(error, **options):
    """A check that is right on lattices and off by `error` on the fitted mesh."""

    @check(what="fitted", order=EXACT, **options)
    def measure(where):
        return Comparison(2.5 * (1 + error * isinstance(where, mesh.Fitted)), 2.5)

    return refine(measure, CELLS, (0.0, 0.5))


def test_the_engine_wants_both_discretisations():
    right, wrong = fitted_only(1e-11), fitted_only(1e-9)
    assert right.passed
    assert wrong.lattice_passed
    assert not wrong.passed
    assert wrong.fitted_error == pytest.approx(1e-9, rel=1e-5, abs=0)
    assert fitted_only(1e-9, fitted_bar=2e-9).passed
    assert not fitted_only(math.nan).passed


def test_what_only_a_lattice_can_do_is_not_asked_of_the_fitted_mesh():
    result = fitted_only(1.0, lattice_only="because")
    assert result.passed
    assert math.isnan(result.fitted_error)
    assert verify.fitted(result) == "—"
    assert "because" in verify.report(verify.Record(verify.Parameters(), (result,), None), "")


def test_an_error_of_the_fitted_mesh_alone_fails_the_check_and_is_reported():
    @check(what="breaks", order=EXACT)
    def measure(where):
        if isinstance(where, mesh.Fitted):
            raise ValueError("no such depth")
        return Comparison(1.0, 1.0)

    result = refine(measure, CELLS, (0.0,))
    assert result.lattice_passed
    assert not result.passed
    assert result.fitted_error == math.inf
    assert "fitted: ValueError: no such depth" in verify.line(result)


def test_fewer_than_four_levels_have_no_order():
    assert math.isnan(convergence.observed_order((50, 100, 200), (4e-6, 1e-6, 2.5e-7)))


def test_an_error_of_the_simulator_fails_the_check_and_is_reported():
    @check(what="breaks")
    def measure(grid):
        raise ValueError("no such depth")

    result = refine(measure, CELLS, (0.0,))
    assert not result.passed
    assert "ValueError: no such depth" in verify.line(result)


def test_a_first_order_check_has_to_name_its_bar():
    with pytest.raises(ValueError, match="bar="):
        check(what="x", order=FIRST)
