"""The stiffness of a bonded layer as a sum of poles, to a tolerance.

With s = q²,

    k(s) = k₀ + k₁/(s + τ₁) + Σ c_j s/(s + τ_j),

the first pole that of the flow sideways, and k₀ + k₁/τ₁ the stiffness at q = 0; τ₁ = 0 and k₁ =
3G/h³ for an incompressible layer. The first poles are the layer's own: k is infinite where
(3 - 4ν) sinh z = z, s = z²/4h². The others are real, in steps as far apart as the tolerance allows:
a sum over poles in steps of a factor F is off by 4 exp(-π²/ln F). They end where k is hardly more
than the tolerance times γ₁q², and tension has taken over from the layer. k₀, c_j: least squares of
the error over k + γ₁q².

A sum that is bounded for q -> ∞ leaves to tension alone what happens at a contact line: there the
displacement has a kink, and nothing of the layer may compete with γ₁u'².

Conventions
-----------
k is pressure over displacement of a surface wave cos(qx), both positive downwards, q its wave
number, h the thickness, G the shear modulus (`shear_modulus` of a layer), ν Poisson's ratio;
`relative_stiffness(ν, qh)` is k h/G. `bracketed` finds a zero between a place where a function is
<= 0 and one where it is > 0. The poles are at s = -τ, τ real and positive, or complex in pairs of
conjugates, of which "pairs" have the one with Im τ > 0. While they are sought lengths are in h and
stiffnesses in G/h; `Poles` has the units of the layer.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import lstsq

from discretization.certificate import NotCertifiedError
from discretization.roots import bracketed
from energy import ElasticLayer
from energy.arrays import Array, Complex
from energy.layer import relative_stiffness

_FLOW = 3.0  # k₁ over G/h³ of an incompressible layer: Poiseuille flow between its two surfaces


class PoleRules(NamedTuple):
    """Which poles there are, and at which q they are fitted, so that the sum keeps its tolerance;
    tests/layer/test_response.py compares it with the stiffness of layers for tolerances from 1e-9
    to 1e-2 and γ₁ over 8 decades. Of 60 such layers with random ν the sum is off by 0.55 of the
    tolerance at most (`Poles.error`), with 21 poles on average, and so it is with half or twice of
    each of these, but for the first two.

    Attributes
    ----------
    digits_per_pair : float
        Decimal digits that one of the layer's own pairs of poles is good for. With 4 of them 17 of
        these 60 layers miss the tolerance, by up to 13 times; 1 digit costs 4 poles more.
    beyond : float
        The smallest τ of the other poles, over the largest |τ| of the layer's own. With 3 two of
        the 60 miss the tolerance, by up to twice; 0.75 costs one pole more.
    tension_dominates : float
        Relative error of k alone at which no more poles are added.
    samples_per_decade : int
        Samples of q per decimal digit of the tolerance; every second is fitted.
    most_samples : int
        Samples of q at most.
    first : float
        qh of the first sample: there k differs from k(0) by about (qh)² = 2.5e-7.
    furthest : float
        The last q, over that beyond which k < γ₁q² times the tolerance.
    """

    digits_per_pair: float = 2.0
    beyond: float = 1.5
    tension_dominates: float = 0.3
    samples_per_decade: int = 160
    most_samples: int = 1401
    first: float = 5e-4
    furthest: float = 1e3


_POLES = PoleRules()


class ZeroRules(NamedTuple):
    """How zeros in the complex plane are found.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 5 random states,
    branches and paths as they are to 1e-9: `python -m tests.sensitivity
    discretization.layer.poles`.

    Attributes
    ----------
    newton_steps : int
        Steps from the asymptotic zeros of (3 - 4ν) sinh z = z; each doubles the digits.
    aberth_steps : int
        Steps of Aberth's method at most: of 300 random layers half took 8, and one 17.
    converged : float
        A relative change of λ² after which only rounding is left, as the method converges
        cubically.
    real : float
        Imaginary part over |λ| that is rounding.
    beside : float
        |μ| over |τ| at which Aberth's method starts beside a pole,
    off_axis : float
        and the angle between the two [rad]: on the pole itself the function is infinite, and what
        starts on the real axis stays there. With half or twice of 5 % or of the angle it finds the
        same zeros of 40 random layers to 3e-16, in 8.7 to 9.1 steps on average, here in 8.9.
    """

    newton_steps: int = 8
    aberth_steps: int = 100
    converged: float = 1e-9
    real: float = 1e-13
    beside: float = 1.05
    off_axis: float = 0.05


_ZEROS = ZeroRules()


class Poles(NamedTuple):
    """The sum of poles of a layer, and the decays of a free surface on it.

    Attributes
    ----------
    still : float
        k₀ [stress/length].
    flow, first : float
        k₁ [stress/length³] and τ₁ [1/length²]; τ₁ is real.
    tau, c : ndarray (n,)
        The other τ [1/length²] and their weights [stress/length]: real ones in increasing order,
        then one of each pair of conjugates, then the other ones in the same order.
    decays : ndarray (n + 2,)
        λ with k(-λ²) = γ₁λ² and positive real parts [1/length]: a free surface is a sum of
        exp(-λx). What is not real comes with its conjugate.
    error : float
        Largest error of the sum over k + γ₁q² at the samples. It may exceed the tolerance a little
        (1.3 times in the worst of 300 random layers): error estimates are built on this number.
    """

    still: float
    flow: float
    first: float
    tau: Complex
    c: Complex
    decays: Complex
    error: float


@functools.lru_cache(maxsize=32)
def poles(layer: ElasticLayer, gamma1: float, tolerance: float) -> Poles:
    """The poles of a layer under a surface tension, kept.

    Parameters
    ----------
    layer : ElasticLayer
    gamma1 : float
        [force/length], > 0.
    tolerance : float
        Error of k over k + γ₁q² that is aimed at.

    Returns
    -------
    Poles

    Raises
    ------
    NotCertifiedError
        If the decays of the free surface are not found.
    """
    h = layer.h
    unit = layer.shear_modulus / h  # of stiffness
    gamma = gamma1 / (unit * h**2)  # from here on in units of the thickness and the shear modulus
    half_space = 1 - layer.nu  # a half-space has the stiffness q over this
    count = max(1, round(-math.log10(tolerance) / _POLES.digits_per_pair))
    first = _flow_pole(layer.nu)
    pairs = _own_pairs(layer.nu, count)
    real = _spaced_poles(abs(pairs[-1]) * _POLES.beyond, gamma * half_space, tolerance)
    # k(0) τ₁, which is k₀τ₁ + k₁; without τ₁ it is k₁.
    at_rest = first * float(relative_stiffness(layer.nu, 0.0)) if first else _FLOW

    furthest = max(_POLES.furthest / (tolerance * gamma * half_space), _POLES.furthest)
    samples = min(
        round(_POLES.samples_per_decade * (1 - math.log10(tolerance))), _POLES.most_samples
    )
    q = np.exp(np.linspace(math.log(_POLES.first), math.log(furthest), samples))
    fitted, error = _fitted(layer.nu, gamma, q, at_rest, first, real, pairs)
    still = fitted[0]
    c_real = fitted[1 : real.size + 1]
    c_pairs = np.dot([1, 1j], np.reshape(fitted[real.size + 1 :], (2, -1)))  # Re c, then Im c

    tau: Complex = np.array([*real, *pairs, *pairs.conj()], complex)
    c: Complex = np.array([*c_real, *c_pairs, *c_pairs.conj()], complex)
    flow = (at_rest - first * still) * unit / h**2
    none = np.empty(0, complex)
    found = Poles(still * unit, flow, first / h**2, tau / h**2, c * unit, none, error)
    return found._replace(decays=_decays(found, gamma1))


def _fitted(
    nu: float, gamma: float, q: Array, at_rest: float, first: float, real: Array, pairs: Complex
) -> tuple[list[float], float]:
    """Least squares of k₀, the c of real poles, and of the c of pairs of poles.

    As k₁ = `at_rest` - k₀τ₁, k₀ + k₁/(s + τ₁) is at_rest/(s + τ₁) + k₀ s/(s + τ₁): k₀ has the shape
    of a pole at τ₁. Columns are scaled to one size. All is in units of h and G.

    Parameters
    ----------
    nu, gamma : float
        Poisson's ratio, and γ₁.
    q : ndarray (m,)
        Samples of the wave number, of which every second one is fitted.
    at_rest : float
        k(0) τ₁.
    first : float
        τ₁.
    real, pairs : ndarray
        τ of the other poles; of each pair of conjugates one.

    Returns
    -------
    fitted : list of float
        k₀, the c of `real`, the real parts of the c of `pairs`, and their imaginary parts.
    error : float
        Largest error of the sum over k + γ₁q², at all samples.
    """
    s = (q * q)[:, None]
    exact = relative_stiffness(nu, q)
    size = exact + gamma * q * q
    of_pairs = 2 * s / (s + pairs)  # c times this has the real part of both conjugates together
    of_real = s / (s + np.append(first, real))
    matrix = np.concatenate([of_real, of_pairs.real, -of_pairs.imag], axis=1)
    matrix /= size[:, None]
    scale = np.sqrt((matrix[::2] * matrix[::2]).sum(axis=0))
    wanted = (exact - at_rest / (q * q + first)) / size
    solution = lstsq(matrix[::2] / scale, wanted[::2], lapack_driver="gelsy")[0] / scale
    error = float(np.abs(matrix @ solution - wanted).max())
    return list(solution.tolist()), error


def _flow_pole(nu: float) -> float:
    """τ₁h² = y²/4 of the zero z = iy, (3 - 4ν) sin y = y with 0 < y < π, and 0 for ν = ½."""
    if nu >= 0.5:
        return 0.0
    ratio = 3 - 4 * nu
    low = math.sqrt(6 * (1 - 1 / ratio)) / 2  # below the zero: half that of ratio (y - y³/6) - y
    return bracketed(lambda y: ratio * math.sin(y) - y, math.pi, low) ** 2 / 4


def _own_pairs(nu: float, count: int) -> Complex:
    """τh² (count,) of the layer's own pairs of poles, the one of each with Im τ > 0.

    With τ = -z²/4h² they are the zeros of (3 - 4ν) sinh z = z off the axes, by Newton's method from
    the asymptotic ones: z is so far up the imaginary axis, at y, that e^z (3 - 4ν)/2 = iy.
    """
    ratio = 3 - 4 * nu
    y = (2 * np.arange(1, count + 1) + 0.5) * math.pi
    z = np.log(2 * y / ratio) + 1j * y
    for _ in range(_ZEROS.newton_steps):
        z -= (ratio * np.sinh(z) - z) / (ratio * np.cosh(z) - 1)
    return np.asarray((-z * z / 4).conj())


def _spaced_poles(first: float, gamma: float, tolerance: float) -> Array:
    """Real τh² of the poles beyond the layer's own, up to where tension dominates.

    There the layer is a half-space of stiffness q/(1 - ν). The relative error of k may be the
    tolerance times 1 + γ₁q²/k at q = √τ, and the steps from pole to pole, of a factor F with
    4 exp(-π²/ln F) that error, grow with it. Each pole is in the middle of its step in log τ.

    Parameters
    ----------
    first : float
        τh² where they begin.
    gamma : float
        γ₁q²/k of a half-space at qh = 1.
    tolerance : float

    Returns
    -------
    ndarray
        Increasing.
    """
    found = []
    tau = first
    error = 0.0
    while error < _POLES.tension_dominates:
        error = min(tolerance * (1 + gamma * math.sqrt(tau)), _POLES.tension_dominates)
        factor = math.exp(math.pi**2 / math.log(4 / error))
        found.append(tau * math.sqrt(factor))
        tau *= factor
    return np.array(found)


def _decays(found: Poles, gamma1: float) -> Complex:
    """λ (n + 2,) of a free surface: with μ = λ² all zeros of

        γ₁μ - k₀ - k₁/(τ₁ - μ) - Σ c μ/(μ - τ)

    at once by Aberth's method, which starts beside the poles and from both zeros of the first pole
    alone (O. Aberth, Math. Comp. 27 (1973) 339). It stops where every step is at most 1e-9 |μ|.
    The function times all its denominators is a polynomial p of degree n + 2: Newton's step for p
    is f/(f' + f Σ 1/(μ - pole)), and what other zeros that are known so far would add is subtracted
    from the sum.

    Parameters
    ----------
    found : Poles
        All but the decays.
    gamma1 : float
        [force/length].

    Raises
    ------
    NotCertifiedError
        If it does not converge.
    """
    # Off the real axis, on the side of each pole; those beside conjugates begin as conjugates.
    side = np.where(found.tau.imag == 0, 0.5, np.sign(found.tau.imag))
    beside_poles = found.tau * _ZEROS.beside * np.exp(1j * _ZEROS.off_axis * side)
    # The first pole alone has two zeros of this size. They start far off the real axis, one on each
    # side, but not as conjugates: those would stay conjugates where the zeros are real. Angles half
    # or twice as large give the same zeros, in 9.5 or 8.1 steps.
    mean = math.sqrt((found.still * found.first + found.flow) / gamma1)
    mu = np.concatenate([beside_poles, mean * np.exp([-0.6j, 0.5j])])
    for _ in range(_ZEROS.aberth_steps):
        inverse = 1 / (mu[:, None] - found.tau)
        inverse_first = 1 / (found.first - mu)
        value = gamma1 * mu - found.still - found.flow * inverse_first - mu * (inverse @ found.c)
        rate = gamma1 - found.flow * inverse_first**2 + inverse**2 @ (found.c * found.tau)
        differences = mu[:, None] - mu
        np.fill_diagonal(differences, math.inf)
        repulsion = (1 / differences).sum(axis=1)
        step = value / (rate + value * (inverse.sum(axis=1) - inverse_first - repulsion))
        mu = mu - step
        if (np.abs(step) <= _ZEROS.converged * np.abs(mu)).all():
            root = np.sqrt(mu)  # with a positive real part
            return np.where(np.abs(root.imag) <= _ZEROS.real * np.abs(root), root.real, root)
    raise NotCertifiedError(
        "the free surface of the layer is not resolved; use another rtol, or response='springs'"
    )
