"""Fixed nodes: the discrete energy and what is exact on the lattice itself.

Nodes x_i = origin + iΔx, a spring kΔx under each, a link of the stretched surface between
neighbours. With t = γ₁/Δx and contact links C (both ends in contact), the nodal energy is

    U[u] = Σ_i kΔx u_i²/2 + Σ_i t (u_{i+1} - u_i)²/2 - w Δx |C|     min over u, s.t. u_i >= g_i.

Free nodes obey t(u_{i-1} - 2u_i + u_{i+1}) = kΔx u_i, so a free tail decays by
λ = exp(-2 asinh(√κ/2)), κ = kΔx²/γ₁, per node, exactly. Eliminating the tail leaves a spring
t(1-λ) on the contact node where it begins: the half-infinite far field needs no nodes.

Finite slopes: with s = (u_{i+1} - u_i)/Δx a free link has the energy γ₁Δx(√(1+s²) - 1), and on a
contact link wΔx becomes wΔx√(1+s²): plain.py.

Adhesion is counted per link: a lone node has none. With γ₁ = 0 there are no links and the springs
are independent, so it is counted per node, and a contact reaches half a node past its last one.

With rotational symmetry nodes and links have weights, and the surface outside is that of radial.py.

Conventions
-----------
u and d are positive down into the layer, heights f upwards, g = d - f; forces are positive where
they press. Nodes have any integers as numbers, with x = origin + number Δx; the link between the
nodes i and i + 1 is called by its middle, i + ½. `side` is -1 on the left of a node and 1 on its
right. A free surface of T links is between contact nodes T apart, and a tail, that ends at
infinity, counts as one of infinitely many links.

Three letters stand for what free surfaces do (`shares`, `free_node_response`,
`surface_stiffnesses`): a and b are the shares of both ends in the displacement of a free node, A
and B those of the free node next to a contact line, A of its own line and B of the line that it
faces; S is the stiffness of that node: a force F on it moves it by F/S. What is returned is always
B and 1 - A - B, which keep all digits where A is next to 1.

Of an indenter, `extent` is (low, high), between which its profile is known, ±∞ without an end;
`walls` are those of its ends at which the body itself ends, also called its edges; `corners` are x
at which f' jumps, increasing; `apex` is x of the lowest point if the profile falls nowhere on the
way outwards from it, else None.
`Radial(indenter)` is the half r >= 0 of a profile that is mirror-symmetric about r = 0, with the
axis as an end. `Scene.spring(u)` is what springs store per area with its first and second
derivative by u, a `Density`; so is `terms.spring`, k u²/2.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import scipy

from discretization.nodes.radial import outer_pull
from energy import Scene, terms
from energy.arrays import Array
from energy.axis import Radial
from energy.checks import positive

# Nodes at a time. Arrays of 64 KB stay in the processor's cache and in the heap: of 128 KB and more
# the C library maps new ones each time, which takes longer than to fill them.
# Half or twice as many change no result, and no time by more than 9 % (`python -m tests.sensitivity
# discretization.nodes.lattice PIECE`).
PIECE = 1 << 13
_AXIS_WEIGHT = 1 / 8  # of the node on the axis: π(Δr/2)² over 2πΔr²
# Spacings by which a place may be off a node that counts as on it. Places up to a million spacings
# from 0 are rounded by less, 2e-10 of a spacing.
ON_NODE = 1e-9
_DEEPEST = 1.9  # D of `Lattice.deepest_contact` over δ₀; 1.88 is the bound worked out there


def shares(rate: float, p: Any, q: Any) -> tuple[Array, Array, Array]:
    """The free surface u = a left + b right between two ends, at distances p and q from them.

        a = sinh(rate·q)/sinh(rate·(p+q)),  b = sinh(rate·p)/sinh(rate·(p+q)),
        1 - a - b = 2 sinh(rate·p/2) sinh(rate·q/2)/cosh(rate·(p+q)/2)

    Written with decaying exponentials alone, which do not overflow, and without differences of
    numbers next to each other.

    Parameters
    ----------
    rate : float
        A tail decays by exp(-rate) per unit of p and q: μ if these are numbers of links, μ/Δx if
        they are lengths.
    p, q : float or ndarray
        Distances from the left and from the right end; one may be infinite.

    Returns
    -------
    a, b, 1 - a - b : ndarray
    """
    decay_p = np.exp(-rate * p)
    decay_q = np.exp(-rate * q)
    less_p = np.expm1(-rate * p)  # decay - 1; that of twice the distance is less (2 + less)
    less_q = np.expm1(-rate * q)
    both = np.expm1(-2 * rate * (p + q))
    a = decay_p * less_q * (2 + less_q) / both
    b = decay_q * less_p * (2 + less_p) / both
    return a, b, less_p * less_q / (1 + decay_p * decay_q)


@dataclass(frozen=True)
class LatticeTail:
    """Free nodes beyond a contact: u decays by exp(-rate) per length, Eq. (6) on the lattice.

    Attributes
    ----------
    rate : float
        μ/Δx [1/length]; ∞ without tension, where u is 0 beyond a contact and states ask for no
        shape, as its slope there would be nan.
    """

    rate: float

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """Displacement and slope between two contact lines.

            u = [u_left sinh(rate·q) + u_right sinh(rate·p)]/sinh(rate·(p + q)),
            du/dx = rate [u_right cosh(rate·p) - u_left cosh(rate·q)]/sinh(rate·(p + q)),

        p and q the distances from the left and the right line.

        Parameters
        ----------
        z : ndarray (n,)
            Positions [length].
        left, right : LinePosition or None
            Lines with their x and the height f of the profile there; None is infinitely far away.
        depth : float
            [length].

        Returns
        -------
        u, slope : ndarray (n,)
            u positive downwards [length], and du/dx, towards the right on both sides.
        """
        p: Any = math.inf
        q: Any = math.inf
        u_left = u_right = 0.0
        if left is not None:
            p = z - left.x
            u_left = depth - left.f
        if right is not None:
            q = right.x - z
            u_right = depth - right.f
        a, b, _ = shares(self.rate, p, q)
        decay_p = np.exp(-self.rate * p)
        decay_q = np.exp(-self.rate * q)
        from_left = decay_p * (1 + decay_q * decay_q) * u_left
        from_right = decay_q * (1 + decay_p * decay_p) * u_right
        slope = self.rate * (from_left - from_right) / np.expm1(-2 * self.rate * (p + q))
        return a * u_left + b * u_right, slope


@dataclass(frozen=True)
class RadialTail(LatticeTail):
    """The free surface outside a contact as a function of r, in between the nodes, too."""

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u_a K₀(r/l)/K₀(a/l) and du/dr = -(u_a/l) K₁(r/l)/K₀(a/l) outside a line at r = a.

        u_a = d - f(a). Both are 0 without a line on the left, inside a contact around the axis.
        `rate` stands for 1/l. With K₀(x) = exp(-x) k0e(x), and K₁(x) = exp(-x) k1e(x), the
        quotients do not underflow.
        """
        if left is None:
            return np.zeros_like(z), np.zeros_like(z)
        r = self.rate * z
        a = self.rate * left.x
        unit = (depth - left.f) * np.exp(a - r) / scipy.special.k0e(a)
        return unit * scipy.special.k0e(r), -self.rate * unit * scipy.special.k1e(r)


