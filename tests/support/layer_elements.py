"""A bonded elastic layer resolved through its thickness by finite elements: a truth of its own.

Biquadratic elements on a grid that is graded towards the contact line, half of a line contact or a
section through an axis; the base is fixed, the top without shear stress, its surface tension a sum
over the top edges, and nodes in contact are prescribed. With the line at a node the least energy is
a quadratic form of the depth; where the line rests follows from how it changes with the place of
the line, and nothing is used of Fourier's kernel, of poles, or of the angle at the line.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
SHAPES = np.array([POINTS * (POINTS - 1) / 2, 1 - POINTS**2, POINTS * (POINTS + 1) / 2])
SLOPES = np.array([POINTS - 0.5, -2 * POINTS, POINTS + 0.5])
AROUND = 0.04 * np.arange(-2, 3)  # places of the line around the one that is wanted, over it
HALVINGS = 9  # of elements towards the line
FAR = 14  # thicknesses of layer beside the line


@dataclass(frozen=True)
class Line:
    """A line contact, mirrored about x = 0."""

    whole = 2.0
    turned = False

    def area(self, a):
        return 2 * a


@dataclass(frozen=True)
class Axis:
    """A contact about an axis."""

    whole = 2 * math.pi
    turned = True

    def area(self, a):
        return math.pi * a * a


def halved(length, times):
    """0, and places up to a length, the first steps halved so often."""
    return np.concatenate([[0.0], length * 0.5 ** np.arange(times, -1, -1)])


def split(ends, parts):
    """Every interval in so many parts, and the midpoints of these: nodes."""
    return np.interp(
        np.arange(0, 2 * parts * (ends.size - 1) + 1) / (2 * parts), np.arange(ends.size), ends
    )


def sums(nodes, measure, left, right):
    """∫ left right m dx of all pairs of shape functions, of which SHAPES or SLOPES are given."""
    elements = (nodes.size - 1) // 2
    middle = nodes[1::2]
    half = (nodes[2::2] - nodes[:-1:2]) / 2
    weights = measure(middle[:, None] + half[:, None] * POINTS) * WEIGHTS
    power = 1 - (left is SLOPES) - (right is SLOPES)
    values = np.einsum("ip,jp,ep->eij", left, right, weights) * half[:, None, None] ** power
    own = 2 * np.arange(elements)[:, None] + np.arange(3)
    rows = np.repeat(own, 3, axis=1).ravel()
    columns = np.tile(own, 3).ravel()
    return sparse.csr_matrix((values.ravel(), (rows, columns)), shape=(nodes.size,) * 2)


def stiffness(geometry, nu, gamma, x, y):
    """K of the displacements along x and downwards at nodes (x, y), y first; shear modulus 1."""
    first = 2 * nu / (1 - 2 * nu)
    whole = first + 2

    def m(z):
        return z if geometry.turned else np.ones_like(z)

    def one(z):
        return np.ones_like(z)

    kx, mx, gx = (
        sums(x, m, *pair) for pair in ((SLOPES, SLOPES), (SHAPES, SHAPES), (SLOPES, SHAPES))
    )
    ky, my, gy = (
        sums(y, one, *pair) for pair in ((SLOPES, SLOPES), (SHAPES, SHAPES), (SLOPES, SHAPES))
    )
    sideways = whole * sparse.kron(kx, my) + sparse.kron(mx, ky)
    both = first * sparse.kron(gx, gy.T) + sparse.kron(gx.T, gy)
    if geometry.turned:  # the strain along circles, u/r
        ring = sums(x, lambda r: 1 / r, SHAPES, SHAPES)
        across = sums(x, one, SLOPES, SHAPES)
        sideways = sideways + whole * sparse.kron(ring, my)
        sideways = sideways + first * sparse.kron(across + across.T, my)
        both = both + first * sparse.kron(sums(x, one, SHAPES, SHAPES), gy.T)
    top = sparse.csr_matrix(([1.0], ([0], [0])), shape=(y.size,) * 2)
    down = whole * sparse.kron(mx, ky) + sparse.kron(kx, my) + gamma * sparse.kron(kx, top)
    return sparse.bmat([[sideways, both], [both.T, down]], format="csc")


def quadratic(geometry, nu, gamma, heights, a, parts):
    """A, B, C of the energy A d²/2 + B d + C/2 without adhesion, with the line at a, of each body.

    The layer is the same under all of them, and so is what K has to be solved for.
    """
    graded = halved(1.0, HALVINGS)
    inside = a - a * graded[::-1]
    outside = np.concatenate([graded, 1 + np.arange(1, FAR)])
    x = split(np.concatenate([inside, a + outside[1:]]), parts)
    y = split(graded, parts)

    # numbers of the unknowns: along x and downwards, at each node
    number = np.arange(2 * x.size * y.size).reshape(2, x.size, y.size)
    in_contact = number[1, : 2 * parts * (inside.size - 1) + 1, 0]
    base = number[:, :, -1].ravel()
    middle = number[0, 0]  # where nothing moves sideways
    free = np.setdiff1d(number.ravel(), np.concatenate([base, middle, in_contact]))

    # displacements of the contact: those of a depth of 1, and those of each body
    contact = x[: in_contact.size]
    prescribed = np.column_stack([np.ones_like(contact), *(-height(contact) for height in heights)])
    k = stiffness(geometry, nu, gamma, x, y)
    forces = k[:, in_contact] @ prescribed
    moved = splu(k[free][:, free]).solve(-forces[free])
    reactions = forces[in_contact] + k[in_contact][:, free] @ moved
    form = prescribed.T @ reactions * geometry.whole
    return [(form[0, 0], form[0, i], form[i, i]) for i in range(1, 1 + len(heights))]


def rests(geometry, nu, gamma, heights, a, works, parts):
    """Where a line rests at a: depth, force and energy for each body and work of adhesion.

    A line that moves by da changes the energy by U' da; at rest U' = 0, the lower of two depths.
    """
    places = [quadratic(geometry, nu, gamma, heights, a * (1 + t), parts) for t in AROUND]
    return [_of_body(np.array(forms), geometry, a, works) for forms in zip(*places, strict=True)]


def _of_body(forms, geometry, a, works):
    """The same of one body, from A, B, C at the places around a."""
    # A', B' and C' by the place of the line, from a polynomial through these places
    rate_A, rate_B, rate_C = np.polynomial.polynomial.polyfit(AROUND * a, forms, AROUND.size - 1)[1]
    A, B, C = forms[AROUND.size // 2]
    found = []
    for w in works:
        rate_of_adhesion = w * geometry.area(1.0) * (2 * a if geometry.turned else 1.0)
        # the lower root of A' d²/2 + B' d + C'/2 - (adhesion)' = 0
        half = rate_B / rate_A
        constant = (rate_C - 2 * rate_of_adhesion) / rate_A
        depth = -half - (math.sqrt(half * half - constant) if w else 0.0)
        energy = A * depth * depth / 2 + B * depth + C / 2 - w * geometry.area(a)
        found.append((depth, A * depth + B, energy))
    return np.array(found)
