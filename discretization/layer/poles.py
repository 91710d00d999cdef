"""The stiffness of a bonded layer as a sum of poles, to a tolerance.

With s = q²,

    k(s) = k₀ + k₁/(s + τ₁) + Σ c_j s/(s + τ_j),

the first pole that of the flow sideways, and k₀ + k₁/τ₁ the stiffness at q = 0; τ₁ = 0 and k₁ =
3G/h³ for an incompressible layer. The first poles are the layer's own: k is infinite where
(3 - 4ν) sinh z = z, s = z²/4h². The others are real, in steps as far apart as the tolerance allows
where tension has not yet taken over from the layer, k < γ₁q² times the tolerance: a sum over poles
in steps of a factor e^h is off by 4 exp(-π²/h). k₀, c_j: least squares of the error over k + γ₁q².

A sum that is bounded for q -> ∞ leaves to tension alone what happens at a contact line: there the
displacement has a kink, and nothing of the layer may compete with γ₁u'².
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

_FLOW = 3.0  # k₁ of an incompressible layer, over G/h³
_DIGITS = 2.0  # of the tolerance that one of the layer's own pairs of poles is good for
_BEYOND = 1.5  # times the last of them, where the others begin
_LEAST = 0.3  # of k: an error that may be, where tension rules
_SAMPLES, _MOST = 160, 1401  # of q for a decade of the tolerance; fitted to every second one
_FLATTEST, _FURTHEST = 5e-4, 1e3  # qh of the first; of the last, times where tension rules
_NEWTON, _ABERTH = 8, 100
_STILL = 1e-9  # of a decay squared: a step of Aberth's method after which rounding is left
_REAL = 1e-13  # of a decay: an imaginary part that is rounding


class Poles(NamedTuple):
    """k₀, k₁, τ₁, the other τ and c (n,), and what these make of a free surface.

    decays (n + 2,): λ with k(-λ²) = γ₁λ², real parts positive: a free surface is a sum of
    exp(-λx). error: of the sum, over k + γ₁q².
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
    """The poles of a layer under a tension.

    NotCertifiedError if the decays of its free surface are not found.
    """
    h, k, nu = layer.h, layer.shear_modulus / layer.h, layer.nu
    gamma = gamma1 / (k * h**2)  # from here in units of the thickness and the shear modulus
    first, pairs = _own(nu, max(1, round(-math.log10(tolerance) / _DIGITS)))
    real = _others(abs(pairs[-1]) * _BEYOND, gamma * (1 - nu), tolerance)
    furthest = max(_FURTHEST / (tolerance * gamma * (1 - nu)), _FURTHEST)
    samples = min(round(_SAMPLES * (1 - math.log10(tolerance))), _MOST)
    q = np.exp(np.linspace(math.log(_FLATTEST), math.log(furthest), samples))
    s, exact = (q * q)[:, None], relative_stiffness(nu, q)
    size = exact + gamma * q * q
    whole = first * float(relative_stiffness(nu, 0.0)) if first else _FLOW
    both = 2 * s / (s + pairs)
    matrix = np.concatenate([s / (s + np.append(first, real)), both.real, -both.imag], axis=1)
    matrix /= size[:, None]
    scale = np.sqrt((matrix[::2] * matrix[::2]).sum(axis=0))
    wanted = (exact - whole / (q * q + first)) / size
    fitted = lstsq(matrix[::2] / scale, wanted[::2], lapack_driver="gelsy")[0] / scale
    error, (still, *c) = float(np.abs(matrix @ fitted - wanted).max()), fitted.tolist()
    real_c, above = c[: real.size], np.dot([1, 1j], np.reshape(c[real.size :], (2, -1)))
    tau, c = np.array([[*real, *pairs, *pairs.conj()], [*real_c, *above, *above.conj()]])
    flow, first, tau = (whole - first * still) * k / h**2, first / h**2, tau / h**2
    found = Poles(still * k, flow, first, tau, c * k, tau, error)
    return found._replace(decays=_decays(found, gamma1))


def _own(nu: float, pairs: int) -> tuple[float, Complex]:
    """τ of the layer's own poles: the first, 0 for ν = ½, and so many above the real axis."""
    ratio, first = 3 - 4 * nu, 0.0
    if nu < 0.5:  # i y with ratio sin y = y
        low = math.sqrt(6 * (1 - 1 / ratio)) / 2
        first = bracketed(lambda y: ratio * math.sin(y) - y, math.pi, low) ** 2 / 4
    height = (2 * np.arange(1, pairs + 1) + 0.5) * math.pi
    z = np.log(2 * height / ratio) + 1j * height
    for _ in range(_NEWTON):
        z -= (ratio * np.sinh(z) - z) / (ratio * np.cosh(z) - 1)
    return first, (-z * z / 4).conj()


def _others(first: float, gamma: float, tolerance: float) -> Array:
    """Real τ from here to where tension rules; gamma: Γ over the stiffness of a half-space."""
    found, tau, error = [], first, 0.0
    while error < _LEAST:
        error = min(tolerance * (1 + gamma * math.sqrt(tau)), _LEAST)
        step = math.exp(math.pi**2 / math.log(4 / error))
        found.append(tau * math.sqrt(step))
        tau *= step
    return np.array(found)


def _decays(found: Poles, gamma: float) -> Complex:
    """λ with Γμ = k₀ + k₁/(τ₁ - μ) + Σ c μ/(μ - τ), μ = λ²: all zeros at once, by Aberth's method.

    From beside the poles and from the first one alone. O. Aberth, Math. Comp. 27 (1973) 339.
    """
    still, flow, first, tau, c, *_ = found
    side = np.where(tau.imag == 0, 0.5, np.sign(tau.imag))
    mean = math.sqrt((still * first + flow) / gamma)  # of both zeros of the first pole alone
    mu = np.concatenate([tau * 1.05 * np.exp(0.05j * side), mean * np.exp([-0.6j, 0.5j])])
    for _ in range(_ABERTH):
        apart, away = 1 / (mu[:, None] - tau), 1 / (first - mu)
        value = gamma * mu - still - flow * away - mu * (apart @ c)
        rate = gamma - flow * away**2 + apart**2 @ (c * tau)
        others = mu[:, None] - mu
        np.fill_diagonal(others, math.inf)
        step = value / (rate + value * (apart.sum(axis=1) - away - (1 / others).sum(axis=1)))
        mu = mu - step
        if (np.abs(step) <= _STILL * np.abs(mu)).all():
            root = np.sqrt(mu)  # with a positive real part
            return np.where(np.abs(root.imag) <= _REAL * np.abs(root), root.real, root)
    raise NotCertifiedError(
        "the free surface of the layer is not resolved; use another rtol, or response='springs'"
    )
