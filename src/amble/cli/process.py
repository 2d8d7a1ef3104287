"""A command as a process: signals, streams and exit codes, from the first import to the last line."""

from __future__ import annotations

from amble.cli.signals import Endings
from amble.cli.streams import tolerant_streams


def main(arguments: list[str] | None = None) -> None:
    """Run the program and exit.

    The exit code is 0, 1 (the work failed, or its result could not be printed), 2 (bad usage or input), 130 (Ctrl-C) or
    143 (SIGTERM).

    Args:
        arguments: of the program; those of this process if None, which then ends with it.
    """
    with Endings(own_process=arguments is None) as endings, tolerant_streams() as streams:
        code = endings.ending(lambda: _run(arguments))
        raise SystemExit(streams.code_with_losses(code))


def _run(arguments: list[str] | None) -> None:
    # imported here, where Ctrl-C has its sentence already
    from amble.cli.app import app
    from amble.cli.console import log_to_stderr

    log_to_stderr()
    app(arguments, prog_name="amble")
