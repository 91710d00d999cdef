"""Fits of curves with what disturbs a measurement: spikes, interference, drift, a wrong sign.

Also what is known with an uncertainty, a scene without tension, and data without noise.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.measured_curves import START, sphere, written
from support.scene_files import SPHERE

from discretization import load_path
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Scene,
    SurfaceEnergies,
    cards,
)
from studies.scenes.curve_file import Reading, read_curve
from studies.scenes.fit import study as fit_study
from studies.scenes.fit.branches import retraction
from studies.scenes.fit.disturbances import noise, resolution, without_spikes
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve, Data
from studies.scenes.fit.search import widening
from studies.scenes.fit.trials import SCENE

FAST = {"profiles": False, "alternatives": False}
TRUTH = {"w": 1e-4, "gamma1": 0.03}
K = 0.08  # N/m
CLEAN = sphere(K)


def changed(extra, curve=CLEAN):
    """A curve with more force in it, at the same positions of the machine."""
    force = curve.force + extra
    return Curve(curve.drive - force / curve.machine_stiffness, force, curve.machine_stiffness)


def spiked(*spikes):
    """A curve with forces in newtons at some points more."""
    extra = np.zeros(CLEAN.force.size)
    for point, force in spikes:
        extra[point] += force
    return changed(extra)


def assert_found(found, truth=TRUTH):
    """Whether the model fits with intervals that hold the truth, or miss it by less than half."""
    assert found.quality.fits, found
    for name, true in truth.items():
        low, high = found[name].interval
        assert low - (high - low) / 4 < true < high + (high - low) / 4, (name, str(found))


@pytest.mark.parametrize(
    "spikes",
    [
        [(10, 3e-9)],
        [(30, -1e-9), (31, -1e-9)],
        [(28, 0.5e-9), (29, -1e-9)],
        [(75, 2e-9)],
    ],
)
def test_a_spike_moves_no_contact(spikes):
    """Out of contact and in it; the points are named and left out."""
    data = Data.of(spiked(*spikes))
    assert np.flatnonzero(data.spikes).tolist() == [point for point, _ in spikes]
    clean = Data.of(CLEAN)
    assert data.ends == clean.ends
    assert np.array_equal(data.used, clean.used & ~data.spikes)
    found = fit(START, spiked(*spikes), **FAST)
    assert_found(found)
    count = "1 point" if len(spikes) == 1 else "2 points"
    assert f"left out: {count}, off their neighbours, the first at d = " in str(found)


def test_points_beside_the_end_of_contact_are_no_spikes():
    """A bump of five points beside the detachment makes the last pulled points stick out."""
    bump = [(120 + i, 1e-9 * share) for i, share in enumerate((0.5, 1, 1, 1, 0.5))]
    curve = spiked(*bump)
    assert without_spikes(curve.force)[0][124:127].all()
    data = Data.of(curve)
    assert not data.spikes.any()
    assert np.array_equal(data.used, Data.of(CLEAN).used)


@pytest.mark.parametrize("scale", [0.0, 20e-12])
def test_jumps_and_turns_are_no_spikes(scale):
    curve = sphere(K, noise=scale)
    spikes, smooth = without_spikes(curve.force)
    assert not spikes.any() and np.array_equal(smooth, curve.force)


def test_what_is_wide_and_far_off_hardly_counts_with_soft_l1():
    bump = [(100 + i, 1e-9 * share) for i, share in enumerate((0.5, 1, 1, 1, 0.5))]
    curve = spiked(*bump)
    plain = fit(START, curve, **FAST)
    assert not plain.quality.fits
    assert "try the robust loss (--loss soft_l1)" in str(plain)
    found = fit(START, curve, loss="soft_l1", **FAST)
    assert_found(found)
    there = np.flatnonzero(found.model.data.used).searchsorted(102)
    assert found.model.data.roots[there] ** 2 < 0.2 < 0.8 < np.median(found.model.data.roots)
    with pytest.raises(ValueError, match="loss = 'huber' is unknown"):
        fit(START, curve, loss="huber")


def test_a_spike_at_the_end_of_contact_is_left_out_with_soft_l1():
    """The last two points before the detachment, where no neighbours show what is right.

    The minimum of soft_l1 follows them: w would be found 12 % too small, without a word.
    """
    last = int(Data.of(CLEAN).legs[-1].points[-1])
    curve = spiked((last - 1, 1.2e-9), (last, 1.2e-9))
    assert not Data.of(curve).spikes.any()
    found = fit(START, curve, loss="soft_l1", **FAST)
    assert np.flatnonzero(found.model.data.outliers).tolist() == [last - 1, last]
    assert "left out: 2 points, more than 6 times the noise from the fit" in str(found)
    assert_found(found)
    assert not fit(START, CLEAN, loss="soft_l1", **FAST).model.data.outliers.any()


def test_an_end_of_contact_counts_with_both_points_beside_it():
    """The end lies between two points; if one of them is wrong, so may be the end."""
    data = Data.of(CLEAN)
    (contact,) = data.contacts
    for mark in contact.ends:
        near, beside = mark.between
        assert abs(near - beside) == 1
        assert min(data.curve.drive[[near, beside]]) < mark.depth
        for point in mark.between:
            chosen = np.arange(CLEAN.force.size) != point
            assert contact.of(chosen).ends == [one for one in contact.ends if one != mark]
            lost = [one for one in data.ends if one == mark]
            roots = data.roots_without(~chosen)[data.points.size :]
            assert (roots < 1).tolist() == [one in lost for one in data.ends]


@pytest.mark.slow
def test_an_answer_that_hangs_on_points_far_off_is_doubted():
    """A bump beside the detachment, which tells most: with it w is 8 % off."""
    bump = [(120 + i, 1e-9 * share) for i, share in enumerate((0.5, 1, 1, 1, 0.5))]
    found = fit(START, spiked(*bump), loss="soft_l1", **FAST)
    assert "depends on 5 points far from the fit: without them" in found.unsuited


def test_soft_l1_widens_intervals_as_their_scatter_tells():
    """Of a mean of normal variables: the variance over many samples."""
    samples = np.random.default_rng(1).standard_normal((2000, 50))
    location = samples.mean(axis=1)
    for _ in range(30):
        r = samples - location[:, None]
        weights = 1 / np.sqrt(1 + (r / 2) ** 2)
        location = (weights * samples).sum(axis=1) / weights.sum(axis=1)
    said = np.mean(weights * r**2, axis=1) / weights.sum(axis=1)
    times = [widening(np.sqrt(w) * one, np.sqrt(w)) for w, one in zip(weights, r, strict=True)]
    assert np.mean(said * times) == pytest.approx(location.var(), rel=0.06)
    assert np.mean(said) < 0.9 * location.var()


def test_soft_l1_is_the_loss_of_scipy():
    """At the minimum its gradient vanishes: Σ r/√(1 + r²/c²) ∂r/∂x = 0 for the line's level."""
    bump = [(100 + i, 1e-9) for i in range(5)]
    data = fit(START, spiked(*bump), loss="soft_l1", **FAST).model.data
    found = fit(START, spiked(*bump), loss="soft_l1", **FAST)
    r = found.best.fun / data.roots
    columns = data.lines / data.roots[:, None]
    pull = (r / np.sqrt(1 + (r / (2 * data.sigma)) ** 2)) @ columns
    scale = np.abs(r) @ np.abs(columns)
    assert np.abs(pull / scale).max() < 1e-3


