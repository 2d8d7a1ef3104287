"""Stabilisation from a neighbour's weights: short where they serve, whole where they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.defaults import FREE
from amble.gait import Gait
from amble.stability.search_start import FEW, NEAR, WHOLE, Descents, begin
from amble.stability.stabilize import stabilization


def test_weights_of_the_same_gait_need_one_short_descent(walking_gait: Gait, stabilised_gait: Gait) -> None:
    """The nearest neighbour is the gait itself: its radius is there at once, and nothing whole is descended."""
    evaluations: list[int] = []
    found = stabilization(
        walking_gait,
        progress=lambda report: evaluations.append(report.done or 0) if report.what == "evaluation" else None,
        near=stabilised_gait,
    )
    assert found.initial < 0.3  # 2.3 under the weights of the gait problem
    assert found.radius <= found.initial
    assert max(evaluations, default=0) <= FEW + 5  # a line search may end a little later
    assert len(found.steps) <= 2


@pytest.mark.slow
def test_weights_that_do_not_serve_are_left_by_whole_descents(
    walking_gait: Gait, stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Weights of the gait problem, handed in as a neighbour's: a short descent leads from 2.32 to 0.58."""
    monkeypatch.setattr("amble.stability.stabilize.TARGET", 0.5)
    monkeypatch.setattr("amble.stability.stabilize.WHOLE", Descents(1, 40))
    assert stabilised_gait.feedback is not None
    plain = {
        name: np.where(np.abs(matrix) == 1.0, matrix, 0.0) for name, matrix in stabilised_gait.feedback.weights.items()
    }
    near = replace(stabilised_gait, feedback=replace(stabilised_gait.feedback, weights=plain))
    found = stabilization(walking_gait, near=near)
    assert found.initial > 2.0
    assert 0.5 < found.steps[1].radius < 1.0
    assert found.radius < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("huge", [1e6, 0.0])
def test_weights_without_an_orbit_are_no_start(walking_gait: Gait, stabilised_gait: Gait, huge: float) -> None:
    """Weights under which outputs depend on each other, or that throw the robot: the gait's own are the start."""
    assert stabilised_gait.feedback is not None
    bad = {name: np.full(matrix.shape, huge) for name, matrix in stabilised_gait.feedback.weights.items()}
    near = replace(stabilised_gait, feedback=replace(stabilised_gait.feedback, weights=bad))
    start = begin(walking_gait, FREE, near)
    assert start.descents is WHOLE
    assert start.closed.radius == pytest.approx(2.322, abs=0.01)


@pytest.mark.slow
def test_joints_that_the_neighbour_freed_stay_free(walking_gait: Gait, stabilised_gait: Gait) -> None:
    assert stabilised_gait.feedback is not None
    names = ["roll", "pitch", "yaw", *walking_gait.robot.joint_names]
    joint = walking_gait.robot.joint_names[0]
    changed = {name: np.array(matrix) for name, matrix in stabilised_gait.feedback.weights.items()}
    for matrix in changed.values():
        matrix[:, names.index(joint)] += 1e-6
    near = replace(stabilised_gait, feedback=replace(stabilised_gait.feedback, weights=changed))
    start = begin(walking_gait, None, near)
    assert start.descents is NEAR
    assert joint in start.free
