"""Robots: records, loading from files, kinematics and dynamics, the left-right mirror, a catalogue."""

from amble.robot import catalogue, dynamics, kinematics
from amble.robot.loading import load_robot
from amble.robot.mirror import Mirror
from amble.robot.model import Foot, Joint, Link, Robot
from amble.robot.readers import READERS
from amble.robot.symmetry import symmetrized

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