@dataclass(frozen=True)
class Lattice:
    """Nodes under a line contact: spacing, origin, and the scene's k, γ₁ and w.

    A line that advances over a link to the free node beside it, with gap v = A u + B u' - g there,
    u and u' the displacements of the line and of the one that it faces, changes the re-equilibrated
    energy by S v²/2 - wΔx, a perfect square, so that the line stops at v = √(2wΔx/S), and the force
    by -S (1 - A - B) v. If nothing is faced B = 0, A = λ, S = t/λ.

    `RadialLattice` has the same methods for rotational symmetry: nodes and links have weights
    there, and a surface depends on its place. Displacements u, heights f of the profile and depths
    [length] are numbers or arrays of one shape; energies [energy/length] and forces [force/length]
    are per length of the contact line.

    Parameters
    ----------
    spacing, origin : float
        Δx, and the position of node 0 [length].
    k, gamma1, w : float
        Stiffness per area [stress/length], surface tension [force/length], and work of adhesion
        [energy/area].
    slopes : {"small", "finite"}
        Those of U.
    stored : callable, optional
        What springs store per area, and its derivatives, as a function of u: `Scene.spring`. By
        default that of linear springs, k u²/2.

    Examples
    --------
    >>> from discretization import Lattice
    >>> lattice = Lattice(spacing=0.5, origin=0.0, k=2.0, gamma1=8.0, w=0.1)
    >>> lattice.spring_stiffness, lattice.link_stiffness
    (1.0, 16.0)
    """

    axis: ClassVar[float] = math.nan  # number of the node on the axis, if there is one
    spacing: float
    origin: float
    k: float
    gamma1: float
    w: float
    slopes: str = "small"
    stored: Any = None

    def __post_init__(self) -> None:
        """Linear springs, unless other ones are given."""
        if self.stored is None:
            object.__setattr__(self, "stored", functools.partial(terms.spring, k=self.k))

    @classmethod
    def of(cls, scene: Scene, spacing: float, origin: float | None = None) -> Lattice:
        """The lattice for a scene, with rotational symmetry a `RadialLattice`.

        Parameters
        ----------
        scene : Scene
        spacing : float
            Of the nodes [length], > 0. Edges of a body are nodes, at most that far apart, unless
            its tip or more of its corners are nodes without that.
        origin : float, optional
            Position of a node [length]; by default the axis, or the indenter's `apex`, x = 0 where
            that is not known.

        Returns
        -------
        Lattice

        Raises
        ------
        ValueError
            Unless spacing > 0.
        """
        spacing = positive("spacing", spacing)
        if origin is None:
            spacing, origin = _placed(scene, spacing)
        kind = RadialLattice if scene.axisymmetric else Lattice
        return kind(
            spacing,
            origin,
            k=scene.stiffness,
            gamma1=scene.gamma1,
            w=scene.work_of_adhesion,
            slopes=scene.slopes if scene.gamma1 else "small",
            stored=scene.spring,
        )

    @functools.cached_property
    def cell(self) -> float:
        """Length that a link covers, Δx."""
        return self.spacing

    @functools.cached_property
    def spring_stiffness(self) -> float:
        """Stiffness kΔx of a node's spring [stress]."""
        return self.k * self.cell

    @functools.cached_property
    def link_stiffness(self) -> float:
        """Stiffness t = γ₁/Δx of a link [stress]."""
        return self.gamma1 / self.spacing

    @functools.cached_property
    def log_decay(self) -> float:
        """μ = -ln λ, by which a free tail of a line contact decays per node; ∞ without tension."""
        if not self.gamma1:
            return math.inf
        kappa = self.k * self.spacing / (self.gamma1 / self.spacing)
        return 2 * math.asinh(math.sqrt(kappa) / 2)

    @functools.cached_property
    def end_stiffness(self) -> float:
        """t(1 - λ): a tail pulls at the contact node that it begins at with this times u."""
        return -(self.gamma1 / self.spacing) * math.expm1(-self.log_decay)

    @functools.cached_property
    def linear(self) -> bool:
        """Whether free nodes obey k u - γ₁ u'' = 0; else `NodalEnergy` alone knows them.

        `Density.hookean` is whether a density and both its derivatives are k u²/2, k u and k to
        twelve digits at given u. Two of different size and sign are enough: where the second
        derivative is constant, the density is one parabola, or at most one for each sign of u.
        """
        u = self.spacing * np.array([-1.0, 2.0])
        with np.errstate(over="ignore", invalid="ignore"):
            return self.slopes == "small" and bool(self.stored(u).hookean(u, self.k))

    def scene_on_nodes(self, scene: Scene) -> Scene:
        """The scene of which these nodes are those of a line contact: the scene itself."""
        return scene

    def weight(self, at: Any) -> Any:
        """Weights of nodes, or of links, in sums: 1.

        Parameters
        ----------
        at : int or ndarray
            Numbers of nodes, or of the middles of links.

        Returns
        -------
        float or ndarray
        """
        return 1.0

    def sizes(self, first: float, count: int, unit: float = 1.0) -> Array:
        """Lengths, or areas, that belong to nodes or are covered by links, times a unit.

        Parameters
        ----------
        first : float
            Number of the first node, or the middle of the first link: i + ½.
        count : int
            How many nodes, or links, from there on: n.
        unit : float
            What sizes are multiplied by, such as a work of adhesion.

        Returns
        -------
        ndarray (n,)
            Read-only.
        """
        return np.broadcast_to(np.float64(unit * self.cell), count)

    def tail_stiffness(self, nodes: Any, side: int) -> Any:
        """Stiffness of tails beyond contact nodes; their springs' own is not counted.

        Parameters
        ----------
        nodes : int or ndarray
            The contact nodes.
        side : {1, -1}
            On which the tails are.

        Returns
        -------
        float or ndarray
            [stress].
        """
        return self.surface_stiffnesses(math.inf, nodes, side)[1]

    def surface_stiffnesses(self, links: Any, node: Any = 0, side: Any = 1) -> tuple[Any, Any]:
        """Stiffnesses of a free surface of this many links between two contact nodes.

        It pulls at an end displaced by u, the other one by u', with tie (u - u') + ground u: as a
        spring between both ends and one from each of them to the ground. As its first free node is
        displaced by a u + b u', so that its first link pulls with t (u - a u - b u'), tie = t b and
        ground = t (1 - a - b), the shares taken at that node.

        Parameters
        ----------
        links : float or ndarray
            At least 1, where tie = t and ground = 0; infinite for a tail.
        node, side : int or ndarray
            The surface is on this side of this contact node: what it does depends on its place only
            with rotational symmetry.

        Returns
        -------
        tie, ground : float or ndarray
            [stress]; about an axis times a length.
        """
        if isinstance(links, float) and links == math.inf:
            return 0.0, self.end_stiffness
        _, b, remainder = shares(self.log_decay, 1.0, links - 1.0)
        return self.link_stiffness * b, self.link_stiffness * remainder

    def free_node_response(
        self, node: Any, side: Any, distance: Any = math.inf
    ) -> tuple[Any, Any, Any]:
        """Response of the free node next to a contact line: u = A g + B g' there.

        g and g' are the displacements of the line and of the one that it faces. At the free node
        its spring, the link to the line, and the rest of the surface beyond it pull.

        Parameters
        ----------
        node, side : int or ndarray
            Contact nodes at the lines, and the side on which the free node is.
        distance : float or ndarray
            Number of links from the contact node to the line on the other side of the free
            surface; infinite for a tail.

        Returns
        -------
        B, 1 - A - B, S : float or ndarray
            The last is its stiffness [stress], about an axis times a length.
        """
        after = node + side  # the free node, of which a surface of one link less begins
        tie, ground = self.surface_stiffnesses(distance - 1.0, after, side)
        spring = self.spring_stiffness * self.weight(after)
        link = self.link_stiffness * self.weight(node + side / 2)
        total = spring + link + tie + ground
        return tie / total, (spring + ground) / total, total

    @property
    def deepest_contact(self) -> float:
        """D [length]: no contact of lowest energy has a larger drop than this.

        For line contacts with linear springs and small slopes: only these are searched for their
        lowest energy (lowest.py). For others D is no bound, but just how far the profile rises at
        both ends of the window in which a lowest node is looked for (`region` in row.py).

        The drop v of a node is by how much it is higher than the surface of the same scene without
        adhesion, ū - u. Let v be largest in contact node j, and replace it by the free surface
        between v_{j-r} and v_{j+r} where that is lower. This loses at most the 2r links there and
        gains at least t sinh μ coth μr (v_j - s)², s <= v_j/cosh μr that surface at j. With r next
        to 2.4/μ both are equal at v_j = 1.88 δ₀ at most, whatever μ.
        """
        return _DEEPEST * math.sqrt(2 * self.w / self.k)

    @property
    def overhang(self) -> float:
        """How many spacings a contact reaches beyond its last node: ½ without tension."""
        return 0.0 if self.gamma1 else 0.5

    @property
    def tail(self) -> LatticeTail:
        """The free surface beyond a contact line."""
        return LatticeTail(self.log_decay / self.spacing)

    def x(self, node: Any) -> Any:
        """Position of nodes.

        Parameters
        ----------
        node : float or ndarray
            Their numbers.

        Returns
        -------
        float or ndarray
            [length].
        """
        return self.origin + self.spacing * node


