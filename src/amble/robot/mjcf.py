"""Reading an MJCF file through MuJoCo's MjSpec: defaults, Euler conventions and inertias of geoms are MuJoCo's own.

A body with its joints becomes links and joints as a URDF has them: a joint's frame lies where the joint is, and joints
of one body follow each other. Meshes of bodies whose inertia is written out are removed before compiling, so that their
files need not be there (``mjcf_model``). Sites and geoms with a name are frames that a foot may be called by.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError
from amble.io.reader import read_bytes
from amble.robot.mjcf_model import compiled
from amble.robot.rotation import rotation_about, snap
from amble.robot.urdf import LARGEST, FileJoint, FileLink, FileRobot, read_urdf
from amble.types import Matrix, Vector, frozen

ROOT = re.compile(rb"<(mujoco|robot)\b")
KINDS = ("floating", "ball", "prismatic", "revolute")
"""MuJoCo's joint types 0 to 3: free, ball, slide, hinge."""

UNNAMED = "MuJoCo Model"
"""What MuJoCo calls a model without a name."""

FREE, SLIDE, HINGE = 0, 2, 3
CONNECT, WELD, JOINT = 0, 1, 2
"""Types of equality constraints that matter here."""


def read_xml(path: Path) -> FileRobot:
    """Read an XML file by its root element: MJCF where that is ``mujoco``, else URDF."""
    found = ROOT.search(read_bytes(path, "robot file", LARGEST))
    return read_mjcf(path) if found is not None and found.group(1) == b"mujoco" else read_urdf(path)


def read_mjcf(path: Path) -> FileRobot:
    """Read an MJCF file.

    Raises:
        MissingExtraError: mujoco is not installed.
        InputError: MuJoCo does not compile the file, its robot has no free joint or virtual base, or a loop is closed.
    """
    model = compiled(path)
    walking = _walking_bodies(model)
    if not walking:
        raise InputError(f"{path.name}: no body of the file moves on joints")
    _check_open(model, path)
    links: list[FileLink] = []
    joints: list[FileJoint] = []
    roots = [body for body in walking if model.body_parentid[body] == 0]
    free = [body for body in roots if _kinds(model, body) == ["floating"]]
    if free:
        walking = [body for body in walking if model.body_rootid[body] in free]
    else:
        links.append(FileLink("world", 0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3)))))
        if any(not _kinds(model, body) for body in roots):
            raise InputError(
                f"{path.name}: the body '{_name(model, 'body', roots[0])}' is fixed to the world, a floating base is "
                "needed: give it a freejoint"
            )
    for body in walking:
        parts = _body(model, body, bare=body in free)
        links += parts[0]
        joints += parts[1]
    known = {link.name for link in links}
    for frame, body, place in _frames(model, walking):
        if frame not in known:
            known.add(frame)
            links.append(FileLink(frame, 0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3)))))
            on = _name(model, "body", body)
            joints.append(_file_joint(f"{frame} on {on}", "fixed", on, frame, np.eye(3), place))
    named = model.name if model.name not in ("", UNNAMED) else path.stem
    return FileRobot(named, tuple(links), _coupled(model, joints), _unused(model))


def _name(model: Any, kind: str, number: int) -> str:
    return model.names[kind][number] or f"{kind} {number}"


def _joints(model: Any, body: int) -> list[int]:
    first = int(model.body_jntadr[body])
    return [] if first < 0 else list(range(first, first + int(model.body_jntnum[body])))


def _kinds(model: Any, body: int) -> list[str]:
    return [KINDS[int(model.jnt_type[j])] for j in _joints(model, body)]


def _walking_bodies(model: Any) -> list[int]:
    """Bodies of the trees that joints move, in file order."""
    moved = {int(model.body_rootid[body]) for body in range(1, len(model.body_mass)) if _joints(model, body)}
    return [body for body in range(1, len(model.body_mass)) if int(model.body_rootid[body]) in moved]


