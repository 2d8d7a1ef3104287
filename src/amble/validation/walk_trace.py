"""A walk in MuJoCo as a trace, the record that simulations leave: for replays, figures and files."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from amble.gait import Gait
from amble.robot import Robot
from amble.simulation import Event, Trace
from amble.simulation.trace import COMPLETED
from amble.types import Matrix
from amble.validation.loop import Walk

ROWS = 100
"""Rows a gait cycle, about."""


def interval_of(gait: Gait, step: float) -> int:
    """Return how many steps of the plant lie between two rows of a trace."""
    return max(1, round(gait.period / ROWS / step))


def walk_trace(gait: Gait, model: Any, walk: Walk, cycles: int) -> Trace:
    """Return a walk in amble's coordinates.

    The engine has no resets, so both sides of an event are the rows beside it; the controller's stance is the domain.

    Args:
        gait: what walked.
        model: the model in which it did.
        walk: with rows, at least one.
        cycles: how many were asked for.
    """
    robot, rows = gait.robot, walk.trace
    states = from_mujoco(robot, model, rows[:, 2 : 2 + model.nq], rows[:, 2 + model.nq : 2 + model.nq + model.nv])
    torques, forces = np.split(rows[:, 2 + model.nq + model.nv :], [len(robot.joints)], axis=1)
    names, stances = tuple(stance.name for stance in gait.pattern.visited), rows[:, 1].astype(np.int64)
    changes = np.flatnonzero(np.diff(stances)) + 1
    entries = np.concatenate([[0], changes])
    entered = entries[np.searchsorted(entries, np.arange(len(rows)), side="right") - 1]
    events = [
        Event(float(rows[row, 0]), f"{names[stances[row - 1]]} to {names[stances[row]]}", states[row - 1], states[row])
        for row in changes
    ]
    if walk.cycles >= cycles:  # the walk ends where the next cycle would begin
        events.append(Event(walk.time, f"{names[stances[-1]]} to {names[0]}", states[-1], states[-1]))
    ended = COMPLETED if walk.cycles >= cycles else f"{'fell' if walk.fell else 'stopped'} after {walk.time:.3g} s"
    return Trace(
        domains=names,
        state_names=(*robot.coordinate_names, *(f"rate of {name}" for name in robot.coordinate_names)),
        time=rows[:, 0].copy(),
        clock=rows[:, 0] - rows[entered, 0],
        domain=stances,
        cycle=np.cumsum(np.diff(stances, prepend=stances[0]) < 0).astype(np.int64),
        state=states,
        signals={"torque": torques.copy(), "force": forces.copy()},
        events=tuple(events),
        cycles=walk.cycles,
        ended=ended,
        tolerance=float(model.opt.tolerance),
        seconds=0.0,
    )


def from_mujoco(robot: Robot, model: Any, qpos: Matrix, qvel: Matrix) -> Matrix:
    """Return states (q, v) of rows of qpos and qvel, the inverse of ``to_mujoco``; angles are continuous, (n, 2 n_q).

    Args:
        robot: the robot.
        model: of it.
        qpos: (n, model.nq).
        qvel: (n, model.nv).
    """
    angles = Rotation.from_quat(qpos[:, [4, 5, 6, 3]]).as_euler("XYZ")
    rates = np.empty_like(angles)
    for row, (_, pitch, yaw) in enumerate(angles):
        cb, sb, cc, sc = np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
        rates[row] = np.linalg.solve([[cc * cb, sc, 0.0], [-sc * cb, cc, 0.0], [sb, 0.0, 1.0]], qvel[row, 3:6])
    joints = [model.joint(name) for name in robot.joint_names]
    places, speeds = [int(joint.qposadr[0]) for joint in joints], [int(joint.dofadr[0]) for joint in joints]
    return np.hstack([qpos[:, :3], np.unwrap(angles, axis=0), qpos[:, places], qvel[:, :3], rates, qvel[:, speeds]])
