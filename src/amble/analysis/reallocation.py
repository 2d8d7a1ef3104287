"""The torques of other laws along a given motion: same accelerations (docs/theory/allocation.md, eq. 6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.analysis.samples import Samples
from amble.control import AllocationLaw, Redundancy
from amble.errors import InputError
from amble.hybrid import Contacts
from amble.numerics.linear_algebra import SymmetricFactor
from amble.types import NodeValues, frozen


@dataclass(frozen=True)
class Allocated:
    """What one law applies along a motion.

    Attributes:
        torques: joint torques, (n, n_joints), N m.
        forces: contact forces of all feet that go with them, zero for swing feet, world frame, (n, n_f), N.
    """

    torques: NodeValues
    forces: NodeValues


def reallocate(samples: Samples, laws: Sequence[AllocationLaw]) -> Mapping[str, Allocated]:
    """Apply laws along a motion whose torques and forces are known.

    Adding internal forces W s to the contact forces and -(leg rows of J^T) W s to the torques changes no acceleration;
    so the recorded torques of any law lead to those of every other, without the controller.

    Args:
        samples: the motion, with the torques and forces of whichever law walked it.
        laws: the laws.

    Returns:
        Law name -> torques and forces, in the order of ``laws``.

    Raises:
        InputError: where two laws have the same name, or a law does not fit a stance.
    """
    names = [law.name for law in laws]
    if len(set(names)) != len(names):
        raise InputError(f"two laws have the same name: {', '.join(names)}")
    torques = {name: np.array(samples.torques) for name in names}
    forces = {name: np.array(samples.forces) for name in names}
    for number, stance in enumerate(samples.pattern.visited):
        inside = np.flatnonzero(samples.stances == number)
        if inside.size == 0:
            continue
        contacts = samples.pattern.contacts(stance)
        columns = np.array(contacts.columns, dtype=np.int64)
        known = (
            samples.positions[inside],
            samples.velocities[inside],
            samples.torques[inside],
            samples.forces[np.ix_(inside, columns)],
        )
        for law in laws:
            found = _reallocation(contacts, law)(*(values.T for values in known))
            torques[law.name][inside] = np.asarray(found[0]).T
            forces[law.name][np.ix_(inside, columns)] = np.asarray(found[1]).T
    return {name: Allocated(frozen(torques[name]), frozen(forces[name])) for name in names}


def _reallocation(contacts: Contacts, law: AllocationLaw) -> ca.Function:
    """Write (q, v, u, lambda) -> (u, lambda) of a law in one stance."""
    robot = contacts.robot
    joints = len(robot.joints)
    q, v = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size)
    u, forces = ca.SX.sym("u", joints), ca.SX.sym("lambda", contacts.size)
    given = Redundancy.at(contacts, (q, v), (u, forces))
    if given.size == 0:
        return ca.Function("reallocation", [q, v, u, forces], [u, forces])
    # to the minimum-norm member first, from which a law chooses
    N = given.torque_basis
    least = given.moved(-SymmetricFactor.of(N.T @ N).solve(N.T @ given.torques))
    chosen = least.moved(law.allocate(least))
    return ca.Function("reallocation", [q, v, u, forces], [chosen.loads, chosen.forces])
