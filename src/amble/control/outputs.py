"""Outputs: which coordinates a domain controls, and the Bezier order of their desired values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from amble.control.phase import Phase, TimePhase
from amble.errors import InputError, UnknownNameError
from amble.hybrid import Contacts, GaitPattern, Stance
from amble.robot import Robot, kinematics
from amble.robot.catalogue import Posture
from amble.robot.coordinate_units import as_torques
from amble.robot.proposal import LATERAL, nominal_posture
from amble.types import Matrix, NodeValues, Vector

LARGEST_ORDER = 14
"""Order in which the closed loop writes every reference curve; a curve of higher order does not fit into it."""

WELL_CONDITIONED = 0.3
"""Share of the largest internal torque from which the paper's choice of the joint left out is kept."""

TIE = 1e-6
"""Relative difference of pivots below which the joint that comes first in the robot is taken, against roundoff."""


@dataclass(frozen=True)
class DomainOutputs:
    """The controlled coordinates of one domain, by name (joints, or roll, pitch, yaw), in coordinate order."""

    domain: str
    coordinates: tuple[str, ...]


@dataclass(frozen=True)
class Outputs:
    """The outputs of every solved domain of a pattern, the order of their Bezier curves and the phase they run on."""

    domains: tuple[DomainOutputs, ...]
    order: int
    phase: Phase = field(default_factory=TimePhase)

    def __post_init__(self) -> None:
        """Check the order.

        Raises:
            InputError: the curves cannot meet position and rate at both ends, or do not fit into the closed loop.
        """
        if self.order < 3:
            raise InputError(f"the order of the output curves is {self.order}; at least 3 is needed to meet both ends")
        if self.order > LARGEST_ORDER:
            raise InputError(
                f"the order of the output curves is {self.order}; the closed loop takes up to {LARGEST_ORDER}"
            )

    def of(self, domain: str) -> DomainOutputs:
        """Look the outputs of a domain up."""
        for candidate in self.domains:
            if candidate.domain == domain:
                return candidate
        raise UnknownNameError("domain", domain, [d.domain for d in self.domains])


def controllable(robot: Robot) -> tuple[str, ...]:
    """Return the names of y_a: roll, pitch, yaw (in the plane pitch) and the joints."""
    return robot.coordinate_names[len(robot.base.axes) :]


def actuated_freedoms(contacts: Contacts) -> int:
    """Return rank G of a stance: joints less the internal forces (docs/theory/hybrid-model.md, eq. 10).

    Raises:
        InputError: there are as many internal forces as joints, or more, so that nothing is left to control.
    """
    left = len(contacts.robot.joints) - contacts.internal_force_count
    if left <= 0:
        raise InputError(
            f"a stance on {', '.join(contacts.feet)} has {contacts.internal_force_count} directions of internal force, "
            f"but robot '{contacts.robot.name}' only {len(contacts.robot.joints)} joints: no motion is left to control"
        )
    return left


def joint_outputs(
    pattern: GaitPattern,
    order: int = 4,
    free: Mapping[str, Sequence[str]] | None = None,
    phase: Phase | None = None,
    posture: Posture | None = None,
) -> Outputs:
    """Control all joints but as many as the stance leaves unactuated.

    Args:
        pattern: the gait pattern.
        order: order of the Bezier curves, 3 to 14.
        free: solved domain -> joints left out; by default ``left_out``.
        phase: the variable that the curves run on; by default time since the entry of the domain.
        posture: where the joints left out by default are chosen; by default the robot's nominal posture.

    Raises:
        InputError: the number of joints left out does not fit the stance, or no posture is known by default.
        UnknownNameError: a domain or joint that does not exist.
    """
    known = [stance.name for stance in pattern.solved]
    for name in free or {}:
        if name not in known:
            raise UnknownNameError("domain", name, known)
    domains = []
    for stance in pattern.solved:
        given = (free or {}).get(stance.name)  # an empty list means that no joint is left out
        free_joints = left_out(pattern, stance, posture) if given is None else tuple(given)
        domains.append(_domain_outputs(pattern, stance, free_joints))
    return Outputs(tuple(domains), order, phase or TimePhase())


def selection_matrix(robot: Robot, outputs: DomainOutputs) -> Matrix:
    """Return H_0: the rows of the identity over y_a that pick the controlled coordinates, (n_y, n_a)."""
    names = controllable(robot)
    matrix = np.zeros((len(outputs.coordinates), len(names)))
    for row, coordinate in enumerate(outputs.coordinates):
        matrix[row, names.index(coordinate)] = 1.0
    return matrix


def left_out(pattern: GaitPattern, stance: Stance, posture: Posture | None = None) -> tuple[str, ...]:
    """Return the joints that a stance leaves out by default, in robot order: as many as it has internal forces.

    The torques that the outputs can do without are those of the internal forces, N (n_joints, k): outputs decouple
    exactly where the k rows of N of the joints left out are regular. They are chosen by pivoting on those rows at a
    posture. For two feet the paper's choice, the hip pitch of the rear stance leg, is kept where it carries at least
    ``WELL_CONDITIONED`` of the largest internal torque.

    Args:
        pattern: the gait pattern.
        stance: one of its stances.
        posture: where to look; by default the robot's nominal posture.

    Raises:
        InputError: no posture is known by default, or no choice of joints is regular at it.
    """
    robot, contacts = pattern.robot, pattern.contacts(stance)
    if actuated_freedoms(contacts) == len(robot.joints):
        return ()
    torques = _internal_torques(contacts, posture or nominal_posture(robot))
    if len(stance.feet) == 2 and torques.shape[1] == 1:
        papers, sizes = rear_hip_pitch(pattern, stance), np.abs(torques[:, 0])
        if papers and sizes[robot.joint_index(papers)] >= WELL_CONDITIONED * sizes.max():
            return (papers,)
    chosen = _pivoted(torques)
    if chosen is None:
        raise InputError(f"no choice of outputs of stance '{stance.name}' is regular at the posture")
    return tuple(robot.joint_names[place] for place in sorted(chosen))


