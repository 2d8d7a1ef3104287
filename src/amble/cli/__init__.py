"""The command line: parse, call, print; no mathematics."""

from amble.cli.process import main

__all__ = ["main"]
