"""Argument checks: every error names the argument, its value and the remedy."""

from __future__ import annotations

import math
from collections.abc import Iterable


def finite(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is one finite real number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r} is not a number; give one finite number") from None
    if isinstance(value, (bool, str)) or not math.isfinite(number):
        raise ValueError(f"{name} = {value!r} is not finite; give one finite number")
    return number


def positive(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is finite and > 0."""
    number = finite(name, value)
    if number <= 0:
        raise ValueError(f"{name} = {value!r} must be positive; give a value > 0")
    return number


def not_negative(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is finite and >= 0."""
    number = finite(name, value)
    if number < 0:
        raise ValueError(f"{name} = {value!r} must not be negative; give a value >= 0")
    return number


def option(name: str, value: str, known: Iterable[str]) -> str:
    """Return value; ValueError with the known options unless it is one of them."""
    known = tuple(known)
    if value not in known:
        raise ValueError(
            f"{name} = {value!r} is unknown; choose one of {', '.join(map(repr, known))}"
        )
    return value
