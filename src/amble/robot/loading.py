"""From a robot file to a `Robot`: find the base, merge fixed joints, check what a dynamics needs."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from amble.errors import InputError, UnknownNameError, listed, printable, shown
from amble.robot.adaptation import AS_WRITTEN, Adaptation, adapted
from amble.robot.base import PLANE, SPACE
from amble.robot.drive import with_friction
from amble.robot.inertia_check import check_inertias
from amble.robot.model import Robot
from amble.robot.parts import Foot, Joint, Link
from amble.robot.readers import FileJoint, FileLink, FileRobot, read_robot
from amble.robot.rotation import skew, snap
from amble.types import Matrix, Vector, frozen

logger = logging.getLogger("amble")

MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class _Placement:
    """Where a link of the file sits: on which moving link, and its frame there."""

    carrier: int
    rotation: Matrix
    translation: Vector


def load_robot(
    path: str | Path,
    feet: Mapping[str, str],
    gravity: float = 9.81,
    name: str | None = None,
    twins: Iterable[tuple[str, str]] | None = None,
    symmetry_tolerance: float = 1e-9,
    format: str | None = None,
    adaptation: Adaptation = AS_WRITTEN,
) -> Robot:
    """Load a floating-base robot from a file of a format in ``READERS``; URDF at first.

    No mesh file is opened, and what is not used is logged.

    Links that hang on fixed joints are merged into the moving link that carries them. The base is the root link; a
    massless root may carry it through a fixed joint, and a floating joint, or six virtual ones without mass (in the
    plane of x and z three), mark their child as the base. Rotor inertia, damping and dry friction that the file states
    are part of the robot.

    Args:
        path: the file.
        feet: label -> name of the link or joint of the file whose frame is the point foot. Which foot is front left
            is the caller's knowledge and never guessed.
        gravity: m/s^2.
        name: what to call the robot; the file's own name where not given.
        twins: pairs of labels that mirror each other left to right; where not given, labels that differ in a last
            letter l and r, such as fl and fr.
        symmetry_tolerance: largest relative asymmetry that ``Robot.mirror`` accepts.
        format: name of the file's format; by default the suffix of its name.
        adaptation: what is different from the file.

    Raises:
        UnknownNameError: a foot, a twin, a joint or a link that does not exist, or a format without a reader.
        InputError: anything else that cannot be used, in one sentence.
    """
    path = Path(path)
    file = read_robot(path, format)
    robot = robot_from(file, path, feet, gravity, name, twins, symmetry_tolerance, adaptation)
    if robot.unused:
        logger.warning(
            "%s: %d things are not used (Robot.unused): %s", path.name, len(robot.unused), _few(robot.unused)
        )
    return robot


def robot_from(
    file: FileRobot,
    path: Path,
    feet: Mapping[str, str],
    gravity: float = 9.81,
    name: str | None = None,
    twins: Iterable[tuple[str, str]] | None = None,
    symmetry_tolerance: float = 1e-9,
    adaptation: Adaptation = AS_WRITTEN,
) -> Robot:
    """Make a robot of a file that was read; arguments and errors are those of ``load_robot``, and nothing is logged."""
    file = adapted(file, adaptation, path)
    root, joints, placements = _tree(file, path)
    links = _merge(file, placements, [root, *(joint.child for joint in joints)])
    if not joints:
        raise InputError(f"{path.name}: the robot has no actuated joint")
    moving = [_moving_joint(joint, index, placements[joint.parent]) for index, joint in enumerate(joints)]
    point_feet = _feet(feet, file, placements, adaptation.foot_offsets)
    robot = Robot(
        name=file.name if name is None else name,
        source=path.name,
        links=links,
        joints=tuple(moving),
        feet=point_feet,
        gravity=float(gravity),
        twins=proposed_twins(tuple(feet)) if twins is None else tuple((left, right) for left, right in twins),
        symmetry_tolerance=symmetry_tolerance,
        unused=file.unused,
        locked_joints=dict(adaptation.locked),
        payload=adaptation.payload,
        base=PLANE if file.planar else SPACE,
    )
    check_inertias(robot, path.name)
    rubbing = {own.name: own.dry_friction for own in joints if own.dry_friction}
    return with_friction(robot, rubbing, adaptation.friction_width) if rubbing else robot


def carried_frames(file: FileRobot, path: Path) -> dict[str, tuple[int, Vector]]:
    """Return link of the file -> the moving link that carries it, and its origin there, m; errors as ``load_robot``."""
    file = adapted(file, AS_WRITTEN, path)
    _, _, placements = _tree(file, path)
    return {name: (at.carrier, at.translation) for name, at in placements.items()}


def placed_links(file: FileRobot, path: Path, change: Adaptation) -> dict[str, tuple[str, Matrix, Vector]]:
    """Return link of the file -> name of the moving link that carries it, its orientation and origin (m) there.

    Errors are those of ``load_robot``.
    """
    file = adapted(file, change, path)
    root, joints, placements = _tree(file, path)
    carriers = [root, *(joint.child for joint in joints)]
    return {name: (carriers[at.carrier], at.rotation, at.translation) for name, at in placements.items()}


def _tree(file: FileRobot, path: Path) -> tuple[str, list[FileJoint], dict[str, _Placement]]:
    """Return the base link, the moving joints, and where every link sits."""
    root = _find_root(file, path)
    joints = [joint for joint in file.joints if joint.kind in MOVING]
    return root, joints, _place(file, root, joints, path)


def _few(notes: Sequence[str], shown: int = 3) -> str:
    more = f"; and {len(notes) - shown} more" if len(notes) > shown else ""
    return printable("; ".join(notes[:shown]) + more)


def _find_root(file: FileRobot, path: Path) -> str:
    """Return the name of the base link, with every joint checked on the way."""
    names = dict.fromkeys(link.name for link in file.links)
    parent_of: dict[str, FileJoint] = {}
    for joint in file.joints:
        for link in (joint.parent, joint.child):
            if link not in names:
                raise UnknownNameError(f"link (joint '{joint.name}' of {path.name})", link, names)
        if joint.child in parent_of:
            first = parent_of[joint.child].name
            raise InputError(
                f"{path.name}: link '{joint.child}' hangs on two joints, '{first}' and '{joint.name}'; amble moves "
                "trees of links, a closed chain has to be cut in the file"
            )
        parent_of[joint.child] = joint
    roots = [name for name in names if name not in parent_of]
    if not roots:
        raise InputError(f"{path.name}: the joints form a cycle, so no link is the root")
    if len(roots) > 1:
        raise InputError(f"{path.name}: more than one root link: {listed(roots)}")
    return _base_below(file, roots[0], path)


def _base_below(file: FileRobot, root: str, path: Path) -> str:
    """Follow a floating joint from a massless root; refuse a robot that is bolted to the world."""
    below = [joint for joint in file.joints if joint.parent == root]
    massless = all(link.mass <= 0.0 for link in file.links if link.name == root)
    floating = [joint for joint in file.joints if joint.kind == "floating"]
    if floating:
        if len(floating) > 1 or len(below) > 1 or floating[0].parent != root or not massless:
            raise InputError(
                f"{path.name}: the only floating joint allowed carries the base from a massless root link; "
                f"{_lock(floating[-1])}"
            )
        return floating[0].child
    if root == "world" and any(joint.kind == "fixed" for joint in below):
        raise InputError(f"{path.name}: the robot is fixed to the link 'world', a floating base is needed")
    return root


def _place(file: FileRobot, root: str, joints: list[FileJoint], path: Path) -> dict[str, _Placement]:
    """Place every link below the root on the moving link that carries it."""
    placements = {root: _Placement(0, np.eye(3), np.zeros(3))}
    for index, joint in enumerate(joints, start=1):
        placements[joint.child] = _Placement(index, np.eye(3), np.zeros(3))
    for joint in file.joints:
        if joint.mimics is not None:
            raise InputError(
                f"{path.name}: joint '{joint.name}' mimics '{shown(joint.mimics)}', which amble cannot move; "
                f"{_lock(joint)}"
            )
        if joint.kind not in (*MOVING, "fixed", "floating"):
            raise InputError(
                f"{path.name}: joint '{joint.name}' is {shown(joint.kind)}; known: {', '.join((*MOVING, 'fixed'))}; "
                f"{_lock(joint)}"
            )
    fixed: dict[str, list[FileJoint]] = {}
    for joint in file.joints:
        if joint.kind == "fixed":
            fixed.setdefault(joint.parent, []).append(joint)
    placed = list(placements)
    while placed:
        link = placed.pop()
        on = placements[link]
        for joint in fixed.pop(link, ()):
            placements[joint.child] = _Placement(
                on.carrier, snap(on.rotation @ joint.rotation), on.translation + on.rotation @ joint.translation
            )
            placed.append(joint.child)
    if fixed:
        lost = next(joint for joint in file.joints if joint.kind == "fixed" and joint.child not in placements)
        raise InputError(f"{path.name}: link '{lost.child}' is not connected to the base '{root}'")
    _check_connected(joints, placements, root, path)
    return placements


def _lock(joint: FileJoint) -> str:
    return f"hold it: locked = {{ {joint.name} = 0.0 }} in [robot], or Adaptation(locked=...)"


def _check_connected(joints: list[FileJoint], placements: dict[str, _Placement], root: str, path: Path) -> None:
    """Raise where a moving link's parents never reach the base: a cycle beside the tree."""
    below: dict[int, list[int]] = {}
    for index, joint in enumerate(joints, start=1):
        below.setdefault(placements[joint.parent].carrier, []).append(index)
    reached = [0]
    for carrier in reached:  # grows while it is walked
        reached += below.pop(carrier, [])
    for joint in joints:
        if placements[joint.parent].carrier in below:
            raise InputError(f"{path.name}: link '{joint.child}' is in a cycle, not connected to the base '{root}'")


