"""What is read from states and paths, whoever found them: in words, as plain data, and in parts.

    springs   ∫ k/2 u² dx, over the whole surface
    surface   ∫ γ₁/2 u'² dx, or ∫ γ₁ (√(1+u'²) - 1) dx with finite slopes
    adhesion  -w times the length in contact, along the indenter with finite slopes
    pressure  k ∫ (d - f) dx over the contacts (9)
    lines     -γ₁ Σ sin β over all contact lines (10), β the outward inclination beside each

The parts are integrals over the displacement field and its slopes. Their sums are the energy and
the force up to quadrature and to what `error_estimate` says of the latter.

What a state assumes of the model is said by energy.validity. Of its nodes it assumes one in each l,
and four links in a contact: of 600 random parabolas a was off by at most 7 % inside these limits,
and by up to its own size outside, where the energy may be wrong by orders of magnitude.

state: an `Equilibrium`; history: a `History`. Both are built on this module, not it on them.

Forces are positive if the indenter is pressed. Arrays (m, 2) of a state have a row for each contact
and the left and right line in the columns; `at_axis` marks ends that are the axis and no lines.
`line_slopes` are two of them: slopes of the indenter and of the free surface, positive where the
profile rises, and the surface sinks, away from the contact; `angle_deficits` are π - θ. An
`Assumption` has a name, a value, the limit that it must not exceed, and what follows if it does;
`in_contact` gives the parts over the contacts, adhesion as a positive number.

`terms.surface` is the energy of a surface of given slope per length, `Scene.spring(u)` that of the
springs; `measure(x)` is 1, about an axis 2πx. l = √(γ₁/k) is `elastocapillary_length`.
`free_surfaces` are the lines (left, right) of every free surface, None for none, and
`surfaces.shape(x, left, right, depth)` is u and du/dx on one. `summed` integrates over panels until
that changes nothing; its `sums` are the integrals of each. `contact_area` is the length, or area,
in contact; `breaks()` of an indenter are the places between which it is smooth. `uncertainty` are
absolute errors, `scales` the sums of the sizes of the terms of force and energy. A path has its
`control` ("depth", "force" or "drive"), `events` with a `kind` and `energy_released`, `dissipated`,
the energy lost in all, `inner`, the lines between the outermost ones, and `on_nodes`, depths
between which its states are those of nodes alone.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import AccuracyWarning
from discretization.quadrature import in_contact, summed
from energy import Assumption, Scene, terms
from energy.arrays import Array
from energy.validity import Deformation, assumptions

OBSERVABLES = ("depth", "half_width", "force", "energy", "contact_angle")
_UNRESOLVED = "not resolved: use smaller spacing"
STORED = ("springs", "surface", "adhesion")
ACTING = ("pressure", "lines")


class ReadingRules(NamedTuple):
    """How closely states are read.

    Attributes
    ----------
    far : float
        Elastocapillary lengths of a free surface without end over which it is integrated: e⁻⁴⁸ =
        1e-21 of it is left.
    exact : float
        Of the parts of the free surfaces: what halving a panel may change them by; less than the
        1e-9 by which a certified state may be off.
    samples : int
        Places in each contact at which its deformation is read, besides kinks: of a parabola the
        largest slope and depth are at the ends and the apex, and nothing narrow is missed that
        assumptions of the model, which hold to a few percent, could depend on.
    digits : int
        Digits of a number that is printed, at most: more are rarely known.
    angle_rounding : float
        Of the two slopes that make an angle [rad]: the error of θ at least.
    """

    far: float = 48.0
    exact: float = 1e-11
    samples: int = 257
    digits: int = 10
    angle_rounding: float = 1e-15


_READING = ReadingRules()


# Limits of nodes: spacing over l, and over the half-width of a contact, at most. They are one node
# in each l and four links in a contact, of the head of this module.
LINKS = 1.0
FEWEST = 0.5


def parts_of(state: Any) -> dict[str, float]:
    """Energy and force of a state in parts; see the head of this module.

    Of a plane without end every part is endless; of a layer with its exact response the fields
    that were found know them.

    Parameters
    ----------
    state : Equilibrium

    Returns
    -------
    dict of float
        By the names in `STORED` and `ACTING`; 0 without contact.
    """
    parts = dict.fromkeys((*STORED, *ACTING), 0.0)
    if not state.contacts.size:
        return parts
    if state.scene.layer.exact:
        return dict(state.surfaces.parts(state))
    if not np.isfinite(state.contacts).all():
        bound = -math.inf if state.scene.work_of_adhesion else 0.0
        stored = math.inf if state.depth else 0.0
        return {**parts, "springs": stored, "adhesion": bound, "pressure": state.force}
    springs, surface, adhesion, pressure = in_contact(
        state.scene, state.depth, state.contacts
    ).totals
    parts |= {"adhesion": -adhesion, "pressure": pressure}
    if state.scene.gamma1:
        free_springs, free_surface = _of_free(state)
        springs = springs + free_springs
        surface = surface + free_surface
        parts["lines"] = _of_lines(state)
    return {**parts, "springs": float(springs), "surface": float(surface)}


def _of_lines(state: Any) -> float:
    """-γ₁ Σ sin β, or -γ₁ Σ u' with small slopes (11); about an axis each times 2πr.

    u' = tan β is the outward slope of the free surface beside each line, positive where it sinks.
    """
    beside = state.line_slopes[1]
    if state.scene.slopes == "finite":
        beside = beside / np.hypot(1.0, beside)
    return -state.scene.gamma1 * float((beside * state.scene.measure(state.contacts)).sum())


def _of_free(state: Any) -> Array:
    """Energies of springs and of the surface (2,), summed over all free surfaces."""
    scene = state.scene
    found = np.zeros(2)
    far = _READING.far * scene.elastocapillary_length
    least = 0.0 if scene.axisymmetric else -math.inf  # radii end at the axis
    for left, right in state.free_surfaces:

        def density(x: Array, pair: Any = (left, right)) -> Array:
            """Energies of springs and surface per length of x (2, ..), at places."""
            u, slope = state.surfaces.shape(x, *pair, state.depth)
            surface = terms.surface(slope, gamma1=scene.gamma1, slopes=scene.slopes).value
            return np.array([scene.spring(u).value, surface]) * scene.measure(x)

        end = left.x + far if right is None else right.x
        start = max(end - far, least) if left is None else left.x
        ends = np.array([[start], [end]])
        found += summed(density, ends, _READING.exact, np.zeros((2, 1)), smooth=True).sums.sum(
            axis=1
        )
    return found


def with_surface(state: Any, surface: float) -> dict[str, float]:
    """Energy and force of a state in parts, from what its surface stores.

    The layer itself stores the rest of the energy, under the name of the springs. Lines pull by the
    slopes beside them, and the rest of the force is the pressure.

    Parameters
    ----------
    state : Equilibrium
    surface : float
        Energy of the surface [energy/length].

    Returns
    -------
    dict of str to float
        By the names in `STORED` and `ACTING`.
    """
    adhesion = -state.scene.work_of_adhesion * state.contact_area
    lines = _of_lines(state)
    return {
        "springs": state.energy - adhesion - surface,
        "surface": surface,
        "adhesion": adhesion,
        "pressure": state.force - lines,
        "lines": lines,
    }


def of_path(history: Any) -> tuple[Assumption, ...]:
    """What a load path assumes whatever its states are: of surfaces, samples and nodes.

    Parameters
    ----------
    history : History

    Returns
    -------
    tuple of Assumption
    """
    nodes = resolution(history.scene, history.spacing or math.nan)
    return (*assumptions(history.scene, None), *nodes, *_left_to_nodes(history.on_nodes))


def _left_to_nodes(ranges: Sequence[tuple[float, float]]) -> tuple[Assumption, ...]:
    """What it means that parts of a refined path are those of nodes alone.

    ranges: their first and last depths [length].
    """
    if not ranges:
        return ()
    where = ", ".join(f"{start:.6g} to {end:.6g}" for start, end in ranges)
    what = (
        f"on the way between depths {where} contacts found on nodes could not be refined: states "
        "and events there, and the energy lost, are those of nodes (see error_estimate)"
    )
    return (Assumption("parts on nodes", len(ranges), 0, what),)


def violated(shown: Any) -> tuple[str, ...]:
    """The violated assumptions of a state or of a path, one sentence each.

    Parameters
    ----------
    shown : Equilibrium or History

    Returns
    -------
    tuple of str
    """
    return tuple(str(one) for one in shown.validity if not one.holds)


def half_widths(state: Any) -> Array:
    """Half-widths of every contact (m,) [length]; of one around the axis its radius."""
    return np.diff(state.contacts)[:, 0] / np.where(state.at_axis[:, 0], 1, 2)


def deformation(state: Any) -> Deformation:
    """What the contact does to the layer, at many x.

    The ends, corners, knots and the apex are among them. Where the layer is pressed anywhere, the
    least height in contact is that of the whole profile: were it free, the surface would stand
    above it by more than anywhere in contact. Free surfaces bend and move most at their lines.

    Parameters
    ----------
    state : Equilibrium
        In contact.

    Returns
    -------
    Deformation
        The largest depth of indentation, d less the least height in contact, the largest |u|, the
        half-width of the narrowest contact, and the largest slope of indenter and free surfaces.
    """
    indenter = state.scene.indenter
    ends = state.contacts
    x = np.zeros(1)  # of a plane without end all places are alike
    bounded = bool(np.isfinite(ends).all())
    if bounded:
        kinks = indenter.breaks()
        even = np.linspace(ends[:, 0], ends[:, 1], _READING.samples).ravel()
        x = np.concatenate([even, kinks[state.inside(kinks)]])
    u = state.depth - indenter.height(x)
    slopes = [np.abs(indenter.slope(x)).max(), *np.ravel(state.line_slopes if bounded else 0.0)]
    steepest = float(np.abs(slopes).max())
    narrowest = float(half_widths(state).min())
    return Deformation(float(u.max()), float(np.abs(u).max()), narrowest, steepest)


def of_nodes(state: Any) -> tuple[Assumption, ...]:
    """What the nodes of a state assume; of an endless plane nothing, as its links are alike.

    Contacts with both lines pinned do not count: their half-widths are those of the body.
    """
    if not np.isfinite(state.contacts).all():
        return ()
    own = ~state.pinned.all(axis=1)
    return resolution(state.scene, state.spacing, half_widths(state)[own])


def resolution(scene: Scene, spacing: float, widths: ArrayLike = ()) -> tuple[Assumption, ...]:
    """What nodes `spacing` apart assume of l and of contacts with these half-widths (m,).

    Nothing on a mesh (spacing: nan), of l without tension or for the exact response of a layer, and
    of a without contacts. With rotational symmetry a contact on the axis counts with its radius.
    """
    found = []
    remedy = "; give a smaller spacing, or method='fitted'"
    if spacing > 0 and scene.gamma1 and not scene.layer.exact:
        ratio = spacing / scene.elastocapillary_length
        problem = "the free surface has too few nodes"
        found.append(Assumption("Δx/l", ratio, LINKS, problem + remedy))
    if spacing > 0 and np.size(widths):
        least = float(np.min(widths))
        ratio = spacing / least if least else math.inf
        found.append(Assumption("Δx/a", ratio, FEWEST, "a contact has too few nodes" + remedy))
    return tuple(found)


def warn_coarse(assumed: tuple[Assumption, ...], stacklevel: int) -> None:
    """Warn where the free surface has too few nodes: next to nothing may be right.

    Parameters
    ----------
    assumed : tuple of Assumption
        From `resolution`.
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
    """
    for one in assumed:
        if one.name == "Δx/l" and not one.holds:
            message = f"the nodes are too far apart: {one}"
            warnings.warn(message, AccuracyWarning, stacklevel=stacklevel + 1)


def html(shown: Any) -> str:
    """The text of a state or of a path for notebooks.

    Parameters
    ----------
    shown : Equilibrium or History

    Returns
    -------
    str
        HTML.
    """
    return f"<pre>{escape(str(shown))}</pre>"


def state_row(state: Any) -> dict[str, float | str]:
    """One row of a data frame: observables, their absolute errors, and which state it is.

    Parameters
    ----------
    state : Equilibrium

    Returns
    -------
    dict
        The `OBSERVABLES`, contact_angle [rad] being the mean over all contact lines; error_… of
        half_width, force and energy; how many contacts there are; label, branch and method.
    """
    numbers = {name: float(getattr(state, name)) for name in OBSERVABLES}
    errors = {f"error_{name}": float(error) for name, error in state.uncertainty.items()}
    words = {"label": state.label, "branch": state.branch, "method": state.method}
    return {**numbers, **errors, "contacts": len(state.contacts), **words}


def state_line(state: Any) -> str:
    """One line with the observables."""
    numbers = ", ".join(f"{name}={getattr(state, name):.6g}" for name in OBSERVABLES[:4])
    return f"Equilibrium({numbers}, label={state.label!r}, method={state.method!r})"


def angle_error(state: Any) -> float:
    """Numerical error of θ [rad], of the line where it is largest.

    θ is read beside lines whose positions have the error of the half-width, which changes f' and u'
    there; lines that are pinned have none. On nodes u' has an error of its own, (Δx/l)²/24 of u' to
    the leading order, as a free surface decays by λ = exp(-2 asinh(Δx/2l)) for exp(-Δx/l): twice
    that is taken.

    Parameters
    ----------
    state : Equilibrium

    Returns
    -------
    float
        nan without a line or an angle, and for the exact response of a layer, whose fields are
        those of one contact alone; inf where nodes do not resolve the lines.
    """
    scene = state.scene
    deficits = state.angle_deficits
    if scene.layer.exact or not np.isfinite(deficits).any():
        return math.nan
    position = state.uncertainty["half_width"]
    if not math.isfinite(position):
        return math.inf
    largest = _READING.angle_rounding
    for step in (position, -position):  # all free lines outwards, then inwards
        outwards = np.where(state.pinned | state.at_axis, 0.0, [-step, step])
        moved = replace(state, contacts=state.contacts + outwards)
        change = np.abs(moved.angle_deficits - deficits)
        largest = max(largest, float(np.nanmax(change)))
    if state.spacing > 0:
        links = state.spacing / scene.elastocapillary_length
        largest += links**2 / 12 * float(np.abs(state.line_slopes[1]).max())
    return largest


def rounded(value: float, error: float) -> str:
    """A number to the digit that its error changes, and to 10 at most.

    >>> rounded(0.01413690508, 3.8e-3), rounded(0.01413690508, 1e-18)
    ('0.014', '0.01413690508')
    """
    if not value or not 0 < error < math.inf:
        return f"{value:.{_READING.digits}g}"
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(error)) + 1
    return f"{value:.{min(max(digits, 1), _READING.digits)}g}"


def _error_text(value: float, error: float, unit: str) -> str:
    """The numerical error of a value in words; both in the unit that is written after it."""
    if math.isnan(error):
        return "numerical error not estimated"
    if not math.isfinite(error):
        return _UNRESOLVED
    if error <= 0.5 * 10.0**-_READING.digits * abs(value) or not error:
        return "numerical error below rounding"
    return f"numerical error {error:.1g}{unit}"


def units_of(scene: Scene) -> dict[str, str]:
    """SI units of what is read off a state, those of its scene if that is in SI units."""
    per = scene.per_length
    return {"depth": " m", "half_width": " m", "force": f" N{per}", "energy": f" J{per}"}


def state_text(state: Any) -> str:
    """The observables with their numerical errors, and how far the model's assumptions hold.

    Units are those of SI, which they are if the numbers of the scene are.
    """
    kind = f"{state.label}, {state.branch} branch, {state.method}"
    units = units_of(state.scene)
    errors = state.uncertainty
    width = "radius" if state.scene.axisymmetric else "half-width"
    lines = [f"depth        d = {state.depth:.{_READING.digits}g} m   ({kind})"]
    for name, head in (("half_width", f"{width:12s} a"), ("force", "force        P")):
        lines.append(_measured_text(head, getattr(state, name), errors[name], units[name]))
    lines.append(_measured_text("energy       U", state.energy, errors["energy"], units["energy"]))
    lines.append(_angle_text(state))
    lines += _relative_to(state)
    return "\n".join(lines + [f"validity     {a}" for a in state.validity])


def _measured_text(head: str, value: float, error: float, unit: str) -> str:
    """One line of a state's text: an observable with its error."""
    return f"{head} = {rounded(value, error)}{unit}   ({_error_text(value, error, unit)})"