def least_share(pattern: GaitPattern, stance: Stance, coordinates: Sequence[str], positions: NodeValues) -> float:
    """Return the least that the joints left out hold of any internal torque along a motion, 0 to 1.

    It is the smallest singular value of their rows of N, orthonormal; at 0 the outputs cannot be decoupled.

    Args:
        pattern: the gait pattern.
        stance: one of its stances.
        coordinates: that are controlled in it.
        positions: where the motion passes, (n, n_q).
    """
    rows = [row for row, joint in enumerate(pattern.robot.joint_names) if joint not in coordinates]
    return _least(_along(pattern.contacts(stance), positions), rows)


def left_out_along(
    pattern: GaitPattern, stance: Stance, coordinates: Sequence[str], positions: NodeValues
) -> tuple[str, ...]:
    """Return joints left out whose ``least_share`` along a motion is larger, exchanged one by one while that grows.

    Arguments are those of ``least_share``.
    """
    names = pattern.robot.joint_names
    torques = _along(pattern.contacts(stance), positions)
    chosen = {row for row, joint in enumerate(names) if joint not in coordinates}
    steered = np.flatnonzero(np.abs(torques).max(axis=(0, 2)) > TIE)
    best = _least(torques, sorted(chosen))
    while True:
        trials = [chosen - {out} | {int(other)} for out in chosen for other in steered if other not in chosen]
        sizes = [_least(torques, sorted(trial)) for trial in trials]
        if not trials or not max(sizes) > (1.0 + TIE) * best:
            return tuple(names[row] for row in sorted(chosen))
        place = int(np.argmax(sizes))
        chosen, best = trials[place], sizes[place]


def _along(contacts: Contacts, positions: NodeValues) -> NodeValues:
    """Orthonormal bases of the internal torques along a motion, (n, n_joints, k)."""
    q = ca.SX.sym("q", contacts.robot.size)
    function = ca.Function(
        "internal", [q], [ca.densify(as_torques(contacts.robot, contacts.torque_null_space(q)[0]))]
    ).map(len(positions))
    found = np.asarray(function(np.asarray(positions).T))
    return np.linalg.qr(np.stack(np.split(found, len(positions), axis=1)))[0]


def _least(torques: NodeValues, rows: Sequence[int]) -> float:
    return float(np.linalg.svd(torques[:, rows, :], compute_uv=False)[:, -1].min()) if len(rows) else 1.0


def rear_hip_pitch(pattern: GaitPattern, stance: Stance) -> str | None:
    """Return the paper's choice: the first joint with a lateral axis of the stance leg whose hip lies furthest back.

    None where that leg has no such joint.
    """
    robot = pattern.robot
    poses = {foot: [_at_zero(robot, joint) for joint in robot.legs[foot]] for foot in stance.feet}
    rear = min(stance.feet, key=lambda foot: poses[foot][0][1][0])
    for joint, (axis, _) in zip(robot.legs[rear], poses[rear], strict=True):
        if abs(axis[1]) > LATERAL and not robot.joint(joint).prismatic:
            return joint
    return None


def _internal_torques(contacts: Contacts, posture: Posture) -> Matrix:
    """Orthonormal basis of the torques that cause no acceleration at a posture, (n_joints, k)."""
    found, _ = contacts.torque_null_space(ca.SX(posture.coordinates(contacts.robot)))
    return np.linalg.qr(np.asarray(ca.DM(ca.densify(as_torques(contacts.robot, found))).full()))[0]


def _pivoted(torques: Matrix) -> list[int] | None:
    """Pick as many rows as there are columns, each the longest orthogonal to those before; None where none is left."""
    rest, chosen = torques.copy(), []
    for _ in range(torques.shape[1]):
        lengths = np.linalg.norm(rest, axis=1)
        best = int(np.argmax(lengths >= (1.0 - TIE) * lengths.max()))
        if not lengths[best] > TIE:
            return None
        chosen.append(best)
        direction = rest[best] / lengths[best]
        rest = rest - np.outer(rest @ direction, direction)
    return chosen


def _at_zero(robot: Robot, joint: str) -> tuple[Vector, Vector]:
    """Axis and origin of a joint in the base frame, all joints at zero."""
    record = robot.joint(joint)
    rotation, origin = kinematics.link_pose(robot, record.child, np.zeros(robot.size))
    return np.asarray(rotation) @ record.axis, np.asarray(origin).ravel()


def _domain_outputs(pattern: GaitPattern, stance: Stance, left_out: tuple[str, ...]) -> DomainOutputs:
    robot = pattern.robot
    for joint in left_out:
        if joint not in robot.joint_names:
            raise UnknownNameError("joint", joint, robot.joint_names)
    wanted = actuated_freedoms(pattern.contacts(stance))
    chosen = tuple(joint for joint in robot.joint_names if joint not in left_out)
    if len(chosen) != wanted:
        raise InputError(
            f"stance '{stance.name}' has {wanted} actuated degrees of freedom, but {len(chosen)} outputs "
            f"(left out: {', '.join(left_out) or 'none'})"
        )
    return DomainOutputs(stance.name, chosen)
