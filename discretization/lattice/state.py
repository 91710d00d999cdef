"""Equilibria on a lattice: contact set, certificate, contact lines between the nodes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate, NotCertifiedError, Sums, judged, measured
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice import fronts
from discretization.lattice.line import End, Line, ends, outer
from discretization.lattice.lowest import on_lowest, without_contact
from discretization.lattice.nodes import Lattice
from discretization.lattice.path_state import on_path
from discretization.lattice.springs import on_springs
from energy import Plane, Scene

Array = NDArray[np.float64]
_SAFETY = 1.5


class SeveralContactsError(ValueError):
    """Several contacts where only one is found."""


def on_lattice(
    scene: Scene,
    depth: float,
    spacing: float,
    *,
    branch: str = "adhered",
    origin: float | None = None,
    method: str = "lattice",
    margin: bool = True,
) -> Equilibrium:
    """Certified equilibrium on one lattice, a node on `origin`.

    method: "lattice", or for the lowest energy of all "shortest_path" or "oracle"; margin: whether
    its proof says how far above the next topology lies.
    """
    lattice = Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        if method != "lattice":
            raise ValueError(f"method = {method!r} needs an end to the plane: use 'lattice'")
        return _plane(scene, depth, branch, lattice)
    where = fronts.region(lattice, scene.indenter, depth)
    several = _several(scene, depth, branch, lattice, where, method, margin)
    if several is None:
        return _one_contact(scene, depth, branch, lattice, where)
    return replace(several, errors=estimated)


def _several(
    scene: Scene,
    depth: float,
    branch: str,
    lattice: Lattice,
    where: fronts.Region,
    method: str,
    margin: bool,
) -> Equilibrium | None:
    """The state of any number of contacts; None where there is one or none on the way to it.

    The lowest energy of all contact sets is, of a convex indenter, that of its path or none.
    """
    convex, w = scene.indenter.convex, scene.work_of_adhesion
    if method != "lattice":
        return on_lowest(scene, depth, branch, lattice, where, method, margin)
    if convex:
        return None
    if not scene.gamma1:
        return on_springs(scene, depth, branch, lattice, where)
    if branch == "global" if w else scene.slopes == "small":
        return on_lowest(scene, depth, branch, lattice, where, method, margin)
    return on_path(scene, depth, lattice, where) if branch == "adhered" else None


def _one_contact(
    scene: Scene, depth: float, branch: str, lattice: Lattice, where: fronts.Region
) -> Equilibrium:
    """The certified state of one contact or none. ValueError or NotCertifiedError for others."""
    indenter = scene.indenter
    find = fronts.held if branch == "global" and not scene.gamma1 else fronts.adhered
    contact = find(lattice, indenter, depth, where)
    if contact is None:
        return without_contact(scene, depth, branch, lattice, where)
    sums = measured(lattice, indenter, depth, contact)
    apart = branch == "global" and depth <= fronts.height(lattice, indenter, where.lowest)
    if apart and sums.energy > 0:
        return without_contact(scene, depth, branch, lattice, where)
    both = ends(lattice, indenter, depth, where, contact)
    lines = outer(lattice, indenter, contact.reach, both)
    _refuse_overhang(lattice, scene, depth, contact, lines)
    certificate = judged(lattice, indenter, depth, contact, sums, both)
    if not certificate.ok:
        _refuse(scene, depth, certificate)
    neutral = _indifferent(lattice, contact, both[0])
    return _state(scene, depth, branch, lattice, contact, sums, lines, certificate, neutral)


def _refuse(scene: Scene, depth: float, certificate: Certificate) -> NoReturn:
    """What to say of a state that has not passed its certificate."""
    if scene.slopes == "finite" and "penetration" in certificate.failures:
        raise SeveralContactsError(
            f"slopes = 'finite' at depth = {depth!r}: the surface beside the contact meets the "
            "indenter again, and several contacts are only found for small slopes; use "
            "slopes='small', another depth, or a profile with a single contact"
        )
    raise NotCertifiedError(
        f"the state at depth = {depth!r} violates {', '.join(certificate.failures)} "
        f"({certificate}): the surface meets or leaves the indenter elsewhere than at the two "
        "ends of one contact; try a smaller spacing, slopes='small' for several contacts, or a "
        "profile with a single one"
    )


def _refuse_overhang(
    lattice: Lattice, scene: Scene, depth: float, contact: fronts.Contact, lines: tuple[Line, Line]
) -> None:
    """ValueError for lines at which the surface would all but turn over (finite slopes)."""
    limit = lattice.greatest_displacement
    if limit == math.inf:
        return
    u = depth - scene.indenter.height(np.array([line.x for line in lines]))
    nodes = depth - fronts.heights(lattice, scene.indenter, np.array(contact[:2], float))
    for line, lift, node in zip(lines, u.tolist(), nodes.tolist(), strict=True):
        if abs(lift) > limit or abs(node) > limit + lattice.spacing:
            raise ValueError(_overhang(lattice, depth, f" x = {line.x!r}", lift))


def _overhang(lattice: Lattice, depth: float, where: str, lift: float) -> str:
    return (
        f"depth = {depth!r}: at the contact line{where} the surface is displaced by {lift!r}, more "
        f"than 1.3 l + Δx = {lattice.greatest_displacement!r}; it is too steep for spacing = "
        f"{lattice.spacing!r} and at √2 l it would turn over; use method='fitted', a smaller "
        "|depth|, a smaller w or a blunter indenter"
    )


def _state(
    scene: Scene,
    depth: float,
    branch: str,
    lattice: Lattice,
    contact: fronts.Contact,
    sums: Sums,
    lines: tuple[Line, Line],
    certificate: Certificate,
    neutral: bool,
) -> Equilibrium:
    left, right = lines
    x = left.x, right.x
    if left.x > right.x:  # a contact smaller than the interpolation resolves
        x = ((left.x + right.x) / 2,) * 2
    convex = branch == "global" or scene.work_of_adhesion == 0
    return Equilibrium(
        scene=scene,
        depth=depth,
        contacts=np.array([x]),
        nodes=np.array([[lattice.x(contact.first), lattice.x(contact.last)]]),
        pinned=np.array([[left.pinned, right.pinned]]),
        force=sums.force + left.force + right.force,
        energy=sums.energy + left.energy + right.energy,
        label="neutral" if neutral else "global" if convex else "metastable",
        certificate=certificate,
        tail=lattice.tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=estimated,
        method="lattice",
        branch=branch,
        spacing=lattice.spacing,
    )


def _indifferent(lattice: Lattice, contact: fronts.Contact, end: End) -> bool:
    """Whether moving a line by several links costs nothing: any contact width is an equilibrium."""
    if contact.last - contact.first < 3 or not lattice.w:
        return False
    most, links = 1e-10 * lattice.w * lattice.spacing, range(-end.start - 3, -end.start)
    return all(end.gap[link] > 0 and abs(end.energy[link]) <= most for link in links)


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    gap, cost, _ = map(float, lattice.advance(0.0, 0.0, depth))
    adheres = lattice.gamma1 or branch == "global" or depth < 0
    lift = max(abs(depth), scene.critical_separation) or 1.0
    apart = Certificate(max(0.0, depth / lift), 0.0, 0.0, 0.0, 0.0)
    state = detached(scene, depth, branch, lattice.tail, apart, lattice.spacing)
    if gap > (lattice.critical_gap * (1 + 1e-12) if adheres else 0.0):
        return state
    if gap > 0 and abs(depth) > lattice.greatest_displacement:
        raise ValueError(_overhang(lattice, depth, "", depth))
    gain = max(0.0, cost) / (lattice.w * lattice.spacing) if gap > 0 else 0.0
    lowest = depth >= 0 or branch == "global"
    balanced = abs(cost) <= 1e-10 * lattice.w * lattice.spacing
    neutral = gap > 0 and balanced
    everywhere = np.array([[-math.inf, math.inf]])
    return replace(
        state,
        contacts=everywhere,
        nodes=everywhere,
        pinned=np.zeros((1, 2), bool),
        force=math.copysign(math.inf, depth) if depth else 0.0,
        energy=0.0 if balanced else math.copysign(math.inf, cost),
        label="neutral" if neutral else "global" if lowest else "metastable",
        certificate=Certificate(0.0, 0.0, 0.0, gain, 0.0),
    )


def estimated(fine: Equilibrium) -> dict[str, float]:
    """Errors of a state from a coarse one with twice the spacing: O(Δx²) leaves a third.

    Where the coarse one has another number of contacts all of the change counts; a contact of one
    node among several may be as wide as a link. Infinite where the coarse nodes have no answer.
    """
    if not (fine.contacts.size and np.isfinite(fine.contacts).all()):
        return dict.fromkeys(QUANTITIES, 0.0)
    coarse = _coarser(fine)
    if coarse is None or not coarse.contacts.size:
        return dict.fromkeys(QUANTITIES, math.inf)
    alike = coarse.contacts.shape == fine.contacts.shape
    scales = {"half_width": fine.half_width or fine.spacing, **fine.scales}
    errors = {}
    for name, scale in scales.items():
        values = getattr(fine, name), getattr(coarse, name)
        size = scale or max(map(abs, values))  # touching without adhesion: nothing is deformed
        change = abs(values[0] - values[1]) / size if size else 0.0
        errors[name] = float(_SAFETY * change / (3 if alike else 1) + 4 * np.finfo(float).eps)
    if len(fine.contacts) > 1:
        lone = np.count_nonzero(fine.nodes[:, 0] == fine.nodes[:, 1])
        errors["half_width"] += float(lone) * fine.spacing / scales["half_width"]
    return errors


def _coarser(fine: Equilibrium) -> Equilibrium | None:
    """The same question on every other node; None if it has no answer."""
    scene, branch = fine.scene, fine.branch
    try:
        return on_lattice(scene, fine.depth, 2 * fine.spacing, branch=branch, margin=False)
    except (ValueError, NotCertifiedError):
        return None
