"""Pictures of walking robots: what is seen is a turn of the world, nearer parts come last, and all of it is inside."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.image import imread

from amble.analysis import samples_of_gait
from amble.gait.files import load_gait
from amble.view.meshes import link_meshes
from amble.view.replay import replay_of_samples
from docs.figures.walks import below, draw, forces, seen, solids, window
from tests.robots import path

TROT = Path(__file__).parents[1] / "data" / "trot.json"


def test_a_picture_is_the_world_turned() -> None:
    """Distances stay, the handedness too, up is up, and what is right of the robot is nearer."""
    points = np.random.default_rng(0).normal(size=(4, 3))
    flat, near = seen(points)
    turned = np.column_stack([flat, near])
    np.testing.assert_allclose(turned @ turned.T, points @ points.T, atol=1e-12)
    assert np.linalg.det(np.column_stack(seen(np.eye(3)))) > 0.0
    assert seen(np.array([0.0, 0.0, 1.0]))[0][1] > 0.9
    assert seen(np.array([0.0, -1.0, 0.0]))[1] > 0.5
    assert seen(np.array([1.0, 0.0, 0.0]))[0][0] > 0.5


def test_a_gait_is_drawn(tmp_path: Path) -> None:
    gait = load_gait(TROT)
    replay = replay_of_samples(samples_of_gait(gait, cycles=1), "trot", 1, link_meshes(gait.robot, path("astro")))
    (low, high), frame = window(replay, [0, 30]), 30
    for points in (solids(replay, frame)[0], forces(replay, frame)):
        inside = points.reshape(-1, 2) - below(replay, frame)
        assert np.all((inside > low) & (inside < high))
    lengths = forces(replay, frame)[:, 1] - forces(replay, frame)[:, 0]
    weight = gait.robot.mass * gait.robot.gravity
    upward = replay.forces[frame, replay.stance[frame]][:, 2] / weight
    assert np.all(lengths[:, 1] > 0.8 * upward * gait.robot.leg_length)
    draw(gait, path("astro"), tmp_path / "trot.png")
    assert np.ptp(imread(tmp_path / "trot.png")[..., :3]) > 0.5
