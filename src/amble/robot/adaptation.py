"""Adapting the robot of a file before it becomes a `Robot`: locked joints, another base, payload, drives, feet.

Everything here maps the links and joints of a file to other links and joints, whatever format they were read from; the
rest of loading does not know that they were adapted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from amble.errors import InputError, UnknownNameError, listed, shown
from amble.io.quantities import require_dimension
from amble.robot.parts import Payload, check_bounded
from amble.robot.readers import FileJoint, FileLink, FileRobot
from amble.robot.rotation import rotation_about, rotation_of_rpy, snap
from amble.types import Vector, frozen

TURNING = ("revolute", "continuous")
DRIVES = {
    "rotor_inertia": ("inertia", "mass"),
    "damping": ("damping", "linear damping"),
    "dry_friction": ("torque", "force"),
}
"""What drives a joint -> its dimension where the joint turns, and where it slides."""

VIRTUAL = {6: ["prismatic"] * 3 + ["revolute"] * 3, 3: ["prismatic"] * 2 + ["revolute"]}
"""Kinds of the massless joints that some files have in place of a free base, in space and in a plane."""

PLANAR_AXES = {"prismatic": (0, 2), "revolute": (1,)}
"""Kind -> the base's axes along or about which they move it in the plane of x and z."""


@dataclass(frozen=True, kw_only=True)
class Adaptation:
    """What is different from the file of a robot.

    Attributes:
        locked: joint -> angle, rad, or place of a prismatic joint, m, at which it is held; a joint that mimics a locked
            one is held with it.
        base: link that is the base; by default the root, or what virtual joints without mass carry.
        base_rotation: orientation of the base that amble walks with (x forward, z up) in that link: roll, pitch, yaw
            as in a URDF, rad.
        foot_offsets: foot -> its point in the frame that it names, (3,), m.
        payload: a point mass that a link carries; ``base`` is the robot's base where no link has that name.
        rotor_inertia: joint -> inertia of its rotor as the joint feels it, kg m^2; this and the next two take the place
            of what the file says, and the name ``*`` stands for all joints that turn and are not named. Of a prismatic
            joint it is a mass, kg.
        damping: joint -> N m s/rad, or N s/m.
        dry_friction: joint -> N m, or N.
        friction_width: rate over which dry friction changes its sign, rad/s, times the leg length l of prismatic
            joints; by default 0.05 sqrt(g / l).
        file_drives: whether rotor inertia, damping and friction that the file states are used.
        planar: whether the base moves in the plane of x and z alone: at x, z and pitch. Two prismatic joints without
            mass and one that turns, in place of a free base, say the same.
    """

    locked: Mapping[str, float] = field(default_factory=dict)
    base: str | None = None
    base_rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    foot_offsets: Mapping[str, Vector] = field(default_factory=dict)
    payload: Payload | None = None
    rotor_inertia: Mapping[str, float] = field(default_factory=dict)
    damping: Mapping[str, float] = field(default_factory=dict)
    dry_friction: Mapping[str, float] = field(default_factory=dict)
    friction_width: float | None = None
    file_drives: bool = True
    planar: bool = False


ROUNDING = 1e-9
"""Of an axis along x, y or z."""

BASE = "base"
"""What a payload's link may be called where that is the robot's base, whatever the file calls it."""

AS_WRITTEN = Adaptation()
"""The robot of the file, unchanged."""


def adapted(file: FileRobot, change: Adaptation, path: Path) -> FileRobot:
    """Return the links and joints of a robot's file with joints locked, drives and payload added, and its base first.

    Raises:
        UnknownNameError: a joint or link that does not exist.
        InputError: a joint cannot be held there, or a link cannot be the base.
    """
    file = _driven(_locked(file, change.locked, path), change, path)
    base, planar = (change.base, False) if change.base is not None else _carried_by_virtual(file, path)
    if base is not None:
        file = _rooted(file, base, path)
    file = replace(file, planar=planar or change.planar)
    if change.payload is not None:
        file = _loaded(file, change.payload, path)
    if any(change.base_rotation):
        file = _turned(file, change.base_rotation)
    return file


