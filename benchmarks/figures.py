"""One measured number of a benchmark, with the limit it is held to."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Figure:
    """A number that was measured.

    Attributes:
        name: what was measured.
        value: the number.
        unit: its unit.
        most: the largest value that is allowed, where there is one.
        least: the smallest value that is allowed, where there is one.
        runs: how many runs the value is the median of.
        note: settings, sizes, reasons.
    """

    name: str
    value: float
    unit: str
    most: float | None = None
    least: float | None = None
    runs: int = 1
    note: str = ""

    @property
    def limit(self) -> str:
        """The limit as text."""
        if self.most is not None:
            return f"<= {self.most:g}"
        return "" if self.least is None else f">= {self.least:g}"

    @property
    def verdict(self) -> str:
        """Whether the limit holds."""
        if self.most is None and self.least is None:
            return ""
        inside = (self.most is None or self.value <= self.most) and (self.least is None or self.value >= self.least)
        return "met" if inside else "MISSED"


def timed(
    call: Callable[[], Result], runs: int = 3, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, Result]:
    """Return the median time of some runs, s, and the last result; wall time unless another clock is given."""
    seconds = []
    for _ in range(runs):
        began = clock()
        result = call()
        seconds.append(clock() - began)
    return statistics.median(seconds), result


def show(figures: list[Figure]) -> None:
    """Print figures, one a line."""
    for figure in figures:
        print(
            f"{figure.name:52} {figure.value:10.4g} {figure.unit:8} {figure.limit:10} {figure.verdict:7} {figure.note}"
        )