@pytest.mark.parametrize("period", [40e-9, 70e-9])
def test_the_contact_survives_interference_and_drift(period):
    """Waves over the position, and a zero of the force that moves over time."""
    order = np.linspace(0.0, 1.0, CLEAN.force.size)
    waves = 1.5e-10 * np.sin(2 * math.pi * CLEAN.drive / period + 0.7)
    curve = changed(waves + 2e-10 * order)
    data = Data.of(curve)
    assert 1 / data.wave == pytest.approx(period, rel=0.03)
    (clean,), (one,) = Data.of(CLEAN).contacts, data.contacts
    for leg, own in zip(clean.legs, one.legs, strict=True):
        assert np.abs(leg.points[[0, -1]] - own.points[[0, -1]]).max() <= 1
    found = fit(START, curve, **FAST)
    assert_found(found)
    assert "has waves, as interference has, with a period of" in str(found)
    assert Data.of(CLEAN).wave == 0


def test_a_position_that_falls_on_approach_is_a_height(tmp_path):
    """A table of a piezo whose position falls as it comes nearer: its sign is reversed, said so."""
    curve = sphere(K)
    upside_down = Curve(-curve.drive, curve.force)
    with pytest.raises(ValueError, match=r"depth falls where .* pressed.*give its negative"):
        fit(START, upside_down, **FAST)
    path = written(tmp_path / "falling.csv", upside_down, "Piezo [nm];Force [nN]")
    found = read_curve(path, Reading(width=1.0, spring_constant=K))
    assert found.depth == pytest.approx(curve.depth, abs=1e-14)
    assert "layer is where 'piezo' is smaller, against what its name says" in found.notes[0]
    assert found.notes[0] in str(fit(START, found, **FAST))
    for sign, name in ((1, "Piezo"), (-1, "Height")):
        right = Curve(sign * curve.drive, curve.force)
        path = written(tmp_path / "right.csv", right, f"{name} [nm];Force [nN]")
        assert read_curve(path, Reading(width=1.0, spring_constant=K)).notes == ()


