"""Gain scheduling of the impedance law: one law for a grid of gaits, interpolated at a command.

Over the share of the planned duration the references of all gaits are polynomial pieces with the same ends. Then what
the law is packed into, durations, gains, ends of the pieces and coefficients, is linear in them, and the law at a
command between gaits is the multilinear interpolation of the packed numbers (docs/howto/transitions.md, eq. 1).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait.control_law import Numbers, TorqueLaw
from amble.gait.impedance import GROUP, HOLD, Impedance
from amble.gait.orbit import OrbitArc, orbit_arcs
from amble.gait.record import Gait
from amble.hybrid import SIMULTANEOUS
from amble.numerics.pieces import FAR, ORDER, SAMPLES, Pieces, padded, piece
from amble.types import NodeValues, Vector, frozen

SAME = 1e-9
"""Ends of pieces this near to each other, as a share of the planned duration, are one."""

OUTSIDE = 1e-9
"""How far beyond the range a command may lie by rounding, as a share of the range."""


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """The impedance law of a grid of gaits with the same stances.

    Attributes:
        gait: one of them, which gives robot, stances and limits.
        axes: names of what is commanded, such as speed.
        values: of every axis, ascending, at least two.
        tables: packed numbers of every gait and solved stance (``Impedance.numbers``), with the same ends of pieces as
            shares of the planned duration, (n_1, ..., n_axes, stances, size).
        starts: fixed points of the gaits, (n_1, ..., n_axes, 2 n_q).
    """

    gait: Gait
    axes: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    tables: NodeValues
    starts: NodeValues

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

    def law(self, command: Sequence[float]) -> InterpolatedImpedance:
        """Return the law at a command."""
        packed = sum(weight * self.tables[place] for place, weight in self.weights(command).items())
        return InterpolatedImpedance(entries=tuple(_numbers(row, len(self.gait.robot.joints)) for row in packed))


@dataclass(frozen=True, kw_only=True, eq=False)
class InterpolatedImpedance(TorqueLaw):
    """The impedance law with numbers of its own.

    Attributes:
        entries: of every solved stance.
    """

    units: ClassVar[Mapping[str, str]] = {}

    entries: tuple[Numbers, ...]

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

    torques = staticmethod(Impedance.torques)


def impedance_schedule(
    gaits: Mapping[tuple[float, ...], Gait], axes: Sequence[str], law: AllocationLaw | None = None
) -> Schedule:
    """Write the impedance law of a grid of gaits over the same pieces.

    Args:
        gaits: values along the axes -> stabilised gait under ``Impedance``; every combination of the values.
        axes: their names.
        law: another allocation law of the feed-forward than the gaits'.

    Raises:
        InputError: a combination is missing, an axis has one value only, or the gaits are of different robots, stances
            or grounds; or feet land one by one.
        WorkError: an orbit cannot be integrated.
    """
    values = grid_values(gaits, axes)
    grid = list(itertools.product(*values))
    first = gaits[grid[0]]
    arcs = [orbit_arcs(gaits[place], law or gaits[place].law) for place in grid]
    shape = tuple(len(row) for row in values)
    cuts = [_shares([each[number] for each in arcs]) for number in range(len(first.pattern.solved))]
    count = -(-(max(map(len, cuts)) - 1) // GROUP) * GROUP  # of pieces, the same in every stance
    rows = []
    for number, (stance, shares) in enumerate(zip(first.pattern.solved, cuts, strict=True)):
        gains = [impedance_of(gaits[place]).joint_gains(first.robot, stance) for place in grid]
        rows.append(np.array([_packed(arc[number], shares, own, count) for arc, own in zip(arcs, gains, strict=True)]))
    starts = np.array([gaits[place].feedback.start for place in grid])  # type: ignore[union-attr]  # orbit_arcs saw it
    return Schedule(
        gait=first,
        axes=tuple(axes),
        values=values,
        tables=frozen(np.stack(rows, axis=1).reshape(*shape, len(rows), -1)),
        starts=frozen(starts.reshape(*shape, -1)),
    )


def impedance_of(gait: Gait) -> Impedance:
    """Return the impedance law of a gait.

    Raises:
        InputError: it walks under another.
    """
    if not isinstance(gait.control, Impedance):
        raise InputError("the gaits of a schedule walk under control law 'impedance'")
    return gait.control


def grid_values(gaits: Mapping[tuple[float, ...], Gait], axes: Sequence[str]) -> tuple[tuple[float, ...], ...]:
    """Return the values of every axis, ascending, of gaits that one law can be interpolated over.

    Raises:
        InputError: no law can be; see ``impedance_schedule``.
    """
    values = tuple(tuple(sorted({place[k] for place in gaits})) for k in range(len(axes)))
    grid = list(itertools.product(*values))
    for axis, row in zip(axes, values, strict=True):
        if len(row) < 2:
            raise InputError(f"axis {axis} has one value, {row[0]:g}: between gaits there have to be two at least")
    missing = [place for place in grid if place not in gaits]
    if missing:
        where = ", ".join(f"{axis} {value:g}" for axis, value in zip(axes, missing[0], strict=True))
        raise InputError(f"{len(missing)} of {len(grid)} gaits of the grid are not there, the first at {where}")
    first = gaits[grid[0]]
    for gait in gaits.values():
        if replace(gait.pattern, landing_rule=first.pattern.landing_rule) != first.pattern:
            raise InputError(
                "the gaits differ in robot, stances or ground; between such there is no interpolation"
                + (" (turning gaits have no mirror)" if gait.pattern.mirrored != first.pattern.mirrored else "")
            )
    if any(gait.pattern.steps != gait.pattern.all_switches for gait in gaits.values()):
        raise InputError(
            "between gaits whose feet land one by one there is no interpolation yet; gaits of landing_rule = "
            f'"{SIMULTANEOUS}" ([gait], GaitPattern) are interpolated'
        )
    return values


def _shares(arcs: Sequence[OrbitArc]) -> Vector:
    """Ends of pieces, as shares of the planned duration, at which every gait's pieces end too."""
    every = np.unique(np.concatenate([arc.torques.breaks / arc.duration for arc in arcs]))
    kept = np.concatenate([[True], np.diff(every) > SAME])
    return np.asarray(every[kept])


