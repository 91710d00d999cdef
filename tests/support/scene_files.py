"""Texts of scene files, and the scene that one of them means."""

import re

import pytest

from energy import ElasticLayer, Scene, SurfaceEnergies

TEXT = """
title = "A test"
source = "nowhere"
depth = [2e-6, 0.0, -4e-5]

[layer]
E = 2e3
nu = 0.31
h = 60e-6

[surfaces]
gamma1 = 0.05
gamma2 = 0.03
gamma12 = 0.0791

[indenter]
shape = "parabola"
R = 0.017

[options]
rtol = 1e-6
"""
INDENTER = 'shape = "parabola"\nR = 0.017'
SURFACES = "gamma2 = 0.03\ngamma12 = 0.0791"
DEPTH = "depth = [2e-6, 0.0, -4e-5]"


def writer(path, text=TEXT):
    """A function that writes the text with replacements (old, new) to the file; its path."""

    def write(*changes):
        changed = text
        for old, new in changes:
            assert changed.count(old) == 1, old
            changed = changed.replace(old, new)
        path.write_text(changed, "utf-8")
        return path

    return write


def refused(path, told):
    """pytest.raises of a ValueError that begins with the file and goes on with a pattern."""
    return pytest.raises(ValueError, match=f"^{re.escape(str(path))}: {told}")


def by_hand(indenter, layer=None, **options):
    surfaces = SurfaceEnergies(0.05, 0.03, 0.0791)
    return Scene(layer or ElasticLayer(2e3, 0.31, 60e-6), surfaces, indenter, **options)


FIT_SCENE = """
depth = 0
[layer]
E = 50.0
nu = 0.45
h = 5e-6
[surfaces]
gamma1 = 0.1
w = 1.5e-6
[indenter]
shape = "parabola"
R = 0.05
"""
SPHERE = """
depth = 50e-9
[layer]
E = 30e3
nu = 0.45
h = 0.3e-6
[surfaces]
gamma1 = 0.045
w = 0.7e-4
[indenter]
shape = "sphere"
R = 5e-6
[options]
geometry = "axisymmetric"
"""
