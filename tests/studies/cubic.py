"""Does surface tension help or weaken the adhesion of f = c|x|³? A study outside the package.

A dead load is lowered until the contact lets go, for several l = √(γ₁/k) over δ₀, at fixed w and k.
Without a closed form of the pull-off, the depth where the line lets go is held against Eq. (16),
f(a) = d + δ₀ - l f'(a). Output: cubic.csv, cubic.png; exit status 1 if (16) is missed by 1e-6 δ₀.
"""

from dataclasses import dataclass

from discretization import load_path
from energy import ElasticLayer, PowerLaw, Scene, SurfaceEnergies, cards
from studies.shared import command
from studies.shared.batches import each
from studies.shared.figures import canvas

LAYER, WORK = ElasticLayer(E=2.5e3, nu=0.3, h=5e-6), 1e-6  # Pa, 1, m; N/m
LIFT = float(cards.plane.critical_separation(LAYER.stiffness, WORK))
BODY = PowerLaw(c=LIFT / 50e-6**3, n=3)  # f(50 µm) = δ₀


@dataclass(frozen=True)
class Parameters:
    """l in m."""

    lengths: tuple[float, ...] = (1e-6, 3e-6, 10e-6, 20e-6, 30e-6, 50e-6)


def pulled(length: float) -> tuple[float, ...]:
    """l, γ₁, P, d and a of the pull-off, and how far it is from Eq. (16), over δ₀."""
    scene = Scene(LAYER, SurfaceEnergies.from_work(LAYER.stiffness * length**2, WORK), BODY)
    force = LAYER.stiffness * LIFT * 1e-3  # far more than it takes
    pull = load_path(scene, forces=[0.0, -force]).pull_off
    f, slope = float(BODY.height(pull.half_width)), float(BODY.slope(pull.half_width))
    miss = abs(f - pull.depth - LIFT + length * slope) / LIFT
    return (length, scene.gamma1, *pull, miss)


def plot(rows):
    """F_A over γ₁."""
    figure, axes = canvas(7, 4.5)
    axes.semilogx([1e3 * row[1] for row in rows], [-1e3 * row[2] for row in rows], "o-")
    axes.set(xlabel="surface tension γ₁ in mN/m", ylabel="adhesion force in mN/m")
    axes.set_title("Surface tension strengthens the adhesion of |x|³")
    return figure


def main(argv=None):
    """Command line of the study."""
    full, quick = Parameters(), Parameters((3e-6, 30e-6))
    preset, jobs, out = command.start(__file__, __doc__, argv, "two tensions", full, quick)
    rows = list(each(pulled, preset.lengths, jobs))
    names = ["l", "gamma1", "force", "depth", "half_width", "error"]
    out.table("cubic.csv", preset, names, rows)
    out.figure("cubic.png", plot(rows))
    for row in rows:
        print(f"l = {1e6 * row[0]:.3g} µm: F_A = {-1e3 * row[2]:.6g} mN/m, (16) to {row[5]:.0e} δ₀")
    return int(max(row[5] for row in rows) > 1e-6)
