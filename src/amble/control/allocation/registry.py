"""Laws by name, as files and the command line give them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amble.control.allocation.bounded_minimum_norm import BoundedMinimumNorm
from amble.control.allocation.drop_actuator import DropActuator
from amble.control.allocation.law import AllocationLaw
from amble.control.allocation.minimum_peak import MinimumPeak
from amble.control.allocation.minimum_power import MinimumPower
from amble.control.allocation.pseudo_inverse import PseudoInverse
from amble.control.allocation.weighted_minimum_norm import WeightedMinimumNorm
from amble.errors import InputError, UnknownNameError

LAWS: Mapping[str, type[AllocationLaw]] = {
    "pinv": PseudoInverse,
    "drop": DropActuator,
    "weighted": WeightedMinimumNorm,
    "power": MinimumPower,
    "peak": MinimumPeak,
    "bounded": BoundedMinimumNorm,
}


def law_from(name: str, parameters: Mapping[str, Any]) -> AllocationLaw:
    """Rebuild a law from its name and parameters.

    Raises:
        UnknownNameError: there is no such law.
        InputError: the parameters are not the law's.
    """
    if name not in LAWS:
        raise UnknownNameError("allocation law", name, LAWS)
    plain = {key: tuple(value) if isinstance(value, list) else value for key, value in parameters.items()}
    try:
        return LAWS[name](**plain)
    except TypeError as error:
        raise InputError(f"parameters of allocation law '{name}' do not fit: {error}") from None
