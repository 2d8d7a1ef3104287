"""Named arrays as a netCDF-4 file, by h5py alone.

A netCDF-4 file is an HDF5 file with conventions: every dimension is a dimension scale with a number, every variable is
attached to its scales and lists their numbers, and everything is kept in the order of creation (NetCDF users' guide,
"Format specification", section "NetCDF-4"). Any netCDF library opens it.

Reading is by known variables, in a process of its own with bounds on time and size. HDF5 follows whatever addresses and
lengths a file states; of files of 150 KB with bytes flipped at random, one in 900 kept it busy for ever. A child reads
(``netcdf_worker``), and its processor time is limited.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amble.errors import InputError, shown_path
from amble.io.reader import opened
from amble.io.worker import by_worker
from amble.version import __version__

if TYPE_CHECKING:
    import h5py

NOT_A_VARIABLE = "This is a netCDF dimension but not a netCDF variable."
NOT_A_COORDINATE = "_nc4_non_coord_"
"""Prefix in HDF5 of a variable that shares its name with a dimension without being its coordinate."""

DIMENSION_NUMBER, DIMENSION_NUMBERS = "_Netcdf4Dimid", "_Netcdf4Coordinates"
PROVENANCE = "_NCProperties"

LARGEST = 4 * 2**30
"""Bytes of a file; 500 cycles of ASTRo's amble have 0.05 GB."""

UNPACKED, SMALL = 4, 2**27
"""How many bytes of numbers a file may hold for each of its own (amble packs none), and a small one in any case: three
copies are in memory, and packed zeros take a thousandth of their size."""

SECONDS = 5
"""Processor time for a file that is small: a hundred times what it takes."""

BYTES_A_SECOND = 50 * 2**20
"""A tenth of what is read in a second."""


@dataclass(frozen=True, kw_only=True)
class Variable:
    """A named array of a file.

    Attributes:
        values: numbers.
        attributes: name -> text or number.
        dimensions: name of the dimension of every axis, for writing.
    """

    values: NDArray[Any]
    attributes: Mapping[str, Any]
    dimensions: tuple[str, ...] = ()


def write_netcdf(path: Path, variables: Mapping[str, Variable], attributes: Mapping[str, Any]) -> None:
    """Write variables and the attributes of the whole file; no variable may be the coordinate of a dimension.

    HDF5 makes the file in memory: where it writes to a disk that is full, it prints lines of its own and may end the
    process.

    Raises:
        InputError: where a name has a slash, which would be a group.
        OSError: where the file cannot be written.
    """
    import h5py

    for name in variables:
        if "/" in name:
            raise InputError(f"'{name}' cannot be the name of a netCDF variable, for it has a slash")
    with h5py.File(path.name, "w", track_order=True, driver="core", backing_store=False) as file:
        file.attrs[PROVENANCE] = np.bytes_(f"version=2,amble={__version__},h5py={h5py.__version__}")
        for name, value in attributes.items():
            file.attrs[name] = value
        scales = _write_scales(file, variables)
        numbers = {name: number for number, name in enumerate(scales)}
        for name, variable in variables.items():
            stored = NOT_A_COORDINATE + name if name in scales else name
            dataset = _dataset(file, stored, variable.values)
            for axis, dimension in enumerate(variable.dimensions):
                dataset.dims[axis].attach_scale(scales[dimension])
            own = [numbers[dimension] for dimension in variable.dimensions]
            dataset.attrs[DIMENSION_NUMBERS] = np.array(own, dtype=np.int32)
            dataset.attrs[DIMENSION_NUMBER] = np.int32(own[0])
            for key, value in variable.attributes.items():
                dataset.attrs[key] = value
        file.flush()
        image = file.id.get_file_image()
    path.write_bytes(image)


def _write_scales(file: h5py.File, variables: Mapping[str, Variable]) -> dict[str, h5py.Dataset]:
    """Write the dimensions in the order in which the variables name them."""
    sizes: dict[str, int] = {}
    for variable in variables.values():
        for dimension, size in zip(variable.dimensions, variable.values.shape, strict=True):
            if sizes.setdefault(dimension, size) != size:
                raise ValueError(f"dimension '{dimension}' has the sizes {sizes[dimension]} and {size}")
    scales = {}
    for number, (name, size) in enumerate(sizes.items()):
        # an array of big-endian floats without values is what the netCDF library writes here
        scale = _dataset(file, name, np.zeros(size, dtype=">f4"))
        scale.make_scale(f"{NOT_A_VARIABLE}{size:10d}")
        scale.attrs[DIMENSION_NUMBER] = np.int32(number)
        scales[name] = scale
    return scales


def _dataset(file: h5py.File, name: str, values: NDArray[Any]) -> h5py.Dataset:
    """Write an array; an axis without entries can grow, for netCDF has no other empty dimension."""
    growing = tuple(size or None for size in values.shape) if values.size == 0 else None
    return file.create_dataset(name, data=values, maxshape=growing, track_order=True)


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
    name = f"{what} '{shown_path(path)}'"
    with opened(path, what, LARGEST) as (stream, size):
        wanted = {
            "variables": dict(variables),
            "prefix": prefix,
            "attributes": list(attributes),
            "seconds": SECONDS + size // BYTES_A_SECOND,
            "bytes": max(SMALL, UNPACKED * size),
        }
        found = by_worker(Path(__file__).with_name("netcdf_worker.py"), wanted, stream, name)
    line, _, numbers = found.partition(b"\n")
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
