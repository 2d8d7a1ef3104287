"""A motion as another program has it: samples of its domains, with or without the rest of a gait."""

from __future__ import annotations

from dataclasses import dataclass

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
