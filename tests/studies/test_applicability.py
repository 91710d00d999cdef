"""The study `applicability`: what it measures on a small preset, its report and files."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.repository import ROOT

from discretization import minimise
from energy import ElasticLayer, FlatPunch, Parabola, Scene, SurfaceEnergies, cards
from studies.applicability import figures as applicability_figures
from studies.applicability import report as applicability_report
from studies.applicability import study as applicability
from studies.applicability.record import Point
from studies.shared import small_slopes
from studies.shared.small_slopes import Errors, at_unit_width, blunt, punch, scene
from studies.shared.table import read

PRESET = applicability.Parameters(
    ratios=(1e-4, 1e-3, 0.01, 0.1, 1.25, 1.4),
    steepness=(0.03, 0.3),
    widths=(0.1, 10.0),
    lines=(),
    scan=(1e-4, 0.3),
    paths=(0.05, 0.2),
    tensions=(1.2, 5.0, 100.0),
)


@pytest.fixture(scope="module")
def record():
    return applicability.run(PRESET)


def leading(steepness, ratio):
    """Expansion of (16) against 2l sin((π - θ - β)/2), of third order in both slopes."""
    alpha = math.sqrt(2 * ratio)
    return (alpha**2 - alpha * steepness + 3 * steepness**2) / 8


def test_every_simulated_state_obeys_young_s_law(record):
    young = [abs(x.errors.young) for x in record.points if math.isfinite(x.errors.young)]
    assert len(young) >= 25
    assert max(young) < 1e-9


def test_flat_face_lets_go_at_any_slope(record):
    """A flat face lets go at the critical separation at any slope."""
    errors = {name: [abs(e) for n, _, e in record.flat if n == name] for name, *_ in record.flat}
    assert max(errors["flat punch"]) < 1e-9
    assert max(errors["parabola"]) < 1e-7
    assert all(abs(x.errors.half_width) < 1e-14 for x in record.maps["flat punch"] if x.ratio < 1)


def test_the_punch_s_force_is_off_by_its_surface_term(record):
    for x in record.maps["flat punch"]:
        assert x.errors.exists == (x.ratio < 1)
        if x.ratio < 1:
            elastic = x.width * math.sqrt(2 * x.ratio)
            tension = math.sqrt(2 * x.ratio)
            true = elastic + math.sqrt(x.ratio * (2 - x.ratio))
            expected = (true - elastic - tension) / max(true, tension)
            assert x.errors.force == pytest.approx(expected, rel=1e-7, abs=1e-12)


@pytest.mark.parametrize(("shape", "stiffer"), [("wedge", 1), ("parabola", 2)])
def test_error_of_small_slopes_is_first_order_in_w(shape, stiffer):
    """The error vanishes in first order of w and with the expected factor."""
    ratios = np.geomspace(1e-4, 1e-2, 4)
    power = applicability_report.power
    steepness = 0.5 * np.sqrt(2 * ratios)
    found = [at_unit_width(shape, s, r) for s, r in zip(steepness, ratios, strict=True)]
    width, angle = (np.abs([getattr(x, name) for x in found]) for name in ("half_width", "angle"))
    assert power(ratios, width) == pytest.approx(1, rel=0.02, abs=0)
    expected = -leading(steepness[0], ratios[0]) / stiffer
    assert found[0].half_width == pytest.approx(expected, rel=1e-3, abs=0)
    assert power(ratios, angle) == pytest.approx(1, rel=0.01, abs=0)
    assert angle[0] == pytest.approx(ratios[0] / 12, rel=1e-3, abs=0)


def test_borders_are_where_the_error_has_the_tolerance(record):
    wedge, parabola = (
        lambda ratio, shape=shape: at_unit_width(shape, 0.1, ratio).half_width
        for shape in ("wedge", "parabola")
    )
    border = applicability.border(wedge, (1e-4, 0.02, 0.1), 0.01)
    assert abs(wedge(border)) == pytest.approx(0.01, rel=2e-3, abs=0)
    assert leading(0.1, border) == pytest.approx(0.01, rel=0.05, abs=0)
    assert applicability.border(parabola, (0.02, 0.2), 0.01) > 1.8 * border
    found = {b.tolerance: b.ratio for b in record.borders if b.quantity == "π - θ"}
    for tolerance in (0.01, 0.1):
        alpha = math.sqrt(2 * found[tolerance])
        assert 1 - alpha / (2 * math.asin(alpha / 2)) == pytest.approx(tolerance, rel=5e-3, abs=0)


@pytest.mark.parametrize(
    ("errors", "border"),
    [
        (lambda ratio: at_unit_width("wedge", 0.3, ratio), 1 + math.sin(math.atan(0.3))),
        (lambda ratio: punch(1.0, ratio), 1.0),
    ],
)
def test_surface_turns_over_at_a_right_angle(errors, border):
    """The surface turns over where its inclination is a right angle."""
    assert errors(0.99 * border).exists
    assert not errors(1.01 * border).exists


def test_other_failures_are_no_overhang():
    """Other failures of the simulation are not taken for an overhang."""
    with pytest.raises(ValueError, match="depth"):
        small_slopes.simulated(scene(blunt("wedge", 0.1), 1.0, 0.5), math.nan)


def test_deviation_from_16_scales_with_steepness(record):
    """The deviation from Eq. (16) without tension scales with the steepness."""
    tense, dry = record.small_slopes
    assert tense < 1e-10
    assert dry < 1e-12
    for points_of in record.paths.values():
        steepness, worst = applicability_figures.worst_on_path(points_of, "half_width")
        assert applicability_report.power(steepness, worst) == pytest.approx(1, abs=0.1)
        assert worst[0] < 0.01 < worst[1]
        bound = applicability_report.within(steepness, worst, 0.01)
        assert steepness[0] < bound < steepness[1]
    sharp = [x for x in record.paths["wedge"] if x.steepness == 0.2]
    assert len(sharp) == 2  # at γ₁ = 100 w the wedge is too sharp to stick at d = 0


def test_every_quantity_of_every_shape_has_its_two_borders(monkeypatch):
    monkeypatch.setitem(small_slopes.QUANTITIES, "force", lambda *at: at[2])
    found = list(applicability.borders(replace(PRESET, lines=(0.05,))))
    rows = [(b.shape, b.quantity) for b in found]
    shapes = ("wedge", "parabola", "cone", "sphere")
    named = [(shape, name) for shape in shapes for name in ("half-width", "force")]
    assert rows[::2] == rows[1::2] == [*named, ("any", "π - θ")]
    force = [b.ratio for b in found if b.quantity == "force"]
    assert force == pytest.approx(4 * [0.01, 0.1], rel=2e-3, abs=0)


@pytest.mark.slow
def test_report_table_and_figures_are_written_from_the_record(record, tmp_path, monkeypatch):
    monkeypatch.setattr(applicability, "run", lambda *_: record)
    assert applicability.main(["--quick", "--out", str(tmp_path)]) == 0
    page = (tmp_path / "applicability.md").read_text("utf-8")
    assert "The conjecture holds" in page
    one, ten = (b.ratio for b in record.borders)
    assert f"| any | any | π - θ | below {one:.2g} | below {ten:.2g} |" in page
    gone = min(x.ratio for x in record.points if not x.errors.exists)
    assert f"turns over, first at w/γ₁ = {gone:g}" in page
    assert (tmp_path / "eq16.png").exists()
    rows = read(tmp_path / "applicability.csv")
    assert len(rows) == len(record.points)
    assert float(rows[0]["error_half_width"]) == record.maps["wedge"][0].errors.half_width
    for name in ("applicability.png", "conjecture.png"):
        assert (tmp_path / name).exists()
        assert f"]({name})" in page


def test_the_answer_follows_the_numbers(record):
    def spoilt(x):
        return x._replace(errors=x.errors._replace(half_width=0.3, young=1e-5))

    paths = {shape: tuple(map(spoilt, row)) for shape, row in record.paths.items()}
    flat = (("flat punch", 0.1, 1e-9), ("flat punch", 0.2, -4e-7), ("flat punch", 0.3, 2e-8))
    text = applicability_report.answer(replace(record, paths=paths, flat=flat))
    assert "The conjecture fails" in text
    assert "3.0e-01 at 0.2 | nowhere tried | nowhere tried |" in text
    assert "π - θ obeys Young's law (8) within 1e-05 of itself" in text
    assert "the flat punch detaches at d = -√(2w/k) within 4e-07 for w/γ₁ from 0.1 to 0.3" in text


def test_forces_around_an_axis_are_compared_in_units_of_its_line():
    given = small_slopes.scene(Parabola(5.0), 1.0, 0.3, geometry="axisymmetric")
    depth = small_slopes.depth_by_16(given, 2.0)
    errors = small_slopes.compare(given, depth, 2.0)
    state = minimise(given, depth)
    around = {"R": 5.0, "k": 1.0, "gamma1": 1.0, "w": 0.3}
    force = cards.axisymmetric.sphere.force_of_radius(2.0, **around)
    line = 4 * math.pi * math.sqrt(0.6)
    assert abs(state.force) < line
    assert errors.force == pytest.approx((force - state.force) / line, rel=1e-9, abs=0)
    assert depth == pytest.approx(cards.axisymmetric.sphere.depth(2.0, **around), rel=1e-12, abs=0)


def test_summary_has_the_largest_error(record):
    """The short answer tells the largest error of any shape and quantity."""

    def path(*errors):
        """Points at two γ₁ with these steepness and |error| of a and of P."""
        return tuple(
            Point("wedge", ratio, s, 1.0, Errors(-part * a, part * force, 0.0, 0.0))
            for s, a, force in errors
            for ratio, part in ((0.1, 1.0), (0.2, 0.5))
        )

    wedge = path((0.1, 0.02, 0.01), (1.0, 0.3, 0.6))
    parabola = path((0.1, 0.01, 0.04), (1.0, 0.5, 0.2))
    for paths in ({"wedge": wedge, "parabola": parabola}, {"parabola": parabola, "wedge": wedge}):
        told = applicability_report.short(replace(record, paths=paths))
        assert "4.0% where f'(a₀) = 0.1 and 60.0% where f'(a₀) = 1." in told


@pytest.mark.parametrize("nu", applicability_figures.RATIOS)
def test_borders_of_regimes_are_those_of_warnings(nu):
    """To a percent, on either side: springs, the lift of the layer by δ₀, and small slopes."""

    def warned(thickness, ratio):
        layer = ElasticLayer(1.0, nu, 1.0)
        gamma1 = layer.stiffness / thickness**2  # l = h over that
        surfaces = SurfaceEnergies.from_work(gamma1, ratio * gamma1)
        scene = Scene(layer, surfaces, FlatPunch(1e3))
        assert applicability_figures.place(scene) == pytest.approx((thickness, ratio))
        state = minimise(scene, -(1 - 1e-9) * scene.critical_separation)
        return {a.name for a in state.validity if not a.holds}

    thick = applicability_figures.thickest(nu)
    assert not warned(0.99 * thick, 0.99**3 * thick**2 / 200)
    assert warned(1.01 * thick, 0.99**3 * thick**2 / 200) & {"h/l", "|c₂|(h/l)²"}
    assert "u/h" in warned(0.99 * thick, thick**2 / 200)
    assert "2w/γ₁" not in warned(10.0, 0.0499)
    assert "2w/γ₁" in warned(10.0, 0.0501)


def test_the_figure_of_the_regimes_holds_every_example():
    (axes,) = applicability_figures.draw_regimes().axes
    named = [line.get_label().split(",")[0] for line in axes.lines]
    for path in (ROOT / "studies" / "scenes").glob("*.toml"):
        at = named.index(path.stem.replace("_", " "))
        x, y = axes.lines[at].get_data()
        assert axes.get_xlim()[0] < x[0] < axes.get_xlim()[1]
        assert axes.get_ylim()[0] < y[0] < axes.get_ylim()[1]
