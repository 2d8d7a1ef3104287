"""The program ``amble``: its commands."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from amble.cli import (
    checking,
    doctor,
    front,
    importing,
    library,
    making,
    proving,
    reproducing,
    robots,
    robustness,
    steering,
    validating,
    view,
    walking,
)
from amble.cli.output import reporting
from amble.version import __version__

EXIT_CODES = (
    "Exit codes: 0 done; 1 the work failed, and its last lines say why; 2 usage or input is bad; 130 interrupted; "
    "143 terminated."
)


class Command(TyperCommand):
    """One command, which refuses a place that it could not write before it works for minutes."""

    def invoke(self, ctx: Any) -> Any:
        """Check the places of the results and run."""
        from amble.io.storage import check_file, check_folder

        for name in PLACES & ctx.params.keys():
            place = ctx.params[name]
            if place is None or self.name == "export":  # which checks its folder itself: it is replaced as a whole
                continue
            if self.name in INTO_FOLDERS:
                check_folder(place)
            else:
                check_file(f"{place}.png" if name == "figure" else place)
        return super().invoke(ctx)


PLACES = {"out", "keep", "figure", "mp4", "record"}
"""Parameters that name what is written."""
INTO_FOLDERS = ("front", "library", "reproduce", "report", "robustness")
"""Commands whose ``--out`` is a folder that keeps what else is in it."""

app = typer.Typer(
    name="amble",
    no_args_is_help=True,
    epilog=EXIT_CODES,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help comes in 0.12 s, the framed one in 0.35 s
    context_settings={"help_option_names": ["-h", "--help"]},
)

COMMANDS = (
    reproducing.reproduce,
    making.init,
    making.synthesize,
    checking.check,
    making.stabilize,
    library.library,
    steering.transitions,
    steering.steer,
    checking.certify,
    proving.prove,
    walking.simulate,
    walking.compare,
    walking.export,
    validating.validate,
    robustness.robustness,
    front.front,
    importing.importing,
    view.view,
    reproducing.report,
    robots.robots,
    doctor.doctor,
)

for command in COMMANDS:
    name = "import" if command is importing.importing else None  # which no function in Python can be called
    app.command(name, cls=Command, epilog=EXIT_CODES)(reporting(command))


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"amble {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """From a robot description to a torque-minimal walking controller with a stability certificate."""
