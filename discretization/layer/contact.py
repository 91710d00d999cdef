"""One contact of a layer, condensed to its line: where it rests, and its force and energy.

With the poles of k (poles.py), v_j = u - φ_j of pole j and the flow ψ obey, with the measure m (1,
or r about an axis) and both known at the line,

    -(m v')' + τ_j m v = (m f')',    -(m ψ')' + τ₁ m ψ = m u    on 0 < x < a,

v'(0) + f'(0) = ψ'(0) = 0. With these on elements (elements.py) it is known what the fields pull at
the line from inside. Outside, the layer and the surface are balanced by u = Σ A exp(-λ(x-a)) of the
decays of `Poles` (about an axis K₀(λr)), in which φ_j is τ_j/(τ_j - λ²) of u, and ψ 1/(τ₁ - λ²).
That every φ_j and ψ has one value and one slope at the line are, with u = d - f(a) there, as many
linear equations as decays. So all is linear in u(a) and 1, and the reaction of all that is free or
pressed beside a line is

    S = γ₁ (σ u(a) + s₀).

Of ∂U/∂a = m [γ₁/2 (f' - S/γ₁)² - w] the line rests where that vanishes, m the length of the line:

    D(a) = f(a) + (f'(a) - s₀ - √(2w/γ₁))/σ,    P = c ∫₀ᵃ p dm + c m S,

with the layer's pressure p = k₀u + k₁ψ + Σ c_j v_j and the symmetry factor c, 2 or 2π. The square
is left because f' γ₁ - S is the force on the line and a line that advances takes the surface along.
What is stored at fixed a is ½ c (∫p u dm + m S u(a)), and c γ₁/2 ∫f'² dm of the surface in contact.

Conventions
-----------
Displacements u and depths are positive downwards, the height f of the profile upwards: in contact
u = d - f. x is the distance from the lowest point of the profile, or the axis; f', v' and slopes
are by x, outwards. `Body.power` is 1 about an axis, else 0: the power of x in m, and
`Body.symmetry_factor` is c; energies and forces are per length of a line contact, or all around.
`grid` gives the ends of elements, by their distances from the line over a, and `elements` makes
them: their `x` are the places of the nodes over a, their `mass` the weights of the nodes in
integrals ∫ dm over a contact of half-width 1, `half` half their lengths. `gauss_lobatto(DEGREE)`,
DEGREE = 12, has 13 points on [-1, 1], and its `derivative` is the matrix that differentiates values
there. `Fields` has, of each pole, the force own V - given that holds its field at V at the line,
and `total` the sum of the fields at the nodes, weighted.

The poles (`Poles` of poles.py): `still` is k₀, `flow` k₁, `first` τ₁, and `tau` and `c` belong to
the n - 2 others, `decays` are the n values of λ. τ and fields are counted from the first pole on,
n - 1 of them. e is the number of elements, each with 13 nodes.

Everything is the sum of two parts, and arrays with an axis of 2 have both: u(a) times the response
to u(a) = 1 with a flat profile (index 0), and the response to the profile with u(a) = 0 (index 1).
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np
import scipy

from discretization.layer.body import Body
from discretization.layer.elements import DEGREE, Fields, elements, grid
from discretization.layer.poles import Poles, poles
from discretization.surfaces.network import gauss_lobatto
from energy.arrays import Array, Complex

# For `Body.slope`: at a corner each element has the slope on its own side.
_SIDE_OF_NODES = np.array([1] + [0] * (DEGREE - 1) + [-1])
# |z| up to which K(z) of a complex z is computed by Amos's routine, which loses digits from 3.3e4
# on. Beyond, its expansion is cut after two terms; the next one is less than 9/(128 z²) = 2e-10.
_LARGEST_ARGUMENT = 2e4


class ForceAndEnergy(NamedTuple):
    """Force of a contact, and its energy without adhesion; numbers or arrays alike.

    Attributes
    ----------
    force : float or ndarray
        P, positive if the indenter is pressed.
    without_adhesion : float or ndarray
        U + w·area.
    """

    force: Any
    without_adhesion: Any


def at_depth(coefficients: Any, u: Any) -> ForceAndEnergy:
    """Force and stored energy of contacts at displacements u(a) of their lines.

        P = P₀ + P'u,    U + w·area = U₀ + P₀u + P'u²/2

    Parameters
    ----------
    coefficients : ndarray (5, ...)
        From `Contact.coefficients`.
    u : float or ndarray (...)
        d - f(a) [length].

    Returns
    -------
    ForceAndEnergy
        [force] and [energy], or these per length of a line contact.
    """
    _, _, stiffness, force_at_0, stored_at_0 = coefficients
    energy = stored_at_0 + force_at_0 * u + stiffness * u * u / 2
    return ForceAndEnergy(stiffness * u + force_at_0, energy)


def decayed(power: int, decays: Complex, a: float, distance: Array) -> Complex:
    """Solutions outside a contact that decay from 1 at its line.

    exp(-λx), or about an axis K₀(λ(a + x))/K₀(λa), at distances x from the line.

    Parameters
    ----------
    power : {0, 1}
        1 about an axis.
    decays : ndarray (n,)
        λ [1/length].
    a : float
        Half-width or radius [length].
    distance : ndarray (k,)
        [length].

    Returns
    -------
    ndarray (2, n, k)
        The solutions (0) and their slopes by the distance (1).
    """
    exponential = np.exp(-np.outer(decays, distance))
    found = exponential * np.stack([decays**0, -decays])[..., None]
    if power:
        argument = np.outer(decays, a + distance)
        scaled = np.array([_scaled_bessel(order, argument) for order in (0, 1)])
        found *= scaled / _scaled_bessel(0, decays[:, None] * a)
    return found


def _scaled_bessel(order: int, z: Complex) -> Complex:
    """K(z) exp(z) of order 0 or 1, for complex z with positive real parts, of any shape.

    scipy has k0e and k1e for real z, ten times as fast, and kve for complex z.
    """
    found = np.empty_like(z)
    real = z.imag == 0
    near = ~real & (np.abs(z) <= _LARGEST_ARGUMENT)
    far = ~real & ~near
    of_reals = scipy.special.k1e if order else scipy.special.k0e
    found[real] = of_reals(z.real[real])
    found[near] = scipy.special.kve(order, z[near])
    found[far] = np.sqrt(math.pi / (2 * z[far])) * (1 + (4 * order - 1) / (8 * z[far]))
    return found


class Contact:
    """The linear response of a contact of fixed half-width, by u(a) at its line and 1.

    Arrays with two rows belong to these: the first to u(a), the second to 1. A quantity of the
    contact at a depth is the first times u(a) = d - f(a), plus the second.

    Parameters
    ----------
    body : Body
    a : float
        Half-width or radius [length].
    tolerance : float
        That of the poles.
    first : float
        Where elements begin to be graded; another value makes another mesh, for comparisons.

    Attributes
    ----------
    f : float
        Height of the profile at the line [length].
    slopes, weights : ndarray (e, 13)
        f' at the nodes of the elements, and their weights in integrals c ∫ dm over the contact.
    stretched : float
        Energy c γ₁/2 ∫f'² dm of the surface in contact.
    u : ndarray (2, e, 13)
        Displacements of the nodes, 1 and f(a) - f.
    fields : Fields
        ψ and the v_j inside the contact, condensed to the line.
    outside : ndarray (n - 1, n)
        Fields of what decays by each λ (columns), over its u: ψ, then φ of the other poles.
    amplitudes : ndarray (n, 2)
        A of the decays outside.
    reaction : ndarray (2,)
        σ [1/length] and s₀: what is outside pulls with S = γ₁ (σ u(a) + s₀).
    lines : ndarray (2,)
        c m S of all lines together [force/length] and [force].
    """

    def __init__(self, body: Body, a: float, tolerance: float, first: float = 0.5) -> None:
        """Solve for the fields inside, and match those outside to them at the line."""
        scene = body.scene
        self.body = body
        self.a = a
        self.tolerance = tolerance
        self.poles: Poles = poles(scene.layer, scene.gamma1, tolerance)
        tau: Complex = np.append(self.poles.first, self.poles.tau)
        shortest = np.abs(tau).max() ** -0.5
        self.elements = elements(body.power, grid(body, a, shortest, first))

        nodes = a * self.elements.x  # distances from the lowest point
        self.weights = body.symmetry_factor * a ** (body.power + 1) * self.elements.mass
        self.f = float(body.height(a))
        self.slopes = body.slope(nodes, _SIDE_OF_NODES)
        self.stretched = scene.gamma1 / 2 * float((self.weights * self.slopes**2).sum())
        self.u = np.array([np.ones_like(nodes), self.f - body.height(nodes)])
        self.fields = Fields(self.elements, a * a * tau, self._loads())

        self.outside = np.append(1, self.poles.tau)[:, None] / (tau[:, None] - self.poles.decays**2)
        outward_slopes = self._outward_slopes()
        self.amplitudes = self._amplitudes(outward_slopes)
        self.reaction = (outward_slopes @ self.amplitudes).real
        self.lines = scene.gamma1 * body.symmetry_factor * a**body.power * self.reaction

    def _loads(self) -> Array:
        """Nodal loads of the fields, with x in units of a: of the flow, and of all other poles.

        By parts (m f')' is the load -∫ m f' N' dx, N the function of a node. What is left at the
        line, m (v' + f'), is -m φ', as u' = -f' in contact; at the lowest point it is 0.

        Returns
        -------
        ndarray (e, 3, 13)
            m u for both parts of u; (m f')' of the v_j, which have no load by u(a).
        """
        mass = self.elements.mass
        derivative = gauss_lobatto(DEGREE).derivative
        flow = self.a * self.a * mass * self.u
        bend = self.a * (-(self.slopes * mass / self.elements.half) @ derivative)
        return np.stack([*flow, bend], axis=1)

    def _outward_slopes(self) -> Complex:
        """-u' at the line of what decays by each λ (n,), over its u [1/length].

        λ, or λ K₁(λa)/K₀(λa) about an axis.
        """
        slopes = self.poles.decays.copy()
        if self.body.power:
            argument = self.poles.decays * self.a
            slopes *= _scaled_bessel(1, argument) / _scaled_bessel(0, argument)
        return slopes

    def _amplitudes(self, outward_slopes: Complex) -> Complex:
        """A (n, 2): the fields outside have the values and slopes of those inside at the line.

        The first equation, Σ A = u(a), is that of u itself. The others are those of ψ and φ_j. What
        a field takes from inside if its value at the line is V, own V - given (`Fields`), and from
        outside, -a times its slope there, add up to 0. For φ_j = u - v_j the inside is that of v_j
        = u(a) - φ_j with the opposite sign. Rows are scaled to the size 1.

        outward_slopes: from `_outward_slopes`.
        """
        own = self.fields.own
        given = self.fields.given
        matrix = np.ones((outward_slopes.size,) * 2, complex)
        matrix[1:] = (own[:, None] + self.a * outward_slopes) * self.outside
        of_u = [[1], [0]]
        of_flow = given[:, :1]
        of_poles = [own[1:], -given[1, 1:]]  # v_j has no load by u(a)
        right_side = np.concatenate([of_u, of_flow, of_poles], axis=1).T  # (n, 2)
        size = np.abs(matrix).max(axis=1, keepdims=True)
        return np.linalg.solve(matrix / size, right_side / size)

    @functools.cached_property
    def pressures(self) -> Array:
        """Pressure p = k₀u + k₁ψ + Σ c_j v_j of the layer at the nodes (2, e, 13)."""
        at_line = self.outside @ self.amplitudes  # ψ and the φ_j (n - 1, 2)
        at_line[1:] = [1, 0] - at_line[1:]  # v = u - φ
        weights = np.append(self.poles.flow, self.poles.c)
        return self.poles.still * self.u + self.fields.total(at_line.T, weights)

    @functools.cached_property
    def quadratic_form(self) -> Array:
        """c (∫p u dm + m S u(a)) (2, 2): p and S of the part in the row, u of that in the column.

        It is symmetric but for the errors of the fields (`Layer.certificate`).
        """
        pressed = (self.pressures * self.weights).reshape(2, -1)
        found = pressed @ self.u.reshape(2, -1).T
        found[:, 0] += self.lines
        return np.asarray(found)

    @property
    def coefficients(self) -> Array:
        """σ, s₀, P' = dP/du(a), and P₀ and U₀ at u(a) = 0 without adhesion (5,): all of a contact.

        See `at_depth` and `Body.rest_depth`. As u = 1 in the first part, the first column of the
        quadratic form is the force c (∫p dm + m S) of both parts.
        """
        stored = self.quadratic_form[1, 1] / 2 + self.stretched
        return np.array([*self.reaction, *self.quadratic_form[:, 0], stored])
