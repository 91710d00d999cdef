"""How does a rough indenter touch: spots or all over, and what does surface tension change?

A cylinder of radius R with self-affine roughness (seeded random phases, spectrum of the amplitudes
~ q^-(H + 1/2) between the longest and the shortest wavelength, rms height stated) is pressed into
the layer and pulled off, for several elastocapillary lengths l = √(γ₁/k) at the same k and w. Each
loop is followed on the lattice with all its contacts (`load_path`), and at a few depths the state
of lowest energy of all is found (`branch="global"`). Reported: number of contacts, contact fraction
(contact length over the width between the outermost lines), force, loop area; energy and contact
length of the global state against the metastable one. Expected: tension smooths the surface at
wavelengths below l, so that a contact that follows the roughness for l below the shortest
wavelength breaks up into spots for l above.

The film is outside the model's limits, and any would be: its spots are narrower than the shortest
wavelength, so that h ≪ a would take h ≪ 20 µm, and d ≪ h heights far below a micrometre. What is
compared depends on l over the wavelengths and on δ₀ and d over the heights only.

Nodes stand at the samples, whose straight pieces meet at corners. Such nodes lose some contacts a
little early, which they warn of: next to nodes 8 times closer the energy lost is up to 10 % too
small at l = 4 times the shortest wavelength, 3 % at l = 1; contacts and forces are the same to a
thousandth. The warnings are left out of the table.

Output: a line per l, rough.csv, rough.png, touching.png.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - A `Table` is the names of its columns, and its rows.
# - `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `prefixed(values, unit)` is the unit with a prefix that suits the values: they are divided by
#   its `size`, and its `symbol` is written.
# - `quantity(value, unit)` is a text such as 20 mN/m.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`; `pull_off`, its most tensile state; `dissipated`, the energy
#   that it loses; `work()`, the ∮ P dd.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer; with branch="global" it is the lowest of all; with
#   method="lattice" it is that on nodes of a spacing.
# - A scene has `stiffness` k = Ẽ/h and `gamma1` γ₁.
# - `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
# - `Sampled(x, z)` is a measured profile of heights z at x.
# - `state.displacement(x)` is u, positive into the layer.
# - `AccuracyWarning` says that the estimated error of a state exceeds its rtol.
# - `path.contacts` (n, 2) are the outermost lines at each step, NaN when detached, `path.inner`
#   those between.
# - The method "shortest_path" finds the lowest state of all on nodes.

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from discretization import AccuracyWarning, Equilibrium, History, load_path, minimise
from energy import ElasticLayer, Sampled, Scene, SurfaceEnergies
from energy.arrays import Array, Indices
from energy.units import prefixed, quantity
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, MARKERS, RIGID, SOFT, Figure, canvas, shades
from studies.shared.table import Columns, Table


@dataclass(frozen=True)
class Parameters:
    """Layer, adhesion, cylinder, roughness and depths; in SI units where nothing is said.

    Attributes
    ----------
    E, nu, h : float
        Young's modulus, Poisson's ratio and thickness of the layer.
    w : float
        Work of adhesion.
    R : float
        Radius of the cylinder.
    length : float
        Of the profile, twice the longest wavelength.
    nodes : int
        Samples of the profile, and nodes on it.
    hurst : float
        H of the spectrum.
    shortest : float
        Wavelength.
    rms : float
        Height of the roughness.
    seed : int
        Of its phases.
    tensions : tuple of float
        l over the shortest wavelength, one a loop.
    top, bottom : float
        The deepest and the last depth over the rms height.
    steps : int
        On the way in; three times as many on the way out.
    compared : int
        Steps at which the state of lowest energy of all is found.
    """

    E: float = 300.0
    nu: float = 0.45
    h: float = 50e-6
    w: float = 1e-6
    R: float = 20e-3
    length: float = 2e-3
    nodes: int = 2001
    hurst: float = 0.8
    shortest: float = 20e-6
    rms: float = 1e-6
    seed: int = 1
    tensions: tuple[float, ...] = (0.25, 1.0, 4.0)
    top: float = 4.0
    bottom: float = -2.0
    steps: int = 40
    compared: int = 5

    @property
    def spacing(self) -> float:
        """Distance of the samples and of the lattice's nodes."""
        return self.length / (self.nodes - 1)

    @property
    def indenter(self) -> Sampled:
        """The rough cylinder, its lowest point at the height 0.

        Waves of all lengths that fit into the profile twice or more, down to the shortest, have
        amplitudes q^-(H + ½), which is a self-affine spectrum in one dimension, and random phases.
        """
        x = self.spacing * (np.arange(self.nodes) - self.nodes // 2)
        rng = np.random.default_rng(self.seed)
        z = np.zeros_like(x)
        most_waves = int(self.length / self.shortest)
        for waves in range(2, most_waves + 1):
            q = 2 * np.pi * waves / self.length
            amplitude = q ** -(self.hurst + 0.5)
            phase = rng.uniform(0, 2 * np.pi)
            z += amplitude * np.cos(q * x + phase)
        cylinder = x**2 / (2 * self.R)
        z = z * self.rms / z.std() + cylinder
        return Sampled(np.asarray(x, float), np.asarray(z - z.min(), float))

    def scene(self, tension: float) -> Scene:
        """The scene with l = tension times the shortest wavelength."""
        layer = ElasticLayer(self.E, self.nu, self.h)
        gamma1 = layer.stiffness * (tension * self.shortest) ** 2
        return Scene(layer, SurfaceEnergies.from_work(gamma1, self.w), self.indenter)

    @property
    def programme(self) -> Array:
        """Depths: in to the top, out until the contact is lost."""
        pressed = np.linspace(0, self.top, self.steps)
        pulled = np.linspace(self.top, self.bottom, 3 * self.steps)
        return np.concatenate([pressed, pulled]) * self.rms


@dataclass(frozen=True, eq=False)
class Loop:
    """One tension.

    Attributes
    ----------
    tension : float
        l over the shortest wavelength.
    path : History
    lowest : dict
        The states of lowest energy of all, by their step on the path.
    """

    tension: float
    path: History
    lowest: dict[int, Equilibrium]

    @property
    def contacts(self) -> Indices:
        """Number of contacts at every step."""
        in_contact = ~np.isnan(self.path.contacts[:, 0])  # NaN: no outermost line, detached
        # two inner lines, the ends of a gap, for each contact but the first
        return np.where(in_contact, [len(inner) // 2 + 1 for inner in self.path.inner], 0)

    @property
    def fraction(self) -> Array:
        """Contact length over the width between the outermost lines; 0 when detached."""
        width = self.path.contacts[:, 1] - self.path.contacts[:, 0]
        touches = width > 0  # not where it is NaN; `half_width` is half the contact length
        not_zero = np.where(touches, width, 1)
        return np.where(touches, 2 * self.path.half_width / not_zero, 0.0)


def run(params: Parameters, show: Show = silent, jobs: int = 1) -> list[Loop]:
    """A loop per tension, in `jobs` processes; `show` is told a line when it is done.

    Parameters
    ----------
    params : Parameters
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    list of Loop
    """
    show(COLUMNS.head)
    work = partial(followed, params)
    return list(each(work, params.tensions, jobs, say=lambda loop: show(line(loop))))


def followed(params: Parameters, tension: float) -> Loop:
    """One loop and the lowest states of all beside it.

    Parameters
    ----------
    params : Parameters
    tension : float
        l over the shortest wavelength.

    Returns
    -------
    Loop
    """
    scene = params.scene(tension)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # how much that is stands in the docstring
        path = load_path(scene, depths=params.programme, method="lattice", spacing=params.spacing)
    last = params.programme.size - 1
    steps = np.linspace(0, last, params.compared + 1).astype(int)[1:]
    options: dict[str, Any] = {"method": "shortest_path", "branch": "global"}
    lowest = {}
    for step in steps.tolist():
        depth = float(path.depth[step])
        lowest[step] = minimise(scene, depth, spacing=params.spacing, **options)
    return Loop(tension, path, lowest)


COLUMNS = Columns(
    "l/shortest 10.3g|contacts 9|fraction 9.3f|pull-off N/m 13.6g|loop area J/m 14.6g|balance 8.0e|"
    "global below metastable 23"
)


def line(loop: Loop) -> str:
    """Most contacts, fraction and pull at the deepest, loop area, and the lowest energies."""
    path = loop.path
    deepest = int(np.argmax(path.depth))
    balance = abs(path.work() / path.dissipated - 1)
    below = sum(state.energy < path.energy[step] for step, state in loop.lowest.items())
    return COLUMNS.line(
        loop.tension,
        loop.contacts.max(),
        loop.fraction[deepest],
        path.pull_off.force,
        path.dissipated,
        balance,
        f"{below} of {len(loop.lowest)}",
    )


def plot_touching(params: Parameters, loops: Sequence[Loop]) -> Figure:
    """The touching surface at the least and the largest tension."""
    figure, (above, below) = canvas(8.5, 7, 2, 1)
    _touching(above, params, loops[0])
    _touching(below, params, loops[-1])
    deepest = params.steps - 1
    few = int(loops[0].contacts[deepest])
    many = int(loops[-1].contacts[deepest])
    figure.suptitle(
        f"A rough cylinder at its deepest: {few} contact{'s' * (few > 1)} at the least tension, "
        f"{many} at the largest"
    )
    return figure


def plot(params: Parameters, loops: Sequence[Loop]) -> Figure:
    """Force, number of contacts and fraction over the depth, a colour for each tension."""
    figure, panels = canvas(13, 4.6, 1, 3)
    depth = prefixed(params.programme, "m")
    force = prefixed(np.concatenate([loop.path.force for loop in loops]), "N/m")
    colours = shades(len(loops), top=0.7)
    for colour, marker, loop in zip(colours, MARKERS, loops, strict=False):
        x = loop.path.depth / depth.size
        held = loop.contacts > 0
        curves = (loop.path.force / force.size, loop.contacts, loop.fraction)
        label = f"l = {loop.tension:g} × shortest wavelength"
        style: dict[str, Any] = {"color": colour, "marker": marker, "ms": 3}
        pressed: dict[str, Any] = {"lw": 0.8, "ls": "--", "mfc": "none", **style}
        for panel, values in zip(panels, curves, strict=True):
            y = np.where(held, values, np.nan)
            panel.plot(x[: params.steps], y[: params.steps], **pressed)
            panel.plot(x[params.steps :], y[params.steps :], lw=1.4, label=label, **style)
        at = x[list(loop.lowest)]
        ring: dict[str, Any] = {"color": colour, "mfc": "none", "ms": 9}
        pulls = [state.force / force.size for state in loop.lowest.values()]
        panels[0].plot(at, pulls, "o", **ring)
        counts = [len(state.contacts) for state in loop.lowest.values()]
        panels[1].plot(at, counts, "o", **ring)
    names = (f"force P in {force.symbol}", "number of contacts", "contact fraction")
    for panel, name in zip(panels, names, strict=True):
        panel.set(xlabel=f"depth d in {depth.symbol}", ylabel=name)
        panel.grid(alpha=0.3)
    panels[0].legend(fontsize=9)
    figure.suptitle(
        "Tension breaks the contact of a rough cylinder up into spots "
        "(pressed: dashed; pulled: solid; lowest energy of all: rings)"
    )
    return figure


def _touching(axes: Any, params: Parameters, loop: Loop) -> None:
    """Indenter and surface near the middle, in the deepest of the states of lowest energy."""
    state = max(loop.lowest.values(), key=lambda one: one.depth)
    x = np.linspace(-10, 10, 4001) * params.shortest
    u = state.displacement(x)
    body = state.depth - state.scene.indenter.height(x)
    margin = np.ptp(body) / 4
    top = float(body.min() - margin)
    bottom = float(u.max() + margin)
    across = prefixed(x, "m")
    up = prefixed([top, bottom], "m")
    s = x / across.size
    axes.fill_between(s, body / up.size, top / up.size, color=RIGID, lw=0, label="indenter")
    axes.fill_between(s, u / up.size, bottom / up.size, color=SOFT, lw=0, label="layer")
    axes.plot(s, u / up.size, color=BLUE, lw=1.2, label="surface u(x)")
    axes.set(xlim=(s[0], s[-1]), ylim=(bottom / up.size, top / up.size))
    axes.set(xlabel=f"position x in {across.symbol}", ylabel=f"displacement in {up.symbol}")
    depth = quantity(state.depth, "m")
    axes.set_title(f"l = {loop.tension:g} × shortest wavelength, d = {depth} (not to scale)")
    axes.legend(loc="lower left", fontsize=9, ncols=3)


def table(loops: Sequence[Loop]) -> Table:
    """Columns and a row per step, SI."""
    rows = []
    for loop in loops:
        for step, depth in enumerate(loop.path.depth.tolist()):
            row = [
                loop.tension,
                depth,
                loop.path.force[step],
                loop.path.energy[step],
                loop.contacts[step],
                loop.fraction[step],
                loop.lowest[step].energy if step in loop.lowest else "",
            ]
            rows.append(row)
    return ["l/shortest", "depth", "force", "energy", "contacts", "fraction", "global"], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study; 1 if a global state has more energy than the metastable one."""
    full = Parameters()
    quick = Parameters(nodes=1001, steps=15, compared=3)
    params, jobs, out = command.start("rough", __doc__, argv, "a shorter profile", full, quick)
    loops = run(params, command.say, jobs)
    out.table("rough.csv", params, *table(loops))
    out.figures({"rough.png": plot(params, loops), "touching.png": plot_touching(params, loops)})
    command.answer(answer(params, loops))
    return int(not all(lowest_is_lowest(loop) for loop in loops))


def answer(params: Parameters, loops: Sequence[Loop]) -> str:
    """Contacts at the deepest, for the least and the largest tension."""
    deepest = params.steps - 1
    said = []
    for loop in (loops[0], loops[-1]):
        count = loop.contacts[deepest]
        said.append(
            f"{count} contact{'s' if count > 1 else ''} over {loop.fraction[deepest]:.0%} of the "
            f"width for l = {loop.tension:g} × the shortest wavelength"
        )
    return f"At the largest depth, in {', in '.join(said)}."


def lowest_is_lowest(loop: Loop) -> bool:
    """Whether no metastable state lies below the global one."""
    rounding = 1e-9 * np.abs(loop.path.energy).max()
    states = loop.lowest.items()
    return all(state.energy <= loop.path.energy[step] + rounding for step, state in states)