def _packed(arc: OrbitArc, shares: Vector, gains: tuple[Vector, Vector], count: int) -> Vector:
    """Pack the law as ``Impedance.numbers`` does, with given pieces."""
    T = arc.duration
    joints, torques = (_cut(curve, shares * T) for curve in (arc.joints, arc.torques))
    (places, angles), (_, efforts) = (padded(pieces, count) for pieces in (joints, torques))
    ends = np.array([shares[-1] * T, HOLD * T])
    return frozen(np.concatenate([ends, *gains, places.ravel(), angles.ravel(), efforts.ravel()]))


def _cut(curve: Pieces, breaks: Vector) -> Pieces:
    """Write a curve in pieces with other ends, its own among them: polynomials, so that nothing is lost."""
    found = [piece(curve(0.5 * (a + b) + 0.5 * (b - a) * SAMPLES)[0])[0] for a, b in itertools.pairwise(breaks)]
    return Pieces(breaks=frozen(breaks), coefficients=frozen(np.array(found)))


def _numbers(packed: Vector, joints: int) -> Numbers:
    """The numbers of a stance, with the clocks at which they are not smooth."""
    count = (packed.size - 2 - 2 * joints) // (2 + 2 * joints * (ORDER + 1))
    begins = packed[2 + 2 * joints :][:count]
    inside = begins[1:][begins[1:] < FAR]
    return Numbers(parameters=frozen(packed), breakpoints=(*map(float, inside), float(packed[0]), float(packed[1])))
