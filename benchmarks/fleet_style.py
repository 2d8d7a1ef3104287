"""How the fleet's gaits walk: ``python -m benchmarks.fleet_style FOLDER`` prints a row of every gait file in a folder.

Angles, heights and speeds follow from joints and coordinates alone, by a walk of the link tree in numpy, so that a
row of the gait problem that is wrong shows.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, radians
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from amble.gait import Gait
from amble.gait.files import load_gait
from amble.robot import Robot
from amble.types import Matrix, Vector

BASE, KNEES, TOUCHDOWN, CLEARANCE = 0.1, radians(15.0), 0.5, 0.08
"""Largest roll and pitch, least bend of knees, rad, largest touchdown speed in sqrt(g l), least height of a swing in l.

What every gait of the table shall keep by default."""

ROUNDING = 1e-6
LATERAL = 0.7
"""Least share of a pitch joint's axis along y at the zero pose."""

Places = dict[int, tuple[Matrix, Vector]]


@dataclass(frozen=True, kw_only=True)
class WalkingStyle:
    """Extremes of one gait at its nodes.

    Attributes:
        base: largest roll or pitch, rad.
        knees: least angle between thigh and shank, 0 where the leg is straight, rad; infinite without knees.
        touchdown: largest speed of a landing foot, in sqrt(g l).
        clearance: height that every swing reaches, in l.
    """

    base: float
    knees: float
    touchdown: float
    clearance: float

    @property
    def missed(self) -> tuple[str, ...]:
        """Names of what is not kept."""
        kept = {
            "base": self.base <= BASE + ROUNDING,
            "knees": self.knees >= KNEES - ROUNDING,
            "touchdown": self.touchdown < TOUCHDOWN,
            "clearance": self.clearance >= CLEARANCE - ROUNDING,
        }
        return tuple(name for name, good in kept.items() if not good)


def walking_style(gait: Gait) -> WalkingStyle:
    """Return the extremes of a gait on level ground."""
    robot, switches = gait.robot, gait.pattern.all_switches
    base = [robot.base.coordinates.index(name) for name in ("roll", "pitch") if name in robot.base.coordinates]
    largest, knees, fastest = 0.0, inf, 0.0
    heights: list[tuple[set[str], dict[str, float]]] = []
    for number, domain in enumerate(gait.domains):
        largest = max(largest, float(np.abs(domain.positions[:, base]).max()))
        placed = [_places(robot, q) for q in domain.positions]
        knees = min(knees, *(_least_bend(robot, places) for places in placed))
        tops = {foot: max(_foot(robot, foot, places)[2] for places in placed) for foot in robot.foot_names}
        heights.append((set(gait.pattern.solved[number].feet), tops))
        step = 1e-6 * domain.velocities[-1]
        after, before = (_places(robot, domain.positions[-1] + sign * step) for sign in (0.5, -0.5))
        for foot in switches[number].landing:
            moved = _foot(robot, foot, after) - _foot(robot, foot, before)
            fastest = max(fastest, float(np.linalg.norm(moved)) / 1e-6)
    if gait.pattern.mirrored:
        twin = robot.mirror.feet
        heights += [
            ({twin[foot] for foot in down}, {twin[foot]: z for foot, z in tops.items()}) for down, tops in heights
        ]
    return WalkingStyle(
        base=largest,
        knees=knees,
        touchdown=fastest / float(np.sqrt(robot.gravity * robot.leg_length)),
        clearance=_lowest_swing(robot, heights) / robot.leg_length,
    )


def _lowest_swing(robot: Robot, heights: list[tuple[set[str], dict[str, float]]]) -> float:
    """Return the smallest of the heights that swings reach, over whole swings, which may span stances."""
    found, count = inf, len(heights)
    for foot in robot.foot_names:
        for first in range(count):
            if foot in heights[first][0] or foot not in heights[first - 1][0]:
                continue
            top, k = -inf, first
            while foot not in heights[k % count][0]:
                top, k = max(top, heights[k % count][1][foot]), k + 1
            found = min(found, top)
    return found


def _places(robot: Robot, q: Vector) -> Places:
    """Return orientation and origin of every link in the world."""
    known: Mapping[str, float] = dict(zip(robot.base.coordinates, q, strict=False))
    x, y, z, roll, pitch, yaw = (known.get(name, 0.0) for name in ("x", "y", "z", "roll", "pitch", "yaw"))
    places: Places = {0: (Rotation.from_euler("XYZ", [roll, pitch, yaw]).as_matrix(), np.array([x, y, z]))}
    for j in robot.ordered_joints:
        joint = robot.joints[j]
        rotation, origin = places[joint.parent]
        angle = q[len(robot.base.coordinates) + j]
        turned = joint.rotation @ Rotation.from_rotvec(np.asarray(joint.axis) * angle).as_matrix()
        places[joint.child] = (rotation @ turned, origin + rotation @ joint.translation)
    return places


def _foot(robot: Robot, foot: str, places: Places) -> Vector:
    rotation, origin = places[robot.foot(foot).link]
    return np.asarray(origin + rotation @ np.asarray(robot.foot(foot).offset))


def _least_bend(robot: Robot, places: Places) -> float:
    """Return the least angle at the second pitch joint of the legs, between thigh and shank across its axis, rad."""
    zero, found = _places(robot, np.zeros(robot.size)), inf
    for foot, leg in robot.legs.items():
        joints = [robot.joints[robot.joint_index(name)] for name in leg]
        pitching = [joint for joint in joints if abs((zero[joint.child][0] @ joint.axis)[1]) > LATERAL]
        if len(pitching) < 2:
            continue
        hip, knee = (places[joint.child][1] for joint in pitching[:2])
        end = places[pitching[2].child][1] if len(pitching) > 2 else _foot(robot, foot, places)
        axis = places[pitching[1].child][0] @ np.asarray(pitching[1].axis)
        thigh, shank = ((part - axis * (part @ axis)) for part in (knee - hip, end - knee))
        found = min(found, float(np.arctan2(np.linalg.norm(np.cross(thigh, shank)), thigh @ shank)))
    return found


def main(arguments: list[str]) -> None:
    """Print a row of every gait of a folder, and how many keep all."""
    files = [path for path in sorted(Path(arguments[0]).glob("*.json")) if not path.stem.endswith("-stable")]
    print("| gait | roll, pitch | knees | touchdown | clearance | missed |\n|---|---|---|---|---|---|")
    kept = 0
    for path in files:
        style = walking_style(load_gait(path))
        kept += not style.missed
        cells = (
            f"{style.base:.3f}",
            f"{np.degrees(style.knees):.0f}",
            f"{style.touchdown:.2f}",
            f"{style.clearance:.3f}",
        )
        print(f"| {path.stem} | {' | '.join(cells)} | {', '.join(style.missed)} |", flush=True)
    print(f"\n{kept} of {len(files)} keep roll and pitch, knees, touchdown and clearance")


if __name__ == "__main__":
    main(sys.argv[1:])
