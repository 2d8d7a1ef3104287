"""Commands that make a gait: ``amble init`` its specification, ``synthesize`` itself, ``stabilize`` its weights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import options
from amble.cli.console import progress
from amble.cli.lines import show_stabilized, show_synthesized
from amble.cli.options import METHOD_OPTION
from amble.cli.output import show, wrote
from amble.cli.steps import certified
from amble.defaults import CERTIFICATE, FREE, METHOD, Method
from amble.errors import InputError, shown

if TYPE_CHECKING:
    from amble.gait import Gait


def init(
    robot: Annotated[str, typer.Argument(help="Robot: a URDF file or a name of the catalogue.", show_default=False)],
    gait: Annotated[str | None, options.GAIT] = None,
    speed: Annotated[str | None, options.SPEED] = None,
    lateral: Annotated[str | None, options.LATERAL] = None,
    yaw_rate: Annotated[str | None, options.YAW_RATE] = None,
    cost: Annotated[str | None, options.COST] = None,
    feet: Annotated[str | None, options.FEET] = None,
    symmetrize: Annotated[bool | None, options.SYMMETRIZE] = None,
    out: Annotated[Path, typer.Option(help="Where to write the specification.")] = Path("spec.toml"),
) -> None:
    """Write the specification of a robot's gait with every default filled in, for `amble synthesize`.

    Feet that are not named are proposed by their position, and written into the file. The posture is that of the SRDF
    file beside the robot's, where there is one.
    """
    from amble.io.storage import atomic_write
    from amble.synthesis.specified import problem_of
    from amble.workflow.proposal import with_file_posture, written

    asked = options.specification(robot, feet, gait, speed, symmetrize, True, lateral, yaw_rate, cost)
    asked, source = with_file_posture(asked)
    problem = problem_of(asked)
    if source:
        show(f"posture: {source}")
    if feet is None and asked.robot.feet:
        listing = ", ".join(f"{label} = {frame}" for label, frame in asked.robot.feet.items())
        show(f"feet by position, to be confirmed: {listing}")
    atomic_write(out, written(asked, problem, out.parent))
    wrote(out)


def synthesize(
    spec: Annotated[
        str,
        typer.Argument(
            help="Specification, a TOML file; or a robot (URDF file, name of the catalogue) with --gait and --speed.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option(help="Where to write the gait.")] = Path("gait.json"),
    start: Annotated[
        Path | None,
        typer.Option(
            "--from", help="Gait to start from, with its multipliers; else a kinematic walk.", show_default=False
        ),
    ] = None,
    keep: Annotated[
        Path | None,
        typer.Option(
            help="Where to write the last iterate of a failed run, or a gait that fails its check.", show_default=False
        ),
    ] = None,
    feet: Annotated[str | None, options.FEET] = None,
    gait: Annotated[str | None, options.GAIT] = None,
    speed: Annotated[str | None, options.SPEED] = None,
    lateral: Annotated[str | None, options.LATERAL] = None,
    yaw_rate: Annotated[str | None, options.YAW_RATE] = None,
    cost: Annotated[str | None, options.COST] = None,
    symmetrize: Annotated[bool | None, options.SYMMETRIZE] = None,
    certify: Annotated[
        bool,
        typer.Option("--certify", help="Stabilise and certify it too; certificate.json goes beside it."),
    ] = False,
) -> None:
    """Find the gait that a specification describes, or that of a robot by default."""
    from amble.gait.files import load_gait, save_gait
    from amble.synthesis.synthesize import GaitNotSolvedError
    from amble.workflow.specified import GaitNotCheckedError, pose, solve

    if options.is_robot(spec):
        posed = pose(options.specification(spec, feet, gait, speed, symmetrize, False, lateral, yaw_rate, cost))
    elif any(option is not None for option in (feet, gait, speed, symmetrize, lateral, yaw_rate, cost)):
        raise InputError(
            f"'{shown(spec)}' is a specification, which holds feet, gait and speed itself; --feet, --gait, --speed, "
            "--lateral-speed, --yaw-rate, --symmetrize and --cost belong to a robot (a file or a name of the catalogue)"
        )
    else:
        posed = pose(Path(spec))
    known = None if start is None else load_gait(start, posed.problem.pattern.robot)
    try:
        with progress("optimising the gait") as notify:
            found = solve(posed, known, progress=notify)
    except (GaitNotSolvedError, GaitNotCheckedError) as error:
        if keep is not None:
            wrote(save_gait(error.last, keep))
        raise
    show_synthesized(found)
    wrote(save_gait(found, out))
    if certify:
        stable = _stabilized(found, None, METHOD, out)
        certified(stable, out.with_name(CERTIFICATE))


def stabilize(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    free: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Coordinate with free weights; by default {', '.join(FREE)}, and joints as they are needed.",
            show_default=False,
        ),
    ] = None,
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    method: Annotated[Method, METHOD_OPTION] = METHOD,
    out: Annotated[Path, typer.Option(help="Where to write the stabilised gait.")] = Path("gait.json"),
) -> None:
    """Choose output weights, or the gains of another feedback law, that make the orbit exponentially stable."""
    from amble.gait.files import load_gait

    _stabilized(options.under(load_gait(gait), control), tuple(free) if free else None, method, out)


def _stabilized(gait: Gait, free: Sequence[str] | None, method: Method, out: Path) -> Gait:
    """Stabilise a gait, say how that went, and write it."""
    from amble.gait.files import save_gait
    from amble.stability.stabilize import stabilization

    with progress("stabilising") as notify:
        found = stabilization(gait, free, method, notify)
    show_stabilized(found)
    wrote(save_gait(found.gait, out))
    return found.gait
