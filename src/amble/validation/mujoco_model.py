"""A robot record as a MuJoCo model with exactly its inertias, on point feet as small spheres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from amble.optional import require
from amble.robot import Robot
from amble.robot.free_base import free_base
from amble.types import Matrix, Vector

FAR = 1e4
"""How far a step of the ground goes on, m: beyond the way of the most cycles that are walked."""

POINT = 1e-3
"""Radius of a sphere that stands for a point foot, m."""


HARD = 2e-3
"""Time constant of a hard contact, s."""


@dataclass(frozen=True, kw_only=True)
class Plant:
    """What a model differs in from the robot record; SI units.

    Attributes:
        step: of the integration, s.
        friction: coefficient between feet and ground.
        radius: of the feet, m; the ground lies as much lower, so that a point foot would touch z = 0.
        softness: time constant of the contacts along the normal, s.
        damping: of all joints, N m s/rad, beside that of the record.
        dry_friction: of all joints, N m, beside that of the record.
        armature: rotor inertia of all joints, kg m^2, beside that of the record.
        trunk: factor of the base link's mass and inertia.
        links: factor of the mass and inertia of every other link.
        balanced: inertias that no body can have are made physical, as MuJoCo does by itself.
        rise: height of a step of the ground, m, negative where it goes down; 0 where there is none.
        edge: where it is, x in m.
        ahead: 1 where the ground that is higher or lower lies towards +x, -1 towards -x.
    """

    step: float
    friction: float = 0.8
    radius: float = POINT
    softness: float = HARD
    damping: float = 0.0
    dry_friction: float = 0.0
    armature: float = 0.0
    trunk: float = 1.0
    links: float = 1.0
    balanced: bool = False
    rise: float = 0.0
    edge: float = 0.0
    ahead: float = 1.0


def require_mujoco() -> None:
    """Refuse work in MuJoCo where it is not installed."""
    require("mujoco", "mujoco", "validations in MuJoCo")


def mujoco_model(robot: Robot, plant: Plant) -> Any:
    """Build the model with MjSpec: one motor a joint, all names those of the record, only feet collide.

    MuJoCo refuses inertias against the triangle inequality, which a published model may have (ASTRo's lower legs), or
    changes them; so the record's are written into the compiled model.

    Raises:
        InputError: MuJoCo is not installed.
    """
    require_mujoco()
    import mujoco

    spec = mujoco.MjSpec()
    spec.compiler.balanceinertia = True
    spec.compiler.degree = False
    option = spec.option
    option.gravity = [0.0, 0.0, -robot.gravity]
    option.timestep, option.impratio, option.iterations, option.tolerance = plant.step, 10.0, 100, 1e-10
    option.cone, option.integrator = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    grounds = _add_ground(mujoco, spec, plant)
    bodies = {0: spec.worldbody.add_body(name=robot.links[0].name, pos=[0.0, 0.0, 1.0])}
    bodies[0].add_freejoint(name="base")
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    for joint in _from_the_base(robot):
        arm = float(robot.torque_arms[joint.child - 1])  # errors of the plant are those of torques
        body = bodies[joint.parent].add_body(
            name=robot.links[joint.child].name, pos=joint.translation, quat=_quaternion(mujoco, joint.rotation)
        )
        body.add_joint(
            name=joint.name, type=slide if joint.prismatic else hinge, axis=joint.axis,
            armature=joint.rotor_inertia + plant.armature / arm**2,
            damping=[joint.damping + plant.damping / arm**2, 0.0, 0.0],
            frictionloss=joint.dry_friction + plant.dry_friction / arm,
        )  # fmt: skip
        bodies[joint.child] = body
        spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    for number, link in enumerate(robot.links):
        body = bodies[number]
        body.explicitinertial = True
        body.mass, body.ipos = link.mass, link.center
        i = link.inertia
        body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    for foot in robot.feet:
        bodies[foot.link].add_geom(
            name=foot.name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[plant.radius, 0.0, 0.0], pos=foot.offset,
            contype=0, conaffinity=0,
        )  # fmt: skip
        for ground in grounds:
            _touches(spec, ground, foot.name, plant)
    model = spec.compile()
    _write_inertias(mujoco, model, robot, plant)
    return model


def _add_ground(mujoco: Any, spec: Any, plant: Plant) -> tuple[str, ...]:
    """Add a plane, and a box on it whose top is the higher side of a step; return their names."""
    low, high = sorted((0.0, plant.rise))
    spec.worldbody.add_geom(
        name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, pos=[0.0, 0.0, low - plant.radius], size=[FAR, FAR, 1.0],
        contype=0, conaffinity=0,
    )  # fmt: skip
    if not plant.rise:
        return ("ground",)
    towards = plant.ahead if plant.rise > 0.0 else -plant.ahead
    spec.worldbody.add_geom(
        name="step of the ground", type=mujoco.mjtGeom.mjGEOM_BOX, size=[FAR, FAR, 0.5],
        pos=[plant.edge + FAR * towards, 0.0, high - plant.radius - 0.5], contype=0, conaffinity=0,
    )  # fmt: skip
    return "ground", "step of the ground"


def _touches(spec: Any, ground: str, foot: str, plant: Plant) -> None:
    """Let a foot collide with the ground, soft along the normal only.

    MuJoCo's friction creeps with the time constant of its contacts, which no ground does however soft it is: its own
    stays that of a hard contact.
    """
    pair = spec.add_pair(name=f"{foot} on {ground}", geomname1=ground, geomname2=foot)
    pair.condim, pair.friction = 3, [plant.friction, plant.friction, 0.005, 0.0001, 0.0001]
    pair.solimp = [0.95, 0.999, 0.0005, 0.5, 2.0]
    stiffest = 2.0 * plant.step
    pair.solref = [max(plant.softness, stiffest), 1.0]
    pair.solreffriction = [max(min(plant.softness, HARD), stiffest), 1.0]


def _from_the_base(robot: Robot) -> list[Any]:
    """Joints, parents before children."""
    known, found, left = {0}, [], list(robot.joints)
    while left:
        ready = [joint for joint in left if joint.parent in known]
        found += ready
        known |= {joint.child for joint in ready}
        left = [joint for joint in left if joint.child not in known]
    return found


def _write_inertias(mujoco: Any, model: Any, robot: Robot, plant: Plant) -> None:
    for link in robot.links:
        number = model.body(link.name).id
        if not plant.balanced:
            values, axes = np.linalg.eigh(link.inertia)
            if np.linalg.det(axes) < 0.0:
                axes[:, 0] *= -1.0
            model.body_inertia[number], model.body_iquat[number] = values, _quaternion(mujoco, axes)
            model.body_ipos[number], model.body_mass[number] = link.center, link.mass
            model.body_sameframe[number] = 0
    for place, link in enumerate(robot.links):
        number, factor = model.body(link.name).id, plant.links if place else plant.trunk
        model.body_mass[number] *= factor
        model.body_inertia[number] *= factor
    model.body_simple[:] = 0
    model.dof_simplenum[:] = 0
    mujoco.mj_setConst(model, mujoco.MjData(model))


def _quaternion(mujoco: Any, rotation: Matrix) -> Vector:
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(rotation, dtype=np.float64).ravel())
    return found


def to_mujoco(robot: Robot, model: Any, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Return qpos and qvel of a state: base angles of the chain X-Y-Z to a quaternion and rates in the base's frame."""
    qpos, qvel = np.zeros(model.nq), np.zeros(model.nv)
    base, twist = free_base(q[None], v[None])
    qpos[:7], qvel[:6] = base[0], twist[0]
    for number, joint in enumerate(robot.joints):
        entry = model.joint(joint.name)
        qpos[entry.qposadr[0]], qvel[entry.dofadr[0]] = q[6 + number], v[6 + number]
    return qpos, qvel
