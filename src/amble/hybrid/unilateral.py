"""Unilateral contact: the ground pushes and does not pull. Which feet are in contact is a number of each, 1 or 0.

With E the diagonal of these numbers, a foot's repeated for its components, forces and impulses of the feet in contact
follow from (E J D^-1 J^T E + 1 - E) lambda = E b, those of the others are 0: one expression serves every set of feet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from amble.hybrid.constrained_dynamics import StandingEquations, selection
from amble.hybrid.contacts import Contacts
from amble.numerics.linear_algebra import SymmetricFactor
from amble.robot import Robot, dynamics, kinematics
from amble.robot.natural_units import velocity_unit
from amble.types import frozen

STICKS = 1e-4
"""A pulling impulse of this share of m sqrt(g l) is let pass: feet that strike in turn would do so ever faster."""

DROPS = 2
"""How often feet that an impact would have to pull are left out of it, one after the other where need be."""


@dataclass(frozen=True, kw_only=True)
class UnilateralMotion:
    """The motion of a robot with some of its feet in contact.

    Attributes:
        acceleration: q'', (n_q,).
        forces: contact forces of every foot, world frame, (n_f,), N; zero where a foot is not in contact.
    """

    acceleration: ca.SX
    forces: ca.SX


def unilateral_motion(
    contacts: Contacts, active: ca.SX, q: ca.SX, v: ca.SX, u: ca.SX, push: ca.SX, extra: ca.SX
) -> UnilateralMotion:
    """Write the motion with the feet in contact held to the ground, whether they push or pull.

    Args:
        contacts: every foot of the robot.
        active: 1 for a foot in contact, 0 for another, (n_feet,).
        q: coordinates, (n_q,).
        v: their rates, (n_q,).
        u: torques, (n_joints,), N m.
        push: force on the base at its centre of mass, world frame, (3,), N.
        extra: mass and inertia of the base link beside its own, as a share of it.
    """
    robot, equations = contacts.robot, _equations(contacts, q, extra)
    bias, base = dynamics.bias(robot, q, v), robot.size - len(robot.joints)
    bias[:base] += extra * (dynamics.bias(_doubled(robot), q, v)[:base] - bias[:base])
    force = selection(robot) @ u - bias + base_jacobian(contacts, q).T @ push
    free = equations.mass.solve(force)
    wanted = -contacts.bias(q, v) - contacts.jacobian(q) @ free
    forces = _held(contacts, equations, active).solve(_components(contacts, active) * wanted)
    return UnilateralMotion(acceleration=free + equations.moved @ forces, forces=forces)


def unilateral_impact(
    contacts: Contacts, active: ca.SX, landing: ca.SX, q: ca.SX, v: ca.SX, extra: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Write a plastic impact on the feet in contact; a foot that it would have to pull is left out, and rises.

    Of the feet that do not land the one with the most negative normal impulse is left out, up to ``DROPS`` times.

    Args:
        contacts: every foot of the robot.
        active: 1 for a foot in contact after the impact, (n_feet,).
        landing: 1 for those of them that land, which are never left out, (n_feet,).
        q: coordinates, (n_q,).
        v: rates before the impact, (n_q,).
        extra: as of ``unilateral_motion``.

    Returns:
        Rates after it, (n_q,), the feet in contact then, (n_feet,), and the impulses of every foot, (n_f,), N s.
    """
    equations, points = _equations(contacts, q, extra), contacts.points(q)
    missing, unit = -contacts.jacobian(q) @ v, contacts.robot.mass * velocity_unit(contacts.robot)
    for drop in range(DROPS + 1):
        impulses = _held(contacts, equations, active).solve(_components(contacts, active) * missing)
        if drop < DROPS:
            normal = normal_forces(contacts, impulses, points)
            pulled = ca.if_else(active * (1.0 - landing) > 0.5, normal + STICKS * unit, 0.0)
            active = ca.if_else(ca.logic_and(pulled < 0.0, pulled <= ca.mmin(pulled)), 0.0, active)
    return v + equations.moved @ impulses, active, impulses


def normal_forces(contacts: Contacts, forces: ca.SX, points: ca.SX) -> ca.SX:
    """Return the normal force of every foot, (n_c,), N."""
    return ca.vertcat(*[contacts.contact.normal_force(local) for local in contacts.local(forces, points)])


def tangential_loads(contacts: Contacts, forces: ca.SX, points: ca.SX) -> ca.SX:
    """Return what friction carries at every foot, (n_c,), N."""
    return ca.vertcat(*[contacts.contact.tangential(local) for local in contacts.local(forces, points)])


def base_jacobian(contacts: Contacts, q: ca.SX) -> ca.SX:
    """Return the Jacobian of the centre of mass of the base link, (3, n_q)."""
    robot = contacts.robot
    s, base = robot.base.spatial(q), robot.links[0]
    center = s[:3] + kinematics.base_rotation(s) @ ca.DM(base.center)
    return ca.jacobian(center, q)


def _equations(contacts: Contacts, q: ca.SX, extra: ca.SX) -> StandingEquations:
    """Factor the mass matrix with a heavier base link, which enters its own block, linearly."""
    robot = contacts.robot
    D, base = dynamics.mass_matrix(robot, q), robot.size - len(robot.joints)
    D[:base, :base] += extra * (dynamics.mass_matrix(_doubled(robot), q)[:base, :base] - D[:base, :base])
    mass = SymmetricFactor.of(D, list(range(robot.size - 1, -1, -1)))  # from the feet upwards: without fill
    J = contacts.jacobian(q)
    return StandingEquations(mass=mass, jacobian=J, moved=mass.solve(J.T), apparent=None)


@lru_cache(maxsize=8)
def _doubled(robot: Robot) -> Robot:
    """The robot with a base link of twice the mass."""
    base = robot.links[0]
    heavier = replace(base, mass=2.0 * base.mass, inertia=frozen(2.0 * np.asarray(base.inertia)))
    return replace(robot, links=(heavier, *robot.links[1:]))


def _components(contacts: Contacts, active: ca.SX) -> ca.SX:
    return ca.vertcat(*[ca.repmat(active[i], contacts.contact.size, 1) for i in range(len(contacts.feet))])


def _held(contacts: Contacts, equations: StandingEquations, active: ca.SX) -> SymmetricFactor:
    """Factor E J D^-1 J^T E + 1 - E."""
    on = _components(contacts, active)
    apparent = equations.jacobian @ equations.moved
    return SymmetricFactor.of(apparent * (on @ on.T) + ca.diag(1.0 - on))
