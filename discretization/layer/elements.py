"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

In units of the half-width a, for all poles at once: -(m v')' + τ m v = load, with v'(0) = 0 and v
known at the line. In each Gauss-Lobatto element the inner nodes are eliminated with the modes
K φ = λ M φ of its stiffness and mass, by division by λ + τ. What is left of the elements is
tridiagonal. Interior elements need not resolve 1/√τ, as v is smooth there and about f''/τ.
"""

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from discretization.layer.body import Body
from discretization.surfaces.network import gauss_lobatto
from energy.arrays import Array, Complex

DEGREE = 12  # of the polynomials on an element, which leave rounding on elements graded as below


class Grading(NamedTuple):
    """How elements are graded towards the line and towards kinks.

    Attributes
    ----------
    growth : float
        Length of an element over that of its neighbour towards the line.
    boundary_layer : float
        Length of the element beside the line, over 1/√τ of the stiffest pole.
    fewest_at_kink : int
        Elements that grow away from a kink, at least: the shortest is 4⁻⁷ = 6e-5 of the first.
    resolved : float
        Distance from the line, over a, beyond which no element ends: the next one would be shorter
        than what rounding leaves of 1 - x/a.
    sliver : float
        Distance over the length of an element within which no second element ends: a sliver
        resolves nothing, and its stiffness rounds.
    """

    growth: float = 4.0
    boundary_layer: float = 8.0
    fewest_at_kink: int = 8
    resolved: float = 1 - 1e-12
    sliver: float = 1e-3


_GRADING = Grading()


def grid(body: Body, a: float, shortest: float, first: float) -> tuple[float, ...]:
    """Ends of elements under a contact, by their distances from its line.

    Elements end at all breaks of the profile. Towards the line and towards kinks, beside which the
    fields change fast, each is a fourth of its neighbour, until they resolve the shortest length
    on which a pole acts and, beside kinks, f'.

    Parameters
    ----------
    body : Body
    a : float
        Half-width of the contact [length].
    shortest : float
        1/√τ of the stiffest pole [length].
    first : float
        Where the grading begins, as a fraction of the distance from one kink, or line, to the next.

    Returns
    -------
    tuple of float
        Distances from the line over a, decreasing from 1 to 0.
    """
    ends = [0.0, 1.0]
    ends += [1 - x / a for x in body.breaks if 0 < x < a]
    kinks = [x for x in body.kinks if 0 < x < a]
    for left, right in itertools.pairwise([0.0, *kinks, a]):
        kink_on_the_left = left in body.kinks
        ratio = (right - left) / (_GRADING.boundary_layer * shortest)
        count = math.ceil(math.log(max(1.0, ratio), _GRADING.growth))
        if kink_on_the_left:
            count = max(count, _GRADING.fewest_at_kink)
        steps = [(right - left) / a * first / _GRADING.growth**i for i in range(count)]
        ends += _graded(1 - right / a, 1, steps, ends)
        if kink_on_the_left:
            ends += _graded(1 - left / a, -1, steps, ends)
    resolved = {z for z in ends if z == 1 or z < _GRADING.resolved}
    return tuple(sorted(resolved, reverse=True))


def _graded(origin: float, direction: int, steps: list[float], ends: list[float]) -> list[float]:
    """Places in these steps from an origin, but for those that are next to other ends."""
    places = [(origin + direction * step, _GRADING.sliver * step) for step in steps]
    return [z for z, sliver in places if min(abs(z - end) for end in ends) > sliver]


class Elements:
    """Elements of a grid, each with its inner nodes as modes.

    Parameters
    ----------
    power : {0, 1}
        Of x in the measure m.
    ends : tuple of float
        From `grid`; there are as many elements e as steps between them.

    Attributes
    ----------
    x, mass : ndarray (e, 13)
        Distances of the nodes from 0, and their weights times the measure.
    half : ndarray (e, 1)
        Half the lengths of the elements.
    values : ndarray (e, 11)
        λ of the modes of the inner nodes, K φ = λ M φ with φᵀ M φ = 1.
    modes : ndarray (e, 11, 11)
        φ, one in each column.
    ties : ndarray (2, e, 11)
        Stiffness between the modes and the left, and the right, end.
    flat : ndarray (e, 11)
        Mass of the modes: their shares of a field that is 1 everywhere.
    bridge : ndarray (e, 1)
        Stiffness between both ends.
    tied : ndarray (e, 3, 11)
        Products of the modes' ties: left with right, left with `flat`, right with `flat`.
    """

    def __init__(self, power: int, ends: tuple[float, ...]) -> None:
        points, weights, derivative = gauss_lobatto(DEGREE)
        far = np.array(ends[:-1])[:, None]
        near = np.array(ends[1:])[:, None]
        self.half = (far - near) / 2
        distance = (far + near) / 2 - self.half * points
        distance[:, [0, -1]] = np.hstack([far, near])
        self.x = 1 - distance
        self.mass = self.half * weights * self.x**power
        stiffness = (derivative.T * (self.mass / self.half**2)[:, None]) @ derivative

        root_mass = np.sqrt(self.mass[:, 1:-1, None])
        scaled = stiffness[:, 1:-1, 1:-1] / (root_mass * root_mass.swapaxes(1, 2))
        self.values, vectors = np.linalg.eigh(scaled)
        self.modes = vectors / root_mass
        to_ends = self.modes.swapaxes(1, 2) @ stiffness[:, 1:-1, [0, -1]]
        self.ties = np.moveaxis(to_ends, -1, 0)
        left, right = self.ties
        self.flat = (self.modes * self.mass[:, 1:-1, None]).sum(axis=1)
        self.bridge = stiffness[:, 0, -1:]
        self.tied = np.stack([left * right, left * self.flat, right * self.flat], axis=1)


@functools.lru_cache(maxsize=128)
def elements(power: int, ends: tuple[float, ...]) -> Elements:
    """The elements of a grid, kept for contacts whose grids are alike."""
    return Elements(power, ends)


class Fields:
    """Fields v of n poles, each under two loads, condensed to the line.

    Elements are eliminated from 0 to the line. The ground stiffness of an element, by which it
    resists a displacement that is the same everywhere, and its total load are computed as such:
    as differences of stiffnesses they would lose all digits where τ is small.

    Parameters
    ----------
    elements : Elements
    tau : ndarray (n,)
        τ a² of the poles.
    loads : ndarray (e, 3, 13)
        Nodal loads: both of the first pole, then the second of all others, whose first is zero.

    Attributes
    ----------
    own : ndarray (n,)
        Stiffness at the line of what is inside: it pulls there with own v - given.
    given : ndarray (2, n)
        Reactions of both loads there.
    share : ndarray (e, 11, n)
        Compliances 1/(λ + τ) of the modes.
    forced : ndarray (e, 3, 11)
        Loads of the modes.
    passed : ndarray (e, n)
        v on the left of each element over v on its right, without loads.
    rest : ndarray (e, 2, n)
        v on its left where v on its right is 0, under the loads.
    """

    def __init__(self, elements: Elements, tau: Complex, loads: Array) -> None:
        self.elements = elements
        self.share = 1 / (elements.values[:, :, None] + tau)
        self.forced = loads[..., 1:-1] @ elements.modes
        tie, left_end, both_ends = self._condensed(tau, loads)

        # From 0 on: stiffness (row 0) and loads (rows 1, 2) of all on the left of a node.
        behind = np.zeros_like(left_end[0])
        at_left_ends = []
        passed = []
        for i in range(len(tie)):
            at_left = behind + left_end[i]
            at_left_ends.append(at_left)
            passed.append(tie[i] / (at_left[0] + tie[i]))
            behind = (both_ends[i] - left_end[i]) + passed[i] * at_left
        self.own = behind[0]
        self.given = behind[1:]
        self.passed = np.array(passed)
        self.rest = (self.passed / tie)[:, None] * np.array(at_left_ends)[:, 1:]

    def _condensed(self, tau: Complex, loads: Array) -> tuple[Complex, Complex, Complex]:
        """Elements as two-terminal networks.

        Returns
        -------
        tie : ndarray (e, n)
            Stiffness between both ends.
        left_end, both_ends : ndarray (e, 3, n)
            Ground stiffness and both loads, of the left end, and of both ends together.
        """
        elements = self.elements
        flat = elements.flat[:, None]
        with_left = self.forced * elements.ties[0][:, None]
        with_flat = self.forced * flat
        rows = np.concatenate([elements.tied, with_left, with_flat], axis=1)
        modal = (rows @ self.share.view(float)).view(complex)  # sums over the modes (e, 9, n)

        tie = modal[:, 0] - elements.bridge
        ground = tau * (elements.mass[:, [0, -1], None] - modal[:, 1:3])
        left_load = loads[..., :1] - modal[:, 3:6]
        total_load = loads.sum(axis=2)[..., None] - tau * modal[:, 6:]
        for load in (left_load, total_load):  # poles other than the first have loads of their own
            load[:, 0, 1:] = 0
            load[:, 1, 1:] = load[:, 2, 1:]
        left_end = np.concatenate([ground[:, :1], left_load[:, :2]], axis=1)
        total_ground = ground.sum(axis=1, keepdims=True)
        both_ends = np.concatenate([total_ground, total_load[:, :2]], axis=1)
        return tie, left_end, both_ends

    def total(self, at_line: Complex, c: Complex) -> Array:
        """Nodal values of Σ c v.

        Parameters
        ----------
        at_line : ndarray (2, n)
            v at the line, under both loads.
        c : ndarray (n,)
            Weights of the poles.

        Returns
        -------
        ndarray (2, e, 13)
            Their real part.
        """
        # v at the ends of all elements, from the line inwards.
        v = [at_line]
        for passed, rest in zip(self.passed[::-1], self.rest[::-1], strict=True):
            v.append(rest + passed * v[-1])
        at_ends = c * np.array(v[::-1])
        at_left = at_ends[:-1]
        at_right = at_ends[1:]

        # Amplitudes of the modes: what loads them less what the ends take, over λ + τ.
        share = self.share.swapaxes(1, 2)
        left_tie, right_tie = self.elements.ties[:, :, None]
        of_first_pole = c[0] * (self.forced[:, :2] * self.share[:, None, :, 0])
        amplitudes = of_first_pole - left_tie * (at_left @ share)
        amplitudes = amplitudes - right_tie * (at_right @ share)
        amplitudes[:, 1] += self.forced[:, 2] * (c[1:] @ share[:, 1:])  # of all other poles

        inner = amplitudes.real @ self.elements.modes.swapaxes(1, 2)
        ends = at_ends.sum(axis=2, keepdims=True).real
        nodal = np.concatenate([ends[:-1], inner, ends[1:]], axis=2)
        return nodal.swapaxes(0, 1)
