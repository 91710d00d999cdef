"""The stiffness of a bonded layer as a sum of poles, to a tolerance.

With s = q²,

    k(s) = k₀ + k₁/s + Σ c_j s/(s + τ_j),

k₀ that of q = 0 and k₁ = 0; an incompressible layer flows sideways instead, k₁ = 3G/h³ and k₀
fitted. The first poles are the layer's own: k is infinite where (3 - 4ν) sinh z = z, s = z²/4h².
The others are real, in steps as far apart as the tolerance allows where tension has not yet taken
over from the layer, k < γ₁q² times the tolerance: a sum over poles in steps of a factor e^h is off
by 4 exp(-π²/h). The c_j are those of least squares of the error relative to k + γ₁q².

A sum that is bounded for q -> ∞ leaves to tension alone what happens at a contact line: there the
displacement has a kink, and nothing of the layer may compete with γ₁u'².
"""

from __future__ import annotations

import cmath
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.roots import bracketed
from energy import ElasticLayer
from energy.layer import relative_stiffness

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
FLOW = 3.0  # k₁ of an incompressible layer, over G/h³
_DIGITS = 2.0  # of the tolerance that one of the layer's own pairs of poles is good for
_BEYOND = 1.5  # times the last of them, where the others begin
_LEAST = 0.3  # of k: an error that may be, where tension rules
_SAMPLES = 1401  # of q; fitted to every second one, the error looked at on all
_FLATTEST, _FURTHEST = 5e-4, 1e3  # qh of the first; of the last, times where tension rules
_NEWTON, _ABERTH = 50, 100
# of a decay squared: a step of Aberth's method that is rounding if it shrinks no more
_STILL = 1e-9
_REAL = 1e-13  # of a decay: an imaginary part that is rounding
_UNRESOLVED = (
    "the free surface of the layer is not resolved; use another rtol, or response='springs'"
)


class Poles(NamedTuple):
    """k₀, k₁, τ (n,), c (n,), and what these make of a free surface.

    decays (n + 1 or n + 2,): λ with k(-λ²) = γ₁λ², real parts positive: a free surface is a sum of
    exp(-λx). τ and decays are sorted as `paired` says. error: of the sum, over k + γ₁q².
    """

    still: float
    flow: float
    tau: Complex
    c: Complex
    decays: Complex
    error: float

    @property
    def share(self) -> Complex:
        """φ_j over u (n, m) of what decays by each λ: τ/(τ - λ²)."""
        return np.asarray(self.tau[:, None] / (self.tau[:, None] - self.decays**2))

    def stiffness(self, s: Array) -> Array:
        """k(s)."""
        poles = (s[:, None] / (s[:, None] + self.tau) @ self.c).real
        return np.asarray(self.still + self.flow / s + poles)


def paired(real: Callable[[Any], Any], pairs: Callable[[Any], Any], z: Complex) -> Complex:
    """A function of z (n, ...), for real ones, and for those above the real axis.

    Along the first axis z are real, then above the real axis, then their conjugates.
    """
    side = z.reshape(z.shape[0], -1).imag.sum(axis=1)
    n, m = int((side == 0).sum()), int((side > 0).sum())
    above = pairs(z[n : n + m])
    return np.concatenate([real(z[:n].real), above, above.conj()])


@functools.lru_cache(maxsize=32)
def poles(layer: ElasticLayer, gamma1: float, tolerance: float) -> Poles:
    """The poles of a layer under a tension.

    NotCertifiedError if the decays of its free surface are not found.
    """
    stress, h = layer.shear_modulus, layer.h
    found = _relative(layer.nu, gamma1 / (stress * h), tolerance)
    stiff, flow = stress / h, stress / h**3
    tau, decays, c = found.tau / h**2, found.decays / h, found.c * stiff
    return Poles(found.still * stiff, found.flow * flow, tau, c, decays, found.error)


def _relative(nu: float, gamma: float, tolerance: float) -> Poles:
    """The poles in units of the thickness and the shear modulus, γ₁ = Γ."""
    first, *own = _own(nu, max(1, round(-math.log10(tolerance) / _DIGITS)))
    others = _others(abs(own[-1]) * _BEYOND, gamma * (1 - nu), tolerance)
    real, pairs = np.array([first.real, *others][int(nu == 0.5) :]), np.array(own)
    furthest = max(_FURTHEST / (tolerance * gamma * (1 - nu)), _FURTHEST)
    q = np.geomspace(_FLATTEST, furthest, _SAMPLES)
    exact = relative_stiffness(nu, q)
    size = exact + gamma * q * q
    half = slice(None, None, 2)
    still, c = _fitted(nu, real, pairs, q[half], exact[half], size[half])
    tau, flow = np.concatenate([real, pairs, pairs.conj()]), FLOW if nu == 0.5 else 0.0
    found = Poles(still, flow, tau, c, np.empty(0, complex), math.inf)
    error = float((np.abs(found.stiffness(q * q) - exact) / size).max())
    return found._replace(decays=_sorted(_decays(found, gamma)), error=error)


