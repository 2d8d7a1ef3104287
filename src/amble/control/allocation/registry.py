"""Laws by name, as files and the command line give them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amble.control.allocation.bounded_minimum_norm import BoundedMinimumNorm
from amble.control.allocation.drop_actuator import DropActuator
from amble.control.allocation.law import AllocationLaw
from amble.control.allocation.minimum_peak import MinimumPeak
from amble.control.allocation.minimum_power import MinimumPower
from amble.control.allocation.weighted_minimum_norm import PseudoInverse, WeightedMinimumNorm
from amble.io.registry import Registry

LAWS: Registry[AllocationLaw] = Registry("allocation law")
"""The laws that files and the command line can name."""

for _name, _law in (
    ("pinv", PseudoInverse),
    ("drop", DropActuator),
    ("weighted", WeightedMinimumNorm),
    ("power", MinimumPower),
    ("peak", MinimumPeak),
    ("bounded", BoundedMinimumNorm),
):
    LAWS.register(_name, _law)


def law_from(name: str, parameters: Mapping[str, Any]) -> AllocationLaw:
    """Rebuild a law from its name and parameters; errors as in ``Registry.build``."""
    return LAWS.build(name, parameters)
