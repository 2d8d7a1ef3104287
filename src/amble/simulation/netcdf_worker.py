"""A process that reads the arrays of one netCDF file: a damaged file can keep the HDF5 library busy for ever.

Run by ``netcdf`` as a script with the file as standard input, never imported: it needs numpy and h5py alone.
What it found goes to standard output: one line of JSON, then the numbers of every array, one after the other.
"""

from __future__ import annotations

import contextlib
import json
import resource
import sys
from typing import Any

NOT_A_COORDINATE = "_nc4_non_coord_"
"""Prefix in HDF5 of a variable that shares its name with a dimension without being its coordinate."""


class RefusedError(Exception):
    """The file cannot be used, in words."""


def main(wanted: dict[str, Any]) -> None:
    """Read what is wanted and write it to standard output.

    Args:
        wanted: ``variables``: name -> number of axes; ``prefix``: of further variables, with two axes; ``attributes``:
            names, of the file and of the variables; ``seconds`` of processor time; ``bytes`` of numbers.
    """
    resource.setrlimit(resource.RLIMIT_CPU, (wanted["seconds"], wanted["seconds"] + 1))
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    import h5py

    arrays: list[Any] = []
    try:
        with h5py.File("/dev/stdin", "r") as file:
            found = _variables(file, wanted, arrays)
            head: dict[str, Any] = {"attributes": _attributes(file, wanted["attributes"]), "variables": found}
    except RefusedError as error:
        head, arrays = {"refused": str(error)}, []
    except Exception:  # whatever a damaged file makes the library raise
        head, arrays = {"refused": "is not a netCDF file, or it is damaged"}, []
    sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
    for array in arrays:
        sys.stdout.buffer.write(memoryview(array).cast("B") if array.size else b"")


def _variables(file: Any, wanted: dict[str, Any], arrays: list[Any]) -> dict[str, Any]:
    """Read the arrays, and return what to know of each: its shape, its kind of number, its attributes."""
    import h5py
    import numpy as np

    found: dict[str, Any] = {}
    room = wanted["bytes"]
    for stored in file:
        name = stored.removeprefix(NOT_A_COORDINATE)
        axes = wanted["variables"].get(name, 2 if name.startswith(wanted["prefix"]) else None)
        if axes is None or NOT_A_COORDINATE + stored in file:  # the latter is a dimension alone
            continue
        # a link or a raw part that lies in another file is not read
        dataset = file[stored] if isinstance(file.get(stored, getlink=True), h5py.HardLink) else None
        if not isinstance(dataset, h5py.Dataset) or dataset.is_virtual or dataset.external:
            raise RefusedError(f"does not hold '{name}' itself")
        if dataset.dtype.kind not in "iuf" or dataset.dtype.itemsize > 8:
            raise RefusedError(f"does not hold numbers in '{name}'")
        if dataset.ndim != axes:
            raise RefusedError(f"has {dataset.ndim} axes in '{name}', not {axes}")
        room -= 8 * int(np.prod(dataset.shape, dtype=object))
        if room < 0:
            raise RefusedError(f"holds more than {wanted['bytes'] // 2**20} MB of numbers")
        kind = "f8" if dataset.dtype.kind == "f" else "i8"
        arrays.append(np.ascontiguousarray(dataset[()], dtype=kind))
        found[name] = {
            "shape": dataset.shape,
            "kind": kind,
            "attributes": _attributes(dataset, wanted["attributes"]),
        }
    return found


def _attributes(holder: Any, names: list[str]) -> dict[str, Any]:
    """Return text and single numbers; what is neither is left out."""
    found = {}
    for name in names:
        value = holder.attrs.get(name)
        value = value.item() if getattr(value, "size", 0) == 1 else value
        value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        if isinstance(value, str | int | float):
            found[name] = value
    return found


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
