"""Files of reference motions: npz, CSV, MCAP."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amble.analysis.mcap_file import mcap_content
from amble.analysis.reference import ReferenceMotion
from amble.errors import InputError, shown
from amble.io.storage import atomic_write
from amble.io.table import table_text
from amble.types import NodeValues


def write_reference(motion: ReferenceMotion, path: str | Path) -> Path:
    """Write a reference motion as npz, with an array an attribute, as CSV, with a column a number, or as MCAP.

    MCAP (extra ``mcap``) is what Foxglove and PlotJuggler read; docs/howto/export.md lists its topics.

    Raises:
        InputError: the suffix is another one, or the place cannot be written.
        MissingExtraError: the library for MCAP is not installed.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        stream = io.BytesIO()
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in vars(motion).items()}
        np.savez(stream, **arrays)
        return atomic_write(path, stream.getvalue())
    if suffix == ".csv":
        return atomic_write(path, _table(motion))
    if suffix == ".mcap":
        return atomic_write(path, mcap_content(motion))
    raise InputError(f"'{shown(Path(path).name)}' is no reference motion by its suffix; known: .npz, .csv, .mcap")


def _table(motion: ReferenceMotion) -> str:
    base = ("x", "y", "z", "qw", "qx", "qy", "qz")
    twist = ("vx", "vy", "vz", "wx", "wy", "wz")
    columns: list[tuple[Sequence[str], NodeValues]] = [
        (["time"], motion.time[:, None]),
        ([*base, *motion.joints], motion.qpos),
        ([*twist, *(f"rate of {name}" for name in motion.joints)], motion.qvel),
        ([f"torque {name}" for name in motion.joints], motion.torques),
        ([f"force {foot} {axis}" for foot in motion.feet for axis in base[:3]], motion.forces),
        ([f"contact {foot}" for foot in motion.feet], motion.contacts.astype(np.int64)),
        ([f"{body} {axis}" for body in motion.bodies for axis in base[:3]], motion.body_positions),
        ([f"{body} {axis}" for body in motion.bodies for axis in base[3:]], motion.body_quaternions),
    ]
    head = ["stance", *(name for names, _ in columns for name in names)]
    rows = (
        [stance, *(repr(value) for _, values in columns for value in values[row].ravel().tolist())]
        for row, stance in enumerate(motion.stances)
    )
    return table_text([head, *rows])
