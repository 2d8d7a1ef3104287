"""The state of a gait on ground that pushes only: coordinates and rates, and what else the motion depends on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from amble.gait.closed_loop import start_state, trace_units
from amble.gait.linearising_law import control_of
from amble.gait.record import Gait
from amble.hybrid import Contacts, Stance
from amble.types import Vector, frozen


@dataclass(frozen=True, kw_only=True)
class Push:
    """A constant force on the base at its centre of mass for a while; none by default.

    Attributes:
        force: world frame, N.
        begin: s from the start of the motion.
        end: s.
    """

    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    begin: float = 0.0
    end: float = 0.0


NO_PUSH = Push()


def unilateral_start(gait: Gait, state: Vector | None = None, push: Push = NO_PUSH) -> Vector:
    """Return the start of a unilateral motion: entry of the first domain with its feet in contact, the clock at 0.

    Args:
        gait: the gait.
        state: coordinates and rates, (2 n_q,); the gait's own by default.
        push: on the base.
    """
    feet, down = gait.robot.foot_names, gait.pattern.stances[0].feet
    entry = start_state(gait) if state is None else state
    active = [float(foot in down) for foot in feet]
    return frozen(np.concatenate([entry, [0.0], active, push.force, [push.begin, push.end, 0.0]]))


def state_names(gait: Gait, names: Sequence[str]) -> tuple[str, ...]:
    """Name the states of the unilateral loop, after those of the closed loop."""
    contact = [f"contact of {foot}" for foot in gait.robot.foot_names]
    return (*names, "clock", *contact, "push x", "push y", "push z", "push begin", "push end", "time")


def unilateral_units(gait: Gait) -> dict[str, str]:
    """Return name -> unit of the states and signals of the unilateral loop, as traces hold them."""
    names = state_names(gait, ())
    own = ["s", *("1" for _ in gait.robot.foot_names), "N", "N", "N", "s", "s", "s"]
    return {**trace_units(gait), **dict(zip(names, own, strict=True)), "contact": "1"}


@dataclass(frozen=True, kw_only=True)
class UnilateralState:
    """The state by its parts, casadi columns.

    Attributes:
        x: coordinates and rates, (2 n_q,).
        clock: of the controller, s.
        active: 1 for a foot in contact, 0 for another, (n_feet,).
        rest: push, its begin and end, and the time, (6,), N and s.
    """

    x: Any
    clock: Any
    active: Any
    rest: Any

    @classmethod
    def of(cls, contacts: Contacts, state: Any) -> UnilateralState:
        """Take a state apart.

        Args:
            contacts: every foot of the robot.
            state: casadi column, as ``unilateral_start`` orders it.
        """
        size = 2 * contacts.robot.size
        x, clock, active, rest = ca.vertsplit(state, [0, size, size + 1, size + 1 + len(contacts.feet), state.numel()])
        return cls(x=x, clock=clock, active=active, rest=rest)

    @property
    def whole(self) -> Any:
        """All parts again."""
        return ca.vertcat(self.x, self.clock, self.active, self.rest)

    @property
    def push(self) -> Any:
        """The force now; ``rest`` holds force, begin, end and time."""
        time = self.rest[5]
        return ca.if_else(ca.logic_and(time >= self.rest[3], time < self.rest[4]), self.rest[:3], ca.DM.zeros(3))


def within_window(gait: Gait, stance: Stance, crossing: ca.MX, clock: ca.MX, p: ca.MX) -> ca.MX:
    """Bound the guard of feet that lift by the window of the gait's feedback law (``ControlLaw.lift_offs``).

    They are up, but not before the first time, and at the second it ends in any case.

    Args:
        gait: the gait.
        stance: that ends, none landing.
        crossing: the guard, above 0 while they carry.
        clock: s.
        p: the parameters of the stance.
    """
    control = control_of(gait)
    if control.lift_offs is None or stance not in gait.pattern.stances:
        return crossing
    (early, late), share = control.lift_offs, clock / control.planned(gait, stance, p)
    return ca.fmin(ca.fmax(crossing, early - share), late - share)
