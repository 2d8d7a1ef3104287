"""Reference motions: against MuJoCo, against derivatives, against the gait's own nodes; what is in the files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from examples.mujoco_reference import free_model, largest_difference

from amble.analysis.reference import ReferenceMotion, reference_motion
from amble.analysis.reference_files import write_reference
from amble.analysis.samples import samples_of_gait
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.simulation import Trace
from tests.robots import path as robot_file


@pytest.fixture(scope="module")
def motion(walking_gait: Gait) -> ReferenceMotion:
    return reference_motion(walking_gait, 500.0, cycles=2)


def test_mujoco_sees_the_same_bodies_from_the_robots_own_file(motion: ReferenceMotion, tmp_path: Path) -> None:
    """Another reader of the URDF and another kinematics; angles between nodes are cubic, so rates differ by their
    interpolation and the central differences of 2 ms."""
    with np.load(write_reference(motion, tmp_path / "motion.npz")) as file:
        arrays = dict(file)
    apart, slip = largest_difference(arrays, free_model(robot_file("astro")))
    assert apart < 1e-9
    assert slip < 2e-2


def test_velocities_are_the_derivatives_of_positions(walking_gait: Gait) -> None:
    """Also across the quaternion: its rate is half itself times the angular velocity in the base's axes."""
    step = 1e-4
    found = reference_motion(walking_gait, 1.0 / step)
    inside = np.array([len(set(found.stances[k - 1 : k + 2])) == 1 for k in range(1, len(found.time) - 1)])
    middle = slice(1, -1)
    rate = (found.qpos[2:] - found.qpos[:-2])[inside] / (2.0 * step)
    qvel, quaternion = found.qvel[middle][inside], found.qpos[middle, 3:7][inside]
    assert np.abs(rate[:, :3] - qvel[:, :3]).max() < 1e-3
    assert np.abs(rate[:, 7:] - qvel[:, 6:]).max() < 1e-2
    w, x, y, z = quaternion.T
    p, q, r = qvel[:, 3:6].T
    turning = 0.5 * np.column_stack(
        [-x * p - y * q - z * r, w * p + y * r - z * q, w * q + z * p - x * r, w * r + x * q - y * p]
    )
    assert np.abs(rate[:, 3:7] - turning).max() < 1e-3
    assert np.linalg.norm(quaternion, axis=1) == pytest.approx(1.0, abs=1e-12)


def test_nodes_are_met(walking_gait: Gait) -> None:
    """At a rate whose instants are nodes of the first domain."""
    domain = walking_gait.domains[0]
    found = reference_motion(walking_gait, (len(domain.times) - 1) / domain.duration)
    count = len(domain.times) - 1  # at the last the next domain has begun
    assert found.torques[:count] == pytest.approx(domain.torques[:-1], abs=1e-9)
    assert found.qpos[:count, 7:] == pytest.approx(domain.positions[:-1, 6:], abs=1e-12)
    assert found.qvel[:count, 6:] == pytest.approx(domain.velocities[:-1, 6:], abs=1e-9)


def test_contacts_and_forces_go_together(motion: ReferenceMotion, walking_gait: Gait) -> None:
    assert motion.forces.shape == (len(motion.time), 4, 3)
    assert (motion.forces[motion.contacts][:, 2] > 0.0).all()
    assert (motion.forces[~motion.contacts] == 0.0).all()
    assert len(motion.time) == int(np.ceil(2 * walking_gait.period * 500.0))
    assert motion.command == (walking_gait.speed, 0.0, 0.0)
    weight = walking_gait.robot.mass * walking_gait.robot.gravity
    assert motion.forces[:, :, 2].sum(axis=1).mean() == pytest.approx(weight, rel=0.1)


def test_orders_hold_the_same_numbers(walking_gait: Gait) -> None:
    trees, files = (reference_motion(walking_gait, 50.0, order=order) for order in ("mujoco", "file"))  # type: ignore[arg-type]
    assert files.joints == walking_gait.robot.joint_names
    assert sorted(trees.joints) == sorted(files.joints)
    for place, joint in enumerate(trees.joints):
        assert trees.qpos[:, 7 + place] == pytest.approx(files.qpos[:, 7 + files.joints.index(joint)])
        assert trees.torques[:, place] == pytest.approx(files.torques[:, files.joints.index(joint)])
    with pytest.raises(UnknownNameError, match="known: mujoco, file"):
        reference_motion(walking_gait, 50.0, order="isaac")  # type: ignore[arg-type]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf"), 1e9])
def test_rates_that_cannot_be(walking_gait: Gait, rate: float) -> None:
    with pytest.raises(InputError, match="rows a second cannot be"):
        reference_motion(walking_gait, rate)


def test_a_trace_is_sampled_as_it_was_recorded(walking_gait: Gait) -> None:
    """The trace of the gait's own motion at its own instants: what goes in comes out, across every event."""
    samples = samples_of_gait(walking_gait, 2)
    visited = [stance.name for stance in walking_gait.pattern.visited]
    entries = samples.times[np.searchsorted(samples.segments, samples.segments)]
    trace = Trace(
        domains=tuple(visited), state_names=(), time=samples.times.copy(), clock=samples.times - entries,
        domain=samples.stances.copy(), cycle=samples.cycles.copy(),
        state=np.hstack([samples.positions, samples.velocities]),
        signals={"torque": samples.torques.copy(), "force": samples.forces.copy()},
        events=(), cycles=2, ended="completed", tolerance=1e-9, seconds=0.0,
    )  # fmt: skip
    for cycles in (None, 1):
        found = reference_motion(walking_gait, 500.0, cycles, trace=trace)
        planned = reference_motion(walking_gait, 500.0, cycles or 2)
        assert found.stances == planned.stances
        for name in ("time", "qpos", "qvel", "torques", "forces", "contacts", "body_positions"):
            assert np.array_equal(getattr(found, name), getattr(planned, name)), name
    with pytest.raises(InputError, match="rows a second cannot be"):
        reference_motion(walking_gait, 1e9, trace=trace)
