"""The closed forms in 60-digit decimal arithmetic, and how an input's rounding is passed on.

The inputs are the floats of the scene, taken as exact: k = Ẽ/h from (2), (3), w from
(1), f = c|x|ⁿ with whole n, or a flat face. Small slopes:

    f(a) + l f'(a) = d + δ₀ (16),   P = 2k ∫₀ᵃ g dx + 2kl g(a) (11),
    U = 2 ∫₀ᵃ (k/2 g² + γ₁/2 f'² - w) dx + kl g(a)²,   g = d - f;

finite slopes (n = 2): energy.cards.finite with every angle written in square roots. On the lattice:
the sums over a contact of nodes -m..m and the rule by which its line advances.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal, localcontext
from typing import NamedTuple

from scipy.optimize import brentq

from energy import FlatPunch, Parabola, PowerLaw, Scene

DIGITS = 60
_STEP = Decimal("1e-22")
Inputs = Mapping[str, Decimal]


@contextmanager
def precise() -> Iterator[None]:
    """Decimal arithmetic of 60 digits; also a decorator."""
    with localcontext(prec=DIGITS):
        yield


class Exact(NamedTuple):
    """Half-width, force, energy."""

    half_width: Decimal
    force: Decimal
    energy: Decimal


@precise()
def inputs(scene: Scene, depth: float) -> dict[str, Decimal]:
    """k, γ₁, w, d and what the indenter is given by."""
    E, nu, h = map(Decimal, (scene.layer.E, scene.layer.nu, scene.layer.h))
    s = scene.surfaces
    w = (Decimal(s.gamma1) - Decimal(s.gamma12)) + Decimal(s.gamma2)
    k = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / h
    given = {"k": k, "gamma1": Decimal(s.gamma1), "w": w, "d": Decimal(depth)}
    body = scene.indenter
    if isinstance(body, FlatPunch):
        return given | {"a": Decimal(body.half_width)}
    if isinstance(body, Parabola):
        return given | {"c": 1 / (2 * Decimal(body.R)), "n": Decimal(2)}
    if isinstance(body, PowerLaw) and body.n == int(body.n):
        return given | {"c": Decimal(body.c), "n": Decimal(body.n)}
    raise ValueError(f"indenter = {body!r} has no closed form here; use f = c|x|ⁿ with whole n")


@precise()
def answer(given: Inputs, slopes: str) -> Exact | None:
    """a, P, U of the adhered branch; None where it has detached."""
    if slopes == "finite" and "a" not in given:
        return _finite(given)
    k = given["k"]
    w = given["w"]
    d = given["d"]
    if d < -(2 * w / k).sqrt():
        return None
    if "a" not in given:
        return _power(given)
    a = given["a"]
    width = given["a"] + (given["gamma1"] / k).sqrt()
    return Exact(a, 2 * k * d * width, k * d * d * width - 2 * w * a)


@precise()
def from_detachment(given: Inputs) -> float:
    """|d + δ₀|/δ₀."""
    critical = (2 * given["w"] / given["k"]).sqrt()
    return float(abs(given["d"] / critical + 1))


def _power(v: Inputs) -> Exact | None:
    k = v["k"]
    w = v["w"]
    d = v["d"]
    c = v["c"]
    n = v["n"]
    gamma1 = v["gamma1"]
    ell = (v["gamma1"] / k).sqrt()
    excess = d + (2 * w / k).sqrt()
    a = _root(lambda x: c * x**n + ell * _slope(c, n, x) - excess)
    if a is None and d > 0:  # a sharp wedge, pinned at its tip
        a = Decimal(0)
    if a is None:
        return None
    f = c * a**n
    force = 2 * k * (d * a - f * a / (n + 1)) + 2 * k * ell * (d - f)
    squares = d * d * a - 2 * d * f * a / (n + 1) + f * f * a / (2 * n + 1)
    bent = _slope(c, n, a) ** 2 * a / (2 * n - 1)
    energy = k * squares + gamma1 * bent - 2 * w * a + k * ell * (d - f) ** 2
    return Exact(a, force, energy)


def _slope(c: Decimal, n: Decimal, x: Decimal) -> Decimal:
    return c if n == 1 else n * c * x ** (n - 1)


def _finite(v: Inputs) -> Exact | None:
    """Parabola with true lengths."""
    k = v["k"]
    gamma1 = v["gamma1"]
    w = v["w"]
    d = v["d"]
    R = 1 / (2 * v["c"])
    ell = (gamma1 / k).sqrt()
    young = (w / (2 * gamma1)).sqrt()

    def lift(x: Decimal) -> Decimal:
        """-u(a)/2l = sin((π - θ - β)/2), tan β = x/R."""
        t = x / R
        cosine = Decimal(1) / (1 + t * t).sqrt()
        half = t * cosine / (2 * (1 + cosine)).sqrt()  # sin(β/2)
        return young * ((1 + cosine) / 2).sqrt() - (1 - young * young).sqrt() * half

    a = _root(lambda x: x * x / (2 * R) - d - 2 * ell * lift(x))
    if a is None:
        return None
    t = a / R
    s = -lift(a)
    c = (1 - s * s).sqrt()
    force = 2 * k * (d * a - a**3 / (6 * R)) + 4 * gamma1 * s * c
    arc = R / 2 * (t * (1 + t * t).sqrt() + (t + (1 + t * t).sqrt()).ln())
    squares = d * d * a - d * a**3 / (3 * R) + a**5 / (20 * R * R)
    tails = 8 * gamma1 * ell * (1 - c**3) / 3
    return Exact(a, force, k * squares + 2 * (gamma1 - w) * arc - 2 * gamma1 * a + tails)


def _root(h: Callable[[Decimal], Decimal]) -> Decimal | None:
    """Zero of an increasing function on x >= 0: in floats, then by the secant rule."""
    if h(Decimal(0)) > 0:
        return None
    high = Decimal(1)
    while h(high) <= 0:
        high *= 1024
    start = brentq(lambda x: float(h(Decimal(x))), 0, float(high), xtol=1e-200, maxiter=2000)
    x0 = Decimal(start)
    x1 = x0 * (1 + Decimal("1e-15"))
    for _ in range(12):
        h0 = h(x0)
        h1 = h(x1)
        if h0 == h1:
            break
        x0, x1 = x1, x1 - h1 * (x1 - x0) / (h1 - h0)
    return x1


@precise()
def conditions(given: Inputs, slopes: str, scales: Exact) -> tuple[float, float, float]:
    """Σ |p ∂Q/∂p|/scale over the inputs p: by what an input's rounding is magnified."""
    base = answer(given, slopes)
    total = [Decimal(0)] * 3
    assert base is not None
    for name in (name for name in given if name != "n"):
        near = (
            answer({**given, name: given[name] * (1 + step)}, slopes) for step in (_STEP, -_STEP)
        )
        moved = next(filter(None, near), None)
        if moved is None:
            return (float("inf"),) * 3
        for i, (there, here, scale) in enumerate(zip(moved, base, scales, strict=True)):
            total[i] += abs(there - here) / _STEP / abs(scale or Decimal(1))
    a, force, energy = map(float, total)
    return a, force, energy