def _locked(file: FileRobot, locked: Mapping[str, float], path: Path) -> FileRobot:
    held = dict(locked)
    for name in held:
        _require(f"joint to lock in {path.name}", name, [joint.name for joint in file.joints])
    followers = {joint.name: joint for joint in file.joints if joint.mimics is not None}
    for _ in followers:  # chains of them, too
        for name, joint in followers.items():
            if joint.mimics in held and name not in held:
                held[name] = joint.mimic[0] * held[joint.mimics] + joint.mimic[1]
    return replace(
        file,
        joints=tuple(_held(joint, held[joint.name], path) if joint.name in held else joint for joint in file.joints),
    )


def _held(joint: FileJoint, value: float, path: Path) -> FileJoint:
    """A fixed joint in place of a moving one."""
    what = f"value of the locked joint '{joint.name}'"
    check_bounded(what, value)
    require_dimension(value, "length" if joint.kind == "prismatic" else "angle", what)
    rotation, translation = joint.rotation, joint.translation
    if joint.kind in TURNING:
        rotation = frozen(snap(rotation @ np.asarray(rotation_about(joint.axis, value))))
    elif joint.kind == "prismatic":
        translation = frozen(translation + rotation @ joint.axis * value)
    elif value != 0.0:
        raise InputError(f"{path.name}: joint '{joint.name}' is {shown(joint.kind)}, which can be locked only at 0")
    return replace(joint, kind="fixed", rotation=rotation, translation=translation, mimics=None)


def _driven(file: FileRobot, change: Adaptation, path: Path) -> FileRobot:
    """Put what is given in the place of what the file says of rotors, damping and friction."""
    moving = [joint.name for joint in file.joints if joint.kind != "fixed"]
    for drive in DRIVES:
        for name in getattr(change, drive):
            if name != "*":
                _require(f"joint ({drive} in {path.name})", name, moving)

    def driven(joint: FileJoint) -> FileJoint:
        def of(what: str, said: float) -> float:
            given, dimensions = getattr(change, what), DRIVES[what]
            common = given.get("*") if joint.kind in TURNING else None
            if joint.name in given:
                require_dimension(given[joint.name], dimensions[joint.kind == "prismatic"], f"{what} of '{joint.name}'")
            return given.get(joint.name, (said if change.file_drives else 0.0) if common is None else common)

        return replace(
            joint,
            rotor_inertia=of("rotor_inertia", joint.rotor_inertia),
            damping=of("damping", joint.damping),
            dry_friction=of("dry_friction", joint.dry_friction),
        )

    return replace(file, joints=tuple(driven(joint) if joint.kind != "fixed" else joint for joint in file.joints))


def _loaded(file: FileRobot, payload: Payload, path: Path) -> FileRobot:
    """Hang a link without extent on the link that carries the payload."""
    links, carried = [link.name for link in file.links], {joint.child for joint in file.joints}
    roots = [name for name in links if name not in carried]
    root = next((joint.child for joint in file.joints if joint.kind == "floating"), (*roots, BASE)[0])
    carrier = root if payload.link == BASE and BASE not in links else payload.link
    _require(f"link of the payload in {path.name}", carrier, links)
    if not payload.mass > 0.0:
        raise InputError(f"the payload has a mass of {payload.mass:g} kg; it must be positive")
    name = _unused("payload", links)
    point = FileLink(name, payload.mass, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))
    on = _fixed(f"{name} on {carrier}", carrier, name)
    return replace(file, links=(*file.links, point), joints=(*file.joints, replace(on, translation=payload.position)))


