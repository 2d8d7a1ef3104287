"""The step map of a gain-scheduled law at one command: its fixed point on the section, and the derivative there.

The section is where place and heading, the coordinates along the symmetries, are zero.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amble.defaults import TOLERANCE
from amble.errors import FallError, NotSolvedError, WorkError
from amble.gait.closed_loop import closed_loop
from amble.gait.schedule import Schedule
from amble.hybrid import HybridSystem
from amble.stability.fixed_point import FixedPoint, fixed_point
from amble.stability.group import Shift, act, generators
from amble.stability.landing_orders import orders_of
from amble.stability.monodromy import Monodromy, prepare_variational
from amble.stability.poincare import TIME_LIMIT
from amble.types import IntegerVector, Matrix, Vector, frozen

STEPS = 50
SETTLED = 1e-12


@dataclass(frozen=True, kw_only=True)
class SampledStep:
    """The step map at one command.

    Attributes:
        command: one number an axis.
        state: its fixed point with place and heading zero, (2 n_q,).
        matrices: its derivatives there on the section, (m, m): one, or where feet land one by one one of every order.
        duration: of the step, s.
        speed: mean velocity along the way of the orbit, m/s.
        yaw_rate: mean rate of its heading, rad/s.
    """

    command: tuple[float, ...]
    state: Vector
    matrices: tuple[Matrix, ...]
    duration: float
    speed: float
    yaw_rate: float

    @property
    def radius(self) -> float:
        """Spectral radius of the step, the largest of its derivatives'."""
        return max(float(np.abs(np.linalg.eigvals(matrix)).max()) for matrix in self.matrices)


def section_coordinates(schedule: Schedule, system: HybridSystem) -> tuple[IntegerVector, IntegerVector]:
    """Return the places of the coordinates along the symmetries, and of all other states."""
    robot = schedule.gait.robot
    along = np.array([robot.coordinate_index(symmetry.name) for symmetry in system.symmetries], dtype=np.int64)
    return along, np.setdiff1d(np.arange(2 * robot.size), along)


def on_section(system: HybridSystem, along: IntegerVector, state: Vector) -> Shift:
    """Move a state along the symmetries to where their coordinates are zero.

    Raises:
        WorkError: the amounts do not converge.
    """
    shift = act(system, np.zeros(along.size), state)
    for _ in range(STEPS):
        miss = shift.image[along]
        if np.abs(miss).max(initial=0.0) <= SETTLED:
            return shift
        shift = act(system, shift.amounts - np.linalg.solve(shift.slopes[along], miss), state)
    raise WorkError("a state cannot be moved to the section along the symmetries")


def sampled_step(schedule: Schedule, command: Sequence[float]) -> SampledStep:
    """Find the orbit at a command and differentiate the step map on the section.

    Raises:
        NotSolvedError: there is none near the gaits around it.
    """
    gait, law = schedule.gait, schedule.law(command)
    system = closed_loop(gait, control=law, half=True)
    along, _ = section_coordinates(schedule, system)
    smooth = [closed_loop(gait, control=law, half=True, orders=order) for order in orders_of(gait)]
    try:
        found = _orbit(system, smooth, schedule.start(command))
        found = _orbit(system, smooth, on_section(system, along, found.state).image)
    except (NotSolvedError, FallError) as error:
        where = ", ".join(f"{axis} {value:g}" for axis, value in zip(schedule.axes, command, strict=True))
        raise NotSolvedError(
            f"between the gaits there is no orbit at {where} ({str(error).splitlines()[0]}): take gaits nearer to each "
            "other, or of more alike durations ([limits] duration)"
        ) from None
    maps = [prepare_variational(each)(found.state, TOLERANCE, TIME_LIMIT, 1, None) for each in smooth]
    way = np.hypot(found.shift.get("x", 0.0), found.shift.get("y", 0.0))
    return SampledStep(
        command=tuple(map(float, command)),
        state=found.state,
        matrices=tuple(_on_section(schedule, system, found.state, each) for each in maps or [found.monodromy]),
        duration=found.period,
        speed=float(way / found.period),
        yaw_rate=float(found.shift.get("yaw", 0.0) / found.period),
    )


def _orbit(system: HybridSystem, smooth: Sequence[HybridSystem], guess: Vector) -> FixedPoint:
    """Find the fixed point; where feet land one by one the map has a kink, and that of one order may lead to it."""
    try:
        return fixed_point(system, guess)
    except NotSolvedError:
        for each in smooth:
            with contextlib.suppress(NotSolvedError, FallError):
                return fixed_point(system, fixed_point(each, guess).state)
        raise


def _on_section(schedule: Schedule, system: HybridSystem, state: Vector, there: Monodromy) -> Matrix:
    """Return the derivative of a step map on the section, (m, m)."""
    along, kept = section_coordinates(schedule, system)
    shift, tangent = on_section(system, along, there.image), generators(system, state)
    project = np.eye(state.size) - tangent @ np.linalg.solve(tangent[along], np.eye(state.size)[along])
    return frozen((project @ shift.matrix @ there.matrix)[np.ix_(kept, kept)])
