"""The numbers of a replay obey the laws of the motion that they show."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from amble.analysis import Samples, samples_of_gait, samples_of_trace
from amble.errors import InputError
from amble.gait import Gait
from amble.robot import kinematics
from amble.simulation import simulate
from amble.view.replay import FRAMES, Replay, replay_of_samples

CYCLES = 3


@pytest.fixture(scope="module")
def samples(stabilised_gait: Gait) -> Samples:
    return samples_of_gait(stabilised_gait, CYCLES)


@pytest.fixture(scope="module")
def shown(samples: Samples) -> Replay:
    return replay_of_samples(samples, "a gait", CYCLES)


def test_frames_are_evenly_spaced_over_the_whole_motion(shown: Replay, stabilised_gait: Gait) -> None:
    assert len(shown.times) == CYCLES * FRAMES + 1
    np.testing.assert_allclose(np.diff(shown.times), stabilised_gait.period / FRAMES, rtol=1e-9)


def test_links_are_where_the_kinematics_have_them(shown: Replay, samples: Samples) -> None:
    """At the first and the last frame the positions are those of a sample, so nothing is interpolated."""
    for frame, q in ((0, samples.positions[0]), (-1, samples.positions[-1])):
        for link in range(len(shown.robot.links)):
            rotation, origin = kinematics.link_pose(shown.robot, link, q)
            pose = shown.links[frame, link]
            np.testing.assert_allclose(pose[:3], np.asarray(ca.DM(origin)).ravel(), atol=1e-12)
            np.testing.assert_allclose(Rotation.from_quat(pose[3:]).as_matrix(), np.asarray(ca.DM(rotation)), atol=1e-9)


def test_neighbouring_quaternions_have_the_same_sign(shown: Replay) -> None:
    """The page interpolates them, and the way from q to -q leads through nothing."""
    assert np.min(np.sum(shown.links[1:, :, 3:] * shown.links[:-1, :, 3:], axis=-1)) > 0.9


def test_standing_feet_stay_at_their_footholds(shown: Replay) -> None:
    """Between two nodes the joints are interpolated: a ten-thousandth of a leg is far below a pixel."""
    assert len(shown.footholds) >= CYCLES * len(shown.robot.feet)
    for hold in shown.footholds:
        during = (shown.times > hold.start) & (shown.times < hold.end)
        assert np.all(shown.stance[during, hold.foot])
        drift = np.abs(shown.feet[during, hold.foot] - hold.point)
        assert np.max(drift) < 1e-3 * shown.robot.leg_length
    stays = sum(hold.end - hold.start for hold in shown.footholds)
    step = shown.times[1] - shown.times[0]
    # counted by frames, each stay is off by less than one step
    assert abs(stays - step * np.sum(shown.stance[:-1])) < step * len(shown.footholds)


def test_forces_carry_the_weight_and_feet_in_the_air_none(shown: Replay) -> None:
    """The momentum repeats every cycle, so the mean force is the weight; the jumps at events limit the accuracy."""
    robot = shown.robot
    mean = np.sum(np.mean(shown.forces[:-1], axis=0), axis=0)
    assert abs(mean[2] / (robot.mass * robot.gravity) - 1.0) < 0.03
    assert np.all(np.abs(mean[:2]) < 0.03 * mean[2])
    assert np.all(shown.forces[~shown.stance] == 0.0)


def test_the_centre_of_mass_keeps_its_place_among_the_links(shown: Replay) -> None:
    """Moments of the links' weights about it vanish."""
    links, frame = shown.robot.links, 17
    moment = np.zeros(3)
    for link, pose in zip(links, shown.links[frame], strict=True):
        arm = pose[:3] + Rotation.from_quat(pose[3:]).as_matrix() @ link.center - shown.center[frame]
        moment += link.mass * arm
    np.testing.assert_allclose(moment, 0.0, atol=1e-10 * shown.robot.mass)


def test_the_ground_lies_under_the_path(shown: Replay) -> None:
    grid = shown.ground
    far = grid.origin + grid.cell * (np.array(grid.heights.shape) - 1)
    base, margin = shown.links[:, 0, :2], 3.0 * shown.robot.leg_length
    assert np.all(base - margin >= grid.origin)
    assert np.all(base + margin <= far)
    assert np.all(grid.heights == 0.0)


def test_of_a_long_simulation_the_first_cycles_are_shown(stabilised_gait: Gait) -> None:
    trace = simulate(stabilised_gait, cycles=4)
    replay = replay_of_samples(samples_of_trace(trace, stabilised_gait.pattern), "a walk", 2)
    assert replay.cycles == 2
    np.testing.assert_allclose(replay.times[-1], 2.0 * stabilised_gait.period, rtol=1e-3)


def test_no_cycles_are_refused(samples: Samples) -> None:
    with pytest.raises(InputError, match="0 cycles were asked for"):
        replay_of_samples(samples, "none", 0)
