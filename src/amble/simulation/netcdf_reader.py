"""Reading of netCDF files by known variables, in a process of its own with bounds on time and size.

HDF5 follows whatever addresses and lengths a file states; of files of 150 KB with bytes flipped at random, one in 900
kept it busy for ever. A child reads (``netcdf_worker``), and its processor time is limited.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, printable
from amble.io.reader import opened
from amble.simulation.netcdf import Variable

LARGEST = 4 * 2**30
"""Bytes of a file, and of the numbers in it; 500 cycles of ASTRo's amble have 0.05 GB."""

SECONDS = 5
"""Processor time for a file that is small: a hundred times what it takes."""

BYTES_A_SECOND = 50 * 2**20
"""A tenth of what is read in a second."""

WAITING = 20
"""Longest wait, as a multiple of the processor time: the machine may be busy."""


def read_netcdf(
    path: str | Path, what: str, variables: Mapping[str, int], prefix: str, attributes: Sequence[str]
) -> tuple[dict[str, Variable], dict[str, Any]]:
    """Read the variables that are known, and attributes; anything else in the file is not looked at.

    Args:
        path: the file.
        what: what it is, such as "trace file"; sentences begin with it.
        variables: name -> number of axes.
        prefix: of the names of further variables, with two axes.
        attributes: names, of the file and of the variables.

    Returns:
        The variables that are there, and the file's own attributes.

    Raises:
        InputError: in one sentence, where the file cannot be read, is no netCDF-4 file, is damaged or too large.
    """
    name = f"{what} '{printable(str(path))}'"
    worker = str(Path(__file__).with_name("netcdf_worker.py"))
    with opened(path, what, LARGEST) as (stream, size):
        seconds = SECONDS + size // BYTES_A_SECOND
        wanted = {
            "variables": dict(variables),
            "prefix": prefix,
            "attributes": list(attributes),
            "seconds": seconds,
            "bytes": LARGEST,
        }
        # -P: modules beside the worker do not shadow those of the library
        command = [sys.executable, "-P", worker, json.dumps(wanted)]
        try:
            done = subprocess.run(command, stdin=stream, capture_output=True, timeout=WAITING * seconds, check=False)
        except subprocess.TimeoutExpired:
            raise InputError(f"{name} is damaged: reading it did not end in {WAITING * seconds} s") from None
    line, _, numbers = done.stdout.partition(b"\n")
    if done.returncode != 0 or not line:
        raise InputError(f"{name} is damaged: reading it failed or took more than {seconds} s of processor time")
    head = json.loads(line)
    if "refused" in head:
        raise InputError(f"{name} {head['refused']}")
    return _arrays(head["variables"], numbers), head["attributes"]


def _arrays(found: Mapping[str, Any], numbers: bytes) -> dict[str, Variable]:
    variables, start = {}, 0
    for name, about in found.items():
        count = int(np.prod(about["shape"]))
        values = np.frombuffer(numbers, about["kind"], count, start) if count else np.empty(0, about["kind"])
        variables[name] = Variable(values=values.reshape(about["shape"]), attributes=about["attributes"])
        start += values.nbytes
    return variables
