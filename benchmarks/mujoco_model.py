"""The same robot for MuJoCo: links with the same inertias, hinges with the same axes, point feet on a plane.

ASTRo's published lower legs have inertias that no body can have (0.0665, 0.0032, 0.0032 kg m^2); MuJoCo only accepts
them balanced. That changes its motion, not the time of a step.
"""

from __future__ import annotations

import numpy as np

from amble.robot import Robot

FOOT_RADIUS = 0.005


def model_of(robot: Robot) -> str:
    """Return the model as MJCF; joints in the robot's order along the tree, one servo each."""
    body = f'<body name="{robot.links[0].name}" pos="0 0 1"><freejoint/>{_content(robot, 0)}</body>'
    servos = "".join(f'<position joint="{joint.name}" kp="200" kv="5"/>' for joint in robot.joints)
    return (
        f'<mujoco><compiler balanceinertia="true"/><option gravity="0 0 {-robot.gravity}"/>'
        f'<worldbody><geom type="plane" size="100 100 1"/>{body}</worldbody><actuator>{servos}</actuator></mujoco>'
    )


def _content(robot: Robot, link: int) -> str:
    record = robot.links[link]
    inertia = record.inertia
    full = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    text = f'<inertial pos="{_text(record.center)}" mass="{record.mass}" fullinertia="{_text(full)}"/>'
    for foot in robot.feet:
        if foot.link == link:
            text += f'<geom type="sphere" size="{FOOT_RADIUS}" pos="{_text(foot.offset)}" friction="0.6"/>'
    for joint in robot.joints:
        if joint.parent == link:
            axes = f"{_text(joint.rotation[:, 0])} {_text(joint.rotation[:, 1])}"
            text += (
                f'<body name="{robot.links[joint.child].name}" pos="{_text(joint.translation)}" xyaxes="{axes}">'
                f'<joint name="{joint.name}" axis="{_text(joint.axis)}"/>{_content(robot, joint.child)}</body>'
            )
    return text


def _text(values: object) -> str:
    return " ".join(f"{float(value):.12g}" for value in np.asarray(values))
