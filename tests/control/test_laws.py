"""Laws by name."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.control.allocation import DropActuator, PseudoInverse
from amble.control.laws import law_for, paper_baseline
from amble.errors import UnknownNameError
from amble.hybrid.gaits import GAITS, amble
from amble.robot import catalogue
from amble.robot.proposal import nominal_posture
from tests.robots import robot

PATTERN = amble(catalogue.astro())


def test_the_baseline_drops_the_rear_stance_hip_pitch() -> None:
    assert paper_baseline(PATTERN) == DropActuator(("rl_hip_pitch", "rr_hip_pitch"))


@pytest.mark.parametrize("gait", ["bound", "trot", "pace"])
def test_what_drops_by_default_carries_the_internal_force(gait: str) -> None:
    """On two feet beside each other the hip pitch, once the default, carries next to none: 7,824 N m of RMS torque."""
    pattern = GAITS[gait](robot("go2"))
    law, q = law_for(pattern, "drop"), nominal_posture(pattern.robot).coordinates(pattern.robot)
    assert isinstance(law, DropActuator)
    for stance in pattern.solved:
        torques = np.abs(np.asarray(ca.DM(pattern.contacts(stance).torque_null_space(q)[0]))).ravel()
        share = dict(zip(pattern.robot.joint_names, torques / torques.max(), strict=True))
        (dropped,) = (joint for joint in law.joints if share[joint] > 0.0)
        assert share[dropped] > 0.3
        if gait == "bound":
            assert max(value for joint, value in share.items() if "thigh" in joint) < 0.01


def test_laws_are_found_by_name() -> None:
    assert law_for(PATTERN, "pinv") == PseudoInverse()
    assert law_for(PATTERN, "drop") == paper_baseline(PATTERN)
    assert law_for(PATTERN, "drop", {"joints": ["fr_knee", "fl_knee"]}) == DropActuator(("fr_knee", "fl_knee"))


def test_an_unknown_law_or_parameter_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="known: pinv, drop"):
        law_for(PATTERN, "best")
    with pytest.raises(UnknownNameError, match="parameter of allocation law 'pinv' 'power'"):
        law_for(PATTERN, "pinv", {"power": 2})
