"""Checks of arguments: every error names the argument, its value and the remedy."""

import contextlib
import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from energy.arrays import Array

# Largest size of a number that is computed with. A float reaches 1.8e308, so that products of five
# such numbers do not overflow; no system of units needs more. Its inverse is the least size.
LARGEST = 1e60


def real(name: str, value: float) -> float:
    """One finite real number as a float.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : float
        What was given; anything that `float` accepts but truth values and text.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If it is no number, NaN or infinite.
    """
    number: float | None = None
    if not isinstance(value, (bool, np.bool_, str, bytes)):
        with contextlib.suppress(TypeError, ValueError, OverflowError):
            number = float(value)
    if number is None:
        raise ValueError(f"{name} = {value!r} is not a number; give one finite number")
    if not math.isfinite(number):
        raise ValueError(f"{name} = {value!r} is not finite; give one finite number")
    return number


def finite(name: str, value: float) -> float:
    """One finite real number of a size that can be computed with, as a float.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : float
        What was given.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        As `real`, and beyond `LARGEST`.
    """
    number = real(name, value)
    if abs(number) > LARGEST:
        raise ValueError(f"{name} = {value!r} is too large to compute with; choose other units")
    return number


def array(name: str, values: Any) -> Array:
    """A new array of floats from a sequence of real numbers.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    values : array_like
        What was given: integers, floats, or objects that are real numbers.

    Returns
    -------
    ndarray
        Of the same shape; NaN and infinite numbers stay.

    Raises
    ------
    ValueError
        If an entry is no real number, or finite and beyond `LARGEST`.
    """
    numbers: Array | None = None
    with contextlib.suppress(TypeError, ValueError):
        raw = np.asarray(values)
        # A letter for the kind of number: integers, unsigned ones, floats, objects.
        if raw.dtype.kind in "iufO":
            numbers = raw.astype(float)
    if numbers is None:
        raise ValueError(f"{name} = {values!r} must be a sequence of real numbers")
    sizes = np.abs(numbers[np.isfinite(numbers)])
    if (sizes > LARGEST).any():
        raise ValueError(f"{name} = {values!r} is too large to compute with; choose other units")
    return numbers


def positive(name: str, value: float) -> float:
    """A number > 0 as a float.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : float
        What was given.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        As `finite`, for a number <= 0 and one below 1/`LARGEST`.
    """
    number = finite(name, value)
    if number <= 0:
        raise ValueError(f"{name} = {value!r} must be positive; give a value > 0")
    return _large_enough(name, number)


def not_negative(name: str, value: float) -> float:
    """A number >= 0 as a float.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : float
        What was given.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        As `finite`, for a number < 0 and one between 0 and 1/`LARGEST`.
    """
    number = finite(name, value)
    if number < 0:
        raise ValueError(f"{name} = {value!r} must not be negative; give a value >= 0")
    if number == 0:
        return number
    return _large_enough(name, number)


def _large_enough(name: str, number: float) -> float:
    """The positive number; ValueError below 1/`LARGEST`."""
    if number < 1 / LARGEST:
        raise ValueError(f"{name} = {number!r} is too small to compute with; choose other units")
    return number


def option(name: str, value: str, known: Iterable[str]) -> str:
    """The value, if it is one of the known options.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : str
        What was given.
    known : iterable of str
        The options there are.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        Which lists the known options, and the nearest of them, for any other value.
    """
    known = tuple(known)
    if value in known:
        return value
    suggestion = nearest(value, known)
    listed = ", ".join(map(repr, known))
    raise ValueError(f"{name} = {value!r} is unknown{suggestion}; choose one of {listed}")


def nearest(value: object, known: Iterable[str]) -> str:
    """The end of a message that suggests a known word in place of an unknown one.

    Parameters
    ----------
    value : object
        The unknown word.
    known : iterable of str
        The words there are.

    Returns
    -------
    str
        ": did you mean 'gamma1'?" with the known word most alike, the first of several; "" if none
        is alike.
    """
    lower = {word.lower(): word for word in known}
    given = str(value).lower()
    close = difflib.get_close_matches(given, lower, n=max(len(lower), 1))
    if not close:
        return ""

    def likeness(word: str) -> float:
        """Share of letters in common and in order, from 0 to 1."""
        return difflib.SequenceMatcher(None, word, given).ratio()

    best = likeness(close[0])
    first = next(word for word in lower if word in close and likeness(word) == best)
    return f": did you mean {lower[first]!r}?"


def not_a_class(name: str, value: object) -> None:
    """Refuse a class where an object made with it is needed.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : object
        What was given.

    Raises
    ------
    ValueError
        If it is a class.
    """
    if isinstance(value, type):
        raise ValueError(f"{name} = {value.__name__} is a class; make one: {value.__name__}(...)")
