"""The certificate must reject what is no equilibrium; sums on nodes against 50-digit arithmetic."""

import itertools
import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from lattices import nodes_of, of_heights, over, pressed
from scenes import adhesive

from discretization import Lattice, NodalEnergy, minimise
from discretization.lattice.judge import judge, totals
from discretization.lattice.state import on_lattice
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

SCENE, DEPTH = adhesive(Parabola(0.02)), 2e-3
DX = SCENE.elastocapillary_length / 100
ROUGH = adhesive(Sampled([-1.0, 0.0, 1.0, 2.0], [3.0, 0.0, 1.0, 0.5]))


def judged(scene, depth, change=(0, 0), sums_change=None, dx=DX):
    lattice, ((first, last),) = nodes_of(on_lattice(scene, depth, dx))
    moved = over(lattice, scene.indenter, depth, (first + change[0], last + change[1]))
    sums = totals(moved)
    if sums_change:
        sums = sums._replace(**sums_change(sums))
    return judge(moved, sums)


def test_the_equilibrium_passes_with_violations_at_rounding():
    certificate = judged(SCENE, DEPTH)
    assert certificate.ok
    assert certificate.penetration == certificate.opening == certificate.neighbours == 0
    assert certificate.force <= 1e-13


@pytest.mark.parametrize("change", [(0, 1), (0, -1), (1, 0), (-1, 0)])
def test_one_link_off_costs_energy(change):
    assert judged(SCENE, DEPTH).ok
    certificate = judged(SCENE, DEPTH, change)
    assert certificate.failures == ("neighbours",) and certificate.stationarity == 0


def test_a_contact_too_small_penetrates():
    failures = judged(adhesive(Parabola(0.02), w=0.0), DEPTH, (3, -3)).failures
    assert "penetration" in failures


def test_a_contact_too_large_without_adhesion_pulls():
    failures = judged(adhesive(Parabola(0.02), w=0.0), DEPTH, (-3, 3)).failures
    assert "neighbours" in failures


def test_a_wrong_force_is_noticed():
    wrong = judged(SCENE, DEPTH, sums_change=lambda s: {"force": s.force * (1 + 1e-7)})
    assert wrong.failures == ("force",)


@pytest.mark.parametrize(("share", "failures"), [(1.0, ()), (-1.0, ("opening",))])
def test_a_lone_node_holds_nothing(share, failures):
    lattice = Lattice.of(SCENE, DX)
    depth = share * lattice.critical_gap / 100
    contacts = of_heights(lattice, [depth], [(0, 0)], depth)
    assert judge(contacts, totals(contacts)).failures == failures


def test_a_second_contact_is_not_ignored():
    two = Profile(
        lambda x: 50 * (x**2 - 0.01**2) ** 2 / 0.01**2,
        lambda x: 200 * x * (x**2 - 0.01**2) / 0.01**2,
    )
    small = adhesive(two, gamma1=0.001, w=1e-6)
    assert len(minimise(small, 1e-3, method="lattice", spacing=1e-4).contacts) == 2


def test_the_profile_ends_are_not_guessed():
    x = np.linspace(-0.01, 0.01, 201)
    with pytest.raises(ValueError, match="not known any more"):
        minimise(adhesive(Sampled(x, x**2)), 0.01, method="lattice", spacing=1e-4)
    ended = adhesive(Sampled(x, x**2) + FlatPunch(0.009))
    assert minimise(ended, 0.01, method="lattice", spacing=1e-4).half_width == 0.009


def test_a_profile_without_a_lowest_point_is_refused():
    ramp = Profile(lambda x: 0.1 * x, lambda x: 0.1 + 0 * x)
    with pytest.raises(ValueError, match="no lowest point"):
        minimise(adhesive(ramp), 0.0, method="lattice", spacing=0.1)


def test_a_height_that_is_not_a_number_is_refused():
    bad = Profile(lambda x: np.where(np.abs(x) < 0.003, x**2, np.nan), lambda x: 2 * x)
    with pytest.raises(ValueError, match="is not finite"):
        minimise(adhesive(bad), 1e-3, method="lattice", spacing=1e-4)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"depth": math.nan}, "depth = nan"),
        ({"depth": "1 mm"}, "depth = '1 mm'"),
        ({"method": "magic"}, "'auto', 'lattice'"),
        ({"branch": "lucky"}, "'adhered', 'global'"),
        ({"scene": replace(ROUGH, slopes="finite"), "branch": "global"}, "slopes='small'"),
        ({"method": "oracle", "spacing": DX}, "branch = 'adhered'"),
        ({"method": "shortest_path", "branch": "global"}, "spacing = None"),
        ({"method": "lattice"}, "spacing = None"),
        ({"method": "lattice", "spacing": 0.0}, "spacing = 0.0"),
        ({"spacing": 1e-4}, "method='lattice'"),
        ({"rtol": 0.0}, "rtol = 0.0"),
        ({"rtol": 2.0}, "rtol = 2.0"),
        ({"scene": "a scene"}, "scene = 'a scene'"),
    ],
)
def test_bad_arguments_are_refused_before_any_computing(arguments, says):
    arguments = {"scene": SCENE, "depth": DEPTH} | arguments
    with pytest.raises(ValueError) as error:  # noqa: PT011 (the message is what is tested)
        minimise(arguments.pop("scene"), arguments.pop("depth"), **arguments)
    assert says in str(error.value)


