"""The battery: eighteen walks of one gait in MuJoCo, each wrong in another way, and what counts as passed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from amble.amounts import check_amount
from amble.control import AllocationLaw
from amble.errors import InputError
from amble.gait import Gait
from amble.io.facts import rows_html
from amble.progress import Progress, ProgressReport, silent
from amble.simulation import Trace
from amble.types import Json
from amble.validation.cases import BATTERY, BEHIND, Case, Scales
from amble.validation.loop import MOST_CYCLES, Loop, Schedule, Walk
from amble.validation.mujoco_model import mujoco_model
from amble.validation.walk_trace import interval_of, walk_trace

CYCLES = 60

SPEED_BAND, SLIP_BAND = 0.15, 0.02
"""A walk passes with the gait's speed within the first share, and a mean slip below the second share of the way."""


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
    of the distance, and no link came to the ground with its origin or its centre of mass; where a push or a step of the
    ground is to be met, it was.

    Args:
        gait: the gait, under its control law.
        law: another allocation law than the gait's.
        cases: what is tried.
        cycles: gait cycles of a walk.
        seed: of the noise.
        absolute: take the cases' figures as they are, instead of scaling them to the robot.
        progress: called before every case.
        record: keep the motion of every walk, ``CaseResult.trace``.

    Raises:
        InputError: the gait cannot be exported or does not walk on level ground, its robot moves in the plane, the
            cycles are not from 1 to 10,000, or MuJoCo is not installed.
        WorkError: there is no C compiler, or it fails.
    """
    if not gait.pattern.ground.level:
        raise InputError("a validation walks on level ground; this gait was made for another")
    check_amount("cycles", cycles, 1, MOST_CYCLES)
    notify, robot = progress or silent, gait.robot
    scales = Scales() if absolute else Scales.of(robot)
    loop, found = Loop(gait, law, scales.confirm), list[CaseResult]()
    for number, case in enumerate(cases):
        notify(ProgressReport(what=f"case '{case.name}'", done=number, of=len(cases)))
        plant, schedule = scales.applied(case, gait)
        model, every = mujoco_model(robot, plant), interval_of(gait, plant.step) if record else 0
        walk = loop(model, replace(schedule, cycles=cycles, seed=seed), every)
        trace = walk_trace(gait, model, walk, cycles) if record else None
        why = _failures(gait, case, walk, cycles, schedule)
        found.append(CaseResult(case=case, walk=walk, feet=len(robot.feet), failures=why, trace=trace))
    return Validation(
        gait=gait.pattern.name,
        robot=robot.name,
        cycles=cycles,
        scales=(scales.mass, scales.length, scales.time),
        results=tuple(found),
        seed=seed,
    )


def _failures(gait: Gait, case: Case, walk: Walk, cycles: int, schedule: Schedule) -> tuple[str, ...]:
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
    if any(case.push) and not walk.time >= schedule.push[4]:
        found.append("the walk ended before the push was over")
    if case.rise and not abs(walk.distance) > BEHIND * gait.robot.leg_length:
        found.append("the walk ended before the step of the ground was behind it")
    return tuple(found)
