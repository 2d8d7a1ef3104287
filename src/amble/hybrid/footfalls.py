"""Footfalls: a gait by the phase at which every foot lands and the share of the cycle that it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

from amble.errors import InputError

ROUNDING = 1e-9
"""Phases closer than this are one instant, as a share of the cycle."""


@dataclass(frozen=True)
class Footfall:
    """When a foot stands.

    Attributes:
        phase: of its landing, as a share of the cycle; whole numbers more or less are the same.
        duty: duty factor, the share of the cycle that it stands, above 0 and at most 1.

    Raises:
        InputError: the phase is not finite, or the duty factor is not in its range.
    """

    phase: float
    duty: float

    def __post_init__(self) -> None:
        """Check both numbers."""
        if not isfinite(self.phase):
            raise InputError(f"the phase of a footfall is {self.phase}; it must be finite")
        if not ROUNDING < self.duty <= 1.0:
            raise InputError(f"the duty factor of a footfall is {self.duty:g}; it must be above 0 and at most 1")

    def down(self, phase: float) -> bool:
        """Whether the foot stands at a phase of the cycle."""
        return (phase - self.phase) % 1.0 < self.duty


def stance_table(footfalls: Mapping[str, Footfall]) -> tuple[tuple[str, ...], ...]:
    """Return the feet on the ground between one landing or lift-off and the next, one row a domain, from phase 0 on.

    How long the domains last is up to the gait problem; their order is what the footfalls say.

    Args:
        footfalls: foot -> when it stands.
    """
    moments = (fall.phase + part for fall in footfalls.values() if fall.duty < 1.0 for part in (0.0, fall.duty))
    events: list[float] = []
    for moment in sorted(moment % 1.0 for moment in moments):
        if not events or moment - events[-1] > ROUNDING:
            events.append(moment)
    if len(events) > 1 and events[0] + 1.0 - events[-1] <= ROUNDING:
        events.pop()
    ends = [*events[1:], events[0] + 1.0] if events else []
    middles = [0.5 * (begin + end) for begin, end in zip(events, ends, strict=True)]
    return tuple(tuple(foot for foot, fall in footfalls.items() if fall.down(middle)) for middle in middles)
