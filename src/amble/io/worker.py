"""A process of its own that reads what a library of others cannot be trusted with: it may hang, or end the process."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import BinaryIO

from amble.errors import InputError
from amble.types import Json

WAITING = 20
"""Longest wait, as a multiple of the processor time: the machine may be busy."""


def by_worker(script: Path, wanted: Json, stream: BinaryIO, name: str) -> bytes:
    """Run a script with a file as its standard input and return what it writes to standard output.

    Args:
        script: what reads; it limits its own processor time to ``wanted["seconds"]``.
        wanted: the script's only argument, as JSON.
        stream: the file, open.
        name: what the file is, with its name; sentences begin with it.

    Raises:
        InputError: the script did not end, ended by a signal or a failure, or wrote nothing.
    """
    # -P: modules beside the script do not shadow those of the library
    command = [sys.executable, "-P", str(script), json.dumps(wanted)]
    longest = WAITING * wanted["seconds"]
    try:
        done = subprocess.run(command, stdin=stream, capture_output=True, timeout=longest, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"{name} is damaged: reading it did not end in {longest} s") from None
    if done.returncode != 0 or not done.stdout:
        raise InputError(
            f"{name} is damaged: reading it failed or took more than {wanted['seconds']} s of processor time"
        )
    return done.stdout
