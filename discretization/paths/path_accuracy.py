"""How accurate a load path on nodes is: next to the same programme on half as many nodes.

With Q a value at a step, Q_c that on nodes c times further apart (c = 2, but for bodies whose edges
are nodes), and errors O(Δx²),

    e <= 3/2 |Q - Q_c|/(c² - 1),

the largest over all steps. Depths of events are only trusted to the whole difference |C - C_c| of
the control: at a step as close to an event as that, the state may be the one on its other side, and
what they differ by counts instead. The energy lost is a sum over the events, so that errors do not
cancel: 3/2 of the sum of |E - E_c|/(c² - 1).

Where the events are others, errors are of first order: 3/2 |Q - Q_c|/(c - 1), with a warning.

Both paths are a `History` of the same values of the control, step by step; quantities are those of
its columns, named in COLUMNS. Steps are numbered from 0; `Event.step` is the step after the event.

An `Event` has a `kind`, the value of the `control`, the states `before` and `after` it, and
`energy_released`, what is lost in it. `History.friction` is what lines lose as they move under
adhesion hysteresis, and `dissipated` the sum of both. EPSILON is 2⁻⁵².
"""

import math
import warnings
from typing import Any

import numpy as np

from discretization.certificate import EPSILON, AccuracyWarning
from energy.arrays import Array

COLUMNS = ("depth", "half_width", "force", "energy")
QUANTITIES = (*COLUMNS, "dissipated")
# By which differences between two lattices are enlarged, as those of states (`safety` in
# lattice/accuracy.py).
_SAFETY = 1.5
_ROUNDING = 16 * EPSILON  # of every estimate: what a sum of a dozen terms leaves


def estimated(fine: Any, coarse: Any, coarser: float, stacklevel: int) -> dict[str, float]:
    """Relative errors of a path on nodes, from the same programme on wider ones.

    Parameters
    ----------
    fine, coarse : History
        The path, and the one on wider nodes.
    coarser : float
        Spacing of the wider nodes over that of the path, c.
    stacklevel : int
        Of the warning, counted from the caller.

    Returns
    -------
    dict
        By the names in QUANTITIES; 0 for what is 0 on all of the path.

    Warns
    -----
    AccuracyWarning
        Where the events differ.
    """
    alike = [event.kind for event in fine.events] == [event.kind for event in coarse.events]
    if not alike:
        warnings.warn(
            f"on half as many nodes there are {len(coarse.events)} events instead of "
            f"{len(fine.events)}, or others: the error estimate is of first order; give a smaller "
            "spacing",
            AccuracyWarning,
            stacklevel=stacklevel + 1,
        )
    share = _SAFETY / ((coarser**2 if alike else coarser) - 1)
    unsure = _next_to_events(fine, coarse) if alike else {}
    found = {}
    for name in COLUMNS:
        values = np.array(getattr(fine, name), float)
        errors = share * _apart(values, np.array(getattr(coarse, name), float))
        for step, event in unsure.items():
            jump = abs(getattr(event.before, name) - getattr(event.after, name))
            errors[step] = max(errors[step], jump if math.isfinite(jump) else 0.0)
        found[name] = _relative(float(errors.max(initial=0.0)), _size(values, name))
    lost = [abs(event.energy_released) for event in fine.events]
    if alike:
        pairs = zip(fine.events, coarse.events, strict=True)
        changes = [abs(one.energy_released - other.energy_released) for one, other in pairs]
        change = sum(changes) + abs(fine.friction - coarse.friction)
    else:
        change = abs(fine.dissipated - coarse.dissipated)
    found["dissipated"] = _relative(share * change, sum(lost) + abs(fine.friction))
    return found


def _next_to_events(fine: Any, coarse: Any) -> dict[int, Any]:
    """The numbers of the steps that may be on the other side of an event, each with that event.

    They are those next to it whose value of the control is no further from that of the event than
    this differs on both paths.

    fine, coarse: the same programme on nodes and on wider ones, with the same kinds of events in
    the same order.
    """
    found = {}
    for event, other in zip(fine.events, coarse.events, strict=True):
        unknown = abs(event.control - other.control)
        for step in (event.step - 1, event.step):
            if 0 <= step < len(fine) and abs(fine.values[step] - event.control) <= unknown:
                found[step] = event
    return found


def _apart(values: Array, others: Array) -> Array:
    """|Q - Q_c| at the steps; 0 where a dead load has pulled the indenter away."""
    known = np.isfinite(values) & np.isfinite(others)
    return np.abs(np.where(known, values, 0.0) - np.where(known, others, 0.0))


def _size(values: Array, name: str) -> float:
    """What errors are relative to: the largest value, of depths the range."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    return float(np.ptp(known) if name == "depth" else np.abs(known).max())


def _relative(error: float, size: float) -> float:
    """The error over the size, with rounding; 0 where there is no size."""
    return error / size + _ROUNDING if size else 0.0
