"""A motion as a replay draws it: poses of all links, feet, forces and footholds at evenly spaced frames.

Poses are computed here, so the page that shows them knows nothing of joints, and any robot, ground and gait moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from amble.amounts import check_amount
from amble.analysis import Samples
from amble.errors import InputError
from amble.hybrid import Ground
from amble.robot import Robot
from amble.robot.free_base import link_trajectories
from amble.types import IntegerVector, Matrix, NodeValues, Vector, frozen
from amble.view.meshes import Mesh
from amble.view.shapes import Shape, link_shapes

FRAMES = 72
"""Frames a gait cycle: turns of a joint between two are small, and the page interpolates between them."""

MARGIN = 3.0
"""How far the ground is drawn beyond the path of the centre of mass, in leg lengths."""

CELLS = 160
"""Largest number of ground cells along the path; they grow where the path is longer."""

MOST_CYCLES = 1000
"""Most gait cycles of a page: it grows by 50 kB with each."""


@dataclass(frozen=True, kw_only=True)
class Foothold:
    """Where a foot stands: its index, from when to when (s from the start of the replay), the point (m)."""

    foot: int
    start: float
    end: float
    point: Vector


@dataclass(frozen=True, kw_only=True)
class GroundGrid:
    """Heights of the ground over a lattice.

    Attributes:
        origin: x and y of the first point, (2,), m.
        cell: distance of neighbours, m.
        heights: (n_x, n_y), m.
    """

    origin: Vector
    cell: float
    heights: Matrix


@dataclass(frozen=True, kw_only=True)
class Replay:
    """A motion at n evenly spaced times.

    Attributes:
        label: what the motion is called on the page.
        robot: the robot.
        shapes: what is drawn of its links.
        cycles: gait cycles that are shown.
        times: from 0, (n,), s.
        links: origin (3) and orientation as a unit quaternion x, y, z, w (4) of every link, world, (n, n_links, 7).
        feet: positions of the feet, (n, n_feet, 3), m.
        forces: contact forces, world frame, zero of feet in the air, (n, n_feet, 3), N.
        normals: normal of the ground under every foot, (n, n_feet, 3).
        stance: whether a foot stands, (n, n_feet).
        center: centre of mass, (n, 3), m.
        domains: index into ``domain_names``, (n,).
        domain_names: names of the stances.
        footholds: in order of time.
        ground: its heights along the path.
        friction: coefficient of the ground.
        meshes: looks of links, drawn in the place of their shapes.
    """

    label: str
    robot: Robot
    shapes: tuple[Shape, ...]
    cycles: int
    times: Vector
    links: NodeValues
    feet: NodeValues
    forces: NodeValues
    normals: NodeValues
    stance: NDArray[np.bool_]
    center: NodeValues
    domains: IntegerVector
    domain_names: tuple[str, ...]
    footholds: tuple[Foothold, ...]
    ground: GroundGrid
    friction: float
    meshes: tuple[Mesh, ...] = ()


def check_cycles(cycles: int) -> None:
    """Refuse a number of cycles that no page shows.

    Raises:
        InputError: it is not from 1 to ``MOST_CYCLES``.
    """
    check_amount("cycles", cycles, 1, MOST_CYCLES)


def replay_of_samples(samples: Samples, label: str, cycles: int, meshes: tuple[Mesh, ...] = ()) -> Replay:
    """Lay a motion out for a replay, from its beginning.

    Args:
        samples: the motion of a legged robot.
        label: what to call it on the page.
        cycles: the most gait cycles to show, from 1 to 1000.
        meshes: looks of links; a link without is drawn from the tree.

    Raises:
        InputError: where ``cycles`` is out of range, or the motion lasts no time.
    """
    check_cycles(cycles)
    first = int(samples.cycles[0])
    shown = samples.only(first, first + cycles)
    duration = float(shown.times[-1] - shown.times[0])
    if not duration > 0.0:
        raise InputError(f"the {samples.label} motion lasts {duration:g} s; there is nothing to replay")
    count = int(shown.cycles[-1]) - first + 1
    times = np.linspace(0.0, duration, FRAMES * count + 1)
    rows, weights = _rows(shown, times)
    positions = _between(shown.positions, rows, weights)
    pattern, robot = samples.pattern, samples.robot
    stances = pattern.visited
    standing = np.array([[foot in stance.feet for foot in robot.foot_names] for stance in stances])
    links = link_trajectories(robot, positions)
    feet = _feet(shown, positions)
    axes = list(pattern.contact.axes)
    forces = np.zeros((len(times), len(robot.feet), 3))
    recorded = _between(shown.forces, rows, weights).reshape(len(times), len(robot.feet), -1)
    forces[:, :, axes] = recorded[:, :, : len(axes)]  # without moments
    return Replay(
        label=label,
        robot=robot,
        shapes=link_shapes(robot),
        cycles=count,
        times=frozen(times),
        links=frozen(links),
        feet=frozen(feet),
        forces=frozen(forces),
        normals=frozen(np.asarray(pattern.ground.normal(feet))),
        stance=standing[shown.stances[rows]],
        center=frozen(_centers(robot, links)),
        domains=shown.stances[rows],
        domain_names=tuple(stance.name for stance in stances),
        footholds=_footholds(shown, standing),
        ground=_grid(pattern.ground, robot.base.spatial(positions)[:, :2], robot.leg_length),
        friction=pattern.ground.friction,
        meshes=meshes,
    )


def _rows(samples: Samples, times: Vector) -> tuple[IntegerVector, Vector]:
    """The last sample not after each time, and the share of the way to the next one of the same visit."""
    own = samples.times - samples.times[0]
    rows = np.clip(np.searchsorted(own, times, side="right") - 1, 0, len(own) - 1)
    after = np.minimum(rows + 1, len(own) - 1)
    step = np.where(samples.segments[after] == samples.segments[rows], own[after] - own[rows], 0.0)
    weights = np.where(step > 0.0, (times - own[rows]) / np.where(step > 0.0, step, 1.0), 0.0)
    return rows, np.clip(weights, 0.0, 1.0)


def _between(values: NodeValues, rows: IntegerVector, weights: Vector) -> NodeValues:
    after = np.minimum(rows + 1, len(values) - 1)
    return values[rows] + weights[:, None] * (values[after] - values[rows])


def _feet(samples: Samples, positions: NodeValues) -> NodeValues:
    q = ca.SX.sym("q", samples.robot.size)
    function = ca.Function("feet", [q], [samples.pattern.all_contacts.points(q)])
    return np.asarray(function.map(len(positions))(positions.T)).T.reshape(len(positions), -1, 3)


def _centers(robot: Robot, links: NodeValues) -> NodeValues:
    """Centre of mass of the robot at every frame, (n, 3), m."""
    masses = np.array([link.mass for link in robot.links])
    centers = np.array([link.center for link in robot.links])
    turned = Rotation.from_quat(links[..., 3:].reshape(-1, 4)).apply(np.tile(centers, (len(links), 1)))
    return np.einsum("l,nlk->nk", masses / masses.sum(), links[..., :3] + turned.reshape(*links.shape[:2], 3))


def _footholds(samples: Samples, standing: NDArray[np.bool_]) -> tuple[Foothold, ...]:
    """Every stay of a foot on the ground, over as many domain visits as it lasts."""
    firsts = np.flatnonzero(np.diff(samples.segments, prepend=samples.segments[0] - 1))
    lasts = np.append(firsts[1:], len(samples.times)) - 1
    points = _feet(samples, samples.positions[firsts])
    own = samples.times - samples.times[0]
    found: list[Foothold] = []
    for foot in range(len(samples.robot.feet)):
        stands = [bool(standing[samples.stances[row], foot]) for row in firsts]
        for visit in np.flatnonzero(stands):
            if visit > 0 and stands[visit - 1]:
                continue
            past = next((k for k in range(visit, len(firsts)) if not stands[k]), len(firsts))
            start, end = own[firsts[visit]], own[lasts[past - 1]]
            found.append(Foothold(foot=foot, start=float(start), end=float(end), point=frozen(points[visit, foot])))
    return tuple(sorted(found, key=lambda hold: hold.start))


def _grid(ground: Ground, path: Matrix, length: float) -> GroundGrid:
    low, high = path.min(axis=0) - MARGIN * length, path.max(axis=0) + MARGIN * length
    cell = max(0.5 * length, float(np.max(high - low)) / CELLS)
    low = cell * np.floor(low / cell)
    counts = np.ceil((high - low) / cell).astype(int) + 1
    x, y = (low[axis] + cell * np.arange(counts[axis]) for axis in (0, 1))
    heights = np.asarray(ground.height(x[:, None], y[None, :]), dtype=np.float64)
    return GroundGrid(origin=frozen(low), cell=cell, heights=frozen(np.broadcast_to(heights, tuple(counts))))
