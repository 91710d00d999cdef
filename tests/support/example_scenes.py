"""Scenes in which no parameter is 1, and profiles with several contacts.

Random scenes with closed forms: studies.shared.random_cases.
"""

import math
from dataclasses import replace

import numpy as np

from energy import ElasticLayer, FlatPunch, Parabola, Profile, Sampled, Scene, SurfaceEnergies


def adhesive(indenter, *, k=130.0, gamma1=0.07, w=0.002, opening=None, slopes="small") -> Scene:
    """A scene in which no parameter is 1; opening: work of adhesion of a contact that opens."""
    scene = Scene(
        ElasticLayer(k * 0.03, 0.0, 0.03), SurfaceEnergies.from_work(gamma1, w), indenter, slopes
    )
    return replace(scene, opening=opening and SurfaceEnergies.from_work(gamma1, opening))


def steep(indenter, ratio=0.3, gamma1=0.07) -> Scene:
    """The same with finite slopes and w/γ₁ = ratio."""
    return adhesive(indenter, gamma1=gamma1, w=ratio * gamma1, slopes="finite")


def turned(indenter, **given) -> Scene:
    """The same with rotational symmetry."""
    return replace(adhesive(indenter, **given), geometry="axisymmetric")


def exact(indenter, nu=0.3, **given):
    """The same with the exact response of a layer of this stiffness."""
    scene = adhesive(indenter, **given)
    E = scene.layer.E * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    return replace(scene, layer=ElasticLayer(E, nu, scene.layer.h, response="layer"))


def plain(indenter, *, w=0.02, gamma1=1.0, length=1.0, stress=1.0, **options) -> Scene:
    """k = γ₁ = l = 1 in units of its length and stress."""
    given = {"k": stress / length, "gamma1": gamma1 * stress * length, "w": w * stress * length}
    return replace(adhesive(indenter, **given, **options), layer=ElasticLayer(stress, 0.0, length))


SCENE = adhesive(Parabola(0.02))
L = SCENE.elastocapillary_length
DELTA0 = SCENE.critical_separation
ALPHA = SCENE.surfaces.small_slope_deficit


def rescaled(scene: Scene, length: float, stress: float) -> Scene:
    """The same scene with `length` and `stress` as the new units' inverse sizes.

    Its profile is given by functions, but for a flat punch and a parabola.
    """
    layer = scene.layer
    s = scene.surfaces
    body = scene.indenter
    tension = stress * length
    if isinstance(body, FlatPunch):
        scaled = FlatPunch(length * body.half_width)
    elif isinstance(body, Parabola):
        scaled = Parabola(length * body.R)
    else:
        scaled = Profile(
            lambda x: length * body.height(np.asarray(x) / length),
            lambda x: body.slope(np.asarray(x) / length),
            tuple(length * end for end in body.extent),
            tuple(length * corner for corner in body.corners),
            body.convex,
            tuple(length * knot for knot in body.knots),
        )
    layer = replace(layer, E=layer.E * stress, h=layer.h * length)
    surfaces = SurfaceEnergies.from_work(s.gamma1 * tension, s.work_of_adhesion * tension)
    return replace(scene, layer=layer, surfaces=surfaces, indenter=scaled)


def roughness(n, longest, shortest, seed=0):
    """Self-affine heights of unit rms: amplitude q^-(1/2+H), H = 0.8, flat above `longest`."""
    q = np.fft.rfftfreq(n)
    amplitude = np.maximum(q, 1 / longest) ** -1.3 * ((q > 0) & (q < 1 / shortest))
    phase = np.exp(2j * np.pi * np.random.default_rng(seed).random(q.size))
    f = np.fft.irfft(amplitude * phase, n)
    return (f - f.min()) / f.std()


def two(c, narrow=0.006, wide=0.01, lift=0.0):
    """Two parabolas with their lowest points at ±c, the left one wider and higher."""

    def height(x):
        return np.minimum((np.asarray(x) - c) ** 2 / narrow, (np.asarray(x) + c) ** 2 / wide + lift)

    def slope(x):
        x = np.asarray(x)
        right = (x - c) ** 2 / narrow < (x + c) ** 2 / wide + lift
        return np.where(right, 2 * (x - c) / narrow, 2 * (x + c) / wide)

    return Profile(height, slope, extent=(-4 * c, 4 * c))


def rippled(R, wave, height, extent=(-math.inf, math.inf)):
    """A parabola with ripples of these wavelength and height."""
    q = 2 * math.pi / wave
    return Profile(
        lambda x: np.square(x) / (2 * R) + height * (1 - np.cos(q * np.asarray(x))),
        lambda x: np.asarray(x) / R + height * q * np.sin(q * np.asarray(x)),
        extent,
    )


def dimple(c=1.2 * L, h=DELTA0):
    """Lowest at r = c: about an axis a ring touches first."""
    return Profile(
        lambda r: h * ((np.asarray(r) / c) ** 2 - 1) ** 2,
        lambda r: h * 4 * np.asarray(r) / c**2 * ((np.asarray(r) / c) ** 2 - 1),
        extent=(0, 4 * c),
    )


def tips(c):
    """Two tips at ±c, of a slope of three times √(2w/γ₁)."""
    return Profile(
        lambda x: 3 * ALPHA * np.abs(np.abs(x) - c),
        lambda x: 3 * ALPHA * np.sign(x) * np.sign(np.abs(x) - c),
        (-2 * c, 2 * c),
        (-c, 0.0, c),
    )


def rough(seed, *, w=0.002, n=801, width=20.0):
    """A self-affine body `width` l wide, of random roughness; its ends are edges."""
    rng = np.random.default_rng(seed)
    shortest = n * 10 ** rng.uniform(-2, -1)
    z = roughness(n, n / 2, shortest, seed) * 10 ** rng.uniform(-0.5, 0.8) * DELTA0
    x = np.linspace(-width / 2, width / 2, n) * L
    return adhesive(Sampled(x, z, kind="smooth") + FlatPunch(0.499 * width * L), w=w)


def wavy(w=0.002, crests=20):
    """Crests 2 l apart of random heights on a shallow bowl."""
    rng = np.random.default_rng(1)
    q = 2 * math.pi / (2 * L)
    bowl = 2 * DELTA0 / (crests * L) ** 2
    waves = [(q, 1.5 * DELTA0, math.pi)]
    waves += [(r * q, 0.15 * DELTA0, rng.uniform(0, 2 * math.pi)) for r in (0.31, 0.17, 0.43)]

    def height(x):
        x = np.asarray(x, float)
        return bowl * x**2 + sum(a * (1 + np.cos(k * x + p)) for k, a, p in waves)

    def slope(x):
        x = np.asarray(x, float)
        return 2 * bowl * x - sum(a * k * np.sin(k * x + p) for k, a, p in waves)

    reach = (crests + 6) * L
    return adhesive(Profile(height, slope, extent=(-reach, reach)), w=w)
