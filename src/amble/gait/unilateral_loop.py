"""The closed loop of a gait on ground that pushes only: feet that pull are released, feet that touch stop.

Beside coordinates and rates the state holds the controller's clock, which of the feet are in contact, and a push on the
base with its time. The controller is that of ``closed_loop``: it switches where its own guards fire, and knows
nothing of a foot that was released or touched out of its turn (docs/theory/hybrid-model.md, section 11). A stance ends
where all feet that land next are on the ground, as in the exported code.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from amble.codegen import compile_all
from amble.control import AllocationLaw
from amble.control.stance_functions import ARGUMENTS
from amble.errors import InputError
from amble.gait.closed_loop import closed_loop, start_state, trace_units
from amble.gait.control_law import ControlLaw
from amble.gait.landing_stances import landing_steps
from amble.gait.record import Gait
from amble.hybrid import Contacts, Domain, HybridSystem, Switch, Transition
from amble.hybrid.unilateral import normal_forces, tangential_loads, unilateral_impact, unilateral_motion
from amble.types import Vector, frozen

SINKS = 1e-4
"""How far below the ground a foot out of its turn counts as touching, in leg lengths: one that has just lifted or was
released lies on the ground."""

LIGHT = 0.01
"""A foot that presses with less than this share of the weight carries any load that friction would carry at that share:
on its way to be lifted it slides too little to matter, and force over force is no measure where both vanish."""

ROUNDING = 1e-10
"""Of a gap in leg lengths, and of a force in weights. A planned landing is seen so high above the ground: higher than
the rounding of a foot that has just lifted."""

SLID = "left its friction cone"

RELEASED, TOUCHED = "released", "touched"


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


def unilateral_loop(
    gait: Gait, law: AllocationLaw | None = None, control: ControlLaw | None = None, friction: float | None = None
) -> HybridSystem:
    """Close the loop of a gait on ground that pushes only.

    Three domains a stance: as planned, after a foot was released, after one touched out of its turn. The motion ends
    where a foot in contact leaves its friction cone; how it would slide is left to another engine.

    Args:
        gait: the gait.
        law: another allocation law than the gait's.
        control: another feedback law than the gait's.
        friction: coefficient of the ground that is walked on, where it is not the gait's; the controller's laws know
            the gait's own.

    Raises:
        InputError: feet of the gait land one by one; another allocation law for a feedback law that does not allocate.
    """
    pattern = gait.pattern
    if any(len(landing_steps(gait, switch)) > 1 for switch in pattern.all_switches):
        raise InputError("feet that land one by one have no unilateral simulation yet; the rule 'simultaneous' has")
    system = closed_loop(gait, law, control=control)
    parts = _parts(pattern.all_contacts)
    domains, transitions = list[Domain](), list[Transition]()
    for switch in pattern.all_switches:
        loop = _StanceLoop(
            contacts=pattern.all_contacts,
            planned=system.domain(switch.source.name),
            switch=switch,
            parts=parts,
            lift_off=gait.limits.normal_force,
            friction=pattern.ground.friction if friction is None else friction,
        )
        domains += loop.domains()
        transitions += loop.transitions()
    return HybridSystem(domains, transitions, (), state_names(gait, system.state_names))


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
class _State:
    """The state by its parts, and what makes it again."""

    x: Any
    clock: Any
    active: Any
    rest: Any

    @classmethod
    def of(cls, contacts: Contacts, state: Any) -> _State:
        size = 2 * contacts.robot.size
        x, clock, active, rest = ca.vertsplit(state, [0, size, size + 1, size + 1 + len(contacts.feet), state.numel()])
        return cls(x=x, clock=clock, active=active, rest=rest)

    @property
    def whole(self) -> Any:
        return ca.vertcat(self.x, self.clock, self.active, self.rest)

    @property
    def push(self) -> Any:
        """The force now; ``rest`` holds force, begin, end and time."""
        time = self.rest[5]
        return ca.if_else(ca.logic_and(time >= self.rest[3], time < self.rest[4]), self.rest[:3], ca.DM.zeros(3))


@dataclass(frozen=True, kw_only=True)
class _StanceLoop:
    """One stance of the unilateral loop."""

    contacts: Contacts
    planned: Domain
    switch: Switch
    parts: dict[str, ca.Function]
    lift_off: float
    friction: float

    def domains(self) -> tuple[Domain, ...]:
        """As planned, after a release, after a touch: the same motion."""
        t, state, p, now = self._symbols()
        rate, normal, load, force = self._motion(now, p)
        quiet = ca.MX.zeros(now.active.numel() + 5)
        field = self._function("field", (t, state, p), ca.vertcat(rate, 1.0, quiet, 1.0), "rate")
        cone = ca.mmin(ca.if_else(ca.logic_and(now.active > 0.5, normal > 0.0), self._reserve(normal, load), 1.0))
        margin = self.planned.admissibility
        fall = None if margin is None else self._function("fall", (t, state, p), margin(now.clock, now.x, p), "margin")
        recorded = self._signals(now, p)
        signals = {**recorded, "force": force, "contact": now.active}
        whole = Domain(
            name=self.planned.name,
            field=field,
            parameters=self.planned.parameters,
            signals=ca.Function("signals", [t, state, p], list(signals.values()), ARGUMENTS, list(signals)),
            admissibility=fall,
            margins={SLID: self._function("cone", (t, state, p), cone, "margin")},
            breakpoints=self.planned.breakpoints,
        )
        changed = (replace(whole, name=f"{whole.name} {what}", breakpoints=()) for what in (RELEASED, TOUCHED))
        return (whole, *changed)

    def transitions(self) -> tuple[Transition, ...]:
        """Out of each of the three domains: the planned switch, a release, a touch."""
        guard, reset = self._planned()
        release, released = self._release()
        touch, touched = self._touch()
        name, found = self.planned.name, list[Transition]()
        for source in (name, f"{name} {RELEASED}", f"{name} {TOUCHED}"):
            target = self.switch.target.name
            found += [
                Transition(source=source, target=target, guard=guard, reset=reset, at_entry=True),
                Transition(source=source, target=f"{name} {RELEASED}", guard=release, reset=released, at_entry=True),
                Transition(source=source, target=f"{name} {TOUCHED}", guard=touch, reset=touched),
            ]
        return tuple(found)

    def _planned(self) -> tuple[ca.Function, ca.Function]:
        """The switch of the gait: its guard, and the impact on the feet that land, with those that stay."""
        t, state, p, now = self._symbols()
        feet, switch, length = self.contacts.feet, self.switch, self.contacts.robot.leg_length
        stays = ca.DM([float(foot not in switch.lifting) for foot in feet]) * now.active
        if switch.landing:
            lands = ca.DM([float(foot in switch.landing) for foot in feet])
            height = self.parts["gaps"](now.x) / length + ROUNDING
            crossing = ca.mmax(ca.if_else(lands * (1.0 - now.active) > 0.5, height, -1.0))
            arrived = lands * (1.0 - now.active)
            after, active = self.parts["impact"](now.x, ca.fmax(stays, arrived), arrived)
        else:
            _, normal, _, _ = self._motion(now, p)
            places = [feet.index(foot) for foot in switch.leaving]
            crossing = sum(normal[k] for k in places) / len(places) - self.lift_off
            after, active = now.x, stays
        entered = replace(now, x=after, clock=ca.MX(0.0), active=active)
        return self._pair(t, state, p, crossing, entered)

    def _release(self) -> tuple[ca.Function, ca.Function]:
        """The least normal force comes to zero: its foot is let go."""
        t, state, p, now = self._symbols()
        _, normal, _, _ = self._motion(now, p)
        weight = self.contacts.robot.mass * self.contacts.robot.gravity
        pressed = ca.if_else(now.active > 0.5, normal, weight)
        least = ca.mmin(pressed)
        active = ca.if_else(pressed <= least + ROUNDING * weight, 0.0, now.active)
        return self._pair(t, state, p, least, replace(now, active=active))

    def _touch(self) -> tuple[ca.Function, ca.Function]:
        """A foot out of its turn comes to the ground, and stops."""
        t, state, p, now = self._symbols()
        length = self.contacts.robot.leg_length
        height = ca.if_else(now.active > 0.5, length, self.parts["gaps"](now.x) + SINKS * length)
        arrived = height <= ROUNDING * length
        after, active = self.parts["impact"](now.x, ca.fmax(now.active, arrived), arrived)
        return self._pair(t, state, p, ca.mmin(height), replace(now, x=after, active=active))

    def _symbols(self) -> tuple[ca.MX, ca.MX, ca.MX, _State]:
        size = 2 * self.contacts.robot.size + 7 + len(self.contacts.feet)
        t, state, p = ca.MX.sym("t"), ca.MX.sym("x", size), ca.MX.sym("p", self.planned.parameters.size)
        return t, state, p, _State.of(self.contacts, state)

    def _signals(self, now: _State, p: ca.MX) -> dict[str, ca.MX]:
        signals = self.planned.signals
        if signals is None:
            raise InputError(f"domain '{self.planned.name}' records no torques")
        return dict(zip(signals.name_out(), signals.call([now.clock, now.x, p]), strict=True))

    def _motion(self, now: _State, p: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX, ca.MX]:
        rate, normal, load, force = self.parts["motion"](now.x, self._signals(now, p)["torque"], now.active, now.push)
        return rate, normal, load, force

    def _reserve(self, normal: ca.MX, load: ca.MX) -> ca.MX:
        """Load that friction can carry less that it has to, in weights."""
        weight = self.contacts.robot.mass * self.contacts.robot.gravity
        return (self.friction * ca.fmax(normal, LIGHT * weight) - load) / weight

    def _pair(self, t: ca.MX, state: ca.MX, p: ca.MX, guard: ca.MX, after: _State) -> tuple[ca.Function, ca.Function]:
        symbols = t, state, p
        return self._function("guard", symbols, guard, "guard"), self._function("reset", symbols, after.whole, "state")

    def _function(self, name: str, symbols: tuple[ca.MX, ca.MX, ca.MX], value: ca.MX, result: str) -> ca.Function:
        return ca.Function(f"unilateral_{name}", list(symbols), [ca.densify(value)], ARGUMENTS, [result])


def _parts(contacts: Contacts) -> dict[str, ca.Function]:
    """Compile what all stances share."""
    return compile_all({"unilateral": _written(contacts)})["unilateral"]


@lru_cache(maxsize=8)
def _written(contacts: Contacts) -> tuple[ca.Function, ...]:
    """Write ``motion`` (x, u, active, push), ``gaps`` (x) and ``impact`` (x, active, landing) of all feet."""
    robot, feet = contacts.robot, len(contacts.feet)
    x, u, push = ca.SX.sym("x", 2 * robot.size), ca.SX.sym("u", len(robot.joints)), ca.SX.sym("push", 3)
    active, landing = ca.SX.sym("active", feet), ca.SX.sym("landing", feet)
    q, v = x[: robot.size], x[robot.size :]
    points = contacts.points(q)
    motion = unilateral_motion(contacts, active, q, v, u, push)
    normal, load = normal_forces(contacts, motion.forces, points), tangential_loads(contacts, motion.forces, points)
    moved = [ca.vertcat(v, motion.acceleration), normal, load, motion.forces]
    gaps = ca.vertcat(*[contacts.ground.gap(points[3 * i : 3 * i + 3]) for i in range(feet)])
    after, stands, _ = unilateral_impact(contacts, active, landing, q, v)
    return (
        ca.Function("motion", [x, u, active, push], ca.cse([ca.densify(part) for part in moved])),
        ca.Function("gaps", [x], [ca.densify(gaps)]),
        ca.Function("impact", [x, active, landing], ca.cse([ca.densify(ca.vertcat(q, after)), ca.densify(stands)])),
    )
