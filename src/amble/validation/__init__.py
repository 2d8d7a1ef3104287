"""A gait's exported controller on a robot that another physics engine moves."""

from amble.validation.battery import CaseResult, Validation, validate
from amble.validation.cases import BATTERY, MORE, Case

__all__ = ["BATTERY", "MORE", "Case", "CaseResult", "Validation", "validate"]
