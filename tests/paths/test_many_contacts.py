"""Several contacts on the lattice: every state an equilibrium, every change an event."""

import numpy as np
import pytest
from scenes import adhesive
from truth.scenes import case_of

from discretization import History, NodalEnergy, load_path, minimise
from discretization.paths.branch import moved
from discretization.paths.lattice_branch import LatticeBranch
from energy import Parabola, Sampled

SPACING = 4e-5


def force_of(branch, point):
    """P of the contact set."""
    nodes = np.reshape(point.memory, (1, -1))
    return branch.row.totals(nodes, np.array([point.depth]))[1, 0]


def bumps(heights, wavelength=0.008, amplitude=1e-3, bowl=2.0):
    """A wavy bowl whose crests reach down to different levels, steep at both ends."""
    reach = wavelength * (len(heights) + 2) / 2
    x = np.linspace(-reach, reach, 2001)
    level = np.interp(x, wavelength * (np.arange(len(heights)) - (len(heights) - 1) / 2), heights)
    phase = 2 * np.pi * (x / wavelength + (len(heights) - 1) / 2)
    z = level + amplitude * (1 - np.cos(phase)) + bowl * x**2
    beyond = np.maximum(np.abs(x) - wavelength * len(heights) / 2, 0)
    return Sampled(x, z - z.min() + 300 * beyond**2)


def programme(scene, top=8.0, steps=25):
    delta0 = scene.critical_separation
    return np.r_[np.linspace(-0.2, top, steps), np.linspace(top, -3, 2 * steps)] * delta0


SCENES = {
    "two": adhesive(bumps([0.0, 0.0]), w=2e-4),
    "three": adhesive(bumps([0.0, 3e-4, 1e-4]), w=2e-4),
    "soft": adhesive(bumps([0.0, 2e-4, 1e-4, 0.0]), k=1300.0, w=2e-4),
    "merging": adhesive(bumps([0.0, 5e-5, 0.0], amplitude=1e-4), k=5000.0, w=2e-5),
}
KINDS = {
    "two": {"jump-in", "detachment"},
    "three": {"jump-in", "nucleation", "detachment"},
    "soft": {"jump-in", "nucleation", "closing", "detachment"},
    "merging": {"jump-in", "nucleation", "coalescence", "jump", "detachment"},
}


@pytest.fixture(scope="module", params=SCENES)
def path(request):
    scene = SCENES[request.param]
    return load_path(scene, depths=programme(scene), method="lattice", spacing=SPACING)


def test_contacts_begin_meet_and_end(path):
    (name,) = [name for name, scene in SCENES.items() if scene is path.scene]
    assert KINDS[name] <= {event.kind for event in path.events}
    assert max(len(inner) for inner in path.inner) >= 2
    assert min(event.energy_released for event in path.events) >= -1e-15 * abs(path.energy).max()
    for event in path.events:
        change = len(event.after.inner) - len(event.before.inner)
        if event.kind in ("nucleation", "splitting"):
            assert change > 0
        if event.kind in ("coalescence", "closing"):
            assert change < 0


def test_a_contact_beyond_the_known_profile_is_refused():
    with pytest.raises(ValueError, match="over the whole known profile"):
        load_path(SCENES["two"], depths=[1.0], method="lattice", spacing=SPACING)


def test_the_half_width_leaves_the_gaps_out(path):
    step = int(np.argmax([len(inner) for inner in path.inner]))
    lines = np.array(path.at(step).lines).reshape(-1, 2)
    assert path.half_width[step] == pytest.approx(np.diff(lines).sum() / 2, rel=1e-14, abs=0)


def test_the_energy_balance_is_exact(path):
    assert np.isnan(path.contacts[-1]).all()
    assert path.work() == pytest.approx(path.dissipated, rel=1e-11, abs=0)


def relaxed(branch, nodes, depth):
    held = np.zeros(branch.row.f.size, bool)
    for first, last in nodes:
        held[first : last + 1] = True
    model = NodalEnergy(branch.row.lattice, held)
    u = model.relaxed(depth - branch.row.f)
    return model, u, held


def test_every_state_is_an_equilibrium_of_the_nodal_energy(path):
    branch = LatticeBranch.of(path.scene, SPACING, path.depth.max())
    for step in range(0, len(path.depth), 3):
        point = branch.contact(path.at(step).depth, *path.at(step).lines)
        depth, contacts, nodes = point
        if contacts is None:
            continue
        model, u, held = relaxed(branch, nodes, depth)
        energy, size = model.value(u), sum(map(abs, model.terms(u).values()))
        assert abs(energy - branch.energy(point)) <= 1e-13 * size
        force = model.gradient(u)[held].sum()
        own = force_of(branch, point)
        assert abs(force - own) <= 1e-10 * size / SPACING
        assert (u - (depth - branch.row.f)).min() >= -1e-12 * abs(depth)
        for i, (first, last) in enumerate(nodes):
            for shifted in (
                (first - 1, last),
                (first + 1, last),
                (first, last - 1),
                (first, last + 1),
            ):
                if shifted[0] > shifted[1]:
                    continue
                others = [*nodes[:i], shifted, *nodes[i + 1 :]]
                near, other, _ = relaxed(branch, others, depth)
                if (other - (depth - branch.row.f)).min() >= -1e-12:  # else no admissible state
                    assert near.value(other) >= energy - 1e-9 * size


