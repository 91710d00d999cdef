"""What the study `pull_off` says of the paper's conclusions, in words that follow the numbers."""

from collections.abc import Sequence

import numpy as np

from studies.pull_off.record import Curve
from studies.shared import loops
from studies.shared.loops import SIZE, WORK
from studies.shared.types import Array

_NIL = 1e-8


def conclusions(curves: Sequence[Curve]) -> list[str]:
    """What tension does to each indenter, in words that follow the numbers."""
    flat, wedge, parabola = curves
    return [
        f"w is fixed at {WORK:g} N/m; l/b from {flat.ratios[1]:.3g} to {flat.ratios[-1]:.3g}",
        *_flat_verdict(flat),
        *_wedge_verdict(wedge),
        *_parabola_verdict(parabola),
    ]


def trend(values: Array, rounding: float = 1e-10) -> int:
    """1 where every value is above the one before, -1 where below, else 0."""
    steps = np.diff(values) / np.abs(values).max()
    return int(np.all(steps > rounding)) - int(np.all(steps < -rounding))


def _effect(found: int, claimed: int | None = None) -> str:
    """What a trend says, and whether that is what the paper claims."""
    known = {1: "helps at every step", -1: "weakens at every step", 0: "has no one sign"}
    verdict = f": {'confirmed' if found == claimed else 'NOT confirmed'}"
    return f"tension {known[found]}{'' if claimed is None else verdict}"


def _flat_verdict(flat: Curve) -> list[str]:
    """The metastable limit, and the pull at which the detached state has the lower energy."""
    balanced = np.array([pull.balanced.force for pull in flat.pulls if pull.balanced])
    part, grows = balanced / flat.forces, trend(balanced)
    effect = "also grows" if grows == 1 else "does not grow throughout"
    return [
        f"flat punch (paper: tension helps): {_effect(trend(flat.forces), 1)}; F_A grows "
        f"{flat.gain[-1]:.4g}-fold",
        f"flat punch, qualified: Eq. (23) is the metastable limit. The detached state has the "
        f"lower energy from {part[0]:.4g} F_A on without tension, from {part[-1]:.4g} F_A at "
        f"the largest; that pull {effect} with γ₁ ({balanced[-1] / balanced[0]:.4g}-fold)",
    ]


def _wedge_verdict(wedge: Curve) -> list[str]:
    """Up to tan δ = α, that is l = b, and beyond it."""
    blunt = wedge.ratios < 1
    last = wedge.pulls[int(blunt.sum()) - 1]
    text = [
        f"wedge (paper: tension weakens), tan δ < α: {_effect(trend(wedge.forces[blunt]), -1)}; "
        f"F_A falls to {wedge.gain[blunt][-1]:.4g} of its value without tension at l/b = "
        f"{last.ratio:.3g}"
    ]
    if not blunt.all():
        sharp = [pull for pull in wedge.pulls if pull.ratio > 1]
        largest = max(abs(p.simulated.force) / loops.force_scale(p.scene) for p in sharp)
        given = abs(loops.formula_30(wedge.pulls[-1].scene))
        text.append(
            f"wedge, tan δ > α: it detaches at its tip under a pull of {largest:.1g} kδ₀(b + l); "
            f"the modulus in Eq. (30) would give {given:.3g} N/m: outside its range"
        )
    return text


def _parabola_verdict(parabola: Curve) -> list[str]:
    """Both sides of Λ = 1."""
    ratios, gain = parabola.ratios, parabola.gain
    text = [f"parabola (paper: open): {_effect(trend(parabola.forces))}"]
    low, high = ratios <= 1, ratios >= 1
    if low.sum() > 2:
        last = int(low.sum()) - 1
        a = [pull.simulated.half_width / SIZE for pull in parabola.pulls]
        text.append(
            f"parabola, Λ <= 1: F_A is {gain[last]:.4g}-fold at Λ = {ratios[last]:.3g}, its gain "
            f"~ γ₁^{_power(ratios[low], gain[low] - 1):.3f}; the half-width at pull-off falls "
            f"from {a[0]:.3g} b to {a[last] if a[last] > _NIL else 0:.3g} b"
        )
    if high.sum() > 1:
        text.append(
            f"parabola, Λ >= 1: the contact closes to a point before it detaches, F_A "
            f"~ γ₁^{_power(ratios[high], gain[high]):.3f}, {gain[-1]:.4g}-fold at the end"
        )
    return text


def _power(ratios: Array, values: Array) -> float:
    """n of values ~ γ₁^n, γ₁ ~ (l/b)², between the last two."""
    rise = np.diff(np.log(np.abs(values[-2:]) + np.finfo(float).tiny))[0]
    return float(rise / np.diff(np.log(ratios[-2:]))[0] / 2)
