"""How far a gait's expressions are from the decimal numbers of its robot record, bounded at points along the orbit.

What is proved is proved of the expressions, whose constants are doubles: numbers of the record next to its decimals,
and sums and products of them that were rounded as the expressions were written. Here accelerations, torques, contact
forces, feet and impacts of the expressions, in balls, are put into the equations of motion of the decimals
(``rigid_bodies``). What is left over is the force under which a robot of the record's own numbers would move as the
model does there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca
from flint import arb, ctx

from amble.gait import Gait
from amble.hybrid import Contacts, Switch, impact
from amble.proof.arithmetic import ROOM, column, largest, working_precision
from amble.proof.leg import Leg
from amble.proof.orbit import ProvedOrbit
from amble.proof.return_map import ReturnMap
from amble.proof.rigid_bodies import Column, Motion, decimal, drive, motion, needed_forces, vector
from amble.proof.tape import Tape, record
from amble.robot import Robot, kinematics
from amble.robot.base import SPATIAL

MORE_BITS = 106
"""Than the proof's own precision, of which 64 is the least: 50 decimal digits or more."""

FORCE, MOMENT, ACCELERATION, PLACE = "force_N", "moment_N_m", "foot_acceleration_m_s2", "foot_m"
IMPULSE, ANGULAR_IMPULSE, SPEED = "impulse_N_s", "angular_impulse_N_m_s", "landed_speed_m_s"
Missed: TypeAlias = tuple[str, arb]
"""Of what, and by how much the equations of the decimals are missed."""


@dataclass(frozen=True, kw_only=True)
class _Stance:
    """A stance with the switch that ends it: its leg, feet before and after, what expressions say; and the record."""

    robot: Robot
    leg: Leg
    contacts: Contacts
    landed: Contacts
    feet: Tape
    impact: Tape

    @classmethod
    def of(cls, gait: Gait, robot: Robot, switch: Switch, leg: Leg) -> _Stance:
        landed, size = gait.pattern.contacts(switch.target), gait.robot.size
        q, v = ca.SX.sym("q", size), ca.SX.sym("v", size)
        places = ca.vertcat(*[kinematics.foot_position(gait.robot, foot, q) for foot in gait.robot.foot_names])
        after = [ca.densify(part) for part in impact(landed, q, v)]
        return cls(
            robot=robot,
            leg=leg,
            contacts=gait.pattern.contacts(switch.source),
            landed=landed,
            feet=record(ca.Function("feet", [q], [ca.densify(places)])),
            impact=record(ca.Function("impact", [q, v], ca.cse(after))),
        )


def distances(gait: Gait, robot: Robot, prepared: ReturnMap, orbit: ProvedOrbit, room: bool) -> dict[str, arb]:
    """Bound how far the expressions miss the equations of a record's decimal numbers.

    Args:
        gait: the gait.
        robot: the record: the gait's own, or another that is compared with its expressions.
        prepared: its return map.
        orbit: proved of it; the points are the starts of its steps, and where they land.
        room: whether bounds get room for what another precision makes of the points.

    Returns:
        Name, with its unit -> bound over all points: of the force and moment left over in the equations of motion, of
        the acceleration of stance feet, of the places of all feet, and the same at landings. Empty for contacts that
        carry moments.
    """
    found: dict[str, arb] = {}
    with working_precision(ctx.prec + MORE_BITS):
        for switch, leg, points in zip(gait.pattern.switches, prepared.legs, orbit.points, strict=True):
            stance = _Stance.of(gait, robot, switch, leg)
            if stance.contacts.contact.moments:
                return {}
            for clock, state in points:
                _note(found, _standing(stance, clock, state))
            _note(found, _landing(stance, points[-1][1]))
        return {name: (value * (1 + ROOM)).upper() if room else value for name, value in found.items()}


def _note(found: dict[str, arb], missed: Iterator[Missed]) -> None:
    for name, value in missed:
        found[name] = largest([found.get(name, arb(0)), value])


