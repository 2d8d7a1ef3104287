"""The battery: eighteen walks of one gait in MuJoCo, each wrong in another way, and what counts as passed.

Sizes are those of ASTRo's amble in its robot's natural units, m g l of a torque, sqrt(l / g) of a time, ...; so a case
is as hard for a robot of another size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from amble.amounts import check_amount
from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait import Gait
from amble.io.facts import rows_html
from amble.progress import Progress, ProgressReport, silent
from amble.simulation import Trace
from amble.types import Json
from amble.validation.loop import MOST_CYCLES, Loop, Schedule, Walk
from amble.validation.mujoco_model import HARD, POINT, Plant, mujoco_model
from amble.validation.walk_trace import interval_of, walk_trace

CYCLES = 60

ASTRO_MASS, ASTRO_LENGTH, ASTRO_GRAVITY = 21.5, 0.87628, 9.81
"""The robot whose figures the cases are written in, kg, m, m/s^2."""

SPEED_BAND, SLIP_BAND = 0.15, 0.02
"""A walk passes with the gait's speed within the first share, and a mean slip below the second share of the way."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One way in which a plant and its measurements differ from the model; figures at ASTRo's size, SI units.

    Attributes:
        name: what differs.
        friction: coefficient between feet and ground.
        period: of the controller, s; 0 at every step of the plant.
        delay: until a command arrives, s.
        damping: of the joints, N m s/rad.
        dry_friction: of the joints, N m.
        armature: rotor inertia of the joints, kg m^2.
        balanced: link inertias made physical, as MuJoCo does by itself.
        trunk: factor of the base link's mass and inertia.
        softness: time constant of the contacts, s.
        radius: of the feet, m.
        noise_angle: standard deviation of joint angles, rad.
        noise_rate: of joint rates, rad/s.
    """

    name: str
    friction: float = 0.8
    period: float = 0.0
    delay: float = 0.0
    damping: float = 0.0
    dry_friction: float = 0.0
    armature: float = 0.0
    balanced: bool = False
    trunk: float = 1.0
    softness: float = HARD
    radius: float = POINT
    noise_angle: float = 0.0
    noise_rate: float = 0.0


BATTERY = (
    Case(name="nominal"),
    Case(name="friction 0.6", friction=0.6),
    Case(name="friction 0.45", friction=0.45),
    Case(name="1 kHz, 1 ms delay", period=1e-3, delay=1e-3),
    Case(name="500 Hz, 2 ms delay", period=2e-3, delay=2e-3),
    Case(name="damping 0.1", damping=0.1),
    Case(name="damping 0.5", damping=0.5),
    Case(name="dry friction 0.3", dry_friction=0.3),
    Case(name="dry friction 1", dry_friction=1.0),
    Case(name="armature 0.01", armature=0.01),
    Case(name="armature 0.05", armature=0.05),
    Case(name="balanced inertias", balanced=True),
    Case(name="trunk +10 %", trunk=1.1),
    Case(name="trunk -10 %", trunk=0.9),
    Case(name="soft contact 20 ms", softness=0.02),
    Case(name="feet of 20 mm", radius=0.02),
    Case(name="noise", noise_angle=1e-3, noise_rate=0.05),
    Case(
        name="all, mildly", friction=0.6, period=1e-3, delay=1e-3, damping=0.1, dry_friction=0.3, armature=0.01,
        trunk=1.05, radius=0.01, noise_angle=1e-3, noise_rate=0.05,
    ),
)  # fmt: skip
"""Realism cases, at ASTRo's size."""

STEP, CONFIRM, THRESHOLD = 5e-4, 1e-3, 5.0
"""Step of the plant, s, time that confirms a contact, s, and the force that sets a flag, N, at ASTRo's size."""


HEADER = ("case", "cycles", "speed (m/s)", "RMS (N m)", "peak (N m)", "slip (%)", "outcome")