def _angle_text(state: Any) -> str:
    """One line of a state's text: θ with its error, and whether lines are pinned.

    Pinned lines have the angle that the depth gives them.
    """
    deficit = state.angle_deficit
    if math.isnan(deficit):
        return "angle        none, as there is no contact line under tension"
    scene = state.scene
    if scene.slopes == "small" and scene.work_of_adhesion > 2 * scene.gamma1:
        return (
            f"angle        none by Young's law, w > 2γ₁   (π - θ = {deficit:.6g} of small slopes)"
        )
    error = angle_error(state)
    theta = state.contact_angle
    shown = rounded(deficit, error) if error < 1 else f"{deficit:.6g}"
    pinned = state.pinned[~state.at_axis]
    if pinned.all():
        where = "; pinned at a corner"
    elif pinned.any():
        where = "; a mean, with lines pinned at corners"
    else:
        where = ""
    known = _error_text(theta, error, " rad")
    return f"angle        θ = {rounded(theta, error)} rad   ({known}; π - θ = {shown}{where})"


def _relative_to(state: Any) -> list[str]:
    """Lines of a state's text: relative errors on nodes, and what they are relative to; else none.

    Terms of U cancel, so that its error over U itself may be many times as large.
    """
    errors = state.error_estimate
    scales = state.scales
    if not (state.spacing > 0 and state.contacts.size and all(map(math.isfinite, errors.values()))):
        return []
    terms = [f"{errors[name]:.1e} of {scales[name]:.4g}" for name in ("force", "energy")]
    return [
        f"relative     errors are {errors['half_width']:.1e} of a, and {' and '.join(terms)},",
        "             the sums of the absolute values of the terms of P and of U",
    ]


