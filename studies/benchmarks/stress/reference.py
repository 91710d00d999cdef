"""The closed forms in 60-digit decimal arithmetic, and how an input's rounding is passed on.

The inputs are the floats of the scene, taken as exact; numbers of equations are those of the paper.
k = Ẽ/h from (2), (3), w = γ₁ - γ₁₂ + γ₂ (1), f = c|x|ⁿ with whole n, or a flat face; l = √(γ₁/k)
and δ₀ = √(2w/k). Small slopes:

    f(a) + l f'(a) = d + δ₀ (16),   P = 2k ∫₀ᵃ g dx + 2kl g(a) (11),
    U = 2 ∫₀ᵃ (k/2 g² + γ₁/2 f'² - w) dx + kl g(a)²,   g = d - f;

finite slopes (n = 2, or a flat face), as energy.cards.finite, with every angle written in square
roots: a free surface that leaves its line inclined by φ has u(a) = 2l sin(φ/2) there, pulls the
indenter up by -γ₁ sin φ, and stores 4γ₁l (1 - cos³(φ/2))/3. On the lattice: the sums over a contact
of nodes -m..m and the rule by which its line advances.

Conventions:

- d and u are positive down into the layer, P where the indenter is pressed; P and U are per length
  of a line contact, U is 0 without contact.
- A mapping of inputs has k, gamma1 γ₁, w and d, and either a, the half-width of a punch, or c and n
  of f = c|x|ⁿ.
- A scene has `gamma1` γ₁.
- `FlatPunch(half_width)` has f = 0 up to its edges; `PowerLaw(c, n)` is f = c|x|ⁿ.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal, localcontext
from typing import NamedTuple

from scipy.optimize import brentq

from energy import FlatPunch, Parabola, PowerLaw, Scene

DIGITS = 60  # almost four times those of a float, so that differences have more than these, too
# Relative change of an input by which its derivative is taken: a third of the digits, so that what
# the difference loses, 1e-38, and what its second order leaves, 1e-22, are both small.
_STEP = Decimal("1e-22")
Inputs = Mapping[str, Decimal]


@contextmanager
def precise() -> Iterator[None]:
    """Decimal arithmetic of 60 digits; also a decorator."""
    with localcontext(prec=DIGITS):
        yield


class Exact(NamedTuple):
    """A state in 60 digits.

    Attributes
    ----------
    half_width, force, energy : Decimal
    """

    half_width: Decimal
    force: Decimal
    energy: Decimal


@precise()
def inputs(scene: Scene, depth: float) -> dict[str, Decimal]:
    """k, γ₁, w, d and what the indenter is given by: a of a punch, or c and n."""
    E = Decimal(scene.layer.E)
    nu = Decimal(scene.layer.nu)
    k = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / Decimal(scene.layer.h)
    gamma1 = Decimal(scene.surfaces.gamma1)
    w = (gamma1 - Decimal(scene.surfaces.gamma12)) + Decimal(scene.surfaces.gamma2)
    given = {"k": k, "gamma1": gamma1, "w": w, "d": Decimal(depth)}
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
    """a, P and U of the adhered branch.

    Parameters
    ----------
    given : mapping
        As `inputs` gives it.
    slopes : {"small", "finite"}

    Returns
    -------
    Exact or None
        None where the contact has detached: a punch lets go at d = -δ₀ with either slopes.

    Raises
    ------
    ValueError
        With finite slopes, for a power other than 2, and for a punch deeper than 2l, the most by
        which a free surface rises.
    """
    is_punch = "a" in given
    if slopes == "finite" and not is_punch:
        return _finite(given)
    critical = (2 * given["w"] / given["k"]).sqrt()
    if given["d"] < -critical:
        return None
    if is_punch:
        return _punch(given) if slopes == "small" else _finite_punch(given)
    return _power(given)


@precise()
def from_detachment(given: Inputs) -> float:
    """|d + δ₀|/δ₀."""
    critical = (2 * given["w"] / given["k"]).sqrt()
    return float(abs(given["d"] / critical + 1))


def _punch(v: Inputs) -> Exact:
    """A flat punch with small slopes, whose line is pinned at its edge."""
    k = v["k"]
    d = v["d"]
    a = v["a"]
    width = a + (v["gamma1"] / k).sqrt()
    return Exact(a, 2 * k * d * width, k * d * d * width - 2 * v["w"] * a)


def _finite_punch(v: Inputs) -> Exact:
    """A flat punch with true lengths: u = d at its edge, at which the line is pinned."""
    k = v["k"]
    gamma1 = v["gamma1"]
    d = v["d"]
    a = v["a"]
    ell = (gamma1 / k).sqrt()
    s = d / (2 * ell)  # sine and cosine of half the inclination of the surface at the line
    if s > 1:
        raise ValueError(f"d = {d} is more than 2l = {2 * ell}; no free surface rises so far")
    c = (1 - s * s).sqrt()
    force = 2 * k * d * a + 4 * gamma1 * s * c
    tails = 8 * gamma1 * ell * (1 - c**3) / 3
    return Exact(a, force, (k * d * d - 2 * v["w"]) * a + tails)


def _power(v: Inputs) -> Exact | None:
    """A power law with small slopes."""
    k = v["k"]
    w = v["w"]
    d = v["d"]
    c = v["c"]
    n = v["n"]
    gamma1 = v["gamma1"]
    ell = (gamma1 / k).sqrt()
    level = d + (2 * w / k).sqrt()
    a = _root(lambda x: c * x**n + ell * _slope(c, n, x) - level)
    if a is None and d <= 0:
        return None
    if a is None:  # a sharp wedge, pinned at its tip
        a = Decimal(0)
    f = c * a**n
    force = 2 * k * (d * a - f * a / (n + 1)) + 2 * k * ell * (d - f)
    squares = d * d * a - 2 * d * f * a / (n + 1) + f * f * a / (2 * n + 1)
    bent = _slope(c, n, a) ** 2 * a / (2 * n - 1)
    energy = k * squares + gamma1 * bent - 2 * w * a + k * ell * (d - f) ** 2
    return Exact(a, force, energy)


def _slope(c: Decimal, n: Decimal, x: Decimal) -> Decimal:
    """f'(x), for x >= 0."""
    return c if n == 1 else n * c * x ** (n - 1)


