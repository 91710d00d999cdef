"""Finite slopes with rotational symmetry: the Young-Laplace equation integrated from far away.

In units of l, with h = |u|/l and S the sine of the surface's inclination, the surface outside a
line is the solution of

    dh/dr = −S/√(1 − S²),    d(rS)/dr = −r h,

that decays. It is followed inwards from where it is as small as 1e-8, and the linear one, h ∝ K₀(r)
to rounding; its amplitude there is such that S = sin φ at the line. Energies are over 2πγ₁l².
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import i0e, i1e, k0e, k1e

FAINT = 1e-8  # height over l from which on the linear solution is exact to rounding, 1e-16
RTOL = 3e-14  # of the integration: some roundings
ROUGHLY = 1e-8  # of the integration that gives a first guess
BESIDE = 1e-6  # around that guess, in the logarithm of the amplitude


class Surface(NamedTuple):
    """A free surface from its line: |u_a|/l, energy over 2πγ₁l², and the solution h, S over r."""

    height: float
    energy: float
    inclination: float
    solution: object


def outside(radius, phi, rtol=RTOL):
    """The surface outside a line of this radius (over l), inclined there by 0 < φ < π/2."""
    most = phi / k1e(radius)  # φ > sin φ bounds the amplitude from above, but for some curvature
    far = radius + brentq(lambda x: np.log(most * k1e(radius + x) / FAINT) - x, 0.0, 60.0)

    @functools.cache
    def followed(amplitude, rtol):
        return _integrated(far, radius, _faint(amplitude, far, radius), rtol)

    def excess(log_amplitude, rtol=rtol):
        run = followed(np.exp(log_amplitude), rtol)
        return 1.0 if run.status == 1 else run.y[1, -1] - np.sin(phi)

    start = np.log(most)
    near = brentq(excess, start - 3.0, start + 0.5, args=(ROUGHLY,), xtol=1e-9)
    ends = near - BESIDE, near + BESIDE
    if rtol < ROUGHLY and (excess(ends[0]) > 0 or excess(ends[1]) < 0):
        ends = start - 3.0, start + 0.5
    root = near if rtol >= ROUGHLY else brentq(excess, *ends, xtol=1e-15, rtol=1e-15)
    run = followed(np.exp(root), rtol)
    return Surface(float(run.y[0, -1]), float(run.y[2, -1]), phi, run)


class Lines(NamedTuple):
    """Lines at which surfaces rest: radii over l, φ > 0, |u|/l, and energies over 2πγ₁l²."""

    radius: np.ndarray
    inclination: np.ndarray
    height: np.ndarray
    energy: np.ndarray


def lines_of_a_surface(side, radius, phi):
    """The lines at which one surface could rest, about as inclined as φ at this radius.

    A surface outside a line (side 1), or on the disc inside one (-1), is also that of each line on
    its way. Followed from where it is faint, nothing has to be sought.
    """
    if side > 0:
        most = phi / k1e(radius)
        far = radius + brentq(lambda x: np.log(most * k1e(radius + x) / FAINT) - x, 0.0, 60.0)
        run = _integrated(far, radius, _faint(most, far, radius), RTOL)
        r = np.exp(run.t) if radius < 1 else radius + run.t
    else:
        run = _integrated_on_a_disc(radius, phi)
        r = np.exp(run.t)
    height, sine, energy = run.y
    return Lines(r, np.arcsin(np.minimum(sine, 1.0)), height, energy)


def _integrated_on_a_disc(radius, phi):
    """From the linear solution, h ∝ I₀(r), far inside to the line, in ln r."""
    start = max(radius - 20.0, 1e-8 * min(radius, 1.0))
    sine = phi * i1e(start) / i1e(radius) * math.exp(start - radius)
    height = sine * i0e(start) / i1e(start)

    def slopes(x, y):
        r = math.exp(x)
        h, s, _ = y.tolist()
        c = math.sqrt(max(1 - s * s, 1e-6))
        return [s / c * r, r * h - s, r * r * (h * h / 2 + s * s / (1 + c) / c)]

    def overhangs(x, y):
        return 0.9999 - abs(y[1])

    overhangs.terminal = True
    faint = [height, sine, start * height * sine / 2]
    span = math.log(start), math.log(radius)
    return solve_ivp(slopes, span, faint, method="DOP853", rtol=RTOL, atol=1e-30, events=overhangs)


def _faint(amplitude, far, radius):
    """h, S and energy of A K₀(r) beyond `far`: ½ r h S."""
    fall = amplitude * np.exp(radius - far)
    h = fall * k0e(far)
    s = fall * k1e(far)
    return [h, s, far * h * s / 2]


def _integrated(far, radius, start, rtol):
    """From far to the line, in ln r where the line is narrow; the event: it would overhang."""
    narrow = radius < 1

    def slopes(x, y):
        r = math.exp(x) if narrow else radius + x
        rate = r if narrow else 1.0  # dr/dx
        h, s, _ = y.tolist()
        c = math.sqrt(max(1 - s * s, 1e-6))
        energy = -r * (h * h / 2 + s * s / (1 + c) / c)
        return [-s / c * rate, -(h + s / r) * rate, energy * rate]

    def overhangs(x, y):
        return 0.9999 - abs(y[1])

    overhangs.terminal = True
    span = (np.log(far), np.log(radius)) if narrow else (far - radius, 0.0)
    return solve_ivp(slopes, span, start, method="DOP853", rtol=rtol, atol=1e-30, events=overhangs)


def quadrature(f, a):
    """Gauss points and weights on [0, a], between corners and knots, graded towards both ends."""
    halves = 0.5 ** np.arange(1, 20)
    inner = [x for x in (*f.corners, *f.knots) if 0 < x < a]
    cuts = np.unique(np.concatenate([[0, a], a * halves, a * (1 - halves), inner]))
    t, dt = np.polynomial.legendre.leggauss(30)
    half = np.diff(cuts)[:, None] / 2
    return (cuts[:-1, None] + half * (1 + t)).ravel(), (half * dt).ravel()


class State(NamedTuple):
    """An equilibrium with one contact around the axis."""

    depth: float
    force: float
    energy: float


def state(scene, a, rtol=RTOL):
    """The state of a scene with finite slopes whose contact line rests at the radius a.

    Young's law gives the inclination of the surface, φ = π − θ − atan f'(a), upwards to the line
    where it is positive; ValueError where that is no graph.
    """
    k = scene.stiffness
    gamma1 = scene.gamma1
    w = scene.work_of_adhesion
    f = scene.indenter
    ell = scene.elastocapillary_length
    phi = scene.surfaces.angle_deficit - np.arctan(float(f.slope(a)))
    if abs(phi) >= np.pi / 2:
        raise ValueError(f"a = {a!r}: the surface would overhang, φ = {phi!r}")
    free = outside(a / ell, abs(phi), rtol)
    u_a = -np.sign(phi) * free.height * ell
    d = float(f.height(a)) + u_a

    r, dr = quadrature(f, a)
    g = d - f.height(r)
    arc = np.hypot(1, f.slope(r))
    pressed = k * g @ (r * dr)
    stored = (k / 2 * g**2 + (gamma1 - w) * arc - gamma1) @ (r * dr)
    force = 2 * np.pi * (pressed - a * gamma1 * np.sin(phi))
    energy = 2 * np.pi * (stored + gamma1 * ell**2 * free.energy)
    return State(d, force, energy)