def path_columns(history: Any) -> dict[str, Array]:
    """Columns of a data frame: what is imposed, and the state at every step.

    Parameters
    ----------
    history : History

    Returns
    -------
    dict of ndarray (n,)
        left, right: the outermost contact lines [length], nan when detached; contacts: how many
        there are.
    """
    left, right = history.contacts.T
    inner = np.array([len(lines) // 2 + 1 for lines in history.inner], float)
    names = ("depth", "half_width", "force", "energy")
    return {
        "control": history.values,
        **{name: getattr(history, name) for name in names},
        "left": left,
        "right": right,
        "contacts": np.where(np.isnan(left), 0.0, inner),
    }


def path_line(history: Any) -> str:
    """One line with the counts and the energy lost.

    Parameters
    ----------
    history : History

    Returns
    -------
    str
    """
    counts = f"{len(history)} steps of {history.control}, {len(history.events)} events"
    return f"History({counts}, dissipated={history.dissipated:.6g})"


def path_text(history: Any, si: bool = True) -> str:
    """The events in their order, the most tensile state, the energy lost, and assumptions that do
    not hold.

    Parameters
    ----------
    history : History
    si : bool
        Whether SI units are written, which the numbers have if those of the scene do.

    Returns
    -------
    str
    """
    control = history.control
    count = len(history.events)
    per = history.scene.per_length
    written = "/({})" if per else "/{}"
    units = {"depth": "/m", "force": written.format(f"N{per}"), "lost": written.format(f"J{per}")}
    names = [f"{name}{unit}" if si else name for name, unit in units.items()]
    lines = [f"load path: {len(history)} steps of {control}, {count} events"]
    imposed = () if control == "depth" else (control,)  # a depth has its column
    lines.append(f"{'event':18s}" + "".join(f"{name:>14s}" for name in (*imposed, *names)))
    for event in history.events:
        values = (event.control, event.depth, event.force, event.energy_released)[not imposed :]
        lines.append(f"{event.kind:18s}" + "".join(f"{value:>14.6g}" for value in values))
    metres, newtons, joules = (" m", f" N{per}", f" J{per}") if si else ("", "", "")
    if (pull := most_tensile(history)) is not None:
        at = f"d = {pull.depth:.6g}{metres}, a = {pull.half_width:.6g}{metres}"
        lines.append(f"most tensile: P = {pull.force:.6g}{newtons} at {at}")
    lines.append(f"energy lost on the path: {history.dissipated:.6g}{joules}")
    if history.spacing is not None:
        lines.append(
            "errors: `error_estimate` follows the path on half as many nodes and compares; those "
            "of a state are relative to the sums of the absolute terms of P and of U"
        )
    return "\n".join([*lines, *(f"validity     {violated}" for violated in history.warnings)])


def most_tensile(history: Any) -> Any:
    """`History.pull_off`; None for a path without tension."""
    try:
        return history.pull_off
    except ValueError:
        return None
