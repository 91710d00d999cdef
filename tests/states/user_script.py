"""What a user writes, with types: it runs, and mypy --strict accepts it (`.ci/run`)."""

import numpy as np

from discretization import Equilibrium, Event, History, load_path, minimise
from energy import (
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

layer = ElasticLayer(E=2.5e3, nu=0.3, h=5e-6)
surfaces = SurfaceEnergies.from_work(0.07, 6e-5)
own = Profile(height=lambda x: np.square(x) / 0.04, slope=lambda x: np.asarray(x) / 0.02)
x = [-4e-4, -2e-4, 0.0, 2e-4, 4e-4]
bodies: list[Indenter] = [
    own,
    Parabola(0.02).shifted(1e-5),
    Wedge(0.01).tilted(1e-3) + Parabola(0.02),
    FlatPunch(1e-4),
    PowerLaw(3e3, 3),
    Sampled(x, [25 * at**2 for at in x], kind="smooth"),
]
states: list[Equilibrium] = [
    minimise(Scene(layer, surfaces, body), depth=0.3e-6, rtol=1e-8) for body in bodies
]
state = states[1]
half_width: float = state.half_width
error: float = state.error_estimate["force"]
right: float = float(state.contacts[0, 1])
u = state.displacement(np.linspace(0, 1e-3, 5))
p = state.pressure(0.0)
row: dict[str, float | str] = state.to_dict()
path: History = load_path(state.scene, depths=[0.0, 3e-7, -6e-7])
events: list[Event] = list(path.events)
kinds: list[str] = [event.kind for event in events]
force, depth, width = path.pull_off
lost: float = path.dissipated + events[0].energy_released
steps: int = len(path)
state.plot("a state").savefig("state.png")
path.plot().savefig("path.png")
known = cards.parabola.force(0.3e-6, R=0.02, k=layer.stiffness, gamma1=0.07, w=6e-5)
print(half_width, float(known) / state.force - 1, kinds)
