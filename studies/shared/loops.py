"""What the studies of load paths share: three indenters, closed loops, and their closed forms.

The indenters have the same contact without tension: b = a for the flat punch, δ₀/tan δ for the
wedge, √(Rδ₀) for the parabola, at the work of adhesion WORK. With small slopes a loop then depends
on l/b and on the control only, in units of kδ₀b for forces and 2wb for energies.

These are numbers of the model: over decades of l/b, and up to the last contact, d ≪ h ≪ a and
h <= l cannot all hold for one film. With the same l/b they are those of a film for which they do.

Conventions:

- `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the states
  at these values one after the other: a `History` with arrays `depth`, `force` (positive where it
  presses), `half_width`; `events`, the jumps and other events in their order, each with a kind, the
  states `before` and `after` it and the `energy_released`; `pull_off`, its most tensile state;
  `dissipated`, the energy that it loses.
- A scene has `stiffness` k = Ẽ/h, `work_of_adhesion` w, `elastocapillary_length` l = √(γ₁/k) and
  `critical_separation` δ₀ = √(2w/k).
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `FlatPunch(half_width)` has f = 0 up to its edges.
- `path.contacts` (n, 2) are the outermost lines at each step, NaN when detached.
- The cards of loops are `cards.displacement_control`, `load_control` and `machine_control`: each
  has, for each kind of indenter, a `jump_in`, a `detachment` and a `loop_area`. The first two are a
  `Jump`: force, depth and half_width of the contact just after the jump-in or just before the
  detachment, and the energy_released.
- `cards.PullOff` is the state of the most tensile force: force <= 0, depth and half_width.
- The parameters of indenters are R of a parabola, the angle delta between flank and surface of a
  wedge [rad], and half_width of a flat punch.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from discretization import History, load_path
from energy import ElasticLayer, FlatPunch, Indenter, Parabola, Scene, SurfaceEnergies, Wedge, cards

LAYER = ElasticLayer(E=300.0, nu=0.4, h=10e-6)  # Pa, 1, m: a very soft gel
WORK = 1e-4  # J/m²
SIZE = 50e-6  # b [m]; as all results are ratios of l to b, any size would do
LIFT = float(cards.plane.critical_separation(LAYER.stiffness, WORK))
# The three with the half-width SIZE without tension: b of the module docstring.
INDENTERS: dict[str, Indenter] = {
    "flat punch": FlatPunch(SIZE),
    "wedge": Wedge(math.atan(LIFT / SIZE)),
    "parabola": Parabola(SIZE**2 / LIFT),
}
_DEEPEST = 2.0  # δ₀, the largest depth of a loop: the branch is the same whatever it is
_BEYOND = 0.4  # of a loop's scale, how far it goes on where nothing holds any more
_APART = 1e-6  # of a loop's scale, between the least value of the control and the one before it
_ZERO = 1e-12  # of the scale: a closed form, or an energy, that is 0 but for rounding

_CONTROLS = {
    "depth": cards.displacement_control,
    "force": cards.load_control,
    "drive": cards.machine_control,
}


class Known(NamedTuple):
    """What is known in closed form of one kind of indenter.

    Attributes
    ----------
    name : str
        In the names of the cards of loops.
    argument : str
        Name of its parameter in the cards.
    value : callable
        That parameter of an indenter.
    size : callable
        The length b of this parameter and δ₀.
    pull_off : callable
        The card of the most tensile state.
    """

    name: str
    argument: str
    value: Callable[[Any], float]
    size: Callable[[float, float], float]
    pull_off: Callable[..., Any]

    def loop(self, control: str, given: dict[str, float], K: float | None) -> list[Any]:
        """Jump-in, end of the contact and loop area under one control.

        Parameters
        ----------
        control : {"depth", "force", "drive"}
        given : dict
            As `arguments` gives it.
        K : float or None
            Stiffness of the machine [N/m²], for "drive".

        Returns
        -------
        list
            Two `cards.Jump` and a number [N].
        """
        machine = {"K": K} if control == "drive" else {}
        at_jump_in = {} if self.name == "flat_punch" else machine  # a flat face is not pulled in
        own = _CONTROLS[control]
        jump_in = getattr(own, f"{self.name}_jump_in")(**given, **at_jump_in)
        detachment = getattr(own, f"{self.name}_detachment")(**given, **machine)
        area = getattr(own, f"{self.name}_loop_area")(**given, **machine)
        return [jump_in, detachment, area]


_KNOWN: dict[type, Known] = {
    FlatPunch: Known(
        name="flat_punch",
        argument="a",
        value=lambda body: body.half_width,
        size=lambda a, lift: a,
        pull_off=cards.displacement_control.flat_punch_detachment,
    ),
    Wedge: Known(
        name="wedge",
        argument="delta",
        value=lambda body: body.delta,
        size=lambda delta, lift: lift / math.tan(delta),
        pull_off=cards.wedge.pull_off,
    ),
    Parabola: Known(
        name="parabola",
        argument="R",
        value=lambda body: body.R,
        size=lambda R, lift: math.sqrt(R * lift),
        pull_off=cards.parabola.pull_off,
    ),
}


def known(scene: Scene) -> Known:
    """The closed forms of a scene's indenter.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Known

    Raises
    ------
    ValueError
        For an indenter without closed forms.
    """
    if type(scene.indenter) not in _KNOWN:
        remedy = "must be a FlatPunch, Wedge or Parabola; others have no closed forms"
        raise ValueError(f"indenter = {scene.indenter!r} {remedy}")
    return _KNOWN[type(scene.indenter)]


def arguments(scene: Scene) -> dict[str, float]:
    """The indenter's parameter, k, γ₁ and w by the names that the cards give them.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict
    """
    card = known(scene)
    return {
        card.argument: card.value(scene.indenter),
        "k": scene.stiffness,
        "gamma1": scene.gamma1,
        "w": scene.work_of_adhesion,
    }


def scene_of(shape: str, gamma1: float, w: float = WORK) -> Scene:
    """The scene of one of the INDENTERS.

    Parameters
    ----------
    shape : str
    gamma1, w : float
        Surface tension and work of adhesion [J/m²].

    Returns
    -------
    Scene
    """
    return Scene(LAYER, SurfaceEnergies.from_work(gamma1, w), INDENTERS[shape])


def size(scene: Scene) -> float:
    """b [m], the half-width of the contact without tension at which it bears the largest pull."""
    card = known(scene)
    return card.size(card.value(scene.indenter), scene.critical_separation)


def force_scale(scene: Scene) -> float:
    """k δ₀ (b + l) [N/m]."""
    width = size(scene) + scene.elastocapillary_length
    return scene.stiffness * scene.critical_separation * width


def depth_loop(scene: Scene, steps: int) -> History:
    """Imposed depth from out of contact down to 2δ₀ and back, in steps that shrink towards -δ₀.

    Parameters
    ----------
    scene : Scene
    steps : int
        How many, a third of them downwards.

    Returns
    -------
    History
    """
    lift = scene.critical_separation  # δ₀; at -δ₀ the last contact is lost at the latest
    pressing = np.linspace(-0.3 * lift, _DEEPEST * lift, max(steps // 3, 2))
    part = np.linspace(1, 0, max(steps - pressing.size, 2))
    pulling = (_DEEPEST + 1) * lift * part**2 - lift  # from the deepest to -δ₀
    out_of_contact = -(1 + _BEYOND) * lift
    return load_path(scene, depths=[*pressing, *pulling[1:], out_of_contact])


def driven_loop(path: History, K: float) -> History:
    """The same states as on a loop of imposed depth, held by a machine or a dead load.

    Values of the control are D = d + P/K, or P, of the states of that loop, as far as they grow on
    loading and fall on unloading; then down to where nothing holds.

    Parameters
    ----------
    path : History
        As `depth_loop` gives it.
    K : float
        Stiffness of the machine [N/m²]; 0 for a dead load.

    Returns
    -------
    History
    """
    control = path.depth + path.force / K if K else path.force
    scale = force_scale(path.scene)
    if K:
        scale = path.scene.critical_separation + scale / K
    in_contact = ~np.isnan(path.contacts[:, 0])
    values = control[in_contact]
    turn = int(np.argmax(path.depth[in_contact]))
    loading = values[: turn + 1]
    unloading = np.unique(np.minimum.accumulate(values[turn:]))[::-1]
    least = min(float(unloading[-1]), 0.0)
    unloading = unloading[unloading > least + _APART * scale]
    programme = [*loading[loading > 0], *unloading[1:], least - _BEYOND * scale]
    if K:
        return load_path(path.scene, drives=programme, machine_stiffness=K)
    return load_path(path.scene, forces=programme)


class Form(NamedTuple):
    """One number of a loop beside its closed form.

    Attributes
    ----------
    name : str
    simulated, closed_form : float
    scale : float
        What a difference is measured by where the closed form is 0.
    """

    name: str
    simulated: float
    closed_form: float
    scale: float

    @property
    def error(self) -> float:
        """Relative error, of the scale where the closed form is 0 (within rounding)."""
        size = abs(self.closed_form)
        if size <= _ZERO * self.scale:
            size = self.scale
        return abs(self.simulated - self.closed_form) / size


def pull_off_card(scene: Scene) -> cards.PullOff:
    """The most tensile state of the adhered branch: behind Eqs. (23), (30) and the parabola's."""
    return cards.PullOff(*known(scene).pull_off(**arguments(scene))[:3])