@pytest.mark.parametrize("response", ["springs", "layer"])
def test_a_scene_without_tension_is_springs_or_jkr(response):
    layer = replace(SCENE.layer, response=response, h=5e-3 if response == "layer" else 0.3e-6)
    slack = replace(SCENE, layer=layer, surfaces=SurfaceEnergies.from_work(0.0, 0.7e-4))
    if response == "springs":
        true = replace(slack, surfaces=SurfaceEnergies.from_work(0.0, 1e-4))
        way = np.linspace(-60e-9, 60e-9, 90)
        depth = np.concatenate([way, way[::-1]])
        force = load_path(true, depths=depth).force
        said = "independent springs without surface tension, which detach one by one"
    else:
        given = {"R": 5e-6, "E": layer.E, "nu": layer.nu, "w": 1e-4}
        a = 0.65e-6 * np.linspace(1.0, 3.0, 60)
        depth = cards.layer.half_space_depth(a, **given)
        force = cards.layer.half_space_force(a, **given)
        said = "Johnson, Kendall and Roberts (JKR)"
    size = 2e-3 * np.abs(force).max()
    force = force + size * np.random.default_rng(4).standard_normal(force.size)
    found = fit(slack, Curve(depth, force), **FAST)
    assert "gamma1 = 0 in the scene: " in str(found) and said in str(found)
    assert [one.name for one in found.estimates][:2] == ["w", "offset"]
    assert_found(found, {"w": 1e-4})
    with pytest.raises(ValueError, match=r"parameters = .* must be among"):
        fit(slack, Curve(depth, force), ("gamma1",), **FAST)


def test_a_layer_with_hardly_any_tension_pulls_like_jkr():
    """3/2 π R w: on a body far thicker than the contact."""
    layer = ElasticLayer(30e3, 0.45, 200e-6, response="layer")
    scene = replace(SCENE, layer=layer, surfaces=SurfaceEnergies.from_work(1e-6, 1e-4))
    branch, _ = retraction(scene, 0.0, 1e-7)
    assert branch.force.min() == pytest.approx(-1.5 * math.pi * 5e-6 * 1e-4, rel=1e-3)


def test_youngs_modulus_is_the_stiffness_times_the_thickness():
    names = ("w", "gamma1", "offset")
    one = fit(START, CLEAN, (*names, "E"), **FAST)
    other = fit(START, CLEAN, (*names, "stiffness"), **FAST)
    assert_found(one, TRUTH | {"E": 30e3})
    ratio = SCENE.layer.E / SCENE.stiffness
    assert one["E"].value == pytest.approx(ratio * other["stiffness"].value, rel=1e-4)
    assert one["E"].interval == pytest.approx(
        ratio * np.array(other["stiffness"].interval), rel=1e-3
    )
    assert " Pa\n" in str(one)
    with pytest.raises(ValueError, match="E follows from the stiffness; leave one out"):
        fit(START, CLEAN, ("E", "stiffness"))


@pytest.mark.slow
def test_uncertain_radius_and_thickness_widen_the_intervals():
    """On springs E = k h(1 + ν)(1 - 2ν)/(1 - ν): its relative variance has that of h in it."""
    names = ("w", "gamma1", "E", "offset")
    sure = fit(START, CLEAN, names, **FAST)
    found = fit(START, CLEAN, names, uncertainties={"h": 0.2}, **FAST)
    half = [np.log(one["E"].interval[1] / one["E"].value) for one in (sure, found)]
    assert half[1] == pytest.approx(math.hypot(half[0], 1.98 * 0.2), rel=0.05)
    assert found["h"].value == pytest.approx(0.3e-6, rel=0.01)
    assert np.log(found["h"].interval[1] / 0.3e-6) == pytest.approx(1.98 * 0.2, rel=0.05)
    assert "ill-conditioned" not in str(found)
    wide = fit(START, CLEAN, uncertainties={"R": 0.1}, **FAST)
    assert_found(wide)
    plain = fit(START, CLEAN, **FAST)
    for name in ("w", "gamma1"):
        assert np.ptp(wide[name].interval) > 1.3 * np.ptp(plain[name].interval)
    punch = replace(START, indenter=FlatPunch(1e-6))
    for scene, given, words in (
        (START, {"nu": 0.1}, "uncertainties = 'nu' is unknown.*'R', 'h'"),
        (START, {"R": 0.0}, r"uncertainties\['R'\] = 0.0 must be positive"),
        (punch, {"R": 0.1}, "FlatPunch has no R"),
    ):
        with pytest.raises(ValueError, match=words):
            fit(scene, CLEAN, uncertainties=given)


