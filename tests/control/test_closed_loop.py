"""Guards of feet that leave the ground by their force."""

from __future__ import annotations

import numpy as np
import pytest

from amble.control import PseudoInverse
from amble.control.closed_loop import stance_loops
from amble.control.virtual_constraints import pack
from amble.hybrid import FLAT, Ground, Plane, gait_pattern
from amble.robot import catalogue

FLIGHT = (("fl", "rr"), (), ("fr", "rl"), ())
ONE_LEAVES = (("fl", "rr"), ("fl",), ("fr", "rl"), ("fr",))
ORDER, LIFT_OFF = 4, 7.0


@pytest.mark.parametrize("ground", [FLAT, Plane(slope=0.2)])
@pytest.mark.parametrize(("table", "leaving"), [(FLIGHT, ("fl", "rr")), (ONE_LEAVES, ("rr",))])
def test_feet_leave_at_the_mean_of_their_normal_forces(
    ground: Ground, table: tuple[tuple[str, ...], ...], leaving: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two feet only the first was looked at, and it left at a force of zero, where nothing holds it."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    robot, draw = catalogue.astro(), np.random.default_rng(3)
    pattern = gait_pattern(robot, table, True, ground=ground)
    assert pattern.switches[0].leaving == leaving
    loop = stance_loops(pattern, PseudoInverse(), [11, 12], ORDER, lift_off=LIFT_OFF)[0]
    weights = np.delete(np.eye(15)[3:], robot.joint_index("rr_hip_pitch"), axis=0)
    for _ in range(3):
        q = catalogue.posture("astro").coordinates(robot) + draw.normal(0.0, 0.1, robot.size)
        references = np.tile(q[3:, None], ORDER + 1) + draw.normal(0.0, 0.05, (15, ORDER + 1))
        p = pack(0.2, (100.0, 20.0), references, weights)
        x = np.concatenate([q, draw.normal(0.0, 0.3, robot.size)])
        signals = dict(zip(loop.signals.name_out(), loop.signals(0.1, x, p), strict=True))
        points, forces = (np.asarray(signals[name]).reshape(4, 3) for name in ("foot", "force"))
        normals = np.sum(forces * ground.normal(points), axis=1)
        places = [robot.foot_names.index(foot) for foot in leaving]
        scale = 1.0 + np.max(np.abs(forces))
        assert float(loop.guard(0.1, x, p)) == pytest.approx(np.mean(normals[places]) - LIFT_OFF, abs=1e-10 * scale)
