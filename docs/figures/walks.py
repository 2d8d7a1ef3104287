"""Draw go2-trot.png, hyq-walk.png and anymal_c-running_trot.png: a cycle of three of the fleet's gaits, as they walk.

Run from the folder of the project after `python -m benchmarks fleet`:
python -m docs.figures.walks build/benchmarks/fleet
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from amble.analysis import samples_of_gait
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.report.figures.footfall import footfall
from amble.report.figures.style import BLUE, GREY, PAGE, VERMILION, paper_style, plain_text
from amble.types import Matrix, NodeValues, Vector
from amble.view.meshes import link_meshes
from amble.view.replay import Replay, replay_of_samples
from benchmarks.robot_files import FILES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALKS = {"go2": "trot", "hyq": "walk", "anymal_c": "running trot"}

SHOWN, A_ROW = 8, 4
"""Pictures of a cycle, evenly over its time, and of a row."""

AZIMUTH, ELEVATION = np.radians(-62.0), np.radians(11.0)
"""Whence the robot is seen: from its right and a little in front, from above."""

LIGHT = np.array([0.35, -0.65, 0.85]) / np.linalg.norm([0.35, -0.65, 0.85])
BASE, LEG = np.array([0.40, 0.47, 0.56]), np.array([0.72, 0.77, 0.83])


def seen(points: NodeValues) -> tuple[NodeValues, NodeValues]:
    """Return where points lie in a picture without perspective, (..., 2), and how near they are, (...)."""
    cos, sin = np.cos(AZIMUTH), np.sin(AZIMUTH)
    toward = np.array([cos * np.cos(ELEVATION), sin * np.cos(ELEVATION), np.sin(ELEVATION)])
    right = np.array([-sin, cos, 0.0])
    return np.stack([points @ right, points @ np.cross(toward, right)], axis=-1), points @ toward


def solids(replay: Replay, frame: int) -> tuple[NodeValues, NodeValues]:
    """Return all triangles of a frame from far to near, (n, 3, 2), and their colours, (n, 3)."""
    corners, colours = [], []
    for mesh in replay.meshes:
        pose = replay.links[frame, mesh.link]
        points = Rotation.from_quat(pose[3:]).apply(mesh.vertices) + pose[:3]
        triangles = points[mesh.faces]
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        lit = np.abs(normal / np.where(size > 0.0, size, 1.0) @ LIGHT)
        corners.append(triangles)
        colours.append((0.45 + 0.55 * lit[:, None]) * (LEG if mesh.link else BASE))
    triangles = np.concatenate(corners)
    flat, near = seen(triangles)
    order = np.argsort(near.mean(axis=1))
    return flat[order], np.clip(np.concatenate(colours)[order], 0.0, 1.0)


def forces(replay: Replay, frame: int) -> NodeValues:
    """Return where the contact forces begin and end in a picture, (n, 2, 2); the weight is 0.9 leg lengths long."""
    scale = 0.9 * replay.robot.leg_length / (replay.robot.mass * replay.robot.gravity)
    standing = replay.stance[frame]
    start = replay.feet[frame, standing]
    return seen(np.stack([start, start + scale * replay.forces[frame, standing]], axis=1))[0]


def below(replay: Replay, frame: int) -> Vector:
    """Return where the ground below the base is in a picture, (2,)."""
    return seen(np.array([*replay.links[frame, 0, :2], 0.0]))[0]


def window(replay: Replay, frames: Sequence[int]) -> Matrix:
    """Return the corners of what all frames need around the ground below the base, (2, 2), m."""
    points = np.concatenate(
        [
            np.concatenate([part.reshape(-1, 2) for part in (solids(replay, frame)[0], forces(replay, frame))])
            - below(replay, frame)
            for frame in frames
        ]
    )
    margin = 0.05 * replay.robot.leg_length
    return np.array([points.min(axis=0) - margin, points.max(axis=0) + margin])


def draw_ground(axes: Axes, middle: Vector, length: float) -> None:
    """Draw a lattice of a quarter of a leg length on the ground below the robot, fixed to the world."""
    from matplotlib.collections import LineCollection

    cell = 0.25 * length
    low, high = (cell * np.round((middle + sign * np.array([1.25, 0.75]) * length) / cell) for sign in (-1, 1))
    lines = [[[x, low[1], 0.0], [x, high[1], 0.0]] for x in np.arange(low[0], high[0] + 0.5 * cell, cell)]
    lines += [[[low[0], y, 0.0], [high[0], y, 0.0]] for y in np.arange(low[1], high[1] + 0.5 * cell, cell)]
    axes.add_collection(LineCollection(list(seen(np.array(lines))[0]), colors="#DDDDDD", linewidths=0.5, zorder=0))


def draw_frame(axes: Axes, replay: Replay, frame: int, corners: Matrix) -> None:
    """Draw the robot at one frame, the ground, the ways of its feet, and the forces of those that stand.

    Args:
        axes: to draw into.
        replay: the motion.
        frame: of the motion.
        corners: of the picture, from the ground below the base, m.
    """
    from matplotlib.collections import PolyCollection

    draw_ground(axes, replay.links[frame, 0, :2], replay.robot.leg_length)
    for foot in range(len(replay.robot.feet)):
        axes.plot(*seen(replay.feet[:, foot])[0].T, color=GREY, linewidth=0.5, zorder=1)
    triangles, colours = solids(replay, frame)
    axes.add_collection(
        PolyCollection(list(triangles), facecolors=colours, edgecolors=colours, linewidths=0.15, zorder=2)
    )
    shape = {"arrowstyle": "-|>", "color": VERMILION, "linewidth": 1.1, "mutation_scale": 7.0}
    for start, end in forces(replay, frame):
        axes.plot(*start, marker="o", markersize=3.0, color=BLUE, zorder=4)
        axes.annotate("", end, start, arrowprops=shape | {"shrinkA": 0.0, "shrinkB": 0.0}, zorder=5)
    low, high = corners + below(replay, frame)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.axis("off")


def draw(gait: Gait, meshes_of: Path, place: Path) -> None:
    """Write the picture of a gait: its cycle in eight instants, and which feet stand when."""
    from matplotlib.figure import Figure

    meshes = link_meshes(gait.robot, meshes_of)
    replay = replay_of_samples(samples_of_gait(gait, cycles=1), gait.pattern.name, 1, meshes)
    frames = [round(share * (len(replay.times) - 1)) for share in (np.arange(SHOWN) + 0.5) / SHOWN]
    rows, corners = SHOWN // A_ROW, window(replay, frames)
    with paper_style():
        figure = Figure(figsize=(PAGE, 1.65 * rows + 1.5), layout="constrained")
        halves: Any = figure.subfigures(2, 1, height_ratios=[1.65 * rows, 1.5])
        above, under = halves
        for number, (axes, frame) in enumerate(zip(np.ravel(above.subplots(rows, A_ROW)), frames, strict=True)):
            draw_frame(axes, replay, frame, corners)
            axes.set_title(f"{number + 1}: {replay.times[frame]:.2f} s", fontsize=8.0, pad=1.0)
        draw_stances(under, gait, replay.times[frames])
        speed = f"{gait.speed:.2f} m/s"
        figure.suptitle(plain_text(f"{gait.robot.name}, {gait.pattern.name} at {speed}"))
        figure.savefig(place, dpi=130, metadata={"Software": None})


def draw_stances(figure: Any, gait: Gait, times: Vector) -> None:
    """Draw the stance phases of every foot over the cycle, and when the pictures are of."""
    footfall(gait.pattern, [domain.duration for domain in gait.domains], figure=figure)
    (axes,) = figure.axes
    axes.child_axes[0].remove()  # names of the stances, in the place of the numbers
    place = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "center", "fontsize": 7.0}
    for number, time in enumerate(times):
        axes.axvline(time, color=VERMILION, linewidth=0.7)
        axes.annotate(str(number + 1), (time, 1.0), (0, 2), color=VERMILION, **place)


def main(folder: Path) -> None:
    """Write the pictures beside this file."""
    for robot, name in WALKS.items():
        stem = f"{robot}-{name}".replace(" ", "_")
        gait = load_gait(folder / f"{stem}-0.1.json")
        draw(gait, FILES[robot].place(), Path(__file__).with_name(f"{stem}.png"))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