@dataclass(frozen=True, kw_only=True)
class CaseResult:
    """One case and what became of it.

    Attributes:
        case: as it was tried, figures at ASTRo's size.
        walk: what the walk came to.
        feet: of the robot.
        failures: why it does not pass, in words; empty where it does.
        trace: the walk's motion, where it was recorded.
    """

    case: Case
    walk: Walk
    feet: int
    failures: tuple[str, ...]
    trace: Trace | None = None

    @property
    def passed(self) -> bool:
        """Whether it passed."""
        return not self.failures

    @property
    def speed(self) -> float:
        """Mean speed along x, m/s."""
        return self.walk.distance / max(self.walk.time, 1e-9)

    @property
    def slip(self) -> float:
        """Mean way that a foot slips, over the distance."""
        return self.walk.slip / self.feet / max(abs(self.walk.distance), 1e-9)

    @property
    def cells(self) -> tuple[str, ...]:
        """Its numbers as a table shows them."""
        walk, slip = self.walk, f"{100.0 * self.slip:.2f}"
        return str(walk.cycles), f"{self.speed:.3f}", f"{walk.rms:.3g}", f"{walk.peak:.3g}", slip


@dataclass(frozen=True, kw_only=True)
class Validation:
    """A battery and its results.

    Attributes:
        gait: name of the gait.
        robot: name of the robot.
        cycles: asked for.
        scales: mass, length and time by which the cases were scaled.
        results: case by case.
        seed: of the noise.
    """

    gait: str
    robot: str
    cycles: int
    scales: tuple[float, float, float]
    results: tuple[CaseResult, ...]
    seed: int

    @property
    def passed(self) -> int:
        """How many cases passed."""
        return sum(result.passed for result in self.results)

    @property
    def upright(self) -> int:
        """In how many cases all cycles were walked, whatever the speed and the slip."""
        return sum(result.walk.cycles == self.cycles and not result.walk.fell for result in self.results)

    def __str__(self) -> str:
        """Return one line a case, in columns, and the count."""
        rows = [HEADER, *self._rows]
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
        upright = f"{self.upright} of {len(self.results)} cases walked all {self.cycles} cycles upright"
        return "\n".join([*lines, f"{upright}; {self.passed} of {len(self.results)} passed"])

    def _repr_html_(self) -> str:
        """Show the cases as a table in a notebook."""
        title = f"{self.gait} of {self.robot} in MuJoCo: {self.passed} of {len(self.results)} cases passed"
        return rows_html(title, HEADER, self._rows)

    @property
    def _rows(self) -> list[tuple[str, ...]]:
        return [(result.case.name, *result.cells, "; ".join(result.failures) or "passed") for result in self.results]

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        mass, length, time = self.scales
        return {
            "gait": self.gait,
            "robot": self.robot,
            "cycles": self.cycles,
            "seed": self.seed,
            "scales": {"mass": mass, "length": length, "time": time},
            "passed": self.passed,
            "upright": self.upright,
            "of": len(self.results),
            "cases": [
                {
                    "case": dict(vars(result.case)),
                    "passed": result.passed,
                    "failures": list(result.failures),
                    "cycles": result.walk.cycles,
                    "speed_m_s": result.speed,
                    "rms_torque_N_m": result.walk.rms,
                    "peak_torque_N_m": result.walk.peak,
                    "slip_share": result.slip,
                    "sideways_m": result.walk.sideways,
                    "time_s": result.walk.time,
                }
                for result in self.results
            ],
        }


