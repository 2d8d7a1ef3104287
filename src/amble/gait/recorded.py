"""A motion as another program has it: samples of its domains, with or without the rest of a gait."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError, printable, shown
from amble.types import Json, Matrix, Vector

FIELDS = ("times", "positions", "velocities", "accelerations", "torques", "forces")
"""Arrays of a domain, one row a sample."""

HEADER = "amble_gait"
"""Name of the text that holds the rest of a gait."""

LARGEST = 2**26
"""Bytes of a file, and of what is unpacked from it: 80,000 samples of a hundred numbers."""

MOST_NAMES = 1000
"""Arrays, domains and coordinates of a file."""


@dataclass(frozen=True, kw_only=True)
class RecordedDomain:
    """Samples of one domain from a file: what is not there is None.

    Attributes:
        name: of the domain; empty where the file names none.
        times: (n,), s.
        positions: coordinates in the file's order, (n, width).
        velocities: their rates.
        accelerations: their second derivatives.
        torques: joint torques.
        forces: contact forces.
    """

    name: str
    times: Vector
    positions: Matrix
    velocities: Matrix | None = None
    accelerations: Matrix | None = None
    torques: Matrix | None = None
    forces: Matrix | None = None


@dataclass(frozen=True)
class RecordedMotion:
    """What a file holds.

    Attributes:
        source: name of the file.
        domains: in order.
        header: the rest of a gait that amble wrote; None in a file from elsewhere.
        columns: names of the coordinates, where the file has them.
    """

    source: str
    domains: tuple[RecordedDomain, ...]
    header: Json | None = None
    columns: tuple[str, ...] | None = None

    def check(self) -> None:
        """Refuse a motion without samples, and samples that do not fit together.

        Raises:
            InputError: tables of different lengths, a number that is not finite or too large, a clock that does not
                run forward.
        """
        what = f"motion '{printable(self.source)}'"
        if not self.domains:
            raise InputError(f"{what} has no domain with times and positions")
        for domain in self.domains:
            _check_samples(f"{what}, domain '{shown(domain.name)}'", domain)


def _check_samples(where: str, domain: RecordedDomain) -> None:
    count = np.size(domain.times)
    for field in FIELDS:
        values = getattr(domain, field)
        if values is None:
            continue
        if np.ndim(values) != (1 if field == "times" else 2):
            raise InputError(f"{where}: its {field} are no {'list' if field == 'times' else 'table'} of numbers")
        if len(values) != count:
            raise InputError(f"{where}: {count} times, but {len(values)} rows of {field}")
        if not np.all(np.isfinite(values)):
            raise InputError(f"{where}: its {field} hold a number that is not finite")
        if not np.all(np.abs(values) <= LARGEST_NUMBER):
            raise InputError(f"{where}: its {field} hold a number above {LARGEST_NUMBER:g}")
    if count < 3 or not np.all(np.diff(domain.times) > 0.0):
        raise InputError(f"{where}: its clock must have three samples or more and run forward")
