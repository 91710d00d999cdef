"""How far the assumptions of the model hold: d ≪ h ≪ a, small slopes, h not above l, no noise.

The layer is a bed of independent springs (3). Of a layer bonded to a rigid base that is exact for
a displacement that does not vary over its thickness; one that varies as cos qx meets the stiffness

    k(q) = k (1 - c₂ q²h² + O(q⁴h⁴)),    c₂ = ν(4ν - 1)/(3(1 - ν)(1 - 2ν)).

The free surface varies over l, so that c₂(h/l)² and h/l tell what the springs are worth there.

h is the thickness of the layer, a the half-width or radius of its narrowest contact, d the depth
below first touch, u the displacement, l = √(γ₁/k), δ₀ = √(2w/k). `scene.opened` has the work of
adhesion of a contact that opens, the larger one; `surfaces.doubt` ends a message about w > 10 γ₁
with the question whether the two were swapped. Of a scene, `gamma1` is γ₁, `work_of_adhesion` w of
a contact that closes, `elastocapillary_length` l and `critical_separation` δ₀;
`indenter.noise_slope` is the rms slope that noise makes between neighbouring samples, None without
samples. `relative_stiffness(ν, qh)` is k(q) h/G with the shear modulus G, `second_order(ν)` c₂.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from energy.layer import relative_stiffness, second_order

if TYPE_CHECKING:
    from energy.scene import Scene

_rule = functools.cache(np.polynomial.legendre.leggauss)  # of 200 points it takes 7 ms
# Points of the integral for the compliance; half as many change it by less than 1e-14 for
# h/l <= 30 and ν <= 0.49.
_POINTS = 200
# "≪" is read as "less than a tenth of": what a formula of first order leaves out is then some 10 %.
MUCH_LESS = 0.1
# Above this 2w/γ₁ Young's law, cos θ = w/γ₁ - 1, has no angle.
_NO_ANGLE = 4.0
# Rms slope of the samples' noise over √(2w/γ₁). With white noise in 400 (1000) straight pieces of
# x²/30 on (-9, 9), w = 0.02, k = γ₁ = 1, the energy lost between d = -0.25 and 0.5 is larger than
# without by 3 (6) % at 0.02, 17 (24) % at 0.05, 50 (60) % at 0.1, twice to three times that at 0.4.
NOISE = 0.05
# What springs miss at pull-off of a sphere, in %, over ν (rows) and l/h: layer_springs_worst.csv of
# `python -m studies layer`
_NU = (0.0, 0.3, 0.4, 0.45, 0.48, 0.49)
_RATIOS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
_FORCE = (
    (8.2, 3.3, 1.1, 0.30, 0.069, 0.011),
    (7.7, 3.2, 0.84, 0.33, 0.068, 0.021),
    (8.1, 4.4, 2.0, 1.0, 0.34, 0.11),
    (9.5, 6.9, 3.6, 2.3, 0.99, 0.34),
    (14, 12, 7.5, 4.4, 2.5, 0.91),
    (18, 16, 11, 5.9, 3.9, 1.7),
)
_RADIUS = (
    (21, 7.9, 3.0, 0.63, 0.18, 0.053),
    (17, 6.4, 2.0, 0.33, 0.15, 0.035),
    (10, 4.4, 3.3, 1.9, 0.85, 0.31),
    (13, 11, 8.0, 4.6, 2.4, 0.83),
    (24, 20, 15, 9.8, 5.3, 2.3),
    (32, 27, 20, 14, 7.8, 4.0),
)


class Assumption(NamedTuple):
    """One assumption of the model: a dimensionless measure that should stay below its limit.

    Attributes
    ----------
    name : str
        What is measured, such as "h/a".
    value, limit : float
        What it is, and what it may be at most.
    consequence : str
        What is wrong where it is larger.

    Examples
    --------
    >>> from energy import Assumption
    >>> print(Assumption("h/a", 0.5, 0.1, "the layer is not thin against a contact"))
    h/a = 0.5 (limit 0.1): VIOLATED: the layer is not thin against a contact
    """

    name: str
    value: float
    limit: float
    consequence: str

    @property
    def holds(self) -> bool:
        """Whether the measure does not exceed its limit."""
        return self.value <= self.limit

    def __str__(self) -> str:
        """A line with the measure, its limit and the verdict."""
        verdict = "holds" if self.holds else f"VIOLATED: {self.consequence}"
        return f"{self.name} = {self.value:.3g} (limit {self.limit:g}): {verdict}"


class Deformation(NamedTuple):
    """What an equilibrium in contact does to the layer.

    Attributes
    ----------
    indentation : float
        Depth below first touch, d - min f [length].
    displacement : float
        Largest |u| anywhere [length].
    half_width : float
        That of the narrowest contact [length]: the radius of one around the axis, half the width of
        a ring.
    slope : float
        The steepest |f'| in contact or |u'| beside it [1].
    """

    indentation: float
    displacement: float
    half_width: float
    slope: float


def assumptions(scene: Scene, deformed: Deformation | None) -> tuple[Assumption, ...]:
    """The assumptions that a state of this scene makes.

    Those of Sections 2 and 6: d ≪ h ≪ a (with rotational symmetry the radius), slopes ≪ 1, 2w ≪ γ₁;
    for a nearly incompressible layer (h/a)² ≪ 1 - 2ν; and with tension |c₂|(h/l)² ≪ 1 and h <= l.
    A layer with its exact response takes any h, and instead δ₀ ≪ h: w <= 0.005 γ₁ (h/l)².
    "≪" is read as "less than a tenth of". The rms slope that noise makes between neighbouring
    samples of a profile is at most NOISE of √(2w/γ₁), the change of slope at a contact line.

    Parameters
    ----------
    scene : Scene
    deformed : Deformation or None
        None without contact: what it would say is left out.

    Returns
    -------
    tuple of Assumption
    """
    layered = () if deformed is None else _of_layer(scene, deformed)
    surfaces = (*_of_slopes(scene, deformed), *_of_free_surface(scene))
    return (*layered, *surfaces, *_of_samples(scene))


def _of_layer(scene: Scene, deformed: Deformation) -> tuple[Assumption, ...]:
    """Strain of the layer, and its thickness against the narrowest contact."""
    h = scene.layer.h
    strained = "the layer is strained beyond linearity"
    little = (
        Assumption("d/h", abs(deformed.indentation) / h, MUCH_LESS, strained),
        Assumption("u/h", deformed.displacement / h, MUCH_LESS, strained),
    )
    if scene.layer.exact:
        lifted = scene.opened.critical_separation / h
        return (*little, Assumption("δ₀/h", lifted, MUCH_LESS, strained + " where a line lifts it"))
    thickness = h / deformed.half_width if deformed.half_width else math.inf
    flows = "nearly incompressible: material flows sideways, springs are not independent"
    sideways = thickness**2 / (1 - 2 * scene.layer.nu)
    return (
        *little,
        Assumption("h/a", thickness, MUCH_LESS, "the layer is not thin against a contact"),
        Assumption("(h/a)²/(1-2ν)", sideways, MUCH_LESS, flows),
    )


def _of_slopes(scene: Scene, deformed: Deformation | None) -> tuple[Assumption, ...]:
    """What the small-slope energies need; nothing for finite slopes."""
    if scene.slopes != "small":
        return ()
    w = scene.work_of_adhesion
    if w == 0:
        ratio = 0.0
    elif scene.gamma1 == 0:
        ratio = math.inf
    else:
        ratio = 2 * w / scene.gamma1
    if ratio <= _NO_ANGLE:
        consequence = "the contact angle is far from π"
    else:
        consequence = "Young's law (8) has no contact angle"
    angle = Assumption("2w/γ₁", ratio, MUCH_LESS, consequence + scene.surfaces.doubt)
    if deformed is None:
        return (angle,)
    steep = "surfaces are too steep for small-slope energies"
    return (Assumption("slope", deformed.slope, MUCH_LESS, steep), angle)


def _of_free_surface(scene: Scene) -> tuple[Assumption, ...]:
    """The thickness against the elastocapillary length; nothing without tension."""
    if scene.layer.exact or not scene.gamma1:
        return ()
    nu = scene.layer.nu
    ratio = scene.layer.h / scene.elastocapillary_length
    off = 100 * abs(compliance_error(nu, ratio))
    errors = f"its compliance under a line load is off by {off:.2g} %"
    errors += _pull_off(nu, 1 / ratio) + "; use response='layer'"
    near = f"the free surface bends within l, where springs are not independent: {errors}"
    thick = f"the free surface bends within less than the thickness: {errors}"
    second = abs(second_order(nu)) * ratio**2
    return (
        Assumption("|c₂|(h/l)²", second, MUCH_LESS, near),
        Assumption("h/l", ratio, 1.0, thick),
    )


def _of_samples(scene: Scene) -> tuple[Assumption, ...]:
    """The noise of a sampled profile; nothing where no samples are known, or no angle resists."""
    noise = scene.indenter.noise_slope
    w = scene.work_of_adhesion or scene.opened.work_of_adhesion
    if noise is None or not (w and scene.gamma1):
        return ()
    ratio = noise / math.sqrt(2 * w / scene.gamma1)
    decides = "the samples' noise decides where lines rest: filter the profile"
    return (Assumption("noise slope/√(2w/γ₁)", ratio, NOISE, decides),)


def _pull_off(nu: float, ratio: float) -> str:
    """What is said of springs at pull-off, at ν and ratio = l/h: "" outside of the table."""
    if not _NU[0] <= nu <= _NU[-1] or ratio < _RATIOS[0]:
        return ""
    force, radius = (f"{value:.2g} %" for value in springs_error(nu, ratio))
    return f", a sphere's force at pull-off by up to {force}, its radius there by up to {radius}"


@functools.lru_cache(maxsize=1024)  # two numbers each; states of a sweep over depths share one
def springs_error(nu: float, ratio: float) -> tuple[float, float]:
    """By how much springs miss force and radius at pull-off of a sphere, at the worst tension.

    Interpolated between the entries of the table, linearly in ν and in ln(l/h); beyond the table
    its nearest entry counts.

    Parameters
    ----------
    nu : float
        Poisson's ratio.
    ratio : float
        l/h.

    Returns
    -------
    force, radius : float
        Relative errors in %.
    """

    def interpolated(table: tuple[tuple[float, ...], ...]) -> float:
        """The entry of a table, rows of ν and columns of l/h, between those that it has."""
        of_nu = [np.interp(math.log(ratio), np.log(_RATIOS), row) for row in table]
        return float(np.interp(nu, _NU, of_nu))

    return interpolated(_FORCE), interpolated(_RADIUS)


@functools.lru_cache(maxsize=1024)  # one number each; states of a sweep over depths share one
def compliance_error(nu: float, thickness: float) -> float:
    """Compliance of the free surface of the exact bonded layer over that of springs, minus 1.

    u(0)/F = 1/π ∫₀^∞ dq/(k(q) + γ₁q²) under a line load F, against 1/(2kl); with ql = tan φ

        2/π ∫₀^{π/2} dφ/(cos² φ k(q)/k + sin² φ) - 1.

    Parameters
    ----------
    nu : float
        Poisson's ratio, < ½.
    thickness : float
        h/l.

    Returns
    -------
    float
        [1]
    """
    points, weights = _rule(_POINTS)
    angle = math.pi / 4 * (points + 1)
    uniform = 2 * (1 - nu) / (1 - 2 * nu)  # k h/G
    relative = relative_stiffness(nu, thickness * np.tan(angle)) / uniform
    density = 1 / (np.cos(angle) ** 2 * relative + np.sin(angle) ** 2)
    return float(weights @ density) / 2 - 1
