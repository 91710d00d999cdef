"""What `runtime_vs_error` records."""

from __future__ import annotations

from typing import NamedTuple


class Point(NamedTuple):
    """One method on one task at one size.

    modelling, first: seconds of preparing and of the first call, which may fill caches;
    seconds: median of further ones (of one step in a loop); spread: interquartile range over it;
    ratio: median over dptsv of n unknowns; errors: of a, P, U, θ; note: why there is no answer.
    """

    task: str
    method: str
    size: float
    unknowns: int
    modelling: float
    first: float
    seconds: float
    spread: float
    ratio: float
    errors: tuple[float, float, float, float]
    success: bool
    note: str = ""

    @classmethod
    def failed(cls, task: str, method: str, size: float, note: str) -> Point:
        """Nothing measured."""
        none = float("nan")
        return cls(task, method, size, 0, *(none,) * 5, (none,) * 4, False, note)


class Floor(NamedTuple):
    """Seconds of one dptsv with n unknowns and of one pass over n numbers."""

    unknowns: int
    dptsv: float
    one_pass: float
