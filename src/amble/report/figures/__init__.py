"""Figures; each function returns a matplotlib figure, a given one or a new one; ``save`` writes it as PNG and PDF."""

from amble.report.figures.actuation import joint_power, torque_speed
from amble.report.figures.contacts import contact_forces, foot_paths
from amble.report.figures.footfall import footfall
from amble.report.figures.front import torque_push
from amble.report.figures.gait_map import gait_map
from amble.report.figures.orbital_stability import multiplier_circle, section_distance
from amble.report.figures.portraits import base_portraits, cycle_portraits, joint_portraits
from amble.report.figures.style import require_matplotlib, save
from amble.report.figures.survival import survival
from amble.report.figures.torques import left_joints, torque_lines, torque_magnitudes

__all__ = [
    "base_portraits",
    "contact_forces",
    "cycle_portraits",
    "foot_paths",
    "footfall",
    "gait_map",
    "joint_portraits",
    "joint_power",
    "left_joints",
    "multiplier_circle",
    "require_matplotlib",
    "save",
    "section_distance",
    "survival",
    "torque_lines",
    "torque_magnitudes",
    "torque_push",
    "torque_speed",
]