def test_contacts_many_decay_lengths_apart_are_single_ones():
    """Two parabolas 60 l apart: forces and energies add up."""
    length = adhesive(Parabola(0.02), k=13000.0, w=2e-4).elastocapillary_length
    far, h = 30 * length, 1e-5
    x = np.arange(-round((far + 0.02) / h), round((far + 0.02) / h) + 1) * h
    far = round(far / h) * h
    pair = np.minimum((x - far) ** 2, (x + far) ** 2) / 0.04
    single = np.arange(-2000, 2001) * h
    given = {"k": 13000.0, "w": 2e-4}
    two = adhesive(Sampled(x, pair), **given)
    one = adhesive(Sampled(single, single**2 / 0.04), **given)
    depths = np.array([0.0, 1.5, 0.7, -0.5]) * one.critical_separation
    branches = [LatticeBranch.of(scene, h, depths.max()) for scene in (one, two)]
    points = [branch.first for branch in branches]
    for depth in depths.tolist():
        pairs = list(zip(branches, points, strict=True))
        points = [moved(branch, point, depth) for branch, point in pairs]
        pairs = list(zip(branches, points, strict=True))
        forces = [force_of(branch, point) for branch, point in pairs]
        assert forces[1] == pytest.approx(2 * forces[0], rel=1e-12, abs=0)
        energies = [branch.energy(point) for branch, point in pairs]
        assert energies[1] == pytest.approx(2 * energies[0], rel=1e-10, abs=0)
    assert len(points[1].memory) == 2
    # between the nodes, too: where depths of passing are as good as heights are
    paths = [load_path(scene, depths=depths, method="lattice", spacing=h) for scene in (one, two)]
    assert paths[1].force == pytest.approx(2 * paths[0].force, rel=1e-9, abs=0)
    assert paths[1].energy == pytest.approx(2 * paths[0].energy, rel=1e-9, abs=0)


def test_the_mirror_image_walks_the_mirror_image(path):
    scene = path.scene
    body = scene.indenter
    mirrored = adhesive(
        Sampled(-body.x[::-1], body.z[::-1]), k=scene.stiffness, w=scene.work_of_adhesion
    )
    other = load_path(mirrored, depths=path.values, method="lattice", spacing=SPACING)
    assert other.dissipated == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    assert [e.kind for e in other.events] == [e.kind for e in path.events]
    assert other.contacts[:, ::-1] == pytest.approx(-path.contacts, abs=1e-13, nan_ok=True)


def test_a_path_of_many_contacts_is_saved_and_continued(path, tmp_path):
    cut = int(np.argmax([len(inner) for inner in path.inner])) + 1
    given = {"method": "lattice", "spacing": SPACING}
    first = load_path(path.scene, depths=path.values[:cut], **given)
    first.to_csv(tmp_path / "path.csv")
    read = History.from_csv(tmp_path / "path.csv")
    again = load_path(path.scene, depths=path.values[cut:], after=read, **given)
    assert again.inner == path.inner
    assert again.force.tobytes() == path.force.tobytes()
    assert again.half_width.tobytes() == path.half_width.tobytes()
    assert len(again.events) == len(path.events)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [19, 241, 530, 1861, 1953])
def test_contacts_on_ripples_a_few_nodes_long_come_to_rest(seed):
    """Where a line that has passed a link would penetrate another node, they once did not."""
    case = case_of("small", seed)
    scene, rng = case.scene, np.random.default_rng(seed)
    height = scene.indenter.height(np.linspace(*scene.indenter.extent, 4001)).min()
    for _ in range(8):
        top = height + scene.critical_separation * rng.uniform(0.5, 3)
        least = height - 1.3 * scene.critical_separation
        depths = np.r_[np.linspace(height, top, 20), np.linspace(top, least, 40)]
        spacing = case.feature / rng.uniform(6, 10)
        path = load_path(scene, depths=depths, method="lattice", spacing=spacing)
        size = max(abs(path.dissipated), float(np.ptp(path.energy)))
        assert abs(path.work() - path.dissipated) <= 1e-10 * size or path.half_width[-1] > 0


def test_pressed_contacts_do_not_depend_on_the_steps():
    """To a depth at once or in small steps: the same contacts."""
    for seed in range(12):
        case = case_of("small", seed)
        f = case.scene.indenter.height(np.linspace(*case.scene.indenter.extent, 4001))
        top = float(f.min()) + case.scene.critical_separation
        branch = LatticeBranch.of(case.scene, case.feature / 8, top)
        if branch.row.f.size > 20000:
            continue
        point = branch.first
        for depth in np.linspace(branch.touch, top, 40):
            point = moved(branch, point, float(depth))
        assert moved(branch, branch.first, top) == point


@pytest.mark.parametrize("name", SCENES)
def test_a_state_has_the_lines_force_and_energy_of_its_path(name):
    scene = SCENES[name]
    for share in (2.5, 0.4):
        depth = share * scene.critical_separation
        state = minimise(scene, depth, method="lattice", spacing=SPACING)
        end = load_path(scene, depths=[0.0, depth], method="lattice", spacing=SPACING)
        assert state.contacts[[0, -1], [0, 1]] == pytest.approx(end.contacts[-1], rel=1e-12, abs=0)
        for quantity, scale in state.scales.items():
            off = getattr(state, quantity) - getattr(end, quantity)[-1]
            assert abs(off) <= 1e-11 * scale, quantity
