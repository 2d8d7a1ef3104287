"""Test vectors of an exported controller: arguments, and what the same law answers in Python."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from amble.control.motion_equations import SMALLEST_PIVOT
from amble.errors import InputError
from amble.export.law import StanceLaw, torque_limits
from amble.export.stances import ExportedStance, exported_stances
from amble.gait import Gait
from amble.gait.landing_stances import landings
from amble.hybrid import Stance
from amble.hybrid.system import numeric
from amble.types import IntegerVector, Vector

OK, SATURATED, CONTACT_FORCE, LATE, CONTACT_FLAGS, RANK_LOST, NOT_FINITE, BAD_CLOCK = 0, 1, 2, 4, 8, 16, 32, 64
SILENT = 256
"""Statuses of a step, as the header lists them."""

DAMPING = 1.0
"""Joint damping of the fallback, N m s/rad."""

DISTURBANCE = 0.02
"""Size of the random disturbance of positions (rad) and, ten times that, of rates (rad/s)."""

A_STANCE = 20
SEED = 2026


@dataclass(frozen=True, kw_only=True)
class Vectors:
    """One call of the controller right after the entry of a stance at time 0, and its answer."""

    stance: int
    clock: float
    positions: Vector
    velocities: Vector
    contact: IntegerVector
    torques: Vector
    forces: Vector
    status: int

    def line(self) -> str:
        """One line of the file: numbers that read back exactly, in the order of the attributes."""
        return " ".join(
            [str(self.stance), repr(float(self.clock))]
            + [repr(float(value)) for value in (*self.positions, *self.velocities)]
            + [str(int(flag)) for flag in self.contact]
            + [repr(float(value)) for value in (*self.torques, *self.forces)]
            + [str(self.status)]
        )


def test_vectors(gait: Gait, laws: Sequence[StanceLaw]) -> list[Vectors]:
    """Calls along the gait, disturbed, in every stance, then one for every documented way to fail."""
    generator = np.random.default_rng(SEED)
    found: list[Vectors] = []
    for number, entry in enumerate(exported_stances(gait)):
        solved = entry.law if entry.law < len(gait.domains) else _following(gait, laws[entry.law].stance)
        for clock, q, v in _states(gait, solved, generator):
            positions, velocities = (gait.robot.mirror.position(a) if entry.mirrored else a for a in (q, v))
            found.append(_answer(gait, laws, number, entry, clock, positions, velocities))
    lands = next(number for number, entry in enumerate(exported_stances(gait)) if not entry.lifts)
    return [*found, *_failures(gait, next(one for one in found if one.stance == lands))]


# pytest would take the name for a test
test_vectors.__test__ = False  # type: ignore[attr-defined]


def smallest_pivot(gait: Gait, laws: Sequence[StanceLaw]) -> float:
    """Return the smallest pivot along the optimised motion.

    Raises:
        InputError: where the outputs lose their rank along it, so that no share of it could tell a lost rank.
    """
    found = []
    for law, part in zip(laws[: len(gait.domains)], gait.domains, strict=True):
        for clock, q, v in zip(part.times, part.positions, part.velocities, strict=True):
            found.append(float(law.function(clock, np.concatenate([q, v]), law.parameters)[2]))
    smallest = float(np.min(found))
    if not smallest > SMALLEST_PIVOT:
        raise InputError(
            f"the outputs of the gait lose their rank along its recorded motion (smallest pivot {smallest:.2g}); "
            "`amble check` tells what is wrong with it"
        )
    return smallest


def _following(gait: Gait, stance: Stance) -> int:
    """Number of the solved stance that the landings of a stance lead into."""
    return next(gait.pattern.solved.index(solved) for known, solved in landings(gait) if known == stance)


def _states(gait: Gait, solved: int, generator: np.random.Generator) -> Iterator[tuple[float, Vector, Vector]]:
    """Disturbed states of a solved domain, evenly spaced in time."""
    part = gait.domains[solved]
    for node in np.linspace(0, len(part.times) - 1, A_STANCE).astype(int):
        noise = DISTURBANCE * generator.normal(size=(2, gait.robot.size))
        yield float(part.times[node]), part.positions[node] + noise[0], part.velocities[node] + 10.0 * noise[1]


def _answer(
    gait: Gait, laws: Sequence[StanceLaw], number: int, entry: ExportedStance, clock: float, q: Vector, v: Vector
) -> Vectors:
    """Evaluate the law of a stance as the controller does: mirror, law, mirror, saturation."""
    robot, law, mirrored = gait.robot, laws[entry.law], entry.mirrored
    state = np.concatenate([q, v])
    torques, forces, _, margin = (
        numeric(part) for part in law.function(clock, robot.mirror.state(state) if mirrored else state, law.parameters)
    )
    if mirrored:
        torques, forces = robot.mirror.torque(torques), gait.pattern.all_contacts.mirror(forces)
    limit = torque_limits(gait)
    status = (SATURATED if np.any(np.abs(torques) > limit) else OK) | (CONTACT_FORCE if margin[0] < 0.0 else OK)
    contact = np.array([foot in entry.stance.feet for foot in robot.foot_names], dtype=np.int64)
    return Vectors(
        stance=number,
        clock=clock,
        positions=q,
        velocities=v,
        contact=contact,
        torques=np.clip(torques, -limit, limit),
        forces=forces,
        status=status,
    )


def _failures(gait: Gait, sound: Vectors) -> list[Vectors]:
    """A position and a rate that are not numbers, time before the entry, and no foot on the ground.

    Without one the controller stays in a stance that a landing ends.
    """
    limit, joints = torque_limits(gait), len(gait.robot.joints)

    def fallen(status: int, clock: float, q: Vector, v: Vector) -> Vectors:
        rates = np.where(np.isfinite(v[-joints:]), v[-joints:], 0.0)
        torques = np.clip(-DAMPING * rates, -limit, limit)
        return Vectors(
            stance=sound.stance,
            clock=clock,
            positions=q,
            velocities=v,
            contact=sound.contact,
            torques=torques,
            forces=np.zeros_like(sound.forces),
            status=status,
        )

    lost_position, lost_rate = sound.positions.copy(), sound.velocities.copy()
    lost_position[2], lost_rate[-1] = np.nan, np.inf
    return [
        fallen(NOT_FINITE, sound.clock, lost_position, sound.velocities),
        fallen(NOT_FINITE, sound.clock, sound.positions, lost_rate),
        fallen(BAD_CLOCK, -1.0, sound.positions, sound.velocities),
        fallen(NOT_FINITE, np.nan, sound.positions, sound.velocities),
        Vectors(
            stance=sound.stance,
            clock=sound.clock,
            positions=sound.positions,
            velocities=sound.velocities,
            contact=np.zeros_like(sound.contact),
            torques=sound.torques,
            forces=sound.forces,
            status=sound.status | CONTACT_FLAGS,
        ),
    ]
