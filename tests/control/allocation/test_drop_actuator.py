"""Dropping actuators: which may be dropped, and why no other."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.control import DropActuator, Redundancy
from amble.errors import InputError, UnknownNameError
from amble.hybrid import Contacts
from tests.control.allocation.stances import samples, stance_feet
from tests.robots import robot


def redundancy(feet: tuple[str, ...], free: int) -> Redundancy:
    contacts = Contacts(robot("astro"), feet)
    return Redundancy(
        contacts=contacts,
        points=ca.SX(3 * len(feet), 1),
        torques=ca.SX.sym("u", 12),
        torque_basis=ca.SX.sym("N", 12, free),
        forces=ca.SX.sym("lambda", contacts.size),
        force_basis=ca.SX.sym("W", contacts.size, free),
        speeds=ca.SX.sym("speeds", 12),
    )


@pytest.mark.parametrize(
    ("joints", "error", "says"),
    [
        (("fl_knee",), InputError, "0 belong to the stance legs rl, fr, but 1 must: .* singular"),
        (("fr_knee", "rl_knee"), InputError, "2 belong to the stance legs"),
        ((), InputError, "0 belong to the stance legs"),
        (("fr_ankle",), UnknownNameError, "unknown joint 'fr_ankle'; known: fl_hip_yaw"),
    ],
)
@pytest.mark.parametrize("method", ["optimality_conditions", "allocate"])
def test_what_cannot_be_dropped(joints: tuple[str, ...], error: type[InputError], says: str, method: str) -> None:
    with pytest.raises(error, match=says):
        getattr(DropActuator(joints), method)(redundancy(("rl", "fr"), 1))


@pytest.mark.parametrize(
    ("count", "joints"),
    [
        (1, ()),
        (2, ("fl_hip_pitch",)),
        (2, ("rr_knee", "rl_knee")),  # the second belongs to a leg in swing and keeps its actuator
        (3, ("fl_hip_pitch", "fr_knee", "rr_hip_pitch")),
    ],
)
def test_dropped_joints_carry_no_torque(count: int, joints: tuple[str, ...]) -> None:
    if count == 1:
        feet, sample = ("fl",), None
    else:
        feet, sample = stance_feet(robot("astro"), count), samples("astro", count, 1)[0]
    free = {1: 0, 2: 1, 3: 3}[count]
    at, law = redundancy(feet, free), DropActuator(joints)
    assert law.optimality_conditions(at).shape == (free, 1)
    assert law.allocate(at).shape == (free, 1)
    if sample is None:
        return
    torques = at.torques + at.torque_basis @ law.allocate(at)
    function = ca.Function("dropped", [at.torques, at.torque_basis], [torques])
    values = np.asarray(function(sample.torques, sample.torque_basis)).ravel()
    standing = [joint for foot in feet for joint in robot("astro").legs[foot]]
    for joint in joints:
        size = abs(values[robot("astro").joint_index(joint)])
        assert bool(size < 1e-10 * np.abs(values).max()) is (joint in standing)


def test_the_law_rebuilds_from_its_parameters() -> None:
    from amble.control import law_from

    law = DropActuator(("fr_knee", "fl_knee"))
    assert law_from(law.name, dict(law.parameters)) == law