def _carried_by_virtual(file: FileRobot, path: Path) -> tuple[str | None, bool]:
    """Return the link that joints without mass carry in place of a free base, and whether it moves in a plane.

    None where there is none.
    """
    below: dict[str, list[FileJoint]] = {}
    for joint in file.joints:
        below.setdefault(joint.parent, []).append(joint)
    masses = {link.name: link.mass for link in file.links}
    carried = {joint.child for joint in file.joints}
    roots = [name for name in masses if name not in carried]
    if len(roots) != 1:
        return None, False  # which is said when the tree is built
    link, kinds, rotation, in_plane = roots[0], list[str](), np.eye(3), True
    while masses.get(link, 1.0) <= 0.0 and len(below.get(link, ())) == 1:
        joint = below[link][0]
        kind, rotation = "revolute" if joint.kind in TURNING else joint.kind, rotation @ joint.rotation
        if kind != "fixed":
            kinds.append(kind)
            along = np.abs(rotation @ joint.axis)
            in_plane &= int(np.argmax(along)) in PLANAR_AXES.get(kind, ()) and bool(along.max() > 1.0 - ROUNDING)
        link = joint.child
    found = sorted(kinds)
    if found == VIRTUAL[6]:
        return link, False
    if found == VIRTUAL[3]:
        if in_plane:
            return link, True
        raise InputError(
            f"{path.name}: two prismatic joints and one that turns move the base '{shown(link)}' in another plane than "
            f'that of x and z: name it as the base to free it in space (base = "{shown(link)}" in [robot])'
        )
    return None, False


def _rooted(file: FileRobot, base: str, path: Path) -> FileRobot:
    """Make a link the root: turn the fixed joints above it around, drop what without mass moves it."""
    links = {link.name: link for link in file.links}
    _require(f"link for the base of {path.name}", base, list(links))
    above = {joint.child: joint for joint in file.joints}
    joints, link, climbed = list(file.joints), base, {base}
    while link in above and above[link].kind == "fixed" and above[link].parent not in climbed:
        joint = above[link]
        joints[joints.index(joint)] = _reversed(joint)
        link = joint.parent
        climbed.add(link)
    if link not in above:
        return replace(file, joints=tuple(joints))
    kept, below = {base}, [base]
    while below:
        parent = below.pop()
        children = [joint.child for joint in joints if joint.parent == parent and joint is not above[link]]
        below += [child for child in children if child not in kept]
        kept.update(children)
    heavy = [name for name in links if name not in kept and links[name].mass > 0.0]
    if heavy:
        raise InputError(
            f"{path.name}: '{base}' cannot be the base: joint '{above[link].name}' moves it on {listed(heavy[:3])}; "
            f"lock the joints between (locked = {{ {above[link].name} = 0.0 }} in [robot])"
        )
    return replace(
        file,
        links=tuple(link for link in file.links if link.name in kept),
        joints=tuple(joint for joint in joints if joint.child in kept and joint.parent in kept),
    )


def _reversed(joint: FileJoint) -> FileJoint:
    """The same fixed joint, from the child's side."""
    rotation = joint.rotation.T
    return replace(
        joint,
        parent=joint.child,
        child=joint.parent,
        rotation=frozen(rotation),
        translation=frozen(-rotation @ joint.translation),
    )


def _turned(file: FileRobot, angles: tuple[float, float, float]) -> FileRobot:
    """Put a frame of another orientation, with its origin kept, under the root."""
    carried = {joint.child for joint in file.joints}
    roots = [link.name for link in file.links if link.name not in carried]
    name = _unused("base", [link.name for link in file.links])
    frame = FileLink(name, 0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))
    rotation = frozen(rotation_of_rpy(np.array(angles)).T)
    joints = [replace(_fixed(f"{root} on {name}", name, root), rotation=rotation) for root in roots[:1]]
    return replace(file, links=(frame, *file.links), joints=(*joints, *file.joints))


def _fixed(name: str, parent: str, child: str) -> FileJoint:
    return FileJoint(
        name=name,
        kind="fixed",
        parent=parent,
        child=child,
        rotation=frozen(np.eye(3)),
        translation=frozen(np.zeros(3)),
    )


def _unused(name: str, names: list[str]) -> str:
    while name in names:
        name += "'"
    return name


def _require(kind: str, name: str, known: list[str]) -> None:
    if name not in known:
        raise UnknownNameError(kind, name, known)