def _own(nu: float, pairs: int) -> list[complex]:
    """τ of the layer's own poles: a real one, 0 for ν = ½, and so many above the real axis."""
    ratio = 3 - 4 * nu
    first = 0.0
    if nu < 0.5:  # i y with ratio sin y = y
        low = math.sqrt(6 * (1 - 1 / ratio)) / 2
        first = bracketed(lambda y: ratio * math.sin(y) - y, math.pi, low) ** 2 / 4
    found = [complex(first)]
    for n in range(1, pairs + 1):
        height = (2 * n + 0.5) * math.pi
        z = complex(math.log(2 * height / ratio), height)
        for _ in range(_NEWTON):
            step = (ratio * cmath.sinh(z) - z) / (ratio * cmath.cosh(z) - 1)
            z -= step
            if abs(step) <= 1e-15 * abs(z):
                break
        tau = -z * z / 4
        found.append(complex(tau.real, abs(tau.imag)))
    return found


def _others(first: float, gamma: float, tolerance: float) -> list[float]:
    """Real τ from here to where tension rules; gamma: Γ over the stiffness of a half-space."""
    found, tau, error = [], first, 0.0
    while error < _LEAST:
        error = min(tolerance * (1 + gamma * math.sqrt(tau)), _LEAST)
        step = math.exp(math.pi**2 / math.log(4 / error))
        found.append(tau * math.sqrt(step))
        tau *= step
    return found


def _fitted(
    nu: float, real: Array, pairs: Complex, q: Array, exact: Array, size: Array
) -> tuple[float, Complex]:
    """k₀ and c of poles; size: over which k is fitted at q."""
    s = (q * q)[:, None]
    both = 2 * s / (s + pairs)
    columns = [s / (s + real), both.real, -both.imag]
    still, wanted = 0.0, exact - FLOW / (q * q)
    if nu < 0.5:
        still = float(relative_stiffness(nu, 0.0))
        wanted = exact - still
    else:
        columns.append(np.ones((q.size, 1)))
    matrix = np.concatenate(columns, axis=1) / size[:, None]
    scale = np.sqrt((matrix * matrix).sum(axis=0))
    found = np.linalg.lstsq(matrix / scale, wanted / size, rcond=None)[0] / scale
    if nu == 0.5:
        still = float(found[-1])
    n, m = real.size, pairs.size
    above = found[n : n + m] + 1j * found[n + m : n + 2 * m]
    return still, np.concatenate([found[:n], above, above.conj()])


def _sorted(decays: Complex) -> Complex:
    """Real ones, those above the real axis, and their conjugates."""
    real = np.abs(decays.imag) <= _REAL * np.abs(decays)
    above = decays[~real & (decays.imag > 0)]
    if decays.size != real.sum() + 2 * above.size:
        raise NotCertifiedError(_UNRESOLVED)
    return np.concatenate([decays[real].real, above, above.conj()])


def _decays(found: Poles, gamma: float) -> Complex:
    """λ with Γμ = k₀ - k₁/μ + Σ c μ/(μ - τ), μ = λ²: all zeros at once, by Aberth's method.

    O. Aberth, Mathematics of Computation 27 (1973) 339.
    """
    side = np.where(found.tau.imag == 0, 0.5, np.sign(found.tau.imag))
    more = [found.still / gamma * (0.9 + 0.05j)] if not found.flow else [0.1 - 0.5j, 0.1 + 0.6j]
    mu = np.concatenate([found.tau * 1.05 * np.exp(0.05j * side), more])
    last = math.inf
    for _ in range(_ABERTH):
        apart = 1 / (mu[:, None] - found.tau)
        value = gamma * mu - found.still + found.flow / mu - (found.c * mu[:, None] * apart).sum(1)
        rate = gamma - found.flow / mu**2 + (found.c * found.tau * apart**2).sum(axis=1)
        others = mu[:, None] - mu
        np.fill_diagonal(others, math.inf)
        pull = apart.sum(axis=1) - (1 / others).sum(axis=1)
        pull = pull + 1 / mu if found.flow else pull
        step = value / (rate + value * pull)
        mu = mu - step
        now, before = float(np.abs(step / mu).max()), last
        last = now
        if before / 2 <= now <= _STILL:
            root = np.sqrt(mu)
            return np.where(root.real < 0, -root, root)
    raise NotCertifiedError(_UNRESOLVED)
