"""One gait of the fleet, a process: ``python -m benchmarks.fleet_row ROBOT GAIT SHARE FOLDER [--checked]``.

It prints the row as a line of JSON after every stage, the last one whole, and writes the gaits into the folder.
"""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from amble.analysis import monitors
from amble.errors import AmbleError, CertificateError, NotSolvedError
from amble.gait import Gait
from amble.gait.files import save_gait
from amble.residual import Residual, worst_first, worst_of_kinds
from amble.robot import Robot, load_robot, symmetrized
from amble.robot.loading import proposed_twins
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from amble.stability import certify
from amble.stability.disturbance import SETTLED
from amble.stability.stabilize import stabilize
from amble.synthesis import gait_problem, synthesize
from amble.verification.residuals import CheckReport
from amble.version import __version__
from amble.workflow.specified import until_checked
from benchmarks.robot_files import FILES

ASYMMETRIC = ("hyq",)
"""Robots whose files differ by more than is averaged unasked; they ask for symmetrize."""

CYCLES, CHANGE = 500, 1e-3
"""Of the walk, and of its start in lengths l and times sqrt(l / g)."""

NAMED = 3
"""Rows that failed of which a reason gives name, value and bound; of others it says how many."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """What became of one gait.

    Attributes:
        robot: name of the robot.
        gait: name of the gait.
        share: speed asked for, as a share of sqrt(g l).
        release: of amble, and the hash of the robot.
        speed: m/s.
        status: what the solver or a refusal says.
        solved: whether it was solved.
        iterations: of the solver.
        check: whether it passes its check, and how.
        passed: whether it passes.
        stability: radius before and after, or why it is not stabilised or certified.
        certified: whether there is a certificate.
        walk: how the walk from a changed start ended.
        walked: whether it made all cycles with sound contacts.
        seconds: of processor time, of it all.
    """

    robot: str
    gait: str
    share: float
    release: str = ""
    speed: float = 0.0
    status: str = ""
    solved: bool = False
    iterations: int = 0
    check: str = ""
    passed: bool = False
    stability: str = ""
    certified: bool = False
    walk: str = ""
    walked: bool = False
    seconds: float = 0.0

    @property
    def key(self) -> tuple[str, str, float]:
        """What is asked."""
        return self.robot, self.gait, self.share

    @property
    def name(self) -> str:
        """Of its files."""
        return f"{self.robot}-{self.gait}-{self.share:g}".replace(" ", "_")


@lru_cache(maxsize=32)
def robot(name: str) -> Robot:
    """Load a robot of the fleet.

    Raises:
        InputError: its file is not there.
    """
    from amble.robot import catalogue

    if name == "astro":  # as a file among files: by its name it has its builders' bounds, of their amble
        return replace(catalogue.load(name), name="astro_file")
    if name == "hexapod":
        from tests.robots import hexapod

        model = hexapod()
        return replace(model, twins=proposed_twins(model.foot_names))
    if name == "planar biped":
        from tests.robots import PLANAR, robot

        return robot(PLANAR)
    file = FILES[name]
    found = load_robot(file.place(), file.feet, name=name)
    return symmetrized(found) if name in ASYMMETRIC else found


def computed(row: Row, folder: Path, whole: bool = True, tell: Callable[[Row], None] | None = None) -> Row:
    """Return a row with everything computed; what fails ends it, with its reason.

    Args:
        row: of the table.
        folder: where its gaits are written.
        whole: whether to stabilise, certify and walk what passes its check.
        tell: called with the row after every stage.
    """
    began = _processor_time()

    def told(row: Row) -> Row:
        row = replace(row, seconds=_processor_time() - began)
        if tell is not None:
            tell(row)
        return row

    try:
        walker = robot(row.robot)
        speed = round(row.share * float(np.sqrt(walker.gravity * walker.leg_length)), 3)
        row = told(replace(row, speed=speed, release=release(row.robot), status="not solved in time"))
        problem = gait_problem(walker, row.gait, speed=speed)
        gait = synthesize(problem)
    except AmbleError as error:
        return told(replace(row, status=reason(error)))
    solver = gait.solver
    row = told(replace(row, status=solver.status, solved=True, iterations=solver.iterations, check="not done in time"))
    save_gait(gait, folder / f"{row.name}.json")
    checked = until_checked(problem, gait)
    said = f"{checked.factor * problem.intervals} intervals" if checked.passed else _failed(checked.report)
    row = told(replace(row, check=said or "not computed", passed=checked.passed))
    save_gait(checked.gait, folder / f"{row.name}.json")
    return told(_walked(row, checked.gait, folder, told)) if whole and checked.passed else row


def _walked(row: Row, gait: Gait, folder: Path, told: Callable[[Row], Row]) -> Row:
    """Stabilise, certify, and walk from a start in which every state is changed."""
    row = told(replace(row, stability="not stabilised in time"))
    try:
        stable = stabilize(gait)
        save_gait(stable, folder / f"{row.name}-stable.json")
        row = told(replace(row, stability="not certified in time"))
        certificate = certify(stable)
    except AmbleError as error:
        return replace(row, stability=reason(error))
    row = told(replace(row, stability=f"{certificate.radius:.3f}", certified=True, walk="not done in time"))
    units = natural_units(gait.robot, gait.robot.leg_length)
    start = certificate.state + units * perturbed(np.zeros(units.size), CHANGE, 0)
    try:
        trace = simulate(stable, start, CYCLES)
        report = monitors(stable, trace)
    except AmbleError as error:
        return replace(row, walk=reason(error))
    sound = trace.completed and report.sound_from is not None and report.sound_from <= SETTLED
    end = trace.ended if not trace.completed else "sound" if sound else "contacts are not sound"
    return replace(row, walk=f"{trace.cycles} cycles, {end}", walked=sound)


def _processor_time() -> float:
    """Of this process and of the compilers that it has waited for, s."""
    return sum(os.times()[:4])


def release(name: str) -> str:
    """Return what a row of a robot is of: amble's release and the hash of the robot."""
    return f"{__version__} {robot(name).hash[:12]}"


def reason(error: AmbleError) -> str:
    """Say in a line why a row ended: the first line of the error, and every row that failed, worst first."""
    first = str(error).splitlines()[0]
    if not isinstance(error, CertificateError | NotSolvedError):
        return first
    failed = worst_first(row for row in error.rows if not row.passed)
    return f"{first}: {_named(failed)}" if failed else first


def _named(failed: Sequence[Residual]) -> str:
    """Name the rows that failed, each with its value and the bound that it leaves; of many the first ones."""
    told = [f"{row.name} is {row.value:.3g}, {_bound(row)}" for row in failed[:NAMED]]
    return "; ".join(told if len(failed) <= NAMED else [*told, f"and {len(failed) - NAMED} more"])


def _bound(row: Residual) -> str:
    return f"at least {row.lower:.3g}" if not row.value >= row.lower else f"at most {row.upper:.3g}"


def _failed(report: CheckReport | None) -> str:
    """Name the worst row of every kind that fails a check."""
    return "" if report is None else _named(list(worst_of_kinds(report.failed).values()))


def main(arguments: list[str]) -> None:
    """Compute one row and print it as JSON, after every stage."""
    logging.getLogger("amble").setLevel(logging.ERROR)
    name, gait, share, folder, *options = arguments

    def tell(row: Row) -> None:
        print(json.dumps(asdict(row)), flush=True)

    computed(Row(robot=name, gait=gait, share=float(share)), Path(folder), "--checked" not in options, tell)


if __name__ == "__main__":
    main(sys.argv[1:])