@dataclass(frozen=True)
class RadialLattice(Lattice):
    """Nodes on circles around an axis; see radial.py.

    Springs, links and cells are those of weight 1: 2πkΔr², 2πγ₁ and 2πΔr².
    """

    axis: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        """As of a line contact. ValueError unless node 0 is on the axis, origin = 0."""
        super().__post_init__()
        if self.origin:
            raise ValueError(f"origin = {self.origin!r}: with rotational symmetry it is the axis")

    @functools.cached_property
    def cell(self) -> float:
        """Area that a link of weight 1 covers, 2πΔr²."""
        return 2 * math.pi * self.spacing**2

    @functools.cached_property
    def link_stiffness(self) -> float:
        """Stiffness of a link of weight 1, 2πγ₁."""
        return 2 * math.pi * self.gamma1

    @property
    def tail(self) -> LatticeTail:
        """The free surface outside the contact.

        Of nodes on circles there is no closed form in between. K₀ with μ/Δr in place of 1/l, as far
        out they decay per node by exp(-μ), is nearer to them than K₀(r/l): for l = 8Δr it is off by
        2e-4 of u_a from a line at r = l, and by 1e-5 at 4 l, where K₀(r/l) is by 4e-4 and 2e-4. All
        these fall with Δr².
        """
        return RadialTail(self.log_decay / self.spacing)

    def scene_on_nodes(self, scene: Scene) -> Scene:
        """The scene with r >= 0 only, as if it were a line contact that ends at the axis.

        Its profile is `Radial` of the indenter's.
        """
        return replace(scene, indenter=Radial(scene.indenter), geometry="line")

    def weight(self, at: Any) -> Any:
        """Weights of nodes, or of links by their middles: their radii over Δr, 1/8 on the axis."""
        return np.where(np.asarray(at) > 0, at, _AXIS_WEIGHT)

    def sizes(self, first: float, count: int, unit: float = 1.0) -> Array:
        """Areas of nodes, or links, times a unit (n,)."""
        return np.asarray(unit * self.cell * self.weight(first + np.arange(count)))

    def surface_stiffnesses(self, links: Any, node: Any = 0, side: Any = 1) -> tuple[Any, Any]:
        """Stiffnesses of the surface outside of a node, whatever the links; 0 towards the axis.

        One contact around the axis is known, so that its outer surface faces nothing: tie = 0.
        """
        if not self.gamma1:
            return 0.0, np.zeros(np.shape(node))
        # outer_pull(κ, m) is σ_m of radial.py: what the surface outside of node m pulls with, over
        # 2πγ₁ u_m.
        pull = self.link_stiffness * outer_pull(self.spring_stiffness / self.link_stiffness, node)
        return 0.0, np.where(side < 0, 0.0, pull)


