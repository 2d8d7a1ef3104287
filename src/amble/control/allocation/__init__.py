"""Allocation laws, one a file."""

from amble.control.allocation.bounded_minimum_norm import BoundedMinimumNorm, ContactLimits, margins
from amble.control.allocation.drop_actuator import DropActuator
from amble.control.allocation.law import AllocationLaw, Redundancy
from amble.control.allocation.minimum_peak import MinimumPeak
from amble.control.allocation.minimum_power import MinimumPower
from amble.control.allocation.registry import LAWS, law_from
from amble.control.allocation.weighted_minimum_norm import PseudoInverse, WeightedMinimumNorm

__all__ = [
    "LAWS",
    "AllocationLaw",
    "BoundedMinimumNorm",
    "ContactLimits",
    "DropActuator",
    "MinimumPeak",
    "MinimumPower",
    "PseudoInverse",
    "Redundancy",
    "WeightedMinimumNorm",
    "law_from",
    "margins",
]