def test_the_state_carries_a_validity_warning_and_is_not_refused():
    steep = Scene(SCENE.layer, SurfaceEnergies.from_work(0.07, 0.06), Wedge(0.5))
    state = minimise(steep, 5e-3)
    assert state.certificate.ok
    assert any("2w/γ₁" in text for text in state.warnings)
    assert any(text.startswith("slope") for text in state.warnings)
    assert "VIOLATED" in str(state)


def test_a_layer_lifted_far_is_warned_of_at_any_depth():
    layer, surfaces = ElasticLayer(3e3, 0.45, 20e-6), SurfaceEnergies.from_work(0.07, 3e-3)
    thin = Scene(layer, surfaces, Parabola(1))
    at_rest = {assumption.name: assumption for assumption in minimise(thin, 0.0).validity}
    lifted = thin.indenter.height(minimise(thin, 0.0).half_width) / 20e-6
    assert at_rest["d/h"].holds
    assert at_rest["u/h"].value == pytest.approx(float(lifted), rel=1e-12, abs=0)
    assert not at_rest["u/h"].holds


DX_STABILITY = 0.013


def exact(lattice, height, depth, first, last):
    """Energy and force of the contact set first..last, tails by the characteristic root."""
    dx, k, gamma1, w, d = map(
        mp.mpf, (lattice.spacing, lattice.k, lattice.gamma1, lattice.w, depth)
    )
    kappa = k * dx**2 / gamma1
    lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
    g = [d - height(dx * i) for i in range(first, last + 1)]
    ends = (g[0], g[-1])
    energy = sum(k * dx * u**2 / 2 for u in g) - w * dx * (last - first)
    energy += sum(gamma1 / dx * (q - p) ** 2 / 2 for p, q in itertools.pairwise(g))
    energy += sum(gamma1 / dx * (1 - lam) * u**2 / 2 for u in ends)
    force = k * dx * sum(g) + k * dx * lam / (1 - lam) * sum(ends)
    return energy, force


@pytest.mark.parametrize("decade", range(-3, 9))
@pytest.mark.parametrize("indenter", [Parabola(2000 * DX_STABILITY), Wedge(0.05)])
def test_twelve_digits_for_any_ratio_of_length_to_spacing(decade, indenter):
    """And no admissible contact set with one link more or less on both sides is lower."""

    def height(x):
        if isinstance(indenter, Parabola):
            return x**2 / (2 * mp.mpf(indenter.R))
        return abs(x) * mp.mpf(math.tan(indenter.delta))

    with mp.workdps(50):
        k, ell, a = 37.0, 10.0**decade * DX_STABILITY, 150 * DX_STABILITY
        scene = adhesive(indenter, k=k, gamma1=k * ell**2, w=k * (0.3 * min(ell, a)) ** 2 / 2)
        f, rise = float(indenter.height(a)), float(indenter.slope(a))
        d, lattice = f - scene.critical_separation + ell * rise, Lattice.of(scene, DX_STABILITY)
        first, last = contact = pressed(lattice, scene, d)
        sums = totals(over(lattice, indenter, d, contact))
        energy, force = exact(lattice, height, d, first, last)
        assert first == -last < -50 and on_lattice(scene, d, DX_STABILITY).certificate.ok
        assert abs(sums.energy - energy) <= 1e-12 * sums.energy_scale
        assert abs(sums.force - force) <= 1e-12 * sums.force_scale
        slack = max(1, lattice.link / lattice.spring / 1e3)
        assert abs(sums.force_by_reactions - force) <= 1e-12 * sums.force_scale * slack
        assert energy <= exact(lattice, height, d, first - 1, last + 1)[0]
        kappa = mp.mpf(lattice.k) * mp.mpf(DX_STABILITY) ** 2 / lattice.gamma1
        lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
        before, own = (d - height(mp.mpf(DX_STABILITY) * i) for i in (last - 1, last))
        if lam * before >= own:  # without its last link the surface stays clear
            assert energy <= exact(lattice, height, d, first + 1, last - 1)[0]


def test_exact_tail_equals_a_long_chain_of_nodes():
    scene = adhesive(Parabola(0.02))
    lattice = Lattice.of(scene, scene.elastocapillary_length / 20)
    far = np.zeros(2001, bool)
    far[0] = True
    u = NodalEnergy(lattice, far).relaxed(np.full(2001, 0.7))
    expected = 0.7 * np.exp(-lattice.log_decay * np.arange(2001))
    assert np.abs(u - expected).max() <= 1e-12
    chain = NodalEnergy(lattice, far)
    short = NodalEnergy(lattice, far[:1])
    assert chain.value(u) == pytest.approx(short.value([0.7]), rel=1e-13, abs=0)
