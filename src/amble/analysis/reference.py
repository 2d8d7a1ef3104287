"""A gait as a reference motion for other programs: states, torques, forces, contacts at a steady rate, with names."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from amble.amounts import check_amount
from amble.analysis.samples import Samples, samples_of_gait
from amble.defaults import ORDERS, Order
from amble.errors import InputError, UnknownNameError, shown
from amble.gait import Gait
from amble.io.storage import atomic_write
from amble.robot import Robot
from amble.robot.free_base import free_base, link_trajectories
from amble.types import Matrix, NodeValues, Vector

MOST_CYCLES, MOST_ROWS = 10_000, 100_000


@dataclass(frozen=True, kw_only=True)
class ReferenceMotion:
    """A motion at a steady rate; arrays have a row an instant.

    Attributes:
        time: s, from 0, (n,).
        qpos: place of the base, m, its quaternion (w, x, y, z), joint angles, rad, (n, 7 + n_joints).
        qvel: velocity of the base in the world's axes, m/s, its angular velocity in its own, rad/s, joint rates, rad/s,
            (n, 6 + n_joints).
        torques: of the joints, N m, (n, n_joints).
        forces: on every foot, in the world's axes, N, without moments, (n, n_feet, 3); zero in the air.
        contacts: whether a foot stands, (n, n_feet).
        body_positions: origins of the links in the world, m, (n, n_links, 3).
        body_quaternions: of the links (w, x, y, z), (n, n_links, 4).
        joints: names, in the order of the columns.
        bodies: names.
        feet: labels, in the robot's order.
        stances: name of the stance at every instant.
        rate: Hz.
        period: of the gait, s.
        command: forward and lateral speed, m/s, and yaw rate, rad/s.
    """

    time: Vector
    qpos: Matrix
    qvel: Matrix
    torques: Matrix
    forces: NodeValues
    contacts: NodeValues
    body_positions: NodeValues
    body_quaternions: NodeValues
    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    feet: tuple[str, ...]
    stances: tuple[str, ...]
    rate: float
    period: float
    command: tuple[float, float, float]


def reference_motion(gait: Gait, rate: float, cycles: int = 1, order: Order = "mujoco") -> ReferenceMotion:
    """Sample the optimised motion of a gait.

    Between the nodes positions follow the cubics that meet positions and velocities, all else cubic splines within a
    domain; at an event the instant belongs to the domain that begins.

    Args:
        gait: the gait.
        rate: instants a second.
        cycles: how many gait cycles; the first instant of the next one is not there.
        order: of joints and bodies.

    Raises:
        InputError: the rate or the number of cycles cannot be used.
        UnknownNameError: there is no such order.
    """
    if order not in ORDERS:
        raise UnknownNameError("order", order, ORDERS)
    check_amount("cycles", cycles, 1, MOST_CYCLES)
    if not (isfinite(rate) and rate > 0.0 and rate * cycles * gait.period <= MOST_ROWS):
        raise InputError(
            f"{shown(rate)} rows a second cannot be: the rate must be above 0 and make at most {MOST_ROWS:,} rows"
        )
    samples, robot = samples_of_gait(gait, cycles), gait.robot
    start = float(samples.times[0])
    # an instant that falls on the end by rounding is the first of the next cycle
    count = int(np.ceil(rate * (float(samples.times[-1]) - start) - 1e-6))
    time = np.arange(max(count, 1)) / rate
    q, v, torques, forces, stances = _between(samples, start + time)
    base, twist = free_base(robot.base.spatial(q), robot.base.spatial(v))
    angles, rates = q[:, robot.base.size :], v[:, robot.base.size :]
    axes = list(gait.pattern.contact.axes)
    pushes = np.zeros((len(time), len(robot.feet), 3))
    pushes[:, :, axes] = forces.reshape(len(time), len(robot.feet), -1)[:, :, : len(axes)]
    poses = link_trajectories(robot, q)
    joints, links = _orders(robot, order)
    down = np.array([[foot in stance.feet for foot in robot.foot_names] for stance in gait.pattern.visited])
    return ReferenceMotion(
        time=time,
        qpos=np.hstack([base, angles[:, joints]]),
        qvel=np.hstack([twist, rates[:, joints]]),
        torques=torques[:, joints],
        forces=pushes,
        contacts=down[stances],
        body_positions=poses[:, links, :3],
        body_quaternions=poses[:, links, 3:][..., [3, 0, 1, 2]],
        joints=tuple(robot.joint_names[place] for place in joints),
        bodies=tuple(robot.links[place].name for place in links),
        feet=tuple(robot.foot_names),
        stances=tuple(gait.pattern.visited[number].name for number in stances),
        rate=float(rate),
        period=gait.period,
        command=(gait.speed, gait.lateral_speed, gait.yaw_rate),
    )


def _between(samples: Samples, times: Vector) -> tuple[Matrix, Matrix, Matrix, Matrix, list[int]]:
    """Positions, velocities, torques, forces and stances between the nodes, domain by domain."""
    from scipy.interpolate import CubicHermiteSpline, CubicSpline

    firsts = np.flatnonzero(np.diff(samples.segments, prepend=samples.segments[0] - 1))
    lasts = np.append(firsts[1:], len(samples.times))
    entered = samples.times[firsts]
    visit = np.clip(np.searchsorted(entered, times + 1e-12, side="right") - 1, 0, len(firsts) - 1)
    parts: list[list[Matrix]] = []
    for number in np.unique(visit):
        rows, at = slice(firsts[number], lasts[number]), times[visit == number]
        nodes = samples.times[rows]
        splines = [CubicHermiteSpline(nodes, samples.positions[rows], samples.velocities[rows])]
        splines += [CubicSpline(nodes, each[rows]) for each in (samples.velocities, samples.torques, samples.forces)]
        parts.append([np.asarray(spline(at)) for spline in splines])
    q, v, torques, forces = (np.concatenate(values) for values in zip(*parts, strict=True))
    return q, v, torques, forces, [int(samples.stances[firsts[number]]) for number in visit]


def _orders(robot: Robot, order: Order) -> tuple[list[int], list[int]]:
    """Places of the joints and links."""
    if order == "file":
        return list(range(len(robot.joints))), list(range(len(robot.links)))
    joints, links = list[int](), [0]

    def visit(link: int) -> None:
        for place, joint in enumerate(robot.joints):
            if joint.parent == link:
                joints.append(place)
                links.append(joint.child)
                visit(joint.child)

    visit(0)
    return joints, links


def write_reference(motion: ReferenceMotion, path: str | Path) -> Path:
    """Write a reference motion as npz, with an array an attribute, or as CSV, with a column a number.

    Raises:
        InputError: the suffix is another one, or the place cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        stream = io.BytesIO()
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in vars(motion).items()}
        np.savez(stream, **arrays)
        return atomic_write(path, stream.getvalue())
    if suffix == ".csv":
        return atomic_write(path, _table(motion))
    raise InputError(f"'{shown(Path(path).name)}' is no reference motion by its suffix; known: .npz, .csv")


def _table(motion: ReferenceMotion) -> str:
    base = ("x", "y", "z", "qw", "qx", "qy", "qz")
    twist = ("vx", "vy", "vz", "wx", "wy", "wz")
    columns: list[tuple[Sequence[str], NodeValues]] = [
        (["time"], motion.time[:, None]),
        ([*base, *motion.joints], motion.qpos),
        ([*twist, *(f"rate of {name}" for name in motion.joints)], motion.qvel),
        ([f"torque {name}" for name in motion.joints], motion.torques),
        ([f"force {foot} {axis}" for foot in motion.feet for axis in base[:3]], motion.forces),
        ([f"contact {foot}" for foot in motion.feet], motion.contacts.astype(np.int64)),
        ([f"{body} {axis}" for body in motion.bodies for axis in base[:3]], motion.body_positions),
        ([f"{body} {axis}" for body in motion.bodies for axis in base[3:]], motion.body_quaternions),
    ]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["stance", *(name for names, _ in columns for name in names)])
    for row, stance in enumerate(motion.stances):
        writer.writerow([stance, *(repr(value) for _, values in columns for value in values[row].ravel().tolist())])
    return stream.getvalue()
