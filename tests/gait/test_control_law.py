"""What a control law keeps: by default what its torques, as they are written, do not read."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from examples.extending.control_joint_pd import JointImpedance

from amble.gait import Gait
from amble.gait.closed_loop import symmetries
from amble.gait.control_law import ControlLaw, TorqueLaw
from amble.gait.impedance import Impedance
from amble.hybrid import Contacts
from amble.numerics.pieces import ORDER
from amble.types import Vector


class Reading(JointImpedance):
    """Joint springs and a little of one coordinate."""

    coordinate = "x"

    def torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Add it."""
        read = q[contacts.robot.coordinate_index(self.coordinate)]
        return super().torques(contacts, t, q, v, p) + 1e-3 * read


class ReadingRoll(Reading):
    """The roll, which the turn about the vertical changes."""

    coordinate = "roll"


class Switching(Reading):
    """A push that switches with a coordinate, far from the orbit or on it: none has a slope."""

    def torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Add it to what joints and clock say."""
        at = q[contacts.robot.coordinate_index(self.coordinate)]
        return JointImpedance.torques(self, contacts, t, q, v, p) + self.switched(at)

    def switched(self, at: ca.SX) -> ca.SX:
        return 1e-3 * ca.sign(at)


class SwitchingYaw(Switching):
    """The heading, which no translation moves."""

    coordinate = "yaw"

    def switched(self, at: ca.SX) -> ca.SX:
        return ca.if_else(at < 0.5, 0, 1.0)


class StepsOfHeight(Switching):
    """The height in steps."""

    coordinate = "z"

    def switched(self, at: ca.SX) -> ca.SX:
        return ca.floor(100 * at)


class ReadingHeight(Reading):
    """The height, which no symmetry changes."""

    coordinate = "z"


@pytest.mark.parametrize(
    ("law", "kept"),
    [
        (JointImpedance(), {"x", "y", "yaw"}),
        (ReadingHeight(), {"x", "y", "yaw"}),
        (Reading(), {"y"}),
        (ReadingRoll(), {"x", "y"}),
        (Switching(), {"y"}),
        (SwitchingYaw(), {"x", "y"}),
        (StepsOfHeight(), {"x", "y", "yaw"}),
    ],
)
def test_what_a_law_reads_it_does_not_keep(stabilised_gait: Gait, law: TorqueLaw, kept: set[str]) -> None:
    """Before, every law was believed to keep all: one that walks to x = 0 would have been stable modulo x."""
    assert {symmetry.name for symmetry in symmetries(stabilised_gait, law)} == kept


def test_impedance_keeps_what_its_torques_do_not_read(stabilised_gait: Gait) -> None:
    class Packed(Impedance):
        """As many numbers as four pieces have; which they are does not matter, and a real orbit takes seconds."""

        def packed(self, gait: Gait, domain: str) -> Vector:  # noqa: ARG002
            joints = len(gait.robot.joints)
            return np.zeros(2 + 2 * joints + 4 * (2 + 2 * joints * (ORDER + 1)))

    found = symmetries(stabilised_gait, Impedance())
    assert {symmetry.name for symmetry in found} == {"x", "y", "yaw"}
    assert all(TorqueLaw.keeps(Packed(), stabilised_gait, symmetry) for symmetry in found)


def test_a_law_that_gives_accelerations_has_to_say_what_it_keeps() -> None:
    class Silent(ControlLaw):
        name = "silent"

        def numbers(self, *_: Any) -> Any:
            return ()

        def loops(self, *_: Any) -> Any:
            return ()

    with pytest.raises(TypeError, match="keeps"):
        Silent()  # type: ignore[abstract]
