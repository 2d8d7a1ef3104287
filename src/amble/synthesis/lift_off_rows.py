"""Rows of a lift-off: a foot that leaves by its force accelerates away from the ground just after."""

from __future__ import annotations

import casadi as ca

from amble.hybrid import Switch
from amble.hybrid.ground import into_frame
from amble.robot import kinematics
from amble.synthesis.block import Label
from amble.synthesis.problem import GaitProblem
from amble.synthesis.rows import RowKind

RISE = 0.01
"""Least acceleration of a foot along the ground's normal just after its lift-off, in g: with none it would stay."""


def lift_off_rows(
    problem: GaitProblem, switch: Switch, q: ca.SX, v: ca.SX, a: ca.SX
) -> tuple[list[ca.SX], list[Label]]:
    """Return the acceleration of every leaving foot along the normal, in g, and its label.

    Args:
        problem: the gait problem.
        switch: at which feet leave by their force.
        q: coordinates there, (n_q,).
        v: their rates, (n_q,).
        a: the accelerations at the entry of the next domain, (n_q,).
    """
    robot, ground = problem.pattern.robot, problem.pattern.ground
    rows = []
    for foot in switch.leaving:
        acceleration = kinematics.foot_jacobian(robot, foot, q) @ a + kinematics.foot_bias(robot, foot, q, v)
        along = into_frame(acceleration, ground.frame(kinematics.foot_position(robot, foot, q)))
        rows.append(along[2] / robot.gravity)
    return rows, RowKind.LIFT_OFF.labels((f"lift-off acceleration {foot} (g)" for foot in switch.leaving), "1")
