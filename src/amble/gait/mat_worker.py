"""A process that reads one mat file: SciPy's reader may end the process, or take all memory, on a damaged one.

Run by ``motion_formats`` as a script with the file as standard input, never imported: it needs numpy and scipy alone.
What it found goes to standard output as an npz file: "refused" with a reason, or the arrays of every domain.
"""

from __future__ import annotations

import io
import json
import resource
import sys
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np


class RefusedError(Exception):
    """The file cannot be used, in words."""


def main(wanted: dict[str, Any]) -> None:
    """Read what is wanted and write it to standard output.

    Args:
        wanted: ``texts``: variables of text; ``fields``: name -> path to it in an entry of the variable gait; ``own``:
            the same, of files that amble wrote; ``seconds`` of processor time; ``bytes`` of memory; ``most`` domains.
    """
    _limit(resource.RLIMIT_CPU, wanted["seconds"])
    _limit(resource.RLIMIT_CORE, 0)
    from scipy.io import loadmat

    _limit(resource.RLIMIT_DATA, wanted["bytes"])
    try:
        found = _found(loadmat, wanted)
    except RefusedError as error:
        found = {"refused": np.array(str(error))}
    stream = io.BytesIO()
    np.savez(stream, **found)
    sys.stdout.buffer.write(stream.getvalue())


def _limit(kind: int, most: int) -> None:
    """Lower a limit of this process; one that is lower already stays."""
    _, hard = resource.getrlimit(kind)
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _found(loadmat: Any, wanted: dict[str, Any]) -> dict[str, Any]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            file = loadmat(io.BytesIO(sys.stdin.buffer.read()))
    except Exception as error:  # whatever a damaged file makes the library raise
        raise RefusedError(f"is no mat file up to version 7: {error}") from None
    gait = file.get("gait")
    if gait is None or gait.dtype.names is None or not {"tspan", "states"} <= set(gait.dtype.names):
        raise RefusedError("has no variable gait, a struct with tspan and states.x")
    arrays = {key: np.array([_text(value) for value in file[key].ravel()]) for key in wanted["texts"] if key in file}
    if gait.size > 2 * wanted["most"]:
        raise RefusedError(f"has more than {wanted['most']} domains")
    for number, entry in enumerate(_domains(gait)):
        arrays[f"{number} name"] = np.array(_text(entry["name"]) if "name" in gait.dtype.names else "")
        inputs = entry["inputs"] if "inputs" in gait.dtype.names else None
        own = inputs is not None and inputs.dtype.names is not None and {"u", "f"} <= set(inputs.dtype.names)
        for field, path in {**wanted["fields"], **(wanted["own"] if own else {})}.items():
            values = _inner(entry, path)
            if values is not None:
                arrays[f"{number} {field}"] = _numbers(values, field)
    return arrays


def _domains(gait: Any) -> Iterator[Any]:
    """The entries with more than one sample: FROST puts one for every edge between those of the domains."""
    return (entry for entry in gait.ravel() if np.size(entry["tspan"]) > 1)


def _text(value: Any) -> str:
    return str(np.ravel(value)[0]) if np.size(value) else ""


def _inner(entry: Any, path: Sequence[str]) -> Any:
    for key in path:
        if entry.dtype.names is None or key not in entry.dtype.names:
            return None
        entry = entry[key]
        if entry.dtype == object and entry.size == 1:
            entry = entry.ravel()[0]
    return entry


def _numbers(values: Any, field: str) -> Any:
    if not (isinstance(values, np.ndarray) and values.dtype.kind in "fiu" and values.ndim == 2):
        raise RefusedError(f"has {field} that are not all numbers")
    return values.astype(np.float64)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
