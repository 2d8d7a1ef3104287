"""The command line: parse, call, print; no mathematics."""

from amble.cli.app import main

__all__ = ["main"]
