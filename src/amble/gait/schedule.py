"""Gain scheduling of the impedance law: one law for a grid of gaits, interpolated at a command.

Over the share of the planned duration the references of all gaits are polynomial pieces with the same ends
(``schedule_tables``). Then what the law is packed into, durations, gains, ends of the pieces and coefficients, is
linear in them, and the law at a command between gaits is the multilinear interpolation of the packed numbers
(docs/howto/transitions.md, eq. 1).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait.control_law import Numbers
from amble.gait.impedance import PackedImpedance, unpacked
from amble.gait.landing_stances import landings
from amble.gait.linearising_law import control_of
from amble.gait.record import Gait
from amble.numerics.pieces import FAR
from amble.types import NodeValues, Vector, frozen

OUTSIDE = 1e-9
"""How far beyond the range a command may lie by rounding, as a share of the range."""


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """The impedance law of a grid of gaits with the same stances.

    Attributes:
        gait: one of them, which gives robot, stances, limits and the window of lift-offs; of gaits that turn, without
            the turn, so that its states are in the world's axes.
        axes: names of what is commanded, such as speed.
        values: of every axis, ascending, at least two.
        tables: packed numbers of every gait and law (``Impedance.numbers``), with the same ends of pieces as shares of
            the planned duration, (n_1, ..., n_axes, laws, size): of the solved stances, then of those between landings.
        starts: fixed points of the gaits, (n_1, ..., n_axes, 2 n_q).
        leads: torques of every gait that a change of the command by 1 a step adds, (n_1, ..., n_axes, axes, solved
            stances, n_joints), N m; None for none (``stability.leads``).
    """

    gait: Gait
    axes: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    tables: NodeValues
    starts: NodeValues
    leads: NodeValues | None = None

    def weights(self, command: Sequence[float]) -> Mapping[tuple[int, ...], float]:
        """Return the gaits around a command with their multilinear weights, those of weight 0 left out.

        Args:
            command: one number an axis.

        Raises:
            InputError: it lies outside the gaits.
        """
        found: dict[tuple[int, ...], float] = {(): 1.0}
        for axis, values, asked in zip(self.axes, self.values, command, strict=True):
            span = values[-1] - values[0]
            if not values[0] - OUTSIDE * span <= asked <= values[-1] + OUTSIDE * span:
                raise InputError(f"{axis} {asked:g} is outside the gaits, {values[0]:g} to {values[-1]:g}")
            cell = int(np.clip(np.searchsorted(values, asked, side="right") - 1, 0, len(values) - 2))
            share = min(max((asked - values[cell]) / (values[cell + 1] - values[cell]), 0.0), 1.0)
            found = {
                (*place, cell + side): weight * part
                for place, weight in found.items()
                for side, part in ((0, 1.0 - share), (1, share))
                if part > 0.0
            }
        return found

    def start(self, command: Sequence[float]) -> Vector:
        """Interpolate the gaits' fixed points, (2 n_q,): a guess of the one at a command."""
        return frozen(sum(weight * self.starts[place] for place, weight in self.weights(command).items()))

    def lead(self, command: Sequence[float]) -> NodeValues:
        """Interpolate the torques that a change of the command by 1 a step adds, (axes, solved stances, n_joints)."""
        if self.leads is None:
            return frozen(np.zeros((len(self.axes), len(self.gait.pattern.solved), len(self.gait.robot.joints))))
        return frozen(sum(weight * self.leads[place] for place, weight in self.weights(command).items()))

    def law(self, command: Sequence[float]) -> InterpolatedImpedance:
        """Return the law at a command."""
        packed = sum(weight * self.tables[place] for place, weight in self.weights(command).items())
        numbers = [_numbers(row, len(self.gait.robot.joints)) for row in packed]
        solved, between = len(self.gait.pattern.solved), [stance.name for stance, _ in landings(self.gait)]
        return InterpolatedImpedance(
            entries=tuple(numbers[:solved]),
            between=dict(zip(between, numbers[solved:], strict=True)),
            lift_offs=control_of(self.gait).lift_offs,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class InterpolatedImpedance(PackedImpedance):
    """The impedance law with numbers of its own.

    Attributes:
        entries: of every solved stance.
        between: of every stance between two landings, by its name.
        lift_offs: those of the gaits' laws.
    """

    units: ClassVar[Mapping[str, str]] = {}

    entries: tuple[Numbers, ...]
    between: Mapping[str, Numbers] = field(default_factory=dict)
    lift_offs: tuple[float, float] | None

    @property
    def name(self) -> str:
        """Name in messages."""
        return "interpolated impedance"

    def numbers(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[Numbers, ...]:
        """Return its numbers; the feed-forward is theirs."""
        del gait
        if allocation is not None:
            raise InputError("the interpolated law has the feed-forward of its gaits; it takes no allocation law")
        return self.entries

    def packed(self, gait: Gait, domain: str) -> Vector:
        """Return the parameters of a solved stance."""
        return self.entries[[stance.name for stance in gait.pattern.solved].index(domain)].parameters

    def landing_numbers(self, gait: Gait, allocation: AllocationLaw | None) -> Mapping[str, Numbers]:
        """Return those between landings."""
        del gait, allocation
        return self.between


def _numbers(packed: Vector, joints: int) -> Numbers:
    """The numbers of a stance, with the clocks at which they are not smooth."""
    ends, _, _, places, _ = unpacked(packed, joints)
    begins = places[0, 1:]
    clocks = sorted({*map(float, begins[begins < 0.5 * FAR]), *map(float, ends)})
    return Numbers(parameters=frozen(packed), breakpoints=tuple(clocks))
