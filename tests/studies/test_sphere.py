"""The study `sphere`: numbers, figure, files and answer."""

import numpy as np
import pytest

from studies import sphere
from studies.__main__ import main

SMALL = sphere.Parameters((0.03, 1.0, 4.0), (1.0,), (0.1,))


@pytest.fixture(scope="module")
def spheres():
    return sphere.run(SMALL)


def test_small_slopes_are_the_closed_forms_and_finite_ones_are_near(spheres):
    assert [s.slopes for s in spheres] == ["small"] * 3 + ["finite"]
    assert max(s.error for s in spheres[:3]) <= 1e-11
    assert 1e-4 < spheres[3].error < 1e-2
    forces = [s.load.force for s in spheres[:3]]
    assert forces[0] > 0.97 and 0.5 < forces[2] < 0.501
    for s in spheres:
        assert s.depth.depth < s.load.depth and s.depth.radius < s.load.radius
        assert 0 < s.depth.force < s.load.force


def test_the_expansions_and_the_line_contact_drawn_are_those_of_the_cards(spheres):
    drawn = sphere.plot(spheres)
    left, right = drawn.axes
    lines = {line.get_label(): line for line in left.lines}
    _, line_contact = lines["line contact, over its springs'"].get_data()
    ratios = lines["closed form"].get_xdata()
    given = {"R": 1e-3, "k": 1e8, "w": 1e-3}
    lift = (2 * given["w"] / given["k"]) ** 0.5
    tension = given["k"] * ratios**2 * given["R"] * lift
    pull = sphere.cards.parabola.adhesion_force(gamma1=tension, **given)
    bare = sphere.cards.parabola.adhesion_force(gamma1=0.0, **given)
    assert np.allclose(line_contact, pull / bare, rtol=1e-12, atol=0)
    depth = sphere.cards.parabola.pull_off(gamma1=tension, **given).depth / lift
    pulled = next(line for line in right.lines if line.get_label() == "line contact: dead load")
    assert np.allclose(pulled.get_ydata(), depth, rtol=1e-12, atol=0)
    stiff = lines["expansions, Λ → 0 and Λ → ∞"]
    assert abs(stiff.get_ydata()[0] - sphere.closed_forms(ratios[0])[0].force) < 3e-5


def test_what_is_written_and_said(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sphere, "QUICK", sphere.Parameters((0.1, 1.0), (1.0,), (0.1,)))
    assert main(["sphere", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"sphere.csv", "sphere.png"}
    said = capsys.readouterr().out
    assert "answer: Both: F_A/2πRw falls from 1 to ½" in said
    assert "0.929 at Λ = 0.1, 0.5546 at Λ = 1" in said
    monkeypatch.setattr(sphere, "LARGEST", 1e-30)
    assert main(["sphere", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 1