def _finite(v: Inputs) -> Exact | None:
    """A parabola with true lengths, None where it has detached; needs w <= 2γ₁."""
    if v["n"] != 2:
        raise ValueError(f"n = {v['n']} has no closed form with finite slopes; use a parabola")
    k = v["k"]
    gamma1 = v["gamma1"]
    w = v["w"]
    d = v["d"]
    R = 1 / (2 * v["c"])
    ell = (gamma1 / k).sqrt()
    young = (w / (2 * gamma1)).sqrt()  # cos(θ/2), θ the contact angle: w = γ₁(1 + cos θ)

    def lift(x: Decimal) -> Decimal:
        """-u(x)/2l = sin((π - θ - β)/2) of a line at x; the indenter rises by tan β = x/R."""
        slope = x / R
        cosine = Decimal(1) / (1 + slope * slope).sqrt()
        sine_of_half = slope * cosine / (2 * (1 + cosine)).sqrt()  # sin(β/2)
        cosine_of_half = ((1 + cosine) / 2).sqrt()
        return young * cosine_of_half - (1 - young * young).sqrt() * sine_of_half

    a = _root(lambda x: x * x / (2 * R) - d - 2 * ell * lift(x))
    if a is None:
        return None
    slope = a / R
    s = -lift(a)  # sine and cosine of half the inclination of the surface at the line
    c = (1 - s * s).sqrt()
    force = 2 * k * (d * a - a**3 / (6 * R)) + 4 * gamma1 * s * c
    stretch = (1 + slope * slope).sqrt()
    arc = R / 2 * (slope * stretch + (slope + stretch).ln())
    springs = k * (d * d * a - d * a**3 / (3 * R) + a**5 / (20 * R * R))
    surface = 2 * (gamma1 - w) * arc - 2 * gamma1 * a
    tails = 8 * gamma1 * ell * (1 - c**3) / 3
    return Exact(a, force, springs + surface + tails)


def _root(h: Callable[[Decimal], Decimal]) -> Decimal | None:
    """Zero of an increasing function on x >= 0: in floats, then by the secant rule.

    None where the function is positive from 0 on. Each step of the secant rule adds the digits of
    the step before to its own: four take 15 digits to 60 and more, twelve leave room where the
    floats were worse.
    """
    if h(Decimal(0)) > 0:
        return None
    high = Decimal(1)
    while h(high) <= 0:
        high *= 1024  # three decades a step: ten pass 1e30
    # The absolute tolerance is less than any root, so that the relative one of 4 ε decides. To
    # bisect from 1 down to 1e-200 takes less than 700 steps, three times as many are allowed.
    start = brentq(lambda x: float(h(Decimal(x))), 0, float(high), xtol=1e-200, maxiter=2000)
    x0 = Decimal(start)
    x1 = x0 * (1 + Decimal("1e-15"))  # as far off as the root in floats
    for _ in range(12):
        h0 = h(x0)
        h1 = h(x1)
        if h0 == h1:
            break
        x0, x1 = x1, x1 - h1 * (x1 - x0) / (h1 - h0)
    return x1


