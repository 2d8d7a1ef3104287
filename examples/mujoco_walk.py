"""A gait walks in MuJoCo with its exported C controller in the loop, and a replay shows it beside its gait.

Run it: python mujoco_walk.py [GAIT.json] [REPLAY.html]

Without a gait it takes ASTRo's amble of the tests; without a place for the replay it only tells how the walk went. The
extra mujoco and a C compiler are needed.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import amble
from amble.gait.impedance import Impedance
from amble.validation import BATTERY, Validation, validate

ASTRO = Path(__file__).parents[1] / "tests" / "data" / "stabilised-amble.json"


def walked(gait: amble.Gait, cycles: int = 10) -> Validation:
    """Walk once where the plant is the model, and once in the last case of the battery, everything mildly wrong."""
    return validate(gait, cases=(BATTERY[0], BATTERY[-1]), cycles=cycles, record=True)


def main(arguments: list[str]) -> None:
    """Walk, tell, and write the replay where it is asked for."""
    stored = amble.load_gait(arguments[0] if arguments else ASTRO)
    gait = stored if isinstance(stored.control, Impedance) else replace(stored, control=Impedance())
    found = walked(gait)
    print(found)
    if len(arguments) > 1:
        trace = found.results[-1].trace
        Path(arguments[1]).write_text(amble.replay(gait, trace, cycles=5).html(), encoding="utf-8")
        print(f"wrote {arguments[1]}")


if __name__ == "__main__":
    main(sys.argv[1:])
