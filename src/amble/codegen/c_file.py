"""C files of this package as libraries in the cache, compiled once for all processes."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Sequence
from pathlib import Path

from amble.codegen.cache import content_key, kept, writable_folder
from amble.codegen.compiler import Compiler, compiler

NUMERICAL = ("-O3", "-std=gnu99", "-fPIC", "-shared")
"""Without -ffast-math, so that what is no number is seen."""


def built(source: Path, flags: Sequence[str], beside: Sequence[Path] = ()) -> Path | None:
    """Return the library of a C file, compiled first where it is not in the cache; None where there is no compiler.

    Args:
        source: the C file.
        flags: of the compiler.
        beside: files that it includes.

    Raises:
        OSError: on a full disk, or where the folder may not hold libraries.
        WorkError: the compiler fails.
    """
    tool = compiler()
    return None if tool is None else _built(source, tuple(flags), tuple(beside), tool)


@functools.cache
def numerical(source: Path) -> ctypes.CDLL | None:
    """Load a C file that computes and keeps nothing, compiled with what all such files are; kept for this process.

    Args:
        source: the C file, of this package.

    Returns:
        The library; None where there is no compiler, or no place for what it makes: numpy does the work then.
    """
    try:
        path = built(source, NUMERICAL)
    except OSError:
        return None
    return None if path is None else ctypes.CDLL(str(path))


@functools.cache
def _built(source: Path, flags: tuple[str, ...], beside: tuple[Path, ...], tool: Compiler) -> Path:
    texts = [file.read_text(encoding="utf-8") for file in (source, *beside)]
    key = content_key([*texts, tool.path, tool.version, *flags])
    library = writable_folder() / f"{source.stem}-{key}.so"
    return kept(library, lambda output: tool.build(source, output, flags))
