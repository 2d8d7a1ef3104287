"""The closed loop of a stance as an interpreted function, at random states about a walking posture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from amble.control import AllocationLaw, DropActuator, PseudoInverse
from amble.control.linearisation import Linearised, linearise
from amble.control.outputs import joint_outputs, selection_matrix
from amble.control.virtual_constraints import VirtualConstraints, pack
from amble.hybrid import Contacts, Stance
from amble.hybrid.gaits import amble
from amble.robot import Robot
from amble.types import Matrix, Vector
from tests.control.allocation.stances import random_postures
from tests.robots import robot

ORDER = 4
LAWS: dict[str, AllocationLaw] = {
    "pinv": PseudoInverse(),
    "drop": DropActuator(("rl_hip_pitch", "rr_hip_pitch")),
}


@dataclass(frozen=True)
class Symbols:
    """Arguments of a loop: q, v, t and the constraints."""

    q: ca.SX
    v: ca.SX
    t: ca.SX
    constraints: VirtualConstraints

    @property
    def arguments(self) -> list[ca.SX]:
        """As a function takes them."""
        return [self.q, self.v, self.t, self.constraints.packed()]


def symbols(of: Robot, outputs: int = 11, order: int = ORDER) -> Symbols:
    n = of.size
    return Symbols(
        ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("t"), VirtualConstraints.symbols(outputs, n - 3, order)
    )


def expressions(feet: tuple[str, ...], law: str, outputs: int = 11) -> tuple[Symbols, Linearised]:
    """The closed loop of astro on some feet."""
    at = symbols(robot("astro"), outputs)
    rates = at.constraints.phase_rates(robot("astro"), Stance("S", feet), at.t, at.q, at.v)
    return at, linearise(Contacts(robot("astro"), feet), LAWS[law], at.q, at.v, rates, at.constraints)


@lru_cache(maxsize=8)
def loop(feet: tuple[str, ...], law: str, outputs: int = 11) -> ca.Function:
    """(q, v, t, p) -> acceleration, torques, forces, pivots, null torques."""
    at, linearised = expressions(feet, law, outputs)
    parts = [
        linearised.acceleration,
        linearised.torques,
        linearised.forces,
        linearised.equations.pivots,
        linearised.redundancy.torque_basis,
    ]
    return ca.Function("loop", at.arguments, [ca.densify(part) for part in parts])


def solved_stances() -> tuple[Stance, ...]:
    return amble(robot("astro")).solved


def weights(stance: Stance) -> Matrix:
    """H_0 of a stance of the amble."""
    return selection_matrix(robot("astro"), joint_outputs(amble(robot("astro"))).of(stance.name))


@dataclass(frozen=True)
class Sample:
    """A state with a clock and the numbers of a constraints."""

    q: Vector
    v: Vector
    t: float
    duration: float
    gains: tuple[float, float]
    references: Matrix

    def arguments(self, chosen: Matrix) -> tuple[Vector, Vector, float, Vector]:
        return self.q, self.v, self.t, pack(self.duration, self.gains, self.references, chosen)


def samples(count: int, seed: int = 0, mixed: bool = False) -> list[tuple[Sample, Matrix | None]]:
    """Random states of astro with references near them; where mixed, with random full weights too."""
    generator = np.random.default_rng(seed + 100)
    found: list[tuple[Sample, Matrix | None]] = []
    for q, v in zip(*random_postures("astro", count, seed), strict=True):
        references = q[3:, None] + generator.normal(0.0, 0.1, (q.size - 3, ORDER + 1))
        sample = Sample(q, v, float(generator.uniform(0.0, 0.2)), 0.2, (100.0, 20.0), references)
        found.append((sample, generator.normal(size=(11, q.size - 3)) if mixed else None))
    return found