def validate(
    gait: Gait,
    law: AllocationLaw | None = None,
    cases: Sequence[Case] = BATTERY,
    cycles: int = CYCLES,
    seed: int = 1,
    absolute: bool = False,
    progress: Progress | None = None,
    record: bool = False,
) -> Validation:
    """Walk a gait in MuJoCo, once a case, with its exported C controller in the loop.

    A walk passes where all cycles are walked upright, at the gait's speed within 15 %, a foot's mean slip is below 2 %
    of the distance, and no link came to the ground with its origin or its centre of mass.

    Args:
        gait: the gait, under control law ``Impedance``.
        law: another allocation law than the gait's.
        cases: what is tried.
        cycles: gait cycles of a walk.
        seed: of the noise.
        absolute: take the cases' figures as they are, instead of scaling them to the robot.
        progress: called before every case.
        record: keep the motion of every walk, ``CaseResult.trace``.

    Raises:
        InputError: the gait is under another control law, does not walk on level ground, the cycles are not from 1 to
            10,000, or MuJoCo is not installed.
        WorkError: there is no C compiler, or it fails.
    """
    if not gait.pattern.ground.level:
        raise InputError("a validation walks on level ground; this gait was made for another")
    check_amount("cycles", cycles, 1, MOST_CYCLES)
    notify, robot = progress or silent, gait.robot
    gravity = robot.gravity
    mass, length = (1.0, 1.0) if absolute else (robot.mass / ASTRO_MASS, robot.leg_length / ASTRO_LENGTH)
    time = 1.0 if absolute else float(np.sqrt(length * ASTRO_GRAVITY / gravity))
    loop, found = Loop(gait, law, CONFIRM * time), list[CaseResult]()
    for number, case in enumerate(cases):
        notify(ProgressReport(what=f"case '{case.name}'", done=number, of=len(cases)))
        plant, schedule = _scaled(case, mass, length, time, gravity if not absolute else ASTRO_GRAVITY)
        model, every = mujoco_model(robot, plant), interval_of(gait, plant.step) if record else 0
        walk = loop(model, replace(schedule, cycles=cycles, seed=seed), every)
        trace = walk_trace(gait, model, walk, cycles) if record else None
        why = _failures(gait, walk, cycles)
        found.append(CaseResult(case=case, walk=walk, feet=len(robot.feet), failures=why, trace=trace))
    return Validation(
        gait=gait.pattern.name, robot=robot.name, cycles=cycles, scales=(mass, length, time), results=tuple(found),
        seed=seed,
    )  # fmt: skip


def _scaled(case: Case, mass: float, length: float, time: float, gravity: float) -> tuple[Plant, Schedule]:
    """Scale a case from ASTRo's size."""
    step, torque = STEP * time, mass * length * gravity / ASTRO_GRAVITY
    plant = Plant(
        step=step,
        friction=case.friction,
        radius=case.radius * length,
        softness=case.softness * time,
        damping=case.damping * torque * time,
        dry_friction=case.dry_friction * torque,
        armature=case.armature * mass * length**2,
        trunk=case.trunk,
        balanced=case.balanced,
    )
    schedule = Schedule(
        cycles=1,
        period=case.period * time or step,
        delay=case.delay * time,
        threshold=THRESHOLD * mass * gravity / ASTRO_GRAVITY,
        noise_angle=case.noise_angle,
        noise_rate=case.noise_rate / time,
    )
    return plant, schedule


def _failures(gait: Gait, walk: Walk, cycles: int) -> tuple[str, ...]:
    found = []
    if walk.fell:
        found.append(f"fell after {walk.time:.3g} s")
    elif walk.cycles < cycles:
        found.append(f"walked {walk.cycles} cycles only")
    speed = walk.distance / max(walk.time, 1e-9)
    if not abs(speed - gait.speed) <= SPEED_BAND * abs(gait.speed):
        found.append(f"speed {speed:.3g} m/s, not {gait.speed:g} within {SPEED_BAND:.0%}")
    slip = walk.slip / len(gait.robot.feet) / max(abs(walk.distance), 1e-9)
    if not slip <= SLIP_BAND:
        found.append(f"feet slip {slip:.1%} of the distance")
    if not walk.deepest < 0.0:
        found.append("a link came to the ground")
    return tuple(found)