def _merge(file: FileRobot, placements: Mapping[str, _Placement], carriers: list[str]) -> tuple[Link, ...]:
    """Sum the inertias of all links that one moving link carries."""
    merged = []
    carried: list[list[tuple[FileLink, _Placement]]] = [[] for _ in carriers]
    for link in file.links:
        if link.name in placements:
            carried[placements[link.name].carrier].append((link, placements[link.name]))
    for name, parts in zip(carriers, carried, strict=True):
        mass = sum(link.mass for link, _ in parts)
        centers = [at.translation + at.rotation @ link.center for link, at in parts]
        center = sum((link.mass * c for (link, _), c in zip(parts, centers, strict=True)), np.zeros(3))
        center = center / mass if mass > 0.0 else np.zeros(3)
        inertia = np.zeros((3, 3))
        for (link, at), position in zip(parts, centers, strict=True):
            arm = skew(position - center)
            inertia += at.rotation @ link.inertia @ at.rotation.T - link.mass * arm @ arm
        merged.append(Link(name, float(mass), frozen(center), frozen((inertia + inertia.T) / 2.0)))
    return tuple(merged)


def _moving_joint(joint: FileJoint, index: int, on: _Placement) -> Joint:
    return Joint(
        name=joint.name,
        parent=on.carrier,
        child=index + 1,
        rotation=frozen(snap(on.rotation @ joint.rotation)),
        translation=frozen(on.translation + on.rotation @ joint.translation),
        axis=frozen(snap(joint.axis)),
        lower=joint.lower if joint.kind != "continuous" else -np.inf,
        upper=joint.upper if joint.kind != "continuous" else np.inf,
        effort=joint.effort,
        velocity=joint.velocity,
        rotor_inertia=joint.rotor_inertia,
        damping=joint.damping,
        prismatic=joint.kind == "prismatic",
    )


def _feet(
    feet: Mapping[str, str], file: FileRobot, placements: Mapping[str, _Placement], offsets: Mapping[str, Vector]
) -> tuple[Foot, ...]:
    for label in offsets:
        if label not in feet:
            raise UnknownNameError("foot (foot_offsets)", label, feet)
    still = np.zeros(3)
    return tuple(_foot(label, frame, file, placements, offsets.get(label, still)) for label, frame in feet.items())


def _foot(label: str, frame: str, file: FileRobot, placements: Mapping[str, _Placement], offset: Vector) -> Foot:
    """Place a foot; a joint's frame is that of the link it carries."""
    links = [link.name for link in file.links]
    child_of = {joint.name: joint.child for joint in file.joints}
    link = frame if frame in links else child_of.get(frame)
    if link is None or link not in placements:
        raise UnknownNameError(f"link or joint for foot '{label}'", frame, (*links, *child_of))
    at = placements[link]
    return Foot(label, frame, at.carrier, frozen(at.translation + at.rotation @ offset))


def proposed_twins(labels: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return the pairs of labels that differ in a last letter l and r, such as fl and fr, l and r."""
    return tuple((label, f"{label[:-1]}r") for label in labels if label.endswith("l") and f"{label[:-1]}r" in labels)
