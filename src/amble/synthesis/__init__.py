"""The gait problem, its transcription and its solution."""

from amble.synthesis.defaults import gait_problem
from amble.synthesis.problem import GaitProblem
from amble.synthesis.refine import refine
from amble.synthesis.solve import Iteration
from amble.synthesis.sweep import Outcome, sweep
from amble.synthesis.synthesize import synthesize

__all__ = ["GaitProblem", "Iteration", "Outcome", "gait_problem", "refine", "sweep", "synthesize"]
