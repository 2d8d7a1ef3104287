"""Gaits of real quadrupeds by default: which are solved, and which of these pass their check."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np

from amble.errors import AmbleError
from amble.hybrid import GaitPattern, gait_pattern
from amble.robot import Robot, load_robot, symmetrized
from amble.synthesis import gait_problem, synthesize
from amble.workflow.specified import until_checked
from benchmarks.figures import Figure, show
from benchmarks.report import FOLDER

FILES = {
    "go2": ("go2_description/urdf/go2.urdf", ("FL_foot", "FR_foot", "RL_foot", "RR_foot"), False),
    "a1": ("a1_description/urdf/a1.urdf", ("FL_foot", "FR_foot", "RL_foot", "RR_foot"), False),
    "solo12": ("solo_description/robots/solo12.urdf", ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"), False),
    "anymal_b": (
        "anymal_b_simple_description/robots/anymal.urdf",
        ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"),
        False,
    ),
    "anymal_c": (
        "anymal_c_simple_description/urdf/anymal.urdf",
        ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"),
        False,
    ),
    "hyq": ("hyq_description/robots/hyq_no_sensors.urdf", ("lf_foot", "rf_foot", "lh_foot", "rh_foot"), True),
}
"""Robot -> file in the wheel example-robot-data, its feet fl, fr, rl, rr, whether symmetrize has to be asked for."""

TABLES = {"pace": (("fl", "rl"), ("fr", "rr")), "bound": (("fl", "fr"), ("rl", "rr"))}
"""Gaits beside the named ones, as tables of stance feet."""

NAMED, SPEEDS = ("trot", "amble"), (0.1, 0.2)
"""Gaits of ``--quick``, and speeds as shares of sqrt(g l), l the leg length."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """What became of one gait.

    Attributes:
        robot: name of the robot.
        gait: name of the gait.
        speed: m/s.
        status: what the solver or a refusal says.
        solved: whether it was solved.
        iterations: of the solver.
        check: whether it passes its check, and how.
        passed: whether it passes.
        seconds: of it all, loading and derivatives too.
    """

    robot: str
    gait: str
    speed: float
    status: str
    solved: bool = False
    iterations: int = 0
    check: str = ""
    passed: bool = False
    seconds: float


def robot(name: str) -> Robot:
    """Load a robot of the fleet."""
    file, feet, symmetrize = FILES[name]
    share = metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share/example-robot-data/robots")
    found = load_robot(Path(str(share)) / file, dict(zip(("fl", "fr", "rl", "rr"), feet, strict=True)), name=name)
    return symmetrized(found) if symmetrize else found


def row(name: str, gait: str, share: float) -> Row:
    """Solve and check one gait with the defaults alone."""
    began, walker = time.perf_counter(), robot(name)
    speed = round(share * float(np.sqrt(walker.gravity * walker.leg_length)), 2)

    def after(status: str, **found: object) -> Row:
        entries = {"robot": name, "gait": gait, "speed": speed, "seconds": time.perf_counter() - began}
        return Row(status=status, **{**entries, **found})  # type: ignore[arg-type]

    try:
        pattern = _pattern(walker, gait)
        problem = gait_problem(pattern.robot if isinstance(pattern, GaitPattern) else walker, pattern, speed=speed)
        solved = synthesize(problem)
    except AmbleError as error:
        return after(str(error).splitlines()[0])
    checked = until_checked(problem, solved)
    said = f"{checked.factor * problem.intervals} intervals" if checked.passed else "; ".join(_kinds(checked.report))
    report = solved.solver
    return after(
        report.status, solved=True, iterations=report.iterations, check=said or "not computed", passed=checked.passed
    )


def measure(quick: bool = False) -> list[Figure]:
    """Solve all rows and write their table.

    Args:
        quick: trot and amble only.
    """
    logging.getLogger("amble").setLevel(logging.ERROR)
    rows = []
    for name in FILES:
        for gait in NAMED if quick else (*NAMED, *TABLES):
            for share in SPEEDS:
                rows.append(row(name, gait, share))
                print(_line(rows[-1]), flush=True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "fleet.md").write_text(table(rows))
    solved, passed = sum(row.solved for row in rows), sum(row.passed for row in rows)
    return [
        Figure("gaits of the fleet solved", float(solved), "", note=f"of {len(rows)}"),
        Figure("of these pass their check", float(passed), "", note=f"of {solved}"),
        Figure("time a gait", float(np.median([row.seconds for row in rows])), "s", note="median, all of it"),
    ]


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a Markdown table."""
    header = "| robot | gait | m/s | solver | iterations | check | s |\n|---|---|---|---|---|---|---|"
    return "\n".join([header, *map(_line, rows)]) + "\n"


def _line(row: Row) -> str:
    check = "" if not row.solved else f"passes, {row.check}" if row.passed else f"fails: {row.check}"
    cells = (row.robot, row.gait, f"{row.speed:g}", row.status, str(row.iterations or ""), check, f"{row.seconds:.0f}")
    return f"| {' | '.join(cells)} |"


def _pattern(walker: Robot, gait: str) -> str | GaitPattern:
    if gait not in TABLES:
        return gait
    from amble.synthesis.problem import on_symmetric

    return on_symmetric(walker, lambda one: gait_pattern(one, TABLES[gait], gait == "pace", name=gait))


def _kinds(report: object) -> list[str]:
    from amble.residual import worst_first
    from amble.verification.residuals import CheckReport

    if not isinstance(report, CheckReport):
        return []
    worst: dict[str, str] = {}
    for failed in worst_first(report.failed):
        worst.setdefault(failed.kind, f"{failed.kind} by {failed.violation:.1e}")
    return list(worst.values())


def main(quick: bool = False) -> None:
    """Print what is measured."""
    show(measure(quick))


if __name__ == "__main__":
    main()
