"""Turns as symmetries of a law: proved on what it writes, never by its word."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import pytest
from examples.extending.control_joint_pd import JointImpedance

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.control_law import ControlLaw
from amble.gait.linearising_law import InputOutputLinearisation
from amble.hybrid import Contacts, Symmetry
from amble.proof.turns import turns


class Turning(JointImpedance):
    """Says that it keeps all, and pushes where the base has turned to the other side, which no slope shows."""

    def torques(self, contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Add the push."""
        yaw = q[contacts.robot.coordinate_index("yaw")]
        return super().torques(contacts, t, q, v, p) + ca.if_else(yaw < 0.5, 0, 1)

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """All."""
        del gait, symmetry
        return True


class Worded(InputOutputLinearisation):
    """Has outputs of the orientation, and says that it does not see it."""

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """All."""
        del gait, symmetry
        return True


KEPT = "x", "y"
"""By half a cycle; the mirror reverses the turn."""


def test_a_law_of_clock_and_joints_is_proved_not_to_see_the_turn(stabilised_gait: Gait) -> None:
    assert len(turns(replace(stabilised_gait, control=JointImpedance()), KEPT)) == 1
    assert turns(stabilised_gait, KEPT) == ()  # its outputs see the orientation


@pytest.mark.parametrize("law", [Turning(), Worded(400.0, 40.0)], ids=["switch", "word"])
def test_a_turn_that_is_a_law_s_word_is_refused(stabilised_gait: Gait, law: ControlLaw) -> None:
    with pytest.raises(InputError, match=r"says that it keeps 'yaw', .* in domain 'D1' is not proved"):
        turns(replace(stabilised_gait, control=law), KEPT)
