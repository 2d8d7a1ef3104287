"""Commands that hold a gait to what it claims: ``amble check`` computes it again, ``certify`` its stability."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import options
from amble.cli.console import progress
from amble.cli.output import result, show
from amble.cli.steps import certified
from amble.defaults import CERTIFICATE, GRID
from amble.errors import InputError, WorkError

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.residual import Residual
    from amble.robot import Robot
    from amble.types import Json
    from amble.verification.residuals import CheckReport


def check(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    robot: Annotated[
        Path | None,
        typer.Option(
            help="Robot that the gait must have been made for: its URDF, or a specification whose [robot] adapts one.",
            show_default=False,
        ),
    ] = None,
    grid: Annotated[int, typer.Option(help="Points in every spacing of the gait's nodes, up to 1000.")] = GRID,
    every: Annotated[bool, typer.Option("--all", help="Print every row, not the worst of each kind.")] = False,
) -> None:
    """Check dynamics, contacts, outputs, impacts, periodicity and limits of a gait, between its nodes too."""
    from amble.verification.check import check as recompute

    walker = read(gait, robot)
    with progress("checking") as notify:
        report = recompute(walker, grid, progress=notify)
    if every:
        for row in report.rows:
            show(str(row))
    show(str(report))
    result(**_tree(report, every))
    if not report.passed:
        raise WorkError(f"the gait does not hold: {len(report.failed)} of {len(report.rows)} rows fail")


def read(path: Path, robot: Path | None) -> Gait:
    """Read a gait; where a robot is given, it must be the one that the gait was made for.

    Of a URDF, what it does not say is the gait's: gravity, feet, locked joints, payload and drives. A specification
    says it all, another base, its rotation and offsets of feet too.
    """
    from amble.gait.files import load_gait
    from amble.synthesis.specification import read_specification
    from amble.synthesis.specified import robot_of

    gait = load_gait(path)
    if robot is None:
        return gait
    if robot.suffix == ".toml":
        described = robot_of(read_specification(robot).robot, robot.parent)
    else:
        described = _laid_over(robot, gait.robot)
    averaged = _averaged(described)  # a gait may be that of the file's robot with left and right averaged
    return load_gait(path, averaged if averaged == gait.robot else described)


def _laid_over(file: Path, made_for: Robot) -> Robot:
    from amble.robot import Adaptation, load_robot

    laid = Adaptation(
        locked=made_for.locked_joints,
        payload=made_for.payload,
        rotor_inertia={joint.name: joint.rotor_inertia for joint in made_for.joints},
        damping={joint.name: joint.damping for joint in made_for.joints},
        dry_friction={joint.name: joint.dry_friction for joint in made_for.joints},
        friction_width=max((joint.friction_width for joint in made_for.joints), default=0.0) or None,
    )
    return load_robot(
        file,
        feet={foot.name: foot.frame for foot in made_for.feet},
        gravity=made_for.gravity,
        name=file.stem,
        twins=made_for.twins,
        symmetry_tolerance=made_for.symmetry_tolerance,
        adaptation=laid,
    )


def _averaged(robot: Robot) -> Robot | None:
    from amble.robot import symmetrized

    try:
        return symmetrized(robot)
    except InputError:
        return None


def _tree(report: CheckReport, every: bool) -> Json:
    """Counts, the rows that fail, and the worst row of every kind or all rows."""
    chosen = report.rows if every else tuple(report.worst.values())
    return {
        "passed": report.passed,
        "rows": len(report.rows),
        "failed": [_row(row) for row in report.failed],
        "all" if every else "worst": [_row(row) for row in chosen],
    }


def _row(row: Residual) -> Json:
    numbers = {"lower": row.lower, "value": row.value, "upper": row.upper}
    return {"kind": row.kind, "name": row.name, **numbers, "passed": row.passed}


def certify(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    out: Annotated[Path, typer.Option(help="Where to write the certificate (JSON).")] = Path(CERTIFICATE),
    law: Annotated[str | None, typer.Option(help=options.LAW_HELP, show_default="the gait's own")] = None,
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    allow_absurd_limits: Annotated[
        bool,
        typer.Option(
            "--allow-absurd-limits",
            help="Certify even with friction above 2, torque limits below 1 % of weight times leg length, or gravity "
            "outside 0.5 to 30 m/s^2.",
        ),
    ] = False,
) -> None:
    """Certify that a gait is exponentially stable; where that is refused, exits 1 and the file says so with reasons."""
    from amble.gait.files import load_gait

    walker = options.under(load_gait(gait), control)
    chosen = None if law is None else options.parse_law(law, walker.pattern)
    certified(walker, out, allow_absurd_limits=allow_absurd_limits, law=chosen)
