"""A gait's exported controller on a robot that another physics engine moves."""

from amble.validation.battery import BATTERY, Case, CaseResult, Validation, validate

__all__ = ["BATTERY", "Case", "CaseResult", "Validation", "validate"]
