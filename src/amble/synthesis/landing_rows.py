"""Rows that make every order of landing possible: what has to hold after each impact where feet land one by one."""

from __future__ import annotations

import casadi as ca

from amble.hybrid import Switch, impact
from amble.hybrid.ground import into_frame
from amble.hybrid.landing import steps
from amble.robot import kinematics
from amble.robot.natural_units import velocity_unit
from amble.synthesis.assembly import Label
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowKind

RELEASE = 0.001
"""Least speed of a released foot away from the ground, as a share of sqrt(g l): from a start beside the orbit a slower
one would touch the ground at once."""


def landing_rows(
    problem: GaitProblem, switch: Switch, q: ca.SX, v: ca.SX
) -> tuple[list[ca.SX], list[Label], list[float]]:
    """Return rows that are not negative, their labels and their lower bounds; none where feet do not land one by one.

    After every impact of every order the feet on the ground have pushed, those that were released go up, and those that
    have still to land go on down.

    Args:
        problem: the gait problem.
        switch: at which several feet land.
        q: coordinates there, (n_q,).
        v: their rates before any impact, (n_q,).
    """
    pattern = problem.pattern
    chain = steps(switch, pattern.landing_rule, pattern.robot.foot_names)
    rows: list[ca.SX] = []
    names: list[str] = []
    lower: list[float] = []
    for stance in dict.fromkeys(step.target for step in chain) if len(chain) > 1 else ():
        contacts = pattern.contacts(stance)
        after, impulse = impact(contacts, q, v)
        pushes = contacts.local(impulse, contacts.points(q))
        where = "after " + ", ".join(foot for foot in stance.feet if foot in switch.landing)
        for foot, push in zip(stance.feet, pushes, strict=True):
            rows.append(contacts.contact.normal_force(push))
            names.append(f"{where}: impulse {foot}")
            lower.append(0.0)
        for foot in (*switch.lifting, *(foot for foot in switch.landing if foot not in stance.feet)):
            up = _upwards(problem, foot, q, after)
            rows.append(up if foot in switch.lifting else -up)
            names.append(f"{where}: velocity {'up' if foot in switch.lifting else 'down'} {foot}")
            lower.append(RELEASE * velocity_unit(pattern.robot))
    return rows, list(RowKind.LANDING_ORDER.labels(*names)), lower


def _upwards(problem: GaitProblem, foot: str, q: ca.SX, v: ca.SX) -> ca.SX:
    robot, ground = problem.pattern.robot, problem.pattern.ground
    velocity = kinematics.foot_jacobian(robot, foot, q) @ v
    return into_frame(velocity, ground.frame(kinematics.foot_position(robot, foot, q)))[2]