def _rotation(quaternion: Vector) -> Matrix:
    """Return the rotation matrix of a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return snap(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
    )


def _body(model: Any, body: int, bare: bool) -> tuple[list[FileLink], list[FileJoint]]:
    """Return the link of a body, and joints, with links without mass between several of them."""
    name, parent = _name(model, "body", body), int(model.body_parentid[body])
    principal = _rotation(model.body_iquat[body])
    inertia = principal @ np.diag(model.body_inertia[body]) @ principal.T
    link = FileLink(name, float(model.body_mass[body]), frozen(model.body_ipos[body]), frozen(inertia))
    if bare:
        return [link], []
    links, joints = [], []
    on = "world" if parent == 0 else _name(model, "body", parent)
    rotation, place = _rotation(model.body_quat[body]), np.array(model.body_pos[body])
    for j in _joints(model, body):
        at = np.array(model.jnt_pos[j])
        between = f"{name} at {_name(model, 'joint', j)}"
        joint = _moving(model, j, on, between, rotation, place + rotation @ at)
        links.append(FileLink(between, 0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3)))))
        joints.append(joint)
        on, rotation, place = between, np.eye(3), -at
    if joints and not np.any(place):
        joints[-1], links[-1] = replace(joints[-1], child=name), link
        return links, joints
    joints.append(_file_joint(f"{name} on {on}", "fixed", on, name, rotation, place))
    return [*links, link], joints


def _moving(model: Any, j: int, parent: str, child: str, rotation: Matrix, place: Vector) -> FileJoint:
    """A joint whose coordinate is MuJoCo's: at its reference the body is as it is written."""
    kind, axis = int(model.jnt_type[j]), np.array(model.jnt_axis[j])
    first = int(model.jnt_dofadr[j])
    reference = float(model.qpos0[model.jnt_qposadr[j]]) if kind in (SLIDE, HINGE) else 0.0
    if kind == HINGE:
        rotation = snap(rotation @ np.asarray(rotation_about(axis, -reference)))
    elif kind == SLIDE:
        place = place - rotation @ axis * reference
    limited = bool(model.jnt_limited[j]) and kind in (SLIDE, HINGE)
    lower, upper = model.jnt_range[j] if limited else (-np.inf, np.inf)
    gears = _gears(model, j)
    return replace(
        _file_joint(_name(model, "joint", j), KINDS[kind], parent, child, rotation, place),
        axis=frozen(snap(axis)),
        lower=float(lower),
        upper=float(upper),
        effort=_effort(model, j, gears),
        rotor_inertia=float(model.dof_armature[first]),
        damping=float(np.ravel(model.dof_damping[first])[0]),
        dry_friction=float(model.dof_frictionloss[first]),
    )


def _gears(model: Any, j: int) -> dict[int, float]:
    """Actuator -> gear, of those that move a joint."""
    return {
        number: float(model.actuator_gear[number][0])
        for number in range(len(model.actuator_trntype))
        if int(model.actuator_trntype[number]) in (0, 1) and int(model.actuator_trnid[number][0]) == j
    }


def _effort(model: Any, j: int, gears: dict[int, float]) -> float:
    """Largest force or torque: the joint's own range, or what its actuators can do."""
    if bool(model.jnt_actfrclimited[j]):
        return float(np.abs(model.jnt_actfrcrange[j]).max())
    total = 0.0
    for number, gear in gears.items():
        motor = int(model.actuator_gaintype[number]) == 0 and int(model.actuator_biastype[number]) == 0
        if bool(model.actuator_forcelimited[number]):
            total += abs(gear) * float(np.abs(model.actuator_forcerange[number]).max())
        elif motor and bool(model.actuator_ctrllimited[number]):
            gain = float(model.actuator_gainprm[number][0])
            total += abs(gear * gain) * float(np.abs(model.actuator_ctrlrange[number]).max())
        else:
            return float(np.inf)
    return total if gears else float(np.inf)


def _file_joint(name: str, kind: str, parent: str, child: str, rotation: Matrix, place: Vector) -> FileJoint:
    return FileJoint(
        name=name,
        kind=kind,
        parent=parent,
        child=child,
        rotation=frozen(rotation),
        translation=frozen(place),
    )


def _frames(model: Any, bodies: list[int]) -> list[tuple[str, int, Vector]]:
    """Name, body and place of the sites and named geoms of some bodies."""
    found = []
    for kind, on, places in (
        ("site", model.site_bodyid, model.site_pos),
        ("geom", model.geom_bodyid, model.geom_pos),
    ):
        for name, body, place in zip(model.names[kind], on, places, strict=True):
            if name and int(body) in bodies:
                found.append((name, int(body), place))
    return found


def _coupled(model: Any, joints: list[FileJoint]) -> tuple[FileJoint, ...]:
    """Mark the joints that an equality constraint ties to another by a line."""
    for number in range(len(model.eq_type)):
        if int(model.eq_type[number]) != JOINT or not bool(model.eq_active0[number]):
            continue
        own, other = (_name(model, "joint", int(ids[number])) for ids in (model.eq_obj1id, model.eq_obj2id))
        offset, factor = (float(value) for value in model.eq_data[number][:2])
        joints = [
            replace(joint, mimics=other, mimic=(factor, offset)) if joint.name == own else joint for joint in joints
        ]
    return tuple(joints)


def _check_open(model: Any, path: Path) -> None:
    for number in range(len(model.eq_type)):
        if int(model.eq_type[number]) in (CONNECT, WELD) and bool(model.eq_active0[number]):
            raise InputError(
                f"{path.name}: the equality constraint '{_name(model, 'equality', number)}' closes a loop of bodies; "
                "amble moves trees of links: remove it from the file, or one of the joints"
            )


def _unused(model: Any) -> tuple[str, ...]:
    """Say what the file states about the motion that amble does not use."""
    notes = [
        f"joint '{_name(model, 'joint', j)}' has a spring (stiffness {float(np.ravel(model.jnt_stiffness[j])[0]):g}), "
        "which is not used"
        for j in range(len(model.jnt_type))
        if np.any(model.jnt_stiffness[j])
    ]
    notes += [f"tendons ({model.tendons}) are not used"] if model.tendons else []
    if np.any(model.body_gravcomp):
        notes.append("gravity compensation of bodies is not used")
    return tuple(notes)