def _standing(stance: _Stance, clock: arb, state: Sequence[arb]) -> Iterator[Missed]:
    """Put the model's accelerations, torques and forces at a point into the equations of the decimals."""
    robot = stance.robot
    n, m = robot.size, len(robot.joints)
    z = stance.leg.field.part(clock, state).solution
    a, (u, f) = z[:n], ([arb(stance.leg.load) * value for value in part] for part in (z[n : n + m], z[n + m :]))
    q, v, changes = (_spatial(robot, part) for part in (state[:n], state[n:], a))
    moving = motion(robot, q, v, changes)
    needed = _unmet(robot, stance.contacts, moving, f, decimal(robot.gravity), (v, changes))
    for joint in range(m):
        needed[SPATIAL + joint] -= u[joint]
    yield from _by_kind(robot, needed, (FORCE, MOMENT))
    for foot in stance.contacts.feet:
        _, _, acceleration = _foot(robot, moving, foot)
        yield from ((ACCELERATION, acceleration[axis, 0]) for axis in stance.contacts.contact.axes)
    (places,) = stance.feet.balls(state[:n])
    for number, foot in enumerate(robot.foot_names):
        there, _, _ = _foot(robot, moving, foot)
        yield from ((PLACE, there[axis, 0] - places[3 * number + axis]) for axis in range(3))


def _landing(stance: _Stance, state: Sequence[arb]) -> Iterator[Missed]:
    """Put the model's impact at a point into the equations of the decimals: D (v+ - v) = J^T iota, J v+ = 0."""
    robot, contacts = stance.robot, stance.landed
    n = robot.size
    after, impulse = stance.impact.balls(state[:n], state[n:])
    jump = [new - old for new, old in zip(after, state[n:], strict=True)]
    q, v, changes = (_spatial(robot, part) for part in (state[:n], after, jump))
    still = [arb(0)] * len(q)
    struck = motion(robot, q, still, changes)
    yield from _by_kind(
        robot, _unmet(robot, contacts, struck, impulse, arb(0), (still, changes)), (IMPULSE, ANGULAR_IMPULSE)
    )
    moving = motion(robot, q, v, still)
    for foot in contacts.feet:
        _, velocity, _ = _foot(robot, moving, foot)
        yield from ((SPEED, velocity[axis, 0]) for axis in contacts.contact.axes)


def _unmet(
    robot: Robot,
    contacts: Contacts,
    moving: Motion,
    forces: Sequence[arb],
    gravity: arb,
    rates: tuple[Sequence[arb], Sequence[arb]],
) -> list[arb]:
    """Return what generalised forces a motion needs beside forces at the feet, drives included."""
    axes = contacts.contact.axes
    pushes: dict[int, list[tuple[Column, Column]]] = {}
    for number, foot in enumerate(contacts.feet):
        push = [arb(0)] * 3
        for axis, value in zip(axes, forces[len(axes) * number :], strict=False):
            push[axis] = value
        place, _, _ = _foot(robot, moving, foot)
        pushes.setdefault(robot.foot(foot).link, []).append((place, column(push)))
    needed = needed_forces(robot, moving, pushes, gravity)
    for number, joint in enumerate(robot.joints, start=SPATIAL):
        needed[number] += drive(joint, rates[0][number], rates[1][number])
    return needed


def _foot(robot: Robot, moving: Motion, name: str) -> tuple[Column, Column, Column]:
    """Return place, velocity and acceleration of a foot."""
    foot = robot.foot(name)
    return moving.links[foot.link].point(vector(foot.offset))


def _by_kind(robot: Robot, needed: Sequence[arb], kinds: tuple[str, str]) -> Iterator[Missed]:
    """Of the robot's own coordinates: along axes, and about axes."""
    along, about = kinds
    slides = [True] * 3 + [False] * 3 + [joint.prismatic for joint in robot.joints]
    return ((along if slides[place] else about, needed[place]) for place in robot.base.columns(len(robot.joints)))


def _spatial(robot: Robot, values: Sequence[arb]) -> list[arb]:
    """Return spatial coordinates, or rates, of a robot's (``Base.spatial``)."""
    whole = [arb(0)] * (SPATIAL + len(robot.joints))
    for place, value in zip(robot.base.columns(len(robot.joints)), values, strict=True):
        whole[place] = value
    return whole
