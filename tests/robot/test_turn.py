"""Turns about the vertical: feet turn with the base, orientation and rates by independent means."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.robot import kinematics
from amble.robot.turn import turn_error, turned, turned_velocity
from tests.robots import random_states, robot

ANGLE = 0.7


def _about(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("angle", [ANGLE, -2.0, 3.0])
def test_feet_and_their_velocities_turn_with_the_robot(angle: float) -> None:
    of = robot("astro")
    q, v = random_states(of, 6)
    there, rates = turned(q, v, angle)
    for row in range(len(q)):
        for foot in of.foot_names:
            here, after = (np.asarray(kinematics.foot_position(of, foot, part[row])).ravel() for part in (q, there))
            np.testing.assert_allclose(after, _about(angle) @ here, atol=1e-12)
            slow, fast = (
                np.asarray(kinematics.foot_jacobian(of, foot, place[row])) @ rate[row]
                for place, rate in ((q, v), (there, rates))
            )
            np.testing.assert_allclose(fast, _about(angle) @ slow, atol=1e-9)
    assert np.all(np.abs(there[:, 5] - q[:, 5] - angle) < np.pi + 1e-12)


def test_the_rows_of_a_turn_are_zero_for_turned_states_only() -> None:
    of = robot("astro")
    q, v = random_states(of, 6)
    there, rates = turned(q, v, ANGLE)
    a, b, w, angle = ca.SX.sym("a", of.size), ca.SX.sym("b", of.size), ca.SX.sym("w", of.size), ca.SX.sym("angle")
    error = ca.Function("error", [a, b, angle], [turn_error(a, b, angle)])
    velocity = ca.Function("velocity", [a, w, b, angle], [turned_velocity(a, w, b, angle)])
    for row in range(len(q)):
        assert np.abs(np.asarray(error(q[row], there[row], ANGLE))).max() < 1e-12
        # a further turn by d about the vertical misses by sin d
        missed = np.asarray(error(q[row], there[row], ANGLE + 0.1)).ravel()
        assert np.linalg.norm(missed) == pytest.approx(np.sin(0.1), rel=1e-9)
        found = np.asarray(velocity(q[row], v[row], there[row], ANGLE)).ravel()
        np.testing.assert_allclose(found, rates[row], atol=1e-10)
