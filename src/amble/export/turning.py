"""What an exported controller has more where its gait turns: it sees states in axes that turn at the end of a cycle."""

from __future__ import annotations

from collections.abc import Mapping

from amble.export.code import filled, template
from amble.gait import Gait
from amble.gait.cycle_end import turning_steps

PLACES = ("TURNING", "TURN_STATE", "TURN_FORCES", "TURN_HEADING")


def turning_code(gait: Gait) -> Mapping[str, str]:
    """Return what stands at ``PLACES`` of the controller's template; nothing for a gait that goes straight."""
    if gait.turn == 0.0:
        return dict.fromkeys(PLACES, "")
    turning, next_foot = turning_steps(gait), "AMBLE_FORCES / AMBLE_FEET"
    turns = ", ".join(str(int(step.name in turning)) for step in gait.pattern.steps)
    return {
        "TURNING": filled(template("turning.c"), {"TURN": repr(gait.turn), "TURNS": turns}),
        "TURN_STATE": "  turn_state(-c->heading, x, x + AMBLE_COORDINATES);\n",
        "TURN_FORCES": f"  for (i = 0; i < AMBLE_FORCES; i += {next_foot}) about_vertical(c->heading, force + i);\n",
        "TURN_HEADING": "    if (TURNS[i]) c->heading = remainder(c->heading + TURN, 6.283185307179586);\n",
    }
