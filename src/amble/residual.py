"""A checked quantity with its bounds: what solver failures, checks, monitors and certificates show as evidence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from math import inf, isfinite, isnan

HEADER = f"{'lower':>12} | {'value':>12} | {'upper':>12}"


@dataclass(frozen=True)
class Residual:
    """One named scalar quantity with its bounds and the value it took.

    Attributes:
        name: what it is and where.
        lower: smallest value that is accepted.
        value: the value, where there were several the worst one.
        upper: largest value that is accepted.
        kind: what sort of quantity it is, such as "friction"; empty where its owner has only one.
        slack: how far the value may leave its bounds and still pass.
        time: when the value occurred, s, on the clock of its owner; None where it has no time.
        cycle: the cycle in which it occurred; None where there is none.
    """

    name: str
    lower: float
    value: float
    upper: float
    _: KW_ONLY
    kind: str = ""
    slack: float = 0.0
    time: float | None = None
    cycle: int | None = None

    @property
    def violation(self) -> float:
        """Distance of the value from the interval, zero inside; infinite for a value that is not a number."""
        return inf if isnan(self.value) else max(self.lower - self.value, self.value - self.upper, 0.0)

    @property
    def passed(self) -> bool:
        """Whether the value lies within its bounds and the slack."""
        return self.violation <= self.slack

    @property
    def closeness(self) -> float:
        """How near to its bounds a value is: the share of them where they are symmetric, else minus the distance."""
        if isnan(self.value):
            return inf
        if self.lower == -self.upper and isfinite(self.upper) and self.upper > 0.0:
            return abs(self.value) / self.upper
        return max(self.lower - self.value, self.value - self.upper)

    def widened(self) -> Residual:
        """Return the same quantity with its slack inside its bounds."""
        return replace(self, lower=self.lower - self.slack, upper=self.upper + self.slack, slack=0.0)

    def __str__(self) -> str:
        """Lower bound, value and upper bound in columns; name, time, cycle, and by how much it fails."""
        when = "" if self.time is None else f"  at {self.time:.4f} s"
        lap = "" if self.cycle is None else f", cycle {self.cycle}"
        mark = "" if self.passed else f"  (violated by {self.violation:.3g})"
        return f"{self.lower:>12.5g} | {self.value:>12.5g} | {self.upper:>12.5g}   {self.name}{when}{lap}{mark}"


def worst_first(residuals: Iterable[Residual]) -> tuple[Residual, ...]:
    """Sort by failing or not, then violation, then closeness to the bounds; ties keep their order."""
    return tuple(sorted(residuals, key=_badness, reverse=True))


def worst_of_kinds(residuals: Iterable[Residual]) -> dict[str, Residual]:
    """Return kind -> the residual that is nearest to failing, or fails worst; kinds in the order they come."""
    kinds: dict[str, list[Residual]] = {}
    for residual in residuals:
        kinds.setdefault(residual.kind, []).append(residual)
    return {kind: worst_first(members)[0] for kind, members in kinds.items()}


def listing(residuals: Sequence[Residual], most: int | None = None) -> str:
    """Write residuals one a line, below each other; what is more than ``most`` is counted."""
    lines = [str(residual) for residual in residuals[:most]]
    if len(residuals) > len(lines):
        lines.append(f"... and {len(residuals) - len(lines)} more")
    return "\n".join(lines)


def _badness(residual: Residual) -> tuple[bool, float, float]:
    return not residual.passed, residual.violation, residual.closeness
