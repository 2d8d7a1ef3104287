"""Figures, one a file; each function returns a matplotlib figure, and ``save`` writes it as PNG and PDF."""

from amble.report.figures.base_portraits import base_portraits
from amble.report.figures.cycle_portraits import cycle_portraits
from amble.report.figures.footfall import footfall
from amble.report.figures.joint_portraits import joint_portraits
from amble.report.figures.multipliers import multiplier_circle
from amble.report.figures.section_distance import section_distance
from amble.report.figures.style import require_matplotlib, save
from amble.report.figures.torques import left_joints, torque_lines, torque_magnitudes

__all__ = [
    "base_portraits",
    "cycle_portraits",
    "footfall",
    "joint_portraits",
    "left_joints",
    "multiplier_circle",
    "require_matplotlib",
    "save",
    "section_distance",
    "torque_lines",
    "torque_magnitudes",
]
