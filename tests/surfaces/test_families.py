"""The families of free surfaces about an axis: what is shipped of them, and how good they are."""

import math
import tomllib

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebpts1, chebval
from support.repository import ROOT
from truth import meniscus

from discretization import NotCertifiedError
from discretization.surfaces import menisci, network, rings
from discretization.surfaces.tables import FAMILIES, pieces

EPSILON = float(np.finfo(float).eps)
# A piece is solved for with other instructions on another processor: measured 17 at most.
ROUNDINGS = 64
# Of the first piece on discs: they are displaced by the 1/s-fold of what bends them, and steep ones
# had 15 000.
NARROW = 1 / menisci.LEAST_RADIUS[-1]
ALL = [(family, kind) for family in FAMILIES for kind in family.shipped]
NAMES = [family.key(kind) for family, kind in ALL]


def roundings(family, kind, found, made):
    """How many roundings of the largest coefficient or value two arrays (pieces, n, values) differ.

    Over what is allowed; coefficients over inclinations belong together.
    """
    count = menisci._PIECE.inclinations if family is menisci.FAMILY else 1
    found, made = (part.reshape(*part.shape[:2], -1, count) for part in (found, made))
    size = np.abs(made).max(axis=(1, 3), keepdims=True)
    allowed = np.full(len(made), float(ROUNDINGS))
    if family is menisci.FAMILY and kind < 0:
        allowed[0] = NARROW
    return (np.abs(found - made) / size).max(axis=(1, 2, 3)) / EPSILON / allowed


def at_points(family, kind, table, count=2):
    """The polynomials and what they stand for, at some of the points that they go through."""
    rng = np.random.default_rng(7)
    t = chebpts1(family.points)
    own = np.array([rng.choice(family.points, count, replace=False) for _ in table])
    numbers = np.array(family.shipped[kind])[:, None]
    s = 2.0 ** (family.octaves * (numbers + (t[own] + 1) / 2))
    solved = family.solve(kind, s.ravel()).reshape(*s.shape, family.values)
    read = np.array([chebval(t[at], part).T for at, part in zip(own, table, strict=True)])
    return read, solved


@pytest.mark.parametrize(("family", "kind"), ALL, ids=NAMES)
def test_what_is_shipped_goes_through_what_is_solved_for(family, kind):
    """In every piece; and a wrong coefficient shows."""
    table = network.tables()[family.key(kind)]
    assert table.shape == (len(family.shipped[kind]), family.points, family.values)
    assert table.dtype == float
    read, solved = at_points(family, kind, table)
    assert roundings(family, kind, read, solved).max() <= 1
    wrong = table.copy()
    wrong[:, 3, 0] += 1e-9 * np.abs(table[:, :, 0]).max(axis=1)
    read = at_points(family, kind, wrong)[0]
    assert roundings(family, kind, read, solved).min() > 1


@pytest.mark.parametrize(
    "family", [rings.FAMILY, pytest.param(menisci.FAMILY, marks=pytest.mark.slow)]
)
def test_what_is_shipped_is_what_the_script_makes(family):
    made = pieces(family)
    assert made.keys() == {family.key(kind) for kind in family.shipped}
    for kind in family.shipped:
        table = network.tables()[family.key(kind)]
        assert roundings(family, kind, table, made[family.key(kind)]).max() <= 1


def test_nothing_else_is_shipped():
    assert sorted(network.tables()) == sorted(NAMES)


def test_the_file_is_part_of_the_distributions():
    """What .gitignore names is left out of both; .ci/run reads the file out of a built wheel."""
    targets = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["build"]
    wheel = targets["targets"]["wheel"]
    path = network.TABLES.relative_to(ROOT)
    assert path.parts[0] in wheel["packages"]
    assert targets["targets"].keys() == {"wheel"}
    left_out = [*wheel["exclude"], *(ROOT / ".gitignore").read_text("utf-8").split()]
    assert not any(
        place.match(rule.strip("/")) for rule in left_out for place in (path, *path.parents)
    )


def test_pieces_beyond_those_shipped_are_solved_for(monkeypatch):
    """And those that are shipped are not."""
    solved = []

    def solve(kind, s):
        solved.append(kind)
        return np.ones((s.size, 1))

    shipped = {1: rings.FAMILY.shipped[1]}
    family = network.Family("rings", solve, 1, rings.FAMILY.points, 3.0, shipped)
    within = 2.0 ** (3.0 * np.array([shipped[1].start + 0.5, shipped[1].stop - 0.5]))
    family.at(1.0, within)  # sides of several lines are floating-point numbers at times
    assert not solved
    assert family.at(1, within * 2.0 ** (3 * len(shipped[1])))[:, 0] == pytest.approx([1, 1])
    assert solved == [1, 1]


# Of pieces on discs between l and 8 l with 20 points in radius: measured 2.2e-11.
TRUNCATED = 4e-11


@pytest.mark.parametrize(("side", "allowed"), [(1, 2e-13), (-1, TRUNCATED)])
def test_the_menisci_are_those_of_young_and_laplace(side, allowed):
    """At random radii and inclinations, against an integration that shares nothing."""
    rng = np.random.default_rng(5)
    compared = 0
    least, most = (menisci._SOLVED, 2.0**9) if side > 0 else (menisci.LEAST_RADIUS[-1], 2.0**7)
    for radius in np.exp(rng.uniform(math.log(least), math.log(most), 20)):
        lines = meniscus.lines_of_a_surface(side, radius, rng.uniform(0.05, 1.5))
        r = lines.radius
        phi = lines.inclination
        own = (r >= least) & (phi > 0.01) & (phi < menisci.STEEPEST)
        u, energy = menisci.read(np.full(own.sum(), side), r[own], phi[own])
        assert u == pytest.approx(lines.height[own], rel=allowed, abs=0)
        assert energy * r[own] == pytest.approx(lines.energy[own], rel=allowed, abs=0)
        compared += own.sum()
    assert compared > 500


@pytest.mark.parametrize("sine", [2.0, 1e200])
def test_a_meniscus_without_equilibrium_raises(sine):
    """No surface pulls with sin φ > 1: U falls without end, or its Hessian overflows."""
    given = 1, np.array([1.0]), np.array([sine]), 2
    with np.errstate(all="ignore"), pytest.raises(NotCertifiedError, match="no free surface was"):
        menisci.solve(*given)
