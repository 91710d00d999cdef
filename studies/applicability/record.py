"""What `applicability` compares: its parameters, and the record that figures and report read."""

from dataclasses import dataclass
from typing import NamedTuple

from studies.shared.small_slopes import Errors

TOLERANCES = (0.01, 0.1)  # relative errors whose borders are searched: a per cent, and ten
PUNCH = "flat punch"
NODES = 100  # in the shorter of l and a
WORK = 0.5  # with k = 1 the critical separation δ₀ is 1


@dataclass(frozen=True)
class Parameters:
    """Grids of w/γ₁, steepness and punch width a/l.

    Attributes
    ----------
    ratios, steepness, widths : tuple of float
        w/γ₁, steepness and punch width a/l of the map.
    lines, scan : tuple of float
        Steepness and w/γ₁ where borders are searched.
    paths, tensions : tuple of float
        Steepness and γ₁/w of the conjecture.
    """

    ratios: tuple[float, ...] = (
        *(1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.5, 0.7, 0.9),
        *(0.98, 1.04, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7),
    )
    steepness: tuple[float, ...] = (0.01, 0.03, 0.07, 0.15, 0.25, 0.4, 0.65, 1.0)
    widths: tuple[float, ...] = (0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0)
    lines: tuple[float, ...] = (0.01, 0.1, 0.3)
    scan: tuple[float, ...] = (1e-4, 1e-2, 0.1, 0.4, 0.8)
    paths: tuple[float, ...] = (0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0)
    tensions: tuple[float, ...] = (
        *(0.56, 0.65, 0.75, 0.85, 0.95, 1.02, 1.2, 1.6, 2.5, 5.0, 12.0, 40.0, 200.0, 1e3, 1e4),
    )


FULL = Parameters()
# Fewer of each, over the same ranges: borders are found, and the figures are coarse.
QUICK = Parameters(
    ratios=(1e-4, 1e-3, 0.01, 0.04, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.15, 1.3, 1.5, 1.8),
    steepness=(0.03, 0.06, 0.1, 0.18, 0.3, 0.45, 0.7, 1.0),
    widths=(0.1, 0.3, 1.0, 3.0, 10.0),
    lines=(0.1,),
    scan=(1e-4, 0.05, 0.3),
    paths=(0.1, 0.2, 0.4),
    tensions=(1.2, 2.5, 40.0, 1e3),
)


class Point(NamedTuple):
    """One comparison of small slopes with a simulated state.

    Attributes
    ----------
    shape : str
    ratio : float
        w/γ₁.
    steepness, width : float
        f'(a) and a/l by (16).
    errors : Errors
    """

    shape: str
    ratio: float
    steepness: float
    width: float
    errors: Errors


class Border(NamedTuple):
    """The w/γ₁ at which an error first exceeds a tolerance.

    Attributes
    ----------
    shape : str
    steepness : float
        f' at the line.
    quantity : str
        What the error is of: the force, the half-width, or π - θ, which no shape enters.
    tolerance : float
    ratio : float
        w/γ₁; 0: from the least on; inf: nowhere up to the largest.
    """

    shape: str
    steepness: float
    quantity: str
    tolerance: float
    ratio: float


class Small(NamedTuple):
    """Eq. (16) within the paper's own energy, of small slopes.

    Attributes
    ----------
    shape : str
    steepness : float
        f' at the line.
    tension : float
        γ₁/w; 0 for springs alone and (18).
    mesh : float
        Relative error of a on the mesh, whose lines rest at ∂U/∂x = 0.
    nodes : float
        The same on NODES nodes in the shorter of l and a, where energies of contact sets are
        compared and nothing else; NaN where no nodes are tried.
    """

    shape: str
    steepness: float
    tension: float
    mesh: float
    nodes: float


@dataclass(frozen=True)
class Record:
    """All comparisons.

    Attributes
    ----------
    parameters : Parameters
    maps, paths : dict
        The points of each shape, of the map and of the conjecture.
    borders : tuple of Border
    flat : tuple of (str, float, float)
        Shape, w/γ₁, and the error of d = -δ₀, where the contact detaches, relative to δ₀.
    small : tuple of Small
    """

    parameters: Parameters
    maps: dict[str, tuple[Point, ...]]
    paths: dict[str, tuple[Point, ...]]
    borders: tuple[Border, ...]
    flat: tuple[tuple[str, float, float], ...]
    small: tuple[Small, ...]

    @property
    def small_slopes(self) -> tuple[float, float]:
        """Largest error on the mesh of (16) for γ₁ > 0, and of (18) for γ₁ = 0."""
        tense = max(one.mesh for one in self.small if one.tension)
        return tense, max(one.mesh for one in self.small if not one.tension)

    @property
    def points(self) -> list[Point]:
        """All of them."""
        return [x for part in (self.maps, self.paths) for row in part.values() for x in row]
