"""Argument checks: every error names the argument, its value and the remedy."""

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from energy.arrays import Array

LARGEST = 1e60  # products of a few such numbers still have a float; no unit system needs more


def real(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is one finite real number."""
    try:
        number = None if isinstance(value, (bool, np.bool_, str, bytes)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None:
        raise ValueError(f"{name} = {value!r} is not a number; give one finite number")
    if not math.isfinite(number):
        raise ValueError(f"{name} = {value!r} is not finite; give one finite number")
    return number


def finite(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is real, finite and not beyond computing."""
    number = real(name, value)
    if abs(number) > LARGEST:
        raise ValueError(f"{name} = {value!r} is too large to compute with; choose other units")
    return number


def array(name: str, values: Any) -> Array:
    """Return values as a new array of floats; ValueError unless real and not beyond computing."""
    try:
        raw = np.asarray(values)
        numbers = raw.astype(float) if raw.dtype.kind in "iufO" else None
    except (TypeError, ValueError):
        numbers = None
    if numbers is None:
        raise ValueError(f"{name} = {values!r} must be a sequence of real numbers")
    if (np.abs(numbers[np.isfinite(numbers)]) > LARGEST).any():
        raise ValueError(f"{name} = {values!r} is too large to compute with; choose other units")
    return numbers


def positive(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is finite and > 0."""
    number = finite(name, value)
    if number <= 0:
        raise ValueError(f"{name} = {value!r} must be positive; give a value > 0")
    return _large_enough(name, number)


def not_negative(name: str, value: float) -> float:
    """Return value as a float; ValueError unless it is finite and >= 0."""
    number = finite(name, value)
    if number < 0:
        raise ValueError(f"{name} = {value!r} must not be negative; give a value >= 0")
    return _large_enough(name, number) if number else number


def _large_enough(name: str, number: float) -> float:
    if number < 1 / LARGEST:
        raise ValueError(f"{name} = {number!r} is too small to compute with; choose other units")
    return number


def option(name: str, value: str, known: Iterable[str]) -> str:
    """Return value; ValueError with the known options unless it is one of them."""
    known = tuple(known)
    if value not in known:
        raise ValueError(
            f"{name} = {value!r} is unknown{nearest(value, known)}; choose one of "
            f"{', '.join(map(repr, known))}"
        )
    return value


def nearest(value: object, known: Iterable[str]) -> str:
    """What may have been meant by a word that is unknown, to be put behind that; may be empty."""
    lower = {word.lower(): word for word in known}
    given = str(value).lower()
    close = difflib.get_close_matches(given, lower, len(lower) or 1)
    if not close:
        return ""

    def likeness(word: str) -> float:
        return difflib.SequenceMatcher(None, word, given).ratio()

    best = likeness(close[0])
    first = next(word for word in lower if word in close and likeness(word) == best)
    return f": did you mean {lower[first]!r}?"


def not_a_class(name: str, value: object) -> None:
    """ValueError if value is a class, where an object made with it is needed."""
    if isinstance(value, type):
        raise ValueError(f"{name} = {value.__name__} is a class; make one: {value.__name__}(...)")
