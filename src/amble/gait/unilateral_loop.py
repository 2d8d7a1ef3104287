"""The closed loop of a gait on ground that pushes only: feet that pull are released, feet that touch stop.

Beside coordinates and rates the state holds the controller's clock, which of the feet are in contact, and a push on the
base with its time. The controller is that of ``closed_loop``: it switches where its own guards fire, and knows
nothing of a foot that was released or touched out of its turn (docs/theory/hybrid-model.md, section 11). Where feet
land one by one every landing leads to a stance of its own; under the rule "simultaneous" a stance ends where all feet
that land next are on the ground. The exported code does the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import casadi as ca

from amble.codegen import compile_all
from amble.control import AllocationLaw
from amble.control.stance_functions import ARGUMENTS
from amble.errors import InputError
from amble.gait.closed_loop import closed_loop
from amble.gait.control_law import ControlLaw
from amble.gait.plant_errors import EXACT, PlantErrors
from amble.gait.record import Gait
from amble.gait.unilateral_state import UnilateralState, state_names, within_window
from amble.hybrid import Contacts, Domain, HybridSystem, Switch, Transition
from amble.hybrid.unilateral import normal_forces, tangential_loads, unilateral_impact, unilateral_motion
from amble.robot.coordinate_units import from_torques

SINKS = 1e-4
"""How far below the ground a foot out of its turn counts as touching, in leg lengths: one that has just lifted or was
released lies on the ground."""

STILL = 0.01
"""Rate of a joint, in sqrt(g / l), below which its dry friction fades."""

LIGHT = 0.01
"""A foot that presses with less than this share of the weight carries any load that friction would carry at that share:
on its way to be lifted it slides too little to matter, and force over force is no measure where both vanish."""

ROUNDING = 1e-10
"""Of a gap in leg lengths, and of a force in weights. A planned landing is seen so high above the ground: higher than
the rounding of a foot that has just lifted."""

SLID = "left its friction cone"

RELEASED, TOUCHED = "released", "touched"


def unilateral_loop(
    gait: Gait, law: AllocationLaw | None = None, control: ControlLaw | None = None, errors: PlantErrors = EXACT
) -> HybridSystem:
    """Close the loop of a gait on ground that pushes only.

    Three domains a stance: as planned, after a foot was released, after one touched out of its turn. The motion ends
    where a foot in contact leaves its friction cone; how it would slide is left to another engine.

    Args:
        gait: the gait.
        law: another allocation law than the gait's.
        control: another feedback law than the gait's.
        errors: what the plant differs in from the gait's model; the controller's laws know nothing of it.

    Raises:
        InputError: the gait turns, or another allocation law for a feedback law that does not allocate.
    """
    own = gait if control is None else replace(gait, control=control)
    return on_unilateral_ground(own, closed_loop(gait, law, control=control), errors)


def on_unilateral_ground(gait: Gait, system: HybridSystem, errors: PlantErrors = EXACT) -> HybridSystem:
    """Put a closed loop of a gait on ground that pushes only; see ``unilateral_loop``.

    Args:
        gait: the gait, under the feedback law of the system.
        system: what ``closed_loop`` makes of it, over the whole cycle.
        errors: what the plant differs in from the model.
    """
    pattern = gait.pattern
    if gait.turn:
        raise InputError("a gait that turns has no unilateral simulation yet; one that goes straight has")
    contacts = pattern.all_contacts
    parts = _parts(contacts)
    domains, transitions = list[Domain](), list[Transition]()
    for stance in pattern.visited:
        loop = _StanceLoop(
            contacts=contacts,
            planned=system.domain(stance.name),
            between=stance not in pattern.stances,
            exits=[(step, system.domain(step.target.name)) for step in pattern.steps if step.source == stance],
            parts=parts,
            lift_off=gait.limits.normal_force,
            windowed=partial(within_window, gait, stance),
            errors=errors,
        )
        domains += loop.domains()
        transitions += loop.transitions()
    return HybridSystem(domains, transitions, (), state_names(gait, system.state_names))


@dataclass(frozen=True, kw_only=True)
class _StanceLoop:
    """One stance of the unilateral loop, with the switches that leave it; ``between`` two landings, or of the gait."""

    contacts: Contacts
    planned: Domain
    between: bool
    exits: Sequence[tuple[Switch, Domain]]
    parts: dict[str, ca.Function]
    lift_off: float
    windowed: Callable[[ca.MX, ca.MX, ca.MX], ca.MX]
    errors: PlantErrors

    @property
    def extra(self) -> float:
        """Mass of the base link beside its own, as a share of it."""
        return self.errors.trunk - 1.0

    @property
    def _weight(self) -> float:
        return self.contacts.robot.mass * self.contacts.robot.gravity

    def domains(self) -> tuple[Domain, ...]:
        """As planned, after a release, after a touch: the same motion."""
        t, state, p, now = self._symbols()
        rate, normal, load, force = self._motion(now, p)
        quiet = ca.MX.zeros(now.active.numel() + 5)
        field = self._function("field", (t, state, p), ca.vertcat(rate, 1.0, quiet, 1.0), "rate")
        cone = ca.mmin(ca.if_else(ca.logic_and(now.active > 0.5, normal > 0.0), self._reserve(normal, load), 1.0))
        margin = self.planned.admissibility
        fall = None if margin is None else self._function("fall", (t, state, p), margin(now.clock, now.x, p), "margin")
        recorded = _signals(self.planned, now, p)
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
        """Out of each of the three domains: the planned switches, a release, a touch."""
        switches = [(switch, *self._planned(switch, following)) for switch, following in self.exits]
        release, released = self._release()
        touch, touched = self._touch()
        name, found = self.planned.name, list[Transition]()
        for source in (name, f"{name} {RELEASED}", f"{name} {TOUCHED}"):
            for switch, guard, reset in switches:
                target, entry = switch.target.name, self.between or not switch.landing
                found.append(Transition(source=source, target=target, guard=guard, reset=reset, at_entry=entry))
            found += [
                Transition(source=source, target=f"{name} {RELEASED}", guard=release, reset=released, at_entry=True),
                Transition(source=source, target=f"{name} {TOUCHED}", guard=touch, reset=touched),
            ]
            found += [
                Transition(
                    source=source, target=switch.target.name, guard=self._arrived(switch), reset=reset, at_entry=True
                )
                for switch, _, reset in switches
                if switch.landing
            ]
        return tuple(found)

    def _planned(self, switch: Switch, following: Domain) -> tuple[ca.Function, ca.Function]:
        """The switch of the gait: its guard, and the impact on the feet that land, with those that stay."""
        t, state, p, now = self._symbols()
        feet, length = self.contacts.feet, self.contacts.robot.leg_length
        stays = ca.DM([float(foot not in switch.lifting) for foot in feet]) * now.active
        if switch.landing:
            lands = ca.DM([float(foot in switch.landing) for foot in feet])
            height = self._gaps(now) / length + ROUNDING
            crossing = ca.mmax(ca.if_else(lands * (1.0 - now.active) > 0.5, height, -1.0))
            arrived = lands * (1.0 - now.active)
            after, active = self.parts["impact"](now.x, ca.fmax(stays, arrived), arrived, self.extra)
        else:
            _, normal, _, _ = self._motion(now, p)
            places = [feet.index(foot) for foot in switch.leaving]
            carried = (sum(normal[k] for k in places) / len(places) - self.lift_off) / self._weight
            crossing = self.windowed(carried, now.clock, p)
            after, active = now.x, stays
        entered = replace(now, x=after, clock=ca.MX(-self.errors.lateness), active=active)
        return self._pair(t, state, p, crossing, self._with_late_torques(entered, self._torque(now, p), following))

    def _with_late_torques(self, entered: UnilateralState, before: ca.MX, following: Domain) -> UnilateralState:
        """Let the torques of the last stance go on for a while, to first order: as a jump of the rates."""
        if not self.errors.late:
            return entered
        own = ca.MX(ca.DM(following.parameters))
        after = _signals(following, replace(entered, clock=ca.MX(0.0)), own)["torque"]
        size = self.contacts.robot.size
        moved = [
            self.parts["motion"](entered.x, u, entered.active, entered.push, self.extra)[0][size:]
            for u in (before, after)
        ]
        jump = ca.vertcat(ca.MX.zeros(size), self.errors.late * (moved[0] - moved[1]))
        return replace(entered, x=entered.x + jump)

    def _arrived(self, switch: Switch) -> ca.Function:
        """A guard that is past zero where all feet that land next are in contact already; a gap would also be below."""
        t, state, p, now = self._symbols()
        missing = [1.0 - now.active[self.contacts.feet.index(foot)] for foot in switch.landing]
        return self._function("arrived", (t, state, p), sum(missing, ca.MX(-0.5)), "guard")

    def _release(self) -> tuple[ca.Function, ca.Function]:
        """The least normal force comes to zero: its foot is let go."""
        t, state, p, now = self._symbols()
        _, normal, _, _ = self._motion(now, p)
        pressed = ca.if_else(now.active > 0.5, normal, self._weight)
        least = ca.mmin(pressed)
        active = ca.if_else(pressed <= least + ROUNDING * self._weight, 0.0, now.active)
        return self._pair(t, state, p, least, replace(now, active=active))

    def _touch(self) -> tuple[ca.Function, ca.Function]:
        """A foot out of its turn comes to the ground, and stops."""
        t, state, p, now = self._symbols()
        length = self.contacts.robot.leg_length
        height = ca.if_else(now.active > 0.5, length, self._gaps(now) + SINKS * length)
        arrived = height <= ROUNDING * length
        after, active = self.parts["impact"](now.x, ca.fmax(now.active, arrived), arrived, self.extra)
        return self._pair(t, state, p, ca.mmin(height), replace(now, x=after, active=active))

    def _symbols(self) -> tuple[ca.MX, ca.MX, ca.MX, UnilateralState]:
        size = 2 * self.contacts.robot.size + 7 + len(self.contacts.feet)
        t, state, p = ca.MX.sym("t"), ca.MX.sym("x", size), ca.MX.sym("p", self.planned.parameters.size)
        return t, state, p, UnilateralState.of(self.contacts, state)

    def _gaps(self, now: UnilateralState) -> ca.MX:
        """Heights of the feet over the ground that they land on, m."""
        return self.parts["gaps"](now.x) - ca.DM(self.errors.heights(self.contacts.robot))

    def _torque(self, now: UnilateralState, p: ca.MX) -> ca.MX:
        """Torques that arrive now; a late one is u(t - s, x(t - s)) with x(t - s) = x - s x', to first order in s."""
        torque, late = _signals(self.planned, now, p)["torque"], self.errors.delay
        if not late:
            return torque
        rate = self.parts["motion"](now.x, torque, now.active, now.push, self.extra)[0]
        return _signals(self.planned, replace(now, x=now.x - late * rate, clock=now.clock - late), p)["torque"]

    def _motion(self, now: UnilateralState, p: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX, ca.MX]:
        robot, errors = self.contacts.robot, self.errors
        speed, torque = now.x[-len(robot.joints) :], self._torque(now, p)
        if errors.damping or errors.dry_friction:
            turning = STILL * (robot.gravity / robot.leg_length) ** 0.5
            speed = from_torques(robot, speed)  # both act at an arm of the leg length on prismatic joints
            taken = errors.damping * speed, errors.dry_friction * ca.tanh(speed / turning)
            torque = torque - from_torques(robot, taken[0]) - from_torques(robot, taken[1])
        rate, normal, load, force = self.parts["motion"](now.x, torque, now.active, now.push, self.extra)
        return rate, normal, load, force

    def _reserve(self, normal: ca.MX, load: ca.MX) -> ca.MX:
        """Load that friction can carry less that it has to, in weights."""
        weight = self._weight
        own, given = self.contacts.ground.friction, self.errors.friction
        friction = own if given is None else given
        return (friction * ca.fmax(normal, LIGHT * weight) - load) / weight

    def _pair(
        self, t: ca.MX, state: ca.MX, p: ca.MX, guard: ca.MX, after: UnilateralState
    ) -> tuple[ca.Function, ca.Function]:
        symbols = t, state, p
        return self._function("guard", symbols, guard, "guard"), self._function("reset", symbols, after.whole, "state")

    def _function(self, name: str, symbols: tuple[ca.MX, ca.MX, ca.MX], value: ca.MX, result: str) -> ca.Function:
        return ca.Function(f"unilateral_{name}", list(symbols), [ca.densify(value)], ARGUMENTS, [result])


