"""From a guess to a proof: the point in high precision, the orbit in a box, its stability, its basin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from flint import arb

from amble.amounts import check_amount
from amble.errors import InputError
from amble.gait import Gait
from amble.hybrid import HybridSystem
from amble.progress import Progress, silent
from amble.proof.arithmetic import working_precision
from amble.proof.basin import prove_basin
from amble.proof.gait_map import gait_map, require_provable, require_smooth
from amble.proof.orbit import prove_orbit, refined
from amble.proof.record import Proof, proof_of
from amble.proof.record_distance import distances
from amble.proof.return_map import ReturnMap
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.fixed_point import fixed_point
from amble.types import Vector


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How hard to try.

    Attributes:
        bits: of the arithmetic, from 64 to 1024.
        order: of the Taylor steps, from 4 to 40.
        tolerance: size of a step's remainder that the step length aims at.
        radius: of the box about the fixed point.
        basin: the largest change of a coordinate that is tried for the basin; 0 for no basin.
    """

    bits: int = 128
    order: int = 20
    tolerance: float = 1e-25
    radius: float = 1e-19
    basin: float = 1e-2

    def __post_init__(self) -> None:
        """Refuse what no proof takes, or what takes without end."""
        check_amount("bits", self.bits, 64, 1024)
        check_amount("orders of the Taylor steps", self.order, 4, 40)
        for name in ("tolerance", "radius"):
            if not 0.0 < vars(self)[name] <= 1.0:
                raise InputError(f"the {name} of a proof is a number above 0 and up to 1, not {vars(self)[name]:g}")
        if not 0.0 <= self.basin <= 1.0:
            raise InputError(f"the basin that is tried is a number from 0 to 1, not {self.basin:g}")


GAIT_SETTINGS = Settings(bits=128, order=24, tolerance=1e-25, radius=1e-18, basin=4e-10)
"""What the gait of `amble reproduce` needs: the enclosed derivative is about 1e8 times as wide as the box, and no
contraction follows on a ball that reaches 4e-10."""


def prove(
    system: HybridSystem, guess: Vector, settings: Settings | None = None, progress: Progress | None = None
) -> Proof:
    """Prove a periodic orbit of a hybrid system and what can be proved of its stability.

    Args:
        system: given by casadi expressions.
        guess: state at the entry of the first domain near the fixed point, (n_x,).
        settings: how hard to try.
        progress: called after every pass through the cycle.

    Raises:
        InputError: the system holds compiled code, symmetries that are no translations, or simultaneous guards; or the
            guess is of another size.
        ProofError: existence could not be proved, and why.
    """
    chosen = settings or Settings()
    near = np.asarray(guess, dtype=np.float64)
    if near.shape != (system.state_size,):
        raise InputError(f"a guess of shape {near.shape} for a system of {system.state_size} states")
    start = fixed_point(system, near, progress=progress).state
    with working_precision(chosen.bits):
        return _prove(ReturnMap.of(system, chosen.order, chosen.tolerance), start, chosen, progress)


def prove_gait(gait: Gait, settings: Settings | None = None, progress: Progress | None = None) -> Proof:
    """Prove the periodic orbit of a gait's closed loop, that its contacts and limits hold, and its stability.

    Of a mirrored gait half a cycle is proved, closed by the mirror: multipliers of the full cycle are the squares.

    Args:
        gait: the gait.
        settings: how hard to try.
        progress: called after every pass through the cycle.

    Raises:
        InputError: the loop is no solution of linear equations, or its switches are not single landings.
        NotSolvedError, FallError: the closed loop has no fixed point near the gait.
        ProofError: existence or a margin could not be proved, and why.
    """
    chosen = settings or GAIT_SETTINGS
    require_provable(gait)
    system, found = closed_loop_fixed_point(gait, progress)
    with working_precision(chosen.bits):
        prepared = gait_map(gait, system, chosen.order, chosen.tolerance)
        require_smooth(prepared, found.monodromy.durations)
        return _prove(prepared, found.state, chosen, progress, gait)


def _prove(
    prepared: ReturnMap, start: Vector, chosen: Settings, progress: Progress | None, gait: Gait | None = None
) -> Proof:
    prepared = replace(prepared, progress=progress or silent)
    centre = refined(prepared, start, chosen.radius * 1e-3, progress)
    orbit = prove_orbit(prepared, centre, [arb(chosen.radius)] * len(centre))
    basin, limit = None, ""
    if orbit.stable and chosen.basin > 0.0:
        basin, limit = prove_basin(prepared, orbit, chosen.basin, progress)
    if gait is None:
        return proof_of(prepared, orbit, (basin, limit), chosen.bits, {})
    apart = distances(gait, gait.robot, prepared, orbit, room=True)
    return proof_of(prepared, orbit, (basin, limit), chosen.bits, apart, half=gait.pattern.mirrored)
