"""Rows at every node that a gait problem has where its limits ask for them: knees, base and legs apart, motors."""

from __future__ import annotations

from math import inf

import casadi as ca

from amble.gait.clearances import Clearances, gaps_between_legs, heights
from amble.hybrid import Contacts
from amble.robot.natural_units import RobotUnits
from amble.synthesis.layout import MARGIN, POSITION_MARGIN
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowGroup, RowKind


def clearance_rows(problem: GaitProblem, contacts: Contacts, q: ca.SX, v: ca.SX, u: ca.SX) -> RowGroup:
    """Write the rows of one node, with the margins of a node; none by default.

    Args:
        problem: the problem.
        contacts: of the stance.
        q: coordinates, (n_q,).
        v: their rates, (n_q,).
        u: torques, (n_joints,).
    """
    robot, limits = contacts.robot, problem.limits
    asked = limits.clearances or Clearances()
    margin = POSITION_MARGIN * RobotUnits.of(robot).size("m") * problem.node_margins
    high, apart = heights(robot, contacts.ground, asked, q), gaps_between_legs(robot, asked, q)
    labels = RowKind.PART_HEIGHT.labels(high, "m") + RowKind.LEGS_APART.labels(apart, "m")
    rows, least = [row for row, _ in (high | apart).values()], [low + margin for _, low in (high | apart).values()]
    most = [inf] * len(rows)
    for joint, motor in limits.motors.items():
        place = robot.joint_index(joint)
        rows.append(motor.used(u[place], v[robot.base.size + place]))
        labels += RowKind.TORQUE_SPEED.labels([f"torque over speed {joint}"], "1")
        least, most = [*least, MARGIN - 1.0], [*most, 1.0 - MARGIN]
    return RowGroup(rows=rows, labels=labels, lower=least, upper=most)
