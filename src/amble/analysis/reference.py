"""A gait as a reference motion for other programs: states, torques, forces, contacts at a steady rate, with names."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from amble.amounts import check_amount
from amble.analysis.samples import Samples, samples_of_gait, samples_of_trace
from amble.defaults import ORDERS, Order
from amble.errors import InputError, UnknownNameError, shown
from amble.gait import Gait
from amble.robot import Robot
from amble.robot.free_base import free_base, link_trajectories
from amble.simulation import Trace
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


def reference_motion(
    gait: Gait, rate: float, cycles: int | None = None, order: Order = "mujoco", trace: Trace | None = None
) -> ReferenceMotion:
    """Sample the optimised motion of a gait, or a trace of its walk.

    Between the nodes positions follow the cubics that meet positions and velocities, all else cubic splines within a
    domain; at an event the instant belongs to the domain that begins.

    Args:
        gait: the gait.
        rate: instants a second.
        cycles: how many gait cycles; the first instant of the next one is not there. By default one, of a trace all.
        order: of joints and bodies.
        trace: a motion of this gait, simulated or walked in MuJoCo.

    Raises:
        InputError: the rate or the number of cycles cannot be used, or the trace is of another robot.
        UnknownNameError: there is no such order, or a domain of the trace is no stance of the gait.
    """
    if order not in ORDERS:
        raise UnknownNameError("order", order, ORDERS)
    if cycles is not None:
        check_amount("cycles", cycles, 1, MOST_CYCLES)
    if trace is None:
        _check_rate(rate, (cycles or 1) * gait.period)
        samples = samples_of_gait(gait, cycles or 1)
    else:
        whole = samples_of_trace(trace, gait.pattern)
        samples = whole if cycles is None else whole.only(0, cycles)
        _check_rate(rate, float(samples.times[-1] - samples.times[0]))
    return _sampled(gait, samples, rate, order)


def _check_rate(rate: float, duration: float) -> None:
    if not (isfinite(rate) and rate > 0.0 and rate * duration <= MOST_ROWS):
        raise InputError(
            f"{shown(rate)} rows a second cannot be: the rate must be above 0 and make at most {MOST_ROWS:,} rows"
        )


def _sampled(gait: Gait, samples: Samples, rate: float, order: Order) -> ReferenceMotion:
    robot, start = gait.robot, float(samples.times[0])
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
        at = times[visit == number]
        nodes, kept = np.unique(samples.times[firsts[number] : lasts[number]], return_index=True)
        rows = firsts[number] + kept
        others = (samples.velocities, samples.torques, samples.forces)
        if len(nodes) == 1:  # a visit of one row, as a trace may hold
            parts.append([np.repeat(each[rows], len(at), axis=0) for each in (samples.positions, *others)])
            continue
        splines = [CubicHermiteSpline(nodes, samples.positions[rows], samples.velocities[rows])]
        splines += [CubicSpline(nodes, each[rows]) for each in others]
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
