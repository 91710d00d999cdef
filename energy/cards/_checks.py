"""Argument checks shared by the cards: a refusal names argument, value and remedy.

Conventions: arguments are numbers or arrays of float64 of shapes that broadcast; what a function
returns for numbers is a number (`unwrap`), not an array of shape ().
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from energy.arrays import Array

# Slack of `excess`, in roundings of the terms: a bound such as -√(2w/k) is computed by the caller
# and by the card, in four operations each.
_ROUNDINGS = 8
# What an argument of a name is, for messages.
_MEANING = {
    "E": "the elastic modulus E",
    "K": "the machine stiffness K per length, or use load_control",
    "R": "the radius of curvature R of f = x²/(2R)",
    "a": "the contact half-width, or its radius",
    "b": "the inner radius of a ring",
    "c": "the coefficient c of f = c|x|ⁿ",
    "gamma1": "the surface tension γ₁ of the free surface",
    "h": "the layer thickness",
    "k": "the foundation stiffness Ẽ/h",
    "w": "the work of adhesion",
    "w_closing": "the work of adhesion that closing contact gains",
}


def finite(name: str, value: ArrayLike) -> Array:
    """The argument as float64 numbers, none of them NaN or infinite."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r} is not real: pass a number or an array") from None
    refuse(name, numbers, ~np.isfinite(numbers), "is not finite: pass finite numbers")
    return unwrap(numbers)


def positive(name: str, value: ArrayLike) -> Array:
    """The argument, every entry > 0."""
    numbers = finite(name, value)
    remedy = f"must be > 0: pass {_MEANING.get(name, 'a positive number')}"
    refuse(name, numbers, numbers <= 0.0, remedy)
    return numbers


def non_negative(name: str, value: ArrayLike) -> Array:
    """The argument, every entry >= 0."""
    numbers = finite(name, value)
    remedy = f"must be >= 0: pass {_MEANING.get(name, 'a non-negative number')}"
    refuse(name, numbers, numbers < 0.0, remedy)
    return numbers


def wedge_slope(delta: ArrayLike) -> Array:
    """tan δ of a wedge angle δ in (0, π/2)."""
    angle = finite("delta", delta)
    bad = (angle <= 0.0) | (angle >= np.pi / 2)
    refuse("delta", angle, bad, "must lie in (0, π/2): pass the wedge angle in rad")
    slope: Array = np.tan(angle)
    return slope


def excess(
    name: str, value: Array, bound: Array | float, remedy: str, *, scale: Array | float = 0.0
) -> Array:
    """value − bound >= 0; a shortfall of a few roundings counts as 0, a larger one is refused.

    `name` and `remedy` are for the message, `scale` is the size of the terms that cancel in
    `bound`, where there are such.
    """
    over = value - bound
    rounding = np.finfo(np.float64).eps * (np.abs(value) + np.abs(bound) + scale)
    slack = _ROUNDINGS * rounding
    limit = unwrap(np.asarray(bound, dtype=np.float64))
    refuse(name, value, over < -slack, f"is below {limit}: {remedy}")
    clipped: Array = np.maximum(over, 0.0)
    return clipped


def refuse(name: str, value: Array, bad: Any, remedy: str) -> None:
    """Raise ValueError with the first entry of `value` at which `bad` is true, if there is one."""
    if np.any(bad):
        values, flags = np.broadcast_arrays(value, bad)
        raise ValueError(f"{name} = {float(values[flags][0])!r} {remedy}")


def not_zero(numbers: Array) -> Array:
    """The numbers, with 1 in place of 0: divisors of terms that are 0 there, too."""
    return unwrap(np.where(numbers == 0.0, 1.0, numbers))


def unwrap(numbers: Array) -> Array:
    """A zero-dimensional array as a number, any other array as it is."""
    inner: Array = numbers[()]
    return inner