@precise()
def conditions(given: Inputs, slopes: str, scales: Exact) -> tuple[float, float, float]:
    """By how much the rounding of the inputs p is magnified, Σ |p ∂Q/∂p|/scale.

    The power n is left out, as a whole number has no rounding.

    Parameters
    ----------
    given : mapping
        As `inputs` gives it.
    slopes : {"small", "finite"}
    scales : Exact
        What errors of a, P and U are measured by. A scale that is 0, as that of the width of a
        wedge pinned at its tip, is replaced by 1 in the unit of the scene: its error is 0, too,
        unless an input moves the line off the tip.

    Returns
    -------
    tuple of three floats
        Of a, P and U; inf where the contact detaches with an input changed by 1e-22 of it to
        either side.
    """
    base = answer(given, slopes)
    assert base is not None
    totals = [Decimal(0)] * 3
    for name in given:
        if name == "n":
            continue
        moved = _moved(given, slopes, name)
        if moved is None:
            return (float("inf"),) * 3
        for i, (there, here, scale) in enumerate(zip(moved, base, scales, strict=True)):
            totals[i] += abs(there - here) / _STEP / abs(scale or Decimal(1))
    a, force, energy = map(float, totals)
    return a, force, energy


def _moved(given: Inputs, slopes: str, name: str) -> Exact | None:
    """The state with one input a little larger, or smaller where that has detached."""
    larger = answer({**given, name: given[name] * (1 + _STEP)}, slopes)
    if larger is not None:
        return larger
    return answer({**given, name: given[name] * (1 - _STEP)}, slopes)


@precise()
def on_nodes(v: Inputs, spacing: float, m: int) -> tuple[Decimal, Decimal]:
    """Force and energy of the contact set -m..m of a parabola, with exact tails.

    Parameters
    ----------
    v : mapping
        As `inputs` gives it.
    spacing : float
        Distance of the nodes Δx.
    m : int
        The last contact node. Adhesion counts the 2m links between contact nodes.

    Returns
    -------
    force, energy : Decimal
    """
    k = v["k"]
    gamma1 = v["gamma1"]
    d = v["d"]
    dx = Decimal(spacing)
    b = v["c"] * dx * dx  # f = b i² at node i
    lam = _decay(v, dx)
    N = Decimal(m)
    squares = N * (N + 1) * (2 * N + 1) / 3  # Σ i² over the nodes -m..m
    fourths = N * (N + 1) * (2 * N + 1) * (3 * N * N + 3 * N - 1) / 15  # Σ i⁴
    odd_squares = 2 * N * (4 * N * N - 1) / 3  # Σ (2i+1)² over the 2m links
    displacements = (2 * N + 1) * d - b * squares
    displacements2 = (2 * N + 1) * d * d - 2 * d * b * squares + b * b * fourths
    at_line = d - b * N * N
    force = k * dx * displacements + 2 * k * dx * lam / (1 - lam) * at_line
    springs = k * dx * displacements2 / 2
    surface = gamma1 / dx / 2 * b * b * odd_squares
    adhesion = 2 * N * v["w"] * dx
    tails = gamma1 / dx * (1 - lam) * at_line * at_line
    return force, springs + surface - adhesion + tails


def _decay(v: Inputs, dx: Decimal) -> Decimal:
    """By how much a free surface decays from node to node, λ."""
    kappa = v["k"] * dx * dx / v["gamma1"]
    return 1 / (1 + kappa / 2 + (kappa + kappa * kappa / 4).sqrt())


@precise()
def resistance(v: Inputs, spacing: float, m: int) -> float:
    """The gap over the critical one, minus 1, of the link m -> m+1.

    The line advances over the link where this is <= 0. Then the energy γ₁ gap²/(2λ Δx) that it
    takes to close the gap, with the free surface beyond it in equilibrium, is at most w Δx.

    Parameters
    ----------
    v : mapping
        As `inputs` gives it.
    spacing : float
        Distance of the nodes Δx.
    m : int
        The last contact node.

    Returns
    -------
    float
    """
    dx = Decimal(spacing)
    lam = _decay(v, dx)
    f = v["c"] * (m * dx) ** 2
    f_beyond = v["c"] * ((m + 1) * dx) ** 2
    gap = f_beyond - f + (1 - lam) * (f - v["d"])
    critical = dx * (2 * v["w"] * lam / v["gamma1"]).sqrt()
    return float(gap / critical - 1)
