"""Rows of feet that land one by one: every order of landing is possible, and the feet that stand meanwhile hold."""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.control.landing import landing_motion
from amble.hybrid import Stance, Switch, impact
from amble.hybrid.ground import into_frame
from amble.hybrid.landing import steps
from amble.robot import kinematics
from amble.robot.natural_units import velocity_unit
from amble.synthesis.block import Label
from amble.synthesis.layout import MARGIN
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowGroup, RowKind

RELEASE = 0.001
"""Least speed of a released foot away from the ground, as a share of sqrt(g l): from a start beside the orbit a slower
one would touch the ground at once."""


def lands_in_turn(problem: GaitProblem, switch: Switch) -> bool:
    """Whether the feet of a switch land one by one."""
    return len(_landed(problem, switch)) > 0


def _landed(problem: GaitProblem, switch: Switch) -> tuple[Stance, ...]:
    """The stances behind every landing of every order, the next stance last; none where feet land at once."""
    pattern = problem.pattern
    chain = steps(switch, pattern.landing_rule, pattern.robot.foot_names)
    return tuple(dict.fromkeys(step.target for step in chain)) if len(chain) > 1 else ()


def landing_rows(problem: GaitProblem, switch: Switch, q: ca.SX, v: ca.SX) -> RowGroup:
    """Return rows that are not negative; none where feet do not land one by one.

    After every impact of every order the feet on the ground have pushed, those that were released go up, and those that
    have still to land go on down.

    Args:
        problem: the gait problem.
        switch: at which several feet land.
        q: coordinates there, (n_q,).
        v: their rates before any impact, (n_q,).
    """
    pattern = problem.pattern
    rows: list[ca.SX] = []
    labels: list[Label] = []
    lower: list[float] = []
    for stance in _landed(problem, switch):
        contacts = pattern.contacts(stance)
        after, impulse = impact(contacts, q, v)
        pushes = contacts.local(impulse, contacts.points(q))
        where = "after " + ", ".join(foot for foot in stance.feet if foot in switch.landing)
        for foot, push in zip(stance.feet, pushes, strict=True):
            rows.append(contacts.contact.normal_force(push))
            labels += RowKind.LANDING_ORDER.labels([f"{where}: impulse {foot}"], "N s")
            lower.append(0.0)
        for foot in (*switch.lifting, *(foot for foot in switch.landing if foot not in stance.feet)):
            up = _upwards(problem, foot, q, after)
            rows.append(up if foot in switch.lifting else -up)
            way = "up" if foot in switch.lifting else "down"
            labels += RowKind.LANDING_ORDER.labels([f"{where}: velocity {way} {foot}"], "m/s")
            lower.append(RELEASE * velocity_unit(pattern.robot))
    return RowGroup(rows=rows, labels=labels, lower=lower, upper=[np.inf] * len(rows))


def _upwards(problem: GaitProblem, foot: str, q: ca.SX, v: ca.SX) -> ca.SX:
    robot, ground = problem.pattern.robot, problem.pattern.ground
    velocity = kinematics.foot_jacobian(robot, foot, q) @ v
    return into_frame(velocity, ground.frame(kinematics.foot_position(robot, foot, q)))[2]


def landing_force_rows(
    problem: GaitProblem, switch: Switch, before: tuple[ca.SX, ca.SX], u: ca.SX, friction: ca.SX
) -> RowGroup:
    """Return rows that say that feet which stand between two landings push, within their cones, where all land at once.

    On the gait the domain between two landings lasts no time; its forces are those of (22) of
    docs/theory/hybrid-model.md behind the impacts so far, under the next stance's first torques.

    Args:
        problem: the gait problem.
        switch: at which several feet land one by one.
        before: coordinates and rates before any impact, (n_q,) each.
        u: torques at the entry of the next stance, (n_joints,), N m.
        friction: coefficient.
    """
    q, v = before
    rows: list[ca.SX] = []
    labels: list[Label] = []
    lower: list[float] = []
    for stance in _landed(problem, switch)[:-1]:
        contacts = problem.pattern.contacts(stance)
        late = [foot for foot in switch.landing if foot not in stance.feet]
        forces = landing_motion(contacts, late, q, impact(contacts, q, v)[0], u).forces
        where = "between landings, after " + ", ".join(foot for foot in stance.feet if foot in switch.landing)
        for foot, local in zip(stance.feet, contacts.local(forces, contacts.points(q)), strict=True):
            sides = contacts.contact.sides
            rows.append(contacts.contact.normal_force(local))
            rows.append(contacts.contact.pyramid(local, (1.0 - MARGIN) * friction))
            names = [f"{where}: normal force {foot}", *(f"{where}: friction {foot} {side}" for side in sides)]
            labels += RowKind.LANDING_FORCE.labels(names, "N")
            lower += [problem.limits.normal_force, *(0.0 for _ in sides)]
    return RowGroup(rows=rows, labels=labels, lower=lower, upper=[np.inf] * len(lower))
