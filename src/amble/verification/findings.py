"""What a check found: named rows with their bounds, where the worst value occurred, and what is accepted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amble.errors import Row
from amble.types import Matrix, Vector


@dataclass(frozen=True)
class Finding:
    """The worst value of one checked quantity in one domain or switch.

    Attributes:
        family: kind of the quantity, such as "motion" or "friction".
        row: name, bounds and worst value.
        time: clock of the domain at which the worst value occurs, s; NaN where the quantity has no time.
        slack: how far the value may leave its bounds; zero for residuals, whose bounds are their tolerance.
    """

    family: str
    row: Row
    time: float
    slack: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether the value lies within its bounds and the slack."""
        return self.row.violation <= self.slack

    @property
    def severity(self) -> float:
        """Order of badness inside a family: the share of its bounds that a residual uses, how far a limit is missed."""
        row = self.row
        if np.isnan(row.value):
            return float("inf")
        if row.lower == -row.upper and np.isfinite(row.upper) and row.upper > 0.0:
            return abs(row.value) / row.upper
        return max(row.lower - row.value, row.value - row.upper)

    def __str__(self) -> str:
        """Lower | value | upper, name, time, and a mark where the row fails."""
        row = self.row
        when = "" if np.isnan(self.time) else f"  at {self.time:.4f} s"
        mark = "" if self.passed else f"  FAILED by {row.violation:.3g}"
        return f"{row.lower:>12.5g} | {row.value:>12.5g} | {row.upper:>12.5g}   {row.name}{when}{mark}"


@dataclass(frozen=True)
class CheckReport:
    """The result of a check: every checked quantity as a named row.

    Attributes:
        findings: all rows, in the order of the domains.
        points: number of points along all domains that were looked at.
        tolerance: bound of every residual.
    """

    findings: tuple[Finding, ...]
    points: int
    tolerance: float

    @property
    def rows(self) -> tuple[Row, ...]:
        """Every row: lower bound, worst value, upper bound, by name."""
        return tuple(finding.row for finding in self.findings)

    @property
    def failed(self) -> tuple[Finding, ...]:
        """The rows that fail, worst first inside their family."""
        bad = [finding for finding in self.findings if not finding.passed]
        families = list(dict.fromkeys(finding.family for finding in self.findings))
        return tuple(sorted(bad, key=lambda finding: (families.index(finding.family), -finding.severity)))

    @property
    def passed(self) -> bool:
        """Whether no row fails."""
        return all(finding.passed for finding in self.findings)

    @property
    def worst(self) -> dict[str, Finding]:
        """Family -> the row that is nearest to failing, or fails worst."""
        worst: dict[str, Finding] = {}
        for finding in self.findings:
            held = worst.get(finding.family)
            if held is None or (not finding.passed, finding.severity) > (not held.passed, held.severity):
                worst[finding.family] = finding
        return worst

    def __str__(self) -> str:
        """The worst row of every family, then every row that fails."""
        lines = [f"{'lower':>12} | {'value':>12} | {'upper':>12}   worst row of each family"]
        lines += [f"{finding}" for finding in self.worst.values()]
        if self.failed:
            lines += ["", f"{len(self.failed)} of {len(self.findings)} rows fail:", *map(str, self.failed)]
        else:
            lines += ["", f"all {len(self.findings)} rows hold at {self.points} points"]
        return "\n".join(lines)


def residuals(
    family: str, names: Sequence[str], values: Matrix, times: Vector, tolerance: float, scale: Vector | float = 1.0
) -> list[Finding]:
    """Return one row a column of residuals: the largest in size, signed, divided by the scale.

    Args:
        family: kind of the quantity.
        names: name of every column.
        values: (points, columns).
        times: clock of every point, (points,), s.
        tolerance: bound of the scaled residual.
        scale: what the residuals are divided by, one for all or one a column.
    """
    found = []
    for name, column in zip(names, (np.asarray(values).reshape(len(times), len(names)) / scale).T, strict=True):
        place = int(np.argmax(np.where(np.isnan(column), np.inf, np.abs(column))))
        found.append(Finding(family, Row(name, -tolerance, float(column[place]), tolerance), float(times[place])))
    return found


def limit(family: str, name: str, values: Vector, times: Vector, bounds: tuple[float, float], slack: float) -> Finding:
    """Return the row of the value that leaves its bounds furthest, or comes closest to one of them.

    Args:
        family: kind of the quantity.
        name: name of the row.
        values: (points,).
        times: clock of every point, (points,), s.
        bounds: lower and upper bound.
        slack: how far a value may leave its bounds.
    """
    lower, upper = bounds
    excess = np.maximum(lower - values, values - upper)
    place = int(np.argmax(np.where(np.isnan(excess), np.inf, excess)))
    return Finding(family, Row(name, lower, float(values[place]), upper), float(times[place]), slack)
