"""Laws on the command line: ``NAME`` or ``NAME:key=value,key=value``; a value is JSON or plain text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from amble.errors import InputError, shown
from amble.io.reader import parse_json

if TYPE_CHECKING:
    from amble.control.allocation import AllocationLaw
    from amble.gait.control_law import ControlLaw
    from amble.hybrid import GaitPattern

HELP = "Allocation law: pinv, drop, ... or with parameters, such as power:actuator=datasheet."


def parse_law(text: str, pattern: GaitPattern) -> AllocationLaw:
    """Return the law that a word on the command line means, for a gait pattern."""
    from amble.control.laws import law_for

    return law_for(pattern, *_parts(text))


def parse_control(text: str) -> ControlLaw:
    """Return the feedback law that a word on the command line means."""
    import amble.gait.closed_loop  # noqa: F401  (registers the gait's own law)
    from amble.gait.control_law import CONTROL_LAWS

    return CONTROL_LAWS.build(*_parts(text))


def _parts(text: str) -> tuple[str, dict[str, Any]]:
    """Split a word into name and parameters."""
    name, _, rest = text.partition(":")
    parameters: dict[str, Any] = {}
    for part in filter(None, _split(rest)):
        key, mark, value = part.partition("=")
        if not mark:
            raise InputError(f"law '{shown(text)}': '{shown(part)}' is not key=value")
        parameters[key.strip()] = _value(value.strip(), f"law '{shown(text)}'")
    return name, parameters


def _split(text: str) -> list[str]:
    """Split at commas that are not inside brackets."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "[{") - (character in "]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def _value(text: str, what: str) -> Any:
    """What begins like JSON is JSON, bounded and strict as in a file; anything else is a word."""
    begins = text[:1] in '[{"-0123456789' or text in ("true", "false", "null")
    return parse_json(text, what) if text and begins else text