def _signals(domain: Domain, now: UnilateralState, p: ca.MX) -> dict[str, ca.MX]:
    """What a domain of the closed loop records at a state, by name."""
    signals = domain.signals
    if signals is None:
        raise InputError(f"domain '{domain.name}' records no torques")
    return dict(zip(signals.name_out(), signals.call([now.clock, now.x, p]), strict=True))


def _parts(contacts: Contacts) -> dict[str, ca.Function]:
    """Compile what all stances share."""
    return compile_all({"unilateral": _written(contacts)})["unilateral"]


@lru_cache(maxsize=8)
def _written(contacts: Contacts) -> tuple[ca.Function, ...]:
    """Write ``motion`` (x, u, active, push, extra), ``gaps`` (x), ``impact`` (x, active, landing, extra)."""
    robot, feet = contacts.robot, len(contacts.feet)
    x, u, push = ca.SX.sym("x", 2 * robot.size), ca.SX.sym("u", len(robot.joints)), ca.SX.sym("push", 3)
    active, landing, extra = ca.SX.sym("active", feet), ca.SX.sym("landing", feet), ca.SX.sym("extra")
    q, v = x[: robot.size], x[robot.size :]
    points = contacts.points(q)
    motion = unilateral_motion(contacts, active, q, v, u, push, extra)
    normal, load = normal_forces(contacts, motion.forces, points), tangential_loads(contacts, motion.forces, points)
    moved = [ca.vertcat(v, motion.acceleration), normal, load, motion.forces]
    gaps = ca.vertcat(*[contacts.ground.gap(points[3 * i : 3 * i + 3]) for i in range(feet)])
    after, stands, _ = unilateral_impact(contacts, active, landing, q, v, extra)
    return (
        ca.Function("motion", [x, u, active, push, extra], ca.cse([ca.densify(part) for part in moved])),
        ca.Function("gaps", [x], [ca.densify(gaps)]),
        ca.Function(
            "impact", [x, active, landing, extra], ca.cse([ca.densify(ca.vertcat(q, after)), ca.densify(stands)])
        ),
    )
