"""Equilibria on a lattice: contact set, certificate, contact lines between the nodes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate, NotCertifiedError, Sums, certify, measured
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice import fronts
from discretization.lattice.line import Line, outer
from discretization.lattice.lowest import on_lowest
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
    """Certified equilibrium on one lattice, a node on `origin`; without an error estimate.

    method: "lattice", or for the lowest energy of all "shortest_path" or "oracle"; margin: whether
    its proof says how far above the next topology lies.
    """
    lattice = Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        if method != "lattice":
            raise ValueError(f"method = {method!r} needs an end to the plane: use 'lattice'")
        return _plane(scene, depth, branch, lattice)
    where = fronts.region(lattice, scene.indenter, depth)
    if method != "lattice" or _several(scene, branch):
        return on_lowest(scene, depth, branch, lattice, where, method, margin)
    if not scene.gamma1 and not scene.indenter.convex:
        return on_springs(scene, depth, branch, lattice, where)
    if branch == "adhered" and (several := on_path(scene, depth, lattice, where)) is not None:
        return several
    lowest_energy = branch == "global" and not scene.gamma1
    find = fronts.held if lowest_energy else fronts.adhered
    contact = find(lattice, scene.indenter, depth, where)
    sums = None if contact is None else measured(lattice, scene.indenter, depth, contact)
    apart = branch == "global" and depth <= fronts.height(lattice, scene.indenter, where.lowest)
    if contact is None or sums is None or (apart and sums.energy > 0):
        certificate = certify(lattice, scene.indenter, depth, where, None, None)
        return replace(detached(scene, depth, branch, lattice.tail, certificate), spacing=spacing)
    ends = outer(lattice, scene.indenter, depth, where, contact)
    _refuse_overhang(lattice, scene, depth, contact, ends)
    certificate = certify(lattice, scene.indenter, depth, where, contact, sums)
    if not certificate.ok:
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
    return _state(scene, depth, branch, lattice, contact, sums, ends, certificate)


def _several(scene: Scene, branch: str) -> bool:
    """Whether the lowest energy of all contact sets is asked.

    Of a convex indenter it is that of the one contact of its path, or of none.
    """
    if not scene.gamma1:
        return False
    if scene.work_of_adhesion:
        return branch == "global" and not scene.indenter.convex
    return scene.slopes == "small" and not scene.indenter.convex


def _refuse_overhang(
    lattice: Lattice, scene: Scene, depth: float, contact: fronts.Contact, ends: tuple[Line, Line]
) -> None:
    """ValueError for lines at which the surface would all but turn over (finite slopes)."""
    limit = lattice.greatest_displacement
    if limit == math.inf:
        return
    u = depth - scene.indenter.height(np.array([end.x for end in ends]))
    nodes = depth - fronts.heights(lattice, scene.indenter, np.array(contact[:2], float))
    for end, lift, node in zip(ends, u.tolist(), nodes.tolist(), strict=True):
        if abs(lift) > limit or abs(node) > limit + lattice.spacing:
            raise ValueError(_overhang(lattice, depth, f" x = {end.x!r}", lift))


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
    ends: tuple[Line, Line],
    certificate: Certificate,
) -> Equilibrium:
    x = np.array([[ends[0].x, ends[1].x]])
    if x[0, 0] > x[0, 1]:  # a contact smaller than the interpolation resolves
        x[:] = x.mean()
    convex = branch == "global" or scene.work_of_adhesion == 0
    neutral = _indifferent(lattice, scene, depth, contact)
    return Equilibrium(
        scene=scene,
        depth=depth,
        contacts=x,
        nodes=np.array([[lattice.x(contact.first), lattice.x(contact.last)]]),
        pinned=np.array([[ends[0].pinned, ends[1].pinned]]),
        force=sums.force + ends[0].force + ends[1].force,
        energy=sums.energy + ends[0].energy + ends[1].energy,
        label="neutral" if neutral else "global" if convex else "metastable",
        certificate=certificate,
        tail=lattice.tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=dict.fromkeys(QUANTITIES, math.nan),
        method="lattice",
        branch=branch,
        spacing=lattice.spacing,
    )


def _indifferent(lattice: Lattice, scene: Scene, depth: float, contact: fronts.Contact) -> bool:
    """Whether moving a line by several links costs nothing: any contact width is an equilibrium."""
    links = range(contact.last - 1, max(contact.first, contact.last - 4) - 1, -1)
    if len(links) < 3 or not scene.work_of_adhesion:
        return False
    for link in links:
        f, f_next = (fronts.height(lattice, scene.indenter, node) for node in (link, link + 1))
        gap, cost = lattice.gap(f, f_next, depth), lattice.advance_energy(f, f_next, depth)
        if gap <= 0 or abs(cost) > 1e-10 * lattice.w * lattice.spacing:
            return False
    return True


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    gap, adheres = lattice.gap(0.0, 0.0, depth), lattice.gamma1 or branch == "global" or depth < 0
    lift = max(abs(depth), scene.critical_separation) or 1.0
    apart = Certificate(max(0.0, depth / lift), 0.0, 0.0, 0.0, 0.0)
    state = replace(detached(scene, depth, branch, lattice.tail, apart), spacing=lattice.spacing)
    if gap > (lattice.critical_gap * (1 + 1e-12) if adheres else 0.0):
        return state
    if gap > 0 and abs(depth) > lattice.greatest_displacement:
        raise ValueError(_overhang(lattice, depth, "", depth))
    cost = float(lattice.advance_energy(0.0, 0.0, depth))
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
