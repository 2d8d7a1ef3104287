"""The gait problem, its transcription and its solution."""

from amble.robot.proposal import standing_posture
from amble.synthesis.default_limits import default_limits
from amble.synthesis.problem import GaitProblem, gait_problem
from amble.synthesis.refine import refine
from amble.synthesis.sweep import Outcome, sweep
from amble.synthesis.synthesize import synthesize

__all__ = [
    "GaitProblem",
    "Outcome",
    "default_limits",
    "gait_problem",
    "refine",
    "standing_posture",
    "sweep",
    "synthesize",
]
