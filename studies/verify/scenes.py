"""The scenes that the checks share: a soft gel film in SI units, no parameter equal to 1.

E = 310 Pa, ν = 0.38, h = 11 µm, γ₁ = 47 mN/m, w = 23 µJ/m²: l = 29.8 µm, δ₀ = 0.93 µm,
√(2w/γ₁) = 0.031. At d = 0 the assumptions of the model (d ≪ h ≪ a, small slopes, 2w ≪ γ₁) hold.

The numbers of the checks, of a layer, a shape, a depth or a place, are any of this order of
magnitude: a closed form has to hold for all, and for none by the accident of a round one.

Conventions:

- A scene has `stiffness` k = Ẽ/h, `work_of_adhesion` w, `elastocapillary_length` l = √(γ₁/k) and
  `critical_separation` δ₀ = √(2w/k).
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `FlatPunch(half_width)` has f = 0 up to its edges; `PowerLaw(c, n)` is f = c|x|ⁿ; `Sampled(x, z)`
  is a measured profile of heights z at x; `Profile(height, slope)` is a profile given by two
  functions.
"""

import functools
import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

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
)

# A soft gel film. No number is 1, round, or equal to another: a factor that a formula has lost, or
# two quantities that it has swapped, make an error.
LAYER = ElasticLayer(E=310.0, nu=0.38, h=11e-6)  # Pa, 1, m
GAMMA1 = 0.047  # N/m
GAMMA2 = 0.0312  # J/m²
WORK = 2.3e-5  # J/m²

# Indenters with contacts of about 0.1 mm, several l wide [m, rad].
PUNCH = FlatPunch(half_width=1.93e-4)
WEDGE = Wedge(delta=4.7e-3)
PARABOLA = Parabola(R=2.3e-2)
POWER_LAWS = (PowerLaw(c=0.75, n=1.5), PowerLaw(c=1.2e5, n=3), PowerLaw(c=4e8, n=4))


def gel(
    indenter: Indenter,
    *,
    gamma1: float = GAMMA1,
    w: float = WORK,
    layer: ElasticLayer = LAYER,
    geometry: str = "line",
) -> Scene:
    """An indenter on the gel film.

    Parameters
    ----------
    indenter : Indenter
    gamma1, w : float
        Surface tension and work of adhesion [J/m²].
    layer : ElasticLayer
    geometry : {"line", "axisymmetric"}

    Returns
    -------
    Scene
    """
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    return Scene(layer, surfaces, indenter, geometry=geometry)


class Case(NamedTuple):
    """A scene and what its closed forms take.

    Attributes
    ----------
    scene : Scene
    depths : ndarray (n,)
        [m].
    given : dict
        The arguments of closed forms: those of the shape, k, γ₁ and w.
    """

    scene: Scene
    depths: np.ndarray
    given: dict[str, float]


def case(indenter: Any, levels: ArrayLike, **options: Any) -> Case:
    """A case on the gel film.

    Parameters
    ----------
    indenter : Indenter
        One with a closed form.
    levels : array_like (n,)
        Depths over δ₀.
    options : optional
        Of `gel`.

    Returns
    -------
    Case
    """
    scene = gel(indenter, **options)
    flat = isinstance(indenter, FlatPunch)
    shape = {"a": indenter.half_width} if flat else asdict(indenter)
    depths = np.asarray(levels, float) * scene.critical_separation
    return Case(scene, depths, shape | constants(scene))


@functools.lru_cache(maxsize=256)
def limit(card: Callable[..., Any], **given: float) -> Any:
    """A closed form without an argument, such as a pull-off, worked out once for all grids."""
    return card(**given)


def known(card: Callable[..., Any], at: ArrayLike, **given: float) -> np.ndarray:
    """A closed form at depths or places (n,), worked out once for all grids."""
    return _known(card, tuple(np.ravel(at).tolist()), **given)


@functools.lru_cache(maxsize=256)
def _known(card: Callable[..., Any], at: tuple[float, ...], **given: float) -> np.ndarray:
    """The same of a tuple, which a cache can hold."""
    return np.asarray(card(np.array(at), **given))


def constants(scene: Scene) -> dict[str, float]:
    """k, γ₁ and w of a scene, as the closed forms take them: those for w = 0 take no w."""
    adhesion = {"w": scene.work_of_adhesion} if scene.work_of_adhesion else {}
    return {"k": scene.stiffness, "gamma1": scene.gamma1, **adhesion}


def uneven_profiles() -> tuple[Indenter, ...]:
    """Profiles without mirror symmetry: tilted, sum of two, user-defined, measured."""
    x = np.linspace(-9e-4, 9e-4, 37)
    measured = x**2 / (2 * 2.9e-2) + 4e-8 * np.sin(x / 5.3e-5)

    def height(x: ArrayLike) -> np.ndarray:
        """f, a lopsided catenary [m]."""
        x = np.asarray(x)
        return 9e-6 * (np.cosh(x / 4.1e-4) - 1) + 4e-4 * x

    def slope(x: ArrayLike) -> np.ndarray:
        """f'."""
        return 9e-6 / 4.1e-4 * np.sinh(np.asarray(x) / 4.1e-4) + 4e-4

    tilted = Parabola(R=2.1e-2).tilted(1.3e-3)
    summed = PowerLaw(c=1.1e5, n=3).shifted(2.3e-5) + Parabola(R=4.7e-2)
    defined = Profile(height, slope)
    return tilted, summed, defined, Sampled(x, measured, kind="smooth")


def sharp_wedge(ratio: float) -> Wedge:
    """Wedge with tan δ = ratio·√(2w/γ₁) on the gel film: ratio > 1 never pulls."""
    return Wedge(delta=math.atan(ratio * math.sqrt(2 * WORK / GAMMA1)))


def pulled_parabola(Lambda: float) -> Parabola:
    """Parabola, or sphere, with Λ = l/√(Rδ₀) on the gel film."""
    scene = gel(PARABOLA)
    ell = scene.elastocapillary_length
    delta0 = scene.critical_separation
    return Parabola(R=ell**2 / (delta0 * Lambda**2))
