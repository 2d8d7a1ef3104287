"""Gaits of real robots by default: solved, checked, stabilised, certified, and walked from changed starts.

Rows are fixed in ``rows``. Each is written when it is finished, and a run goes on where one before ended: what
``fleet.json`` beside the report has from the same release and the same robot is not computed again. Delete it to begin
afresh.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from amble.analysis import monitors
from amble.errors import AmbleError
from amble.gait import Gait
from amble.io.storage import atomic_write
from amble.robot import Robot, load_robot, symmetrized
from amble.robot.loading import proposed_twins
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from amble.stability import certify
from amble.stability.disturbance import SETTLED
from amble.stability.stabilize import stabilize
from amble.synthesis import gait_problem, synthesize
from amble.version import __version__
from amble.workflow.specified import until_checked
from benchmarks.figures import Figure, show
from benchmarks.report import FOLDER
from benchmarks.robot_files import FILES

ASYMMETRIC = ("hyq",)
"""Robots whose files differ by more than is averaged unasked; they ask for symmetrize."""

FOUR = ("trot", "amble", "pace", "bound", "walk", "crawl", "running trot")
PRONKING = ("go2", "solo12")
OTHERS = {"bolt": ("walk", "run"), "hexapod": ("tripod",), "planar biped": ("walk", "run")}
QUICK, QUICK_ROBOTS = ("trot", "amble"), ("go2", "a1", "solo12", "anymal_b", "anymal_c", "hyq")
SPEEDS = (0.1, 0.2)
"""Shares of sqrt(g l), l the leg length."""

CYCLES, CHANGE = 500, 1e-3
"""Of the walk, and of its start in lengths l and times sqrt(l / g)."""


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


@lru_cache(maxsize=32)
def robot(name: str) -> Robot:
    """Load a robot of the fleet.

    Raises:
        InputError: its file is not there.
    """
    from amble.robot import catalogue

    if name == "astro":
        return catalogue.load(name)
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


def rows(quick: bool = False) -> list[Row]:
    """Return every row of the table, nothing of it computed."""
    if quick:
        names: dict[str, tuple[str, ...]] = dict.fromkeys(QUICK_ROBOTS, QUICK)
    else:
        names = {name: FOUR for name in ("astro", *FILES)} | OTHERS
        names |= {name: (*FOUR, "pronk") for name in PRONKING}
    return [
        Row(robot=name, gait=gait, share=share) for name, gaits in names.items() for gait in gaits for share in SPEEDS
    ]


def computed(row: Row, whole: bool = True) -> Row:
    """Return a row with everything computed; what fails ends it, with its reason.

    Args:
        row: a row of ``rows``.
        whole: whether to stabilise, certify and walk what passes its check.
    """
    began = _processor_time()
    try:
        walker = robot(row.robot)
        speed = round(row.share * float(np.sqrt(walker.gravity * walker.leg_length)), 3)
        row = replace(row, speed=speed, release=_release(row.robot))
        problem = gait_problem(walker, row.gait, speed=speed)
        gait = synthesize(problem)
    except AmbleError as error:
        return replace(row, status=_first(error), seconds=_processor_time() - began)
    row = replace(row, status=gait.solver.status, solved=True, iterations=gait.solver.iterations)
    checked = until_checked(problem, gait)
    said = f"{checked.factor * problem.intervals} intervals" if checked.passed else "; ".join(_kinds(checked.report))
    row = replace(row, check=said or "not computed", passed=checked.passed)
    if whole and checked.passed:
        row = _walked(row, checked.gait)
    return replace(row, seconds=_processor_time() - began)


def _walked(row: Row, gait: Gait) -> Row:
    """Stabilise, certify, and walk from a start in which every state is changed."""
    try:
        stable = stabilize(gait)
        certificate = certify(stable)
    except AmbleError as error:
        return replace(row, stability=_first(error))
    row = replace(row, stability=f"{certificate.radius:.3f}", certified=True)
    units = natural_units(gait.robot, gait.robot.leg_length)
    start = certificate.state + units * perturbed(np.zeros(units.size), CHANGE, 0)
    try:
        trace = simulate(stable, start, CYCLES)
        report = monitors(stable, trace)
    except AmbleError as error:
        return replace(row, walk=_first(error))
    sound = trace.completed and report.sound_from is not None and report.sound_from <= SETTLED
    reason = trace.ended if not trace.completed else "sound" if sound else "contacts are not sound"
    return replace(row, walk=f"{trace.cycles} cycles, {reason}", walked=sound)


def _processor_time() -> float:
    """Of this process and of the compilers that it has waited for, s."""
    return sum(os.times()[:4])


def _release(name: str) -> str:
    return f"{__version__} {robot(name).hash[:12]}"


def _first(error: AmbleError) -> str:
    return str(error).splitlines()[0]


def resumed(asked: Sequence[Row], place: Path, compute: Callable[[Row], Row] = computed) -> list[Row]:
    """Compute rows that a file does not hold yet; the file is written after every one.

    Args:
        asked: rows of ``rows``.
        place: the file.
        compute: what computes a row.
    """
    known = [Row(**entry) for entry in json.loads(place.read_text())] if place.exists() else []
    done = {(row.robot, row.gait, row.share): row for row in known if _current(row)}
    found = []
    for row in asked:
        key = (row.robot, row.gait, row.share)
        if key not in done:
            done[key] = compute(row)
            atomic_write(place, json.dumps([asdict(entry) for entry in done.values()], indent=1) + "\n")
        found.append(done[key])
        print(_line(found[-1]), flush=True)
    return found


def _current(row: Row) -> bool:
    """Whether a row that was computed before is of this release and this robot."""
    try:
        return row.release == _release(row.robot)
    except AmbleError:
        return False


def measure(quick: bool = False) -> list[Figure]:
    """Compute all rows and write their table.

    Args:
        quick: trot and amble of six robots only, without stability.
    """
    logging.getLogger("amble").setLevel(logging.ERROR)
    FOLDER.mkdir(parents=True, exist_ok=True)
    if quick:
        found = resumed(rows(quick=True), FOLDER / "fleet-quick.json", lambda row: computed(row, whole=False))
    else:
        found = resumed(rows(), FOLDER / "fleet.json")
    (FOLDER / "fleet.md").write_text(table(found))
    counts = {what: sum(getattr(row, what) for row in found) for what in ("solved", "passed", "certified", "walked")}
    figures = [
        Figure("gaits of the fleet solved", float(counts["solved"]), "", note=f"of {len(found)}"),
        Figure("of these pass their check", float(counts["passed"]), "", note=f"of {counts['solved']}"),
    ]
    if not quick:
        figures += [
            Figure("of these certified", float(counts["certified"]), "", note=f"of {counts['passed']}"),
            Figure(
                f"of these walk {CYCLES} cycles soundly", float(counts["walked"]), "", note=f"of {counts['certified']}"
            ),
        ]
    seconds = float(np.median([row.seconds for row in found]))
    return [*figures, Figure("processor time a gait", seconds, "s", note="median, all of it")]


def table(found: Sequence[Row]) -> str:
    """Return rows as a Markdown table."""
    header = "| robot | gait | m/s | solver | iterations | check | radius | walk | s |\n|" + "---|" * 9
    return "\n".join([header, *map(_line, found)]) + "\n"


def _line(row: Row) -> str:
    check = "" if not row.solved else f"passes, {row.check}" if row.passed else f"fails: {row.check}"
    cells = (row.robot, row.gait, f"{row.speed:g}", row.status, str(row.iterations or ""), check)
    return f"| {' | '.join((*cells, row.stability, row.walk, f'{row.seconds:.0f}'))} |"


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
