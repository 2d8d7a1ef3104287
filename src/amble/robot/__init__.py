"""Robots: records, loading from files, kinematics and dynamics, the left-right mirror, a catalogue."""

from amble.robot import catalogue, dynamics, kinematics
from amble.robot.adaptation import Adaptation
from amble.robot.loading import load_robot
from amble.robot.mirror import Mirror
from amble.robot.model import Robot
from amble.robot.parts import Foot, Joint, Link, Payload
from amble.robot.readers import READERS
from amble.robot.symmetry import symmetrized

__all__ = [
    "READERS",
    "Adaptation",
    "Foot",
    "Joint",
    "Link",
    "Mirror",
    "Payload",
    "Robot",
    "catalogue",
    "dynamics",
    "kinematics",
    "load_robot",
    "symmetrized",
]