def _placed(scene: Scene, spacing: float) -> tuple[float, float]:
    """Spacing and origin of nodes of which more are at the tip and at corners; see `Lattice.of`.

    Either the given spacing with a node at the tip, or, for a body with two edges, as many nodes as
    fit between these, an odd number, so that one is in the middle: no farther apart than given.
    Without tension a contact reaches half a node beyond its last one, and nodes stop half a spacing
    before the edges.

    If the tip is a corner and only one of the two has a node there, that one is chosen; else the
    one with more corners in their places, and with as many the one from edge to edge. The place of
    a corner is on a node, so that every link is under one smooth piece of the profile; without
    tension it is half way between two nodes, so that every cell, a spacing wide around its node, is
    under one.
    """
    body = scene.indenter
    low, high = body.extent
    tip = 0.0 if body.apex is None or scene.axisymmetric else body.apex
    if len(body.walls) < 2 or spacing > high - low:
        return spacing, tip
    half_cells = 0 if scene.gamma1 else 1  # between each edge and the last node
    width = high - low
    # Spacings from edge to edge: an even number between the outermost nodes, and both half cells.
    steps = half_cells + 2 * math.ceil((width / spacing - half_cells) / 2 - ON_NODE)
    closer = width / steps
    first = 0.0 if scene.axisymmetric else low + half_cells * closer / 2

    def on_nodes(chosen: tuple[float, float]) -> tuple[bool, int]:
        """Whether the tip is on a node, if it is a corner; and how many corners are in place.

        chosen: the spacing and the origin of the nodes.
        """
        off = (np.append(tip, body.corners) - chosen[1]) / chosen[0]
        off[1:] -= half_cells / 2
        on = np.abs(off - np.rint(off)) < ON_NODE
        return bool(on[0]) or tip not in body.corners, int(on[1:].sum())

    return max((closer, first), (spacing, tip), key=on_nodes)