@precise()
def on_nodes(v: Inputs, spacing: float, m: int) -> tuple[Decimal, Decimal]:
    """Force and energy of the contact set -m..m of a parabola, with exact tails."""
    k = v["k"]
    gamma1 = v["gamma1"]
    w = v["w"]
    d = v["d"]
    dx = Decimal(spacing)
    c = v["c"]
    lam = _decay(v, dx)
    N = Decimal(m)
    squares = N * (N + 1) * (2 * N + 1) / 3
    fourths = N * (N + 1) * (2 * N + 1) * (3 * N * N + 3 * N - 1) / 15
    b = c * dx * dx
    total = (2 * N + 1) * d - b * squares
    quadratic = (2 * N + 1) * d * d - 2 * d * b * squares + b * b * fourths
    odd = 2 * N * (4 * N * N - 1) / 3  # Σ (2i+1)² over the 2m links
    g = d - b * N * N
    energy = k * dx * quadratic / 2 + gamma1 / dx / 2 * b * b * odd - 2 * N * w * dx
    energy += gamma1 / dx * (1 - lam) * g * g
    return k * dx * total + 2 * k * dx * lam / (1 - lam) * g, energy


def _decay(v: Inputs, dx: Decimal) -> Decimal:
    kappa = v["k"] * dx * dx / v["gamma1"]
    return 1 / (1 + kappa / 2 + (kappa + kappa * kappa / 4).sqrt())


@precise()
def resistance(v: Inputs, spacing: float, m: int) -> float:
    """gap/critical gap - 1 of the link m -> m+1: the line advances over it iff that is <= 0."""
    d = v["d"]
    dx = Decimal(spacing)
    c = v["c"]
    lam = _decay(v, dx)
    f = c * (m * dx) ** 2
    beyond = c * ((m + 1) * dx) ** 2
    gap = beyond - f + (1 - lam) * (f - d)
    return float(gap / (dx * (2 * v["w"] * lam / v["gamma1"]).sqrt()) - 1)