def test_the_shares_of_uncertainties_are_read():
    assert fit_study._uncertainty("R=2%") == ("R", 0.02)
    assert fit_study._uncertainty("h=0.05") == ("h", 0.05)
    with pytest.raises(ValueError, match="uncertainty = 'R' must be a name and a share"):
        fit_study._uncertainty("R")


@pytest.mark.parametrize("start", [(0.07, 6e-5), (0.05, 4e-5)])
@pytest.mark.parametrize("digits", [17, 6])
def test_intervals_of_data_without_noise_hold_the_truth(start, digits):
    """Never narrower than the error of simulated forces and the digits that were kept."""
    layer = ElasticLayer(2.5e3, 0.3, 5e-6)
    scene = Scene(layer, SurfaceEnergies.from_work(0.07, 6e-5), Parabola(0.02))
    depth = np.r_[np.linspace(0, 4e-7, 100), np.linspace(4e-7, -6e-7, 200)]
    force = load_path(scene, depths=depth).force
    force = np.array([float(f"{value:.{digits}g}") for value in force])
    begin = replace(scene, surfaces=SurfaceEnergies.from_work(*start))
    found = fit(begin, Curve(depth, force), **FAST)
    for name, true in {"w": 6e-5, "gamma1": 0.07, "offset": 0.0}.items():
        low, high = found[name].interval
        assert low < true < high, name
    smooth = digits == 17
    assert ("These smooth data show no noise" in str(found)) == smooth
    assert (" times the noise" in str(found)) != smooth
    shown = str(found).splitlines()[1].split()
    assert shown[2] != shown[3]  # the ends of a narrow interval are told apart


def test_digits_that_are_missing_are_noise():
    """Forces in steps of 0.1 nN, which third differences often do not show."""
    curve = sphere(K, noise=1e-12)
    force = np.round(curve.force, 10)
    assert resolution(force) == pytest.approx(1e-10, rel=1e-6)
    data = Data.of(Curve(curve.drive - force / K, force, K))
    assert data.sigma >= 1e-10 / math.sqrt(12) * (1 - 1e-6)
    assert noise(curve.force) == pytest.approx(1e-12, rel=0.3)


def test_loading_and_unloading_apart_are_named():
    """Viscoelastic, or two works of adhesion."""
    half = CLEAN.force.size // 2
    unloads = np.arange(CLEAN.force.size) >= half
    lag = np.where(unloads & (CLEAN.drive > 0), -0.1 * np.abs(CLEAN.force).max(), 0.0)
    found = fit(START, changed(lag), **FAST)
    assert not found.quality.fits
    assert "unloading differs from loading by -" in found.unsuited
    assert "viscoelasticity or two works of adhesion. Measured ten times" in found.unsuited
    both = fit(START, changed(np.where(CLEAN.drive > 0, 5e-10, 0.0)), **FAST)
    assert not both.quality.fits and "unloading" not in both.unsuited


@pytest.mark.slow
def test_a_folder_names_the_curves_that_failed(tmp_path, capsys):
    scene = tmp_path / "sphere.toml"
    folder = tmp_path / "curves"
    scene.write_text(SPHERE, "utf-8")
    folder.mkdir()
    curve = sphere(n=50)
    written(folder / "good.csv", curve)
    written(folder / "reversed.csv", curve._replace(force=-curve.force))
    (folder / "creep.csv").write_text("depth [nm];force [nN]\n1;2\n1;3\n", "utf-8")
    given = [str(folder), "--scene", str(scene), "--out", str(tmp_path), "--quick", "--jobs", "1"]
    assert fit_study.main([*given, "--uncertainty", "R=2%", "--loss", "soft_l1"]) == 1
    said = capsys.readouterr().out
    assert "1 of 3 curves are described by the model" in said
    assert f"{folder / 'creep.csv'}: not fitted: curve: the depth is the same at all 2" in said
    assert f"{folder / 'reversed.csv'}: residual is" in said
    assert "good.csv:" not in said
