"""Robots: records, loading from files, kinematics and dynamics, the left-right mirror, a catalogue."""

from amble.robot import catalogue, dynamics, kinematics
from amble.robot.loading import load_robot
from amble.robot.mirror import Mirror, symmetrized
from amble.robot.model import Robot
from amble.robot.parts import Foot, Joint, Link
from amble.robot.readers import READERS

__all__ = [
    "READERS",
    "Foot",
    "Joint",
    "Link",
    "Mirror",
    "Robot",
    "catalogue",
    "dynamics",
    "kinematics",
    "load_robot",
    "symmetrized",
]