def global_pull_off(scene: Scene) -> cards.PullOff:
    """Where the detached state of a flat punch gets the lower energy (Maxwell)."""
    return cards.displacement_control.flat_punch_global_pull_off(**arguments(scene))


def most_tensile(history: History) -> tuple[float, float, float]:
    """(P, d, a) of `History.pull_off`; zeros for a path that never pulls."""
    least = min([0.0, *history.force, *(event.force for event in history.events)])
    if least > -_ZERO * force_scale(history.scene):
        return 0.0, 0.0, 0.0
    found = history.pull_off
    return found.force, found.depth, found.half_width


def compared(history: History) -> list[Form]:
    """Jump-in, end of the contact, pull-off and loop area beside their closed forms.

    Parameters
    ----------
    history : History
        Of a loop that starts and ends detached.

    Returns
    -------
    list of Form
    """
    scene = history.scene
    given = arguments(history.scene)
    jump, end, area = known(scene).loop(history.control, given, history.machine_stiffness)
    first = history.events[0]
    last = history.events[-1]
    force = force_scale(scene)
    lift = scene.critical_separation
    width = size(scene)
    work = force * lift
    ended = last.energy_released if last.kind in ("detachment", "pull-off") else math.nan
    P, d, a = most_tensile(history)
    P_card, d_card, a_card = pull_off_card(scene)
    return [
        Form("jump-in force", first.after.force, float(jump.force), force),
        Form("jump-in half-width", first.after.half_width, float(jump.half_width), width),
        Form("jump-in energy", first.energy_released, float(jump.energy_released), work),
        Form("pull-off force", P, float(P_card), force),
        Form("pull-off depth", d, float(d_card), lift),
        Form("pull-off half-width", a, float(a_card), width),
        Form("end depth", last.depth, float(end.depth), lift),
        Form("end energy", ended, float(end.energy_released), work),
        Form("loop area", history.dissipated, float(area), work),
    ]


def imbalance(history: History, work: float) -> float:
    """Mismatch of the energy balance of a loop, relative.

    Parameters
    ----------
    history : History
    work : float
        ∫P dd from the forces [J/m].

    Returns
    -------
    float
        |work - energy released| over the latter, or over the scale where nothing is released.
    """
    scale = force_scale(history.scene) * history.scene.critical_separation
    size = abs(history.dissipated)
    if size <= _ZERO * scale:
        size = scale
    return abs(work - history.dissipated) / size
