"""Allocation laws by name for a given gait pattern, with the parameters that follow from the pattern."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amble.control.allocation import AllocationLaw, DropActuator, law_from
from amble.control.outputs import left_out
from amble.errors import InputError
from amble.hybrid import GaitPattern


def law_for(pattern: GaitPattern, name: str, parameters: Mapping[str, Any] | None = None) -> AllocationLaw:
    """Return a law by name; "drop" without parameters switches off what the paper's baseline does.

    Args:
        pattern: the gait pattern.
        name: name of the law.
        parameters: of the law.

    Raises:
        UnknownNameError: there is no such law.
        InputError: the parameters are not the law's, or the pattern has no default for "drop".
    """
    if name == DropActuator(()).name and not parameters:
        return paper_baseline(pattern)
    return law_from(name, parameters or {})


def paper_baseline(pattern: GaitPattern) -> DropActuator:
    """Return the law of Ma et al. (2019) as the paper uses it: the hip pitch of the rear stance leg is off.

    Where that joint carries little of the internal force, as in a bound, another is off (``left_out``).

    Raises:
        InputError: a stance of more than two feet, for which the paper names no joint.
    """
    for stance in pattern.stances:
        if len(stance.feet) > 2:
            raise InputError(
                f"which actuators stance '{stance.name}' with {len(stance.feet)} feet drops has no default; "
                "name them: joints of the law 'drop'"
            )
    dropped = (joint for stance in pattern.stances for joint in left_out(pattern, stance))
    return DropActuator(tuple(dict.fromkeys(dropped)))
