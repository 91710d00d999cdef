"""Find the equilibrium of a scene at a depth with the cheapest method that answers."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np

from discretization import fronts
from discretization.certificate import Certificate, Sums, certify, measured
from discretization.equilibrium import Equilibrium
from discretization.lattice import Lattice
from discretization.line import Line, recover
from energy import Plane, Scene
from energy.checks import finite, option, positive

METHODS = ("auto", "lattice")
BRANCHES = ("adhered", "global")
_AUTO_NODES = 1 << 22
_SAFETY = 1.5
_CLEAN = Certificate(0.0, 0.0, 0.0, 0.0, 0.0)


class NotCertifiedError(RuntimeError):
    """The minimiser's state failed its certificate; nothing is returned in its place."""


class AccuracyWarning(UserWarning):
    """The requested rtol was not reached; error_estimate says what was."""


def minimise(
    scene: Scene,
    depth: float,
    *,
    method: str = "auto",
    branch: str = "adhered",
    spacing: float | None = None,
    rtol: float = 1e-8,
) -> Equilibrium:
    """Equilibrium of the scene at an imposed depth: min U[u] s.t. u >= d - f.

    branch "adhered": the metastable state of the quasi-static path that touches first and then
    moves to this depth. "global": the lowest energy of all; here for γ₁ = 0 and for w = 0, where
    the problem is convex.
    method "lattice": fixed nodes `spacing` apart, accurate to O(spacing²). "auto": the spacing
    that reaches rtol by its own error estimate.

    ValueError for an unusable argument or a depth at which the contact would leave the profile;
    NotCertifiedError if the state found is no equilibrium (several contacts, for instance);
    AccuracyWarning if "auto" stops short of rtol.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene = {scene!r} is not a Scene; build one with energy.Scene(...)")
    finite("depth", depth)
    option("method", method, METHODS)
    option("branch", branch, BRANCHES)
    if not 0 < finite("rtol", rtol) < 1:
        raise ValueError(f"rtol = {rtol!r} is outside (0, 1); give a relative error such as 1e-8")
    _refuse_unsupported(scene, branch)
    if method == "auto":
        if spacing is not None:
            raise ValueError(
                f"spacing = {spacing!r} needs method='lattice'; 'auto' chooses its own"
            )
        return _auto(scene, float(depth), branch, rtol)
    if spacing is None:
        raise ValueError("spacing = None: method='lattice' needs the distance between its nodes")
    positive("spacing", spacing)
    fine = on_lattice(scene, float(depth), float(spacing), branch=branch)
    return _with_estimate(fine, _coarser(fine))


def _refuse_unsupported(scene: Scene, branch: str) -> None:
    if scene.slopes != "small":
        raise ValueError(
            f"slopes = {scene.slopes!r} has no minimiser yet; use Scene(..., slopes='small')"
        )
    if branch == "global" and scene.gamma1 and scene.work_of_adhesion:
        raise ValueError(
            "branch = 'global' is available for gamma1 = 0 or w = 0 only; use branch='adhered'"
        )


def on_lattice(
    scene: Scene,
    depth: float,
    spacing: float,
    *,
    branch: str = "adhered",
    origin: float | None = None,
) -> Equilibrium:
    """Certified equilibrium on one lattice, a node on `origin`; without an error estimate."""
    lattice = Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        return _plane(scene, depth, branch, lattice)
    where = fronts.region(lattice, scene.indenter, depth)
    lowest_energy = branch == "global" and not scene.gamma1
    find = fronts.held if lowest_energy else fronts.adhered
    contact = find(lattice, scene.indenter, depth, where)
    if contact is None:
        certificate = certify(lattice, scene.indenter, depth, where, None, None)
        return _detached(scene, depth, branch, lattice, certificate)
    sums = measured(lattice, scene.indenter, depth, contact)
    certificate = certify(lattice, scene.indenter, depth, where, contact, sums)
    if not certificate.ok:
        raise NotCertifiedError(
            f"the state at depth = {depth!r} violates {', '.join(certificate.failures)} "
            f"({certificate}): the surface meets or leaves the indenter elsewhere than at the two "
            "ends of one contact; try a smaller spacing, or a profile with a single contact"
        )
    right = recover(lattice, scene.indenter, depth, where, contact.last, 1, contact.reach)
    axis = fronts.mirror_axis(lattice, scene.indenter, contact.first, contact.last)
    if axis is not None:
        left = right._replace(x=max(2 * axis - right.x, scene.indenter.extent[0]))
    else:
        left = recover(lattice, scene.indenter, depth, where, contact.first, -1, contact.reach)
    ends = [left, right]
    return _state(scene, depth, branch, lattice, contact, sums, ends, certificate)


def _state(
    scene: Scene,
    depth: float,
    branch: str,
    lattice: Lattice,
    contact: fronts.Contact,
    sums: Sums,
    ends: list[Line],
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
        nodes=lattice.x(np.array([[contact.first, contact.last]], float)),
        pinned=np.array([[ends[0].pinned, ends[1].pinned]]),
        force=sums.force + ends[0].force + ends[1].force,
        energy=sums.energy + ends[0].energy + ends[1].energy,
        label="neutral" if neutral else "global" if convex else "metastable",
        certificate=certificate,
        tail_rate=lattice.log_decay / lattice.spacing,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        error_estimate=dict.fromkeys(("half_width", "force", "energy"), math.nan),
        method="lattice",
        branch=branch,
        spacing=lattice.spacing,
    )


def _indifferent(lattice: Lattice, scene: Scene, depth: float, contact: fronts.Contact) -> bool:
    """Whether moving a line by several links costs nothing: any contact width is an equilibrium."""
    nodes = np.arange(contact.last, max(contact.first, contact.last - 4) - 1, -1, dtype=float)
    if nodes.size < 4 or not scene.work_of_adhesion:
        return False
    f = fronts.heights(lattice, scene.indenter, nodes)
    gap = f[:-1] - f[1:] + lattice.loss * (f[1:] - depth)
    cost = lattice.advance_cost(gap)
    return bool(np.all(gap > 0) and np.all(np.abs(cost) <= 1e-10 * lattice.w * lattice.spacing))


def _detached(
    scene: Scene, depth: float, branch: str, lattice: Lattice, certificate: Certificate
) -> Equilibrium:
    none = np.empty((0, 2))
    return Equilibrium(
        scene=scene,
        depth=depth,
        contacts=none,
        nodes=none,
        pinned=none.astype(bool),
        force=0.0,
        energy=0.0,
        label="detached",
        certificate=certificate,
        tail_rate=lattice.log_decay / lattice.spacing,
        scales={"force": 0.0, "energy": 0.0},
        error_estimate=dict.fromkeys(("half_width", "force", "energy"), 0.0),
        method="lattice",
        branch=branch,
        spacing=lattice.spacing,
    )


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    gap, adheres = -lattice.loss * depth, lattice.gamma1 or branch == "global" or depth < 0
    state = _detached(scene, depth, branch, lattice, _CLEAN)
    if gap > (lattice.critical_gap * (1 + 1e-12) if adheres else 0.0):
        return state
    cost = float(lattice.advance_cost(gap))
    neutral = gap > 0 and abs(cost) <= 1e-10 * lattice.w * lattice.spacing
    everywhere = np.array([[-math.inf, math.inf]])
    return replace(
        state,
        contacts=everywhere,
        nodes=everywhere,
        pinned=np.zeros((1, 2), bool),
        force=math.copysign(math.inf, depth) if depth else 0.0,
        energy=0.0 if neutral or cost == 0 else math.copysign(math.inf, cost),
        label="neutral" if neutral else "metastable" if depth < 0 else "global",
    )


def _coarser(fine: Equilibrium) -> Equilibrium | None:
    """The same question on every other node, for the error estimate; None if it has no answer."""
    if not np.isfinite(fine.contacts).all():
        return fine
    try:
        return on_lattice(fine.scene, fine.depth, 2 * fine.spacing, branch=fine.branch)
    except (ValueError, NotCertifiedError):
        return None


def _with_estimate(fine: Equilibrium, coarse: Equilibrium | None) -> Equilibrium:
    """Errors of the fine state from a coarse one with twice the spacing: O(Δx²) leaves a third."""
    if fine.label == "detached" or not np.isfinite(fine.contacts).all():
        return fine
    errors = dict.fromkeys(("half_width", "force", "energy"), math.inf)
    if coarse is not None and coarse.contacts.shape == fine.contacts.shape:
        scales = {"half_width": fine.half_width or fine.spacing, **fine.scales}
        for name, scale in scales.items():
            change = abs(getattr(fine, name) - getattr(coarse, name)) / (scale or 1.0)
            errors[name] = float(_SAFETY * change / 3 + 4 * np.finfo(float).eps)
    return replace(fine, error_estimate=errors)


def _auto(scene: Scene, depth: float, branch: str, rtol: float) -> Equilibrium:
    """Lattices refined until the error estimate meets rtol or the contact has too many nodes."""
    lengths = (scene.elastocapillary_length, scene.critical_separation, abs(depth), scene.layer.h)
    spacing = next(length for length in lengths if length > 0) / 16
    while True:
        fine = on_lattice(scene, depth, spacing, branch=branch)
        state = _with_estimate(fine, _coarser(fine))
        error = max(state.error_estimate.values())
        nodes = 2 * fine.half_width / spacing
        if error <= rtol or not np.isfinite(nodes):
            return replace(state, method="auto")
        factor = (
            1 / 16 if math.isinf(error) else max(1 / 16, min(0.5, 0.9 * math.sqrt(rtol / error)))
        )
        if nodes / factor > _AUTO_NODES or spacing * factor < 1e-12 * max(lengths):
            warnings.warn(
                f"rtol = {rtol!r} not reached: estimated relative error {error:.1e} at spacing "
                f"{spacing:.3g}; ask for a larger rtol",
                AccuracyWarning,
                stacklevel=3,
            )
            return replace(state, method="auto")
        spacing *= factor
