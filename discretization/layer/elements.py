"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

In units of the half-width a, for all poles at once: -(m v')' + τ m v = load on 0 < x < 1, with
v'(0) = 0 and v known at the line, x = 1. m is the measure, 1 or x about an axis. In each
Gauss-Lobatto element the inner nodes are eliminated with the modes K φ = λ M φ of its stiffness and
mass, by division by λ + τ. What is left of the elements is tridiagonal. Interior elements need not
resolve 1/√τ, as v is smooth there and about f''/τ.

Conventions
-----------
x is the distance from the lowest point of the profile, or the axis, over a; elements are numbered
from x = 0 to the line, so that the left end of an element is the one nearer to 0. Their ends are
kept as distances 1 - x from the line, beside which they may be tiny. e is the number of elements,
13 = DEGREE + 1 that of their nodes, 11 that of their inner ones, n the number of poles; the last
axis of complex arrays is the poles.

The first of the poles is the flow sideways, of which the field is ψ, with two loads: one for each
part of the surface displacement u, that which is u(a) and that which is the profile's (contact.py).
All other poles have fields v_j, one load by the profile alone, and none by u(a).

`gauss_lobatto(DEGREE)` has the 13 nodes of an element on [-1, 1], their weights, and the matrix
that differentiates values at them. Of a `Body`, `breaks` and `kinks` are distances [length] at
which elements have to end (`grid`).
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

    Halved or doubled, each leaves 5 random states, branches and paths as they are to 1e-9: `python
    -m tests.sensitivity discretization.layer.elements`.

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
        Its `breaks` are where any derivative of the profile jumps, its `kinks` where f' does or,
        at 0, where f' is no integer power of x.
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
        # Distances from the kink or line, over a, at which elements end.
        steps = [(right - left) / a * first / _GRADING.growth**i for i in range(count)]
        ends += _graded(1 - right / a, 1, steps, ends)
        if kink_on_the_left:
            ends += _graded(1 - left / a, -1, steps, ends)
    resolved = {z for z in ends if z == 1 or z < _GRADING.resolved}
    return tuple(sorted(resolved, reverse=True))


def _graded(origin: float, direction: int, steps: list[float], ends: list[float]) -> list[float]:
    """Ends of elements in these steps from an origin, but for slivers.

    Parameters
    ----------
    origin : float
        Distance of a kink from the line over a, or 0 for the line.
    direction : {1, -1}
        1 away from the line, -1 towards it.
    steps : list of float
        Distances from the origin over a.
    ends : list of float
        Ends that there are; what is too near to one of them is left out.

    Returns
    -------
    list of float
        Distances from the line over a.
    """
    places = [(origin + direction * step, _GRADING.sliver * step) for step in steps]
    return [z for z, sliver in places if min(abs(z - end) for end in ends) > sliver]


class Elements:
    """Elements of a grid, each with its inner nodes as modes.

    K and M are the matrices of ∫v'² m dx and ∫v² m dx of one element; M is diagonal.

    Parameters
    ----------
    power : {0, 1}
        Of x in the measure m: 1 about an axis.
    ends : tuple of float
        From `grid`; there are as many elements e as steps between them.

    Attributes
    ----------
    x, mass : ndarray (e, 13)
        Places of the nodes, and the diagonals of M: their weights times the measure.
    half : ndarray (e, 1)
        Half the lengths of the elements.
    values : ndarray (e, 11)
        λ of the modes of the inner nodes, K φ = λ M φ with φᵀ M φ = 1.
    modes : ndarray (e, 11, 11)
        φ, one in each column.
    ties : ndarray (2, e, 11)
        φᵀK of the left (0) and of the right (1) end: force on an end by a mode of amplitude 1.
    flat : ndarray (e, 11)
        φᵀM 1, the amplitudes of the modes in a field that is 1 everywhere.
    bridge : ndarray (e, 1)
        Element of K between both ends.
    tied : ndarray (e, 3, 11)
        For each mode the products of its ties: left with right, left with `flat`, right with
        `flat`.
    """

    def __init__(self, power: int, ends: tuple[float, ...]) -> None:
        """Integrate K and M by the Gauss-Lobatto rule, and find the modes of the inner nodes."""
        points, weights, derivative = gauss_lobatto(DEGREE)
        far = np.array(ends[:-1])[:, None]  # distances of the left ends from the line
        near = np.array(ends[1:])[:, None]
        self.half = (far - near) / 2
        distance = (far + near) / 2 - self.half * points
        distance[:, [0, -1]] = np.hstack([far, near])  # to the last bit
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


# Elements hold 13 to 40 kB, 128 of them up to 5 MB.
@functools.lru_cache(maxsize=128)
def elements(power: int, ends: tuple[float, ...]) -> Elements:
    """The elements of a grid, kept for contacts whose grids are alike."""
    return Elements(power, ends)


class Fields:
    """Fields v of n poles, each under two loads, condensed to the line.

    Elements are eliminated from 0 to the line, each as a network of two terminals: a `tie` between
    its ends, and at each end a ground stiffness, by which it resists v, and a load. The ground
    stiffness of both ends together, which resists a displacement that is the same everywhere, and
    the total load are computed as such: as differences of stiffnesses they would lose all digits
    where τ is small.

    Arrays with an axis of 2 have the load by u(a) first, that by the profile second.

    Parameters
    ----------
    elements : Elements
    tau : ndarray (n,)
        τ a² of the poles.
    loads : ndarray (e, 3, 13)
        Nodal loads: of the first pole by u(a) and by the profile, and of all others by the profile.

    Attributes
    ----------
    own : ndarray (n,)
        Stiffness at the line of what is inside: the force that holds the line at v is own v -
        given.
    given : ndarray (2, n)
        The force that both loads exert on a line that is held at 0.
    share : ndarray (e, 11, n)
        Compliances 1/(λ + τ) of the modes.
    forced : ndarray (e, 3, 11)
        Loads of the modes, in the order of `loads`.
    passed : ndarray (e, n)
        v at the left end of each element over v at its right end, without loads.
    rest : ndarray (e, 2, n)
        v at its left end where v at its right end is 0, under the loads.
    """

    def __init__(self, elements: Elements, tau: Complex, loads: Array) -> None:
        """Eliminate the elements from 0 to the line, one after the other."""
        self.elements = elements
        self.share = 1 / (elements.values[:, :, None] + tau)
        self.forced = loads[..., 1:-1] @ elements.modes
        tie, left_end, both_ends = self._condensed(tau, loads)

        # From 0 on: ground stiffness (row 0) and loads (rows 1, 2) at a node, of all on its left.
        behind = np.zeros_like(left_end[0])
        at_left_ends = []
        passed = []
        for i in range(len(tie)):
            # The left end is in balance, (ground + tie) v - tie v_right = load: it is at
            # (tie v_right + load)/(ground + tie), and so passes a part of both on to the right.
            at_left = behind + left_end[i]
            at_left_ends.append(at_left)
            passed.append(tie[i] / (at_left[0] + tie[i]))
            behind = (both_ends[i] - left_end[i]) + passed[i] * at_left
        self.own = behind[0]
        self.given = behind[1:]
        self.passed = np.array(passed)
        self.rest = (self.passed / tie)[:, None] * np.array(at_left_ends)[:, 1:]

    def _condensed(self, tau: Complex, loads: Array) -> tuple[Complex, Complex, Complex]:
        """Elements as two-terminal networks, their modes eliminated.

        A mode between ends at v_left and v_right has the amplitude

            share (forced - tie_left v_left - tie_right v_right),    share = 1/(λ + τ).

        As K has no forces on a field that is 1 everywhere, tie_left + tie_right = -λ flat: with it
        the ground stiffnesses and the total load are τ times, or less τ times, sums over the modes.

        Returns
        -------
        tie : ndarray (e, n)
            Stiffness between both ends.
        left_end, both_ends : ndarray (e, 3, n)
            Ground stiffness, load by u(a), and load by the profile: of the left end, and of both
            ends together.
        """
        elements = self.elements
        flat = elements.flat[:, None]
        with_left = self.forced * elements.ties[0][:, None]
        with_flat = self.forced * flat
        # Sums over the modes (e, 9, n): rows times shares, real times complex without a copy.
        rows = np.concatenate([elements.tied, with_left, with_flat], axis=1)
        modal = (rows @ self.share.view(float)).view(complex)
        tied_sum = modal[:, 0]
        ground_sums = modal[:, 1:3]  # of the left and the right end
        left_load_sums = modal[:, 3:6]  # of the three loads
        total_load_sums = modal[:, 6:]

        tie = tied_sum - elements.bridge
        ground = tau * (elements.mass[:, [0, -1], None] - ground_sums)
        left_load = loads[..., :1] - left_load_sums
        total_load = loads.sum(axis=2)[..., None] - tau * total_load_sums
        for load in (left_load, total_load):  # poles other than the first have loads of their own
            load[:, 0, 1:] = 0
            load[:, 1, 1:] = load[:, 2, 1:]
        left_end = np.concatenate([ground[:, :1], left_load[:, :2]], axis=1)
        total_ground = ground.sum(axis=1, keepdims=True)
        both_ends = np.concatenate([total_ground, total_load[:, :2]], axis=1)
        return tie, left_end, both_ends

    def total(self, at_line: Complex, c: Complex) -> Array:
        """Nodal values of Σ c v, the sum over all poles.

        Parameters
        ----------
        at_line : ndarray (2, n)
            v at the line, of the part by u(a) and of that by the profile.
        c : ndarray (n,)
            Weights of the poles.

        Returns
        -------
        ndarray (2, e, 13)
            Their real part; poles that are not real come with their conjugates.
        """
        # v at the ends of all elements, from the line inwards.
        v = [at_line]
        for passed, rest in zip(self.passed[::-1], self.rest[::-1], strict=True):
            v.append(rest + passed * v[-1])
        at_ends = c * np.array(v[::-1])
        at_left = at_ends[:-1]
        at_right = at_ends[1:]

        # Amplitudes of the modes, times c and summed over the poles (e, 2, 11), as in `_condensed`.
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
