"""What sorts of rows a gait problem has; code selects rows by these, never by their names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import casadi as ca

from amble.synthesis.block import Label


class RowKind(StrEnum):
    """What a row of the gait problem says."""

    DYNAMICS = "dynamics"
    CONTACT = "contact"
    OUTPUT = "output"
    OUTPUT_RATE = "output rate"
    OUTPUT_ACCELERATION = "output acceleration"
    LAW = "law"
    FRICTION = "friction"
    HEIGHT = "height"
    NORMAL_FORCE = "normal force"
    BASE_HEIGHT = "base height"
    PART_HEIGHT = "part height"
    LEGS_APART = "legs apart"
    TORQUE_SPEED = "torque over speed"
    PHASE_RATE = "phase rate"
    PHASE = "phase"
    BETWEEN_NODES = "between nodes"
    DEFECT = "defect"
    CONTINUITY = "continuity"
    IMPACT = "impact"
    TOUCHDOWN = "touchdown"
    LIFT_OFF = "lift-off"
    LANDING_ORDER = "landing order"
    LANDING_FORCE = "landing force"
    PERIOD = "period"

    def labels(self, names: Iterable[str], units: str | Iterable[str]) -> list[Label]:
        """Return labels of this kind, by the names that people read, with one unit for all or one each."""
        known = tuple(names)
        each = [units] * len(known) if isinstance(units, str) else units
        return [Label(self.value, name, unit) for name, unit in zip(known, each, strict=True)]


ROW_SIZES = {"N": 10.0, "N m": 10.0, "rad/s^2": 20.0}
"""Unit -> size of one unit of a scaled row, in units of the robot, so that rows of all kinds have similar size; 1 where
nothing is said."""


AT_ENTRY = (RowKind.OUTPUT, RowKind.OUTPUT_RATE)
"""Kinds that at the first node of a domain say something about the entry, which the domain before it decides."""

INITIAL_VALUE = (
    RowKind.DYNAMICS,
    RowKind.CONTACT,
    *AT_ENTRY,
    RowKind.OUTPUT_ACCELERATION,
    RowKind.LAW,
    RowKind.DEFECT,
)
"""Kinds that, but for ``AT_ENTRY`` at the first node, make every domain an initial value problem."""


@dataclass(frozen=True, kw_only=True)
class RowGroup:
    """Rows of a block that say one thing.

    Attributes:
        rows: expressions, one column each.
        labels: one a row, kind by kind.
        lower: lower bounds, one a row.
        upper: upper bounds, one a row.
    """

    rows: list[ca.SX]
    labels: list[Label]
    lower: list[float]
    upper: list[float]

    @classmethod
    def equalities(cls, rows: list[ca.SX], labels: list[Label]) -> RowGroup:
        """Rows that are zero."""
        return cls(rows=rows, labels=labels, lower=[0.0] * len(labels), upper=[0.0] * len(labels))
