"""What sorts of rows a gait problem has; code selects rows by these, never by their names."""

from __future__ import annotations

from enum import StrEnum

from amble.synthesis.assembly import Label


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
    PHASE_RATE = "phase rate"
    PHASE = "phase"
    DEFECT = "defect"
    CONTINUITY = "continuity"
    IMPACT = "impact"
    TOUCHDOWN = "touchdown"
    LIFT_OFF = "lift-off"
    LANDING_ORDER = "landing order"
    PERIOD = "period"

    def labels(self, *names: str) -> list[Label]:
        """Return labels of this kind, by the names that people read."""
        return [Label(self.value, name) for name in names]


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
