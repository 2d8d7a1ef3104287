"""Turns about the vertical that a gait's law does not see: proved on what the law writes, or refused by name.

Of level ground a turn is a symmetry by mechanics; what remains is the law (docs/theory/proof.md, section 5).
``ControlLaw.keeps`` is a law's word for it, which no proof believes.
"""

from __future__ import annotations

from collections.abc import Collection

import casadi as ca

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import symmetries
from amble.gait.control_law import ControlLaw, Numbers, TorqueLaw
from amble.gait.linearising_law import InputOutputLinearisation, control_of
from amble.hybrid import Stance, Symmetry
from amble.numerics.unseen import unseen
from amble.proof.identity import generator
from amble.proof.tape import Tape


def turns(gait: Gait, kept: Collection[str]) -> tuple[Tape, ...]:
    """Return the generators of what a gait's law keeps and its half cycle reverses.

    Args:
        gait: the gait.
        kept: names of the symmetries that the half cycle keeps.

    Raises:
        InputError: the law says that it keeps one, and that is not proved.
    """
    control = control_of(gait)
    found = [symmetry for symmetry in symmetries(gait, control) if symmetry.name not in kept]
    for symmetry in found:
        for stance, numbers in zip(gait.pattern.solved, control.numbers(gait, None), strict=True):
            if not _unseen(gait, control, stance, numbers, symmetry):
                raise InputError(
                    f"control law '{control.name}' says that it keeps '{symmetry.name}', and what it writes in domain "
                    f"'{stance.name}' is not proved to be the same along it: no proof of that; let its keeps say no"
                )
    return tuple(map(generator, found))


def _unseen(gait: Gait, control: ControlLaw, stance: Stance, numbers: Numbers, symmetry: Symmetry) -> bool:
    """Whether a law's torques, or its outputs and their phase, do not change along a symmetry, switches included."""
    half = gait.robot.size
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * half)
    q, v = x[:half], x[half:]
    if isinstance(control, TorqueLaw):
        stretches = control.smooth(gait, numbers)
        p = ca.SX.sym("p", stretches[0].parameters.size)
        written = control.smooth_torques(gait.pattern.contacts(stance), t, q, v, p)
    elif isinstance(control, InputOutputLinearisation) and type(control).keeps is InputOutputLinearisation.keeps:
        # that no weight reads the orientation is seen by its keeps, in numbers that are zero or not; the phase is left
        phase, given = gait.outputs.phase, ca.SX.sym("numbers", len(gait.outputs.phase.numbers))
        written = phase.value(gait.robot, stance, t, q, given)
    else:
        return False
    return unseen(ca.SX(written), x, symmetry.generator(x))
