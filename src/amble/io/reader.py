"""Reading of files that others wrote: bounded before anything is parsed, and every failure one sentence.

A file is data: a regular file of a stated size at most, text in UTF-8 with or without byte order mark, JSON or TOML
of bounded depth and whole numbers of bounded length, no key twice, no character that cannot be written again.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import stat
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

from amble.errors import InputError, shown, shown_path

if TYPE_CHECKING:
    from pydantic import TypeAdapter

    from amble.types import Json  # numpy stays out of the start of the command line

Found = TypeVar("Found")

LARGEST_TEXT = 16 * 2**20
"""Bytes of a text file; a gait of 15 intervals a domain has 0.14 MB. Empty lists take thirty times their size."""

LARGEST_TOML = 2**20
"""Bytes of a TOML file, which people write by hand: Python reads 1 MB in a second."""

LARGEST_RECORD = 2**20
"""Bytes of a record that pydantic reads: of empty lists it takes four hundred times their size."""

DEEPEST = 32
"""Levels of lists and tables; a gait has 7."""

LONGEST_INTEGER = 40
"""Digits of a whole number."""

NUMBER = re.compile(
    r"[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:e[+-]?\d++)?|[+-]?(?:inf|infinity|nan)", re.ASCII | re.IGNORECASE
)
"""Possessive: of a million digits before a letter no shorter start is tried, which would take a square of time."""

DOTTED = re.compile(r"""(?<![\w\\-])(?:(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){32}""")
"""A dotted key of TOML that is deeper than ``DEEPEST``: Python's parser takes the square of its parts in memory."""


@contextlib.contextmanager
def opened(path: str | Path, what: str, largest: int) -> Iterator[tuple[BinaryIO, int]]:
    """Open a regular file that is not too large, and yield it with its size; errors as in ``read_bytes``."""
    name = f"{what} '{shown_path(path)}'"
    try:
        # without O_NONBLOCK, opening a pipe waits for somebody who writes
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            status = os.fstat(descriptor)
            if not stat.S_ISREG(status.st_mode):
                kind = "a folder" if stat.S_ISDIR(status.st_mode) else "a device or a pipe"
                raise InputError(f"{name} cannot be read: it is {kind}, not a file")
            if status.st_size > largest:
                raise InputError(_too_large(name, largest))
            with os.fdopen(descriptor, "rb", closefd=False) as stream:
                yield stream, status.st_size
        finally:
            os.close(descriptor)
    except OSError as error:
        raise InputError(f"{name} cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a NUL or a lone surrogate in the path
        raise InputError(f"{name} cannot be read: no file has such a name ({shown(str(error))})") from None


def read_bytes(path: str | Path, what: str, largest: int = LARGEST_TEXT) -> bytes:
    """Read a whole regular file.

    Args:
        path: the file.
        what: what it is, such as "gait file"; sentences begin with it.
        largest: bytes it may have.

    Raises:
        InputError: the file is missing, is not a regular file (a folder, device or pipe, which may never end), cannot
            be read, or is too large.
    """
    with opened(path, what, largest) as (stream, _):
        content = stream.read(largest + 1)  # a file may grow while it is read, so its size alone is not believed
    if len(content) > largest:
        raise InputError(_too_large(f"{what} '{shown_path(path)}'", largest))
    return content


def read_text(path: str | Path, what: str, largest: int = LARGEST_TEXT) -> str:
    """Read a file of text in UTF-8, with or without byte order mark; errors as in ``read_bytes``.

    Raises:
        InputError: also where the content is not UTF-8.
    """
    try:
        return read_bytes(path, what, largest).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{what} '{shown_path(path)}' is not text in UTF-8: {_reason(error)}") from None


def read_json(path: str | Path, what: str) -> Json:
    """Read a file that holds one JSON object; errors as in ``read_text`` and ``parse_json``."""
    name = f"{what} '{shown_path(path)}'"
    tree = parse_json(read_text(path, what), name)
    if not isinstance(tree, dict):
        raise InputError(f"{name} is not an object")
    return tree


def read_toml(path: str | Path, what: str) -> Json:
    """Read a TOML file; errors as in ``read_text``.

    Raises:
        InputError: also where it is not TOML, or too deep, or holds a whole number that is too long.
    """
    name = f"{what} '{shown_path(path)}'"
    text = read_text(path, what, LARGEST_TOML)
    if DOTTED.search(text):
        raise InputError(f"{name} cannot be read: {_limits()}")
    return _bounded(lambda: tomllib.loads(text), name, "TOML")


def read_record(path: str | Path, what: str, kind: TypeAdapter[Found]) -> Found:
    """Read a file of JSON as what a model describes, strictly; errors as in ``read_text`` and ``parse_json``.

    Args:
        path: the file.
        what: what it is, such as "proof"; sentences begin with it.
        kind: the model.

    Raises:
        InputError: also where it is not what the model describes, with the first place that is not.
    """
    from pydantic import ValidationError

    name, text = f"{what} '{shown_path(path)}'", read_text(path, what, LARGEST_RECORD)
    parse_json(text, name)
    try:
        return kind.validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = shown(".".join(map(str, first["loc"])) or "file")
        raise InputError(f"{name} cannot be used: {where}: {shown(first['msg'], 300)}") from None


def parse_json(text: str, what: str) -> Any:
    """Parse JSON strictly: no NaN, no key twice, nothing too deep or too long.

    Raises:
        InputError: in one sentence that begins with ``what``.
    """
    if len(text) > LARGEST_TEXT:
        raise InputError(_too_large(what, LARGEST_TEXT))

    def refuse_constant(word: str) -> None:
        raise InputError(f"{what} holds {word}, which is not a number")

    def unique(pairs: list[tuple[str, Any]]) -> Json:
        tree = dict(pairs)
        if len(tree) != len(pairs):
            twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
            raise InputError(f"{what} has the key '{shown(twice)}' twice in one object")
        return tree

    return _bounded(
        lambda: json.loads(text, parse_constant=refuse_constant, object_pairs_hook=unique, parse_int=_integer),
        what,
        "JSON",
    )


def parse_number(text: str) -> float:
    """Return the number that a word means in decimal notation; what Python alone reads (``6_0``) is none.

    Raises:
        ValueError: the word is no number.
    """
    if not NUMBER.fullmatch(text):
        raise ValueError(f"'{shown(text)}' is not a number")
    return float(text)


def _integer(digits: str) -> int:
    if len(digits) > LONGEST_INTEGER:
        raise OverflowError(len(digits))
    return int(digits)


def _bounded(parse: Callable[[], Any], name: str, language: str) -> Any:
    """Parse, and look at the depth, the whole numbers and the characters of what came out."""
    try:
        tree = parse()
    except (RecursionError, OverflowError):
        raise InputError(f"{name} cannot be read: {_limits()}") from None
    except ValueError as error:
        # Python's own limit of digits, which the TOML parser meets
        reason = _limits() if "integer string conversion" in str(error) else shown(str(error), 200)
        raise InputError(f"{name} is not {language}: {reason}") from None
    level, depth = [tree], 0
    while level:
        _check_leaves(level, name)
        parts = [entry for entry in level if isinstance(entry, list | dict)]
        level = [entry for part in parts for entry in (part.values() if isinstance(part, dict) else part)]
        level += [key for part in parts if isinstance(part, dict) for key in part]
        depth += bool(parts)
        if depth > DEEPEST:
            raise InputError(f"{name} cannot be read: {_limits()}")
    return tree


def _check_leaves(leaves: list[Any], name: str) -> None:
    if any(type(leaf) is int and abs(leaf) >= 10**LONGEST_INTEGER for leaf in leaves):
        raise InputError(f"{name} cannot be read: {_limits()}")
    try:
        "\n".join(leaf for leaf in leaves if type(leaf) is str).encode()
    except UnicodeEncodeError as error:
        raise InputError(f"{name} holds half of a surrogate pair, which is no character: {_reason(error)}") from None


def _too_large(name: str, largest: int) -> str:
    return f"{name} cannot be read: it has more than {largest / 2**20:g} MB"


def _limits() -> str:
    return f"it is nested deeper than {DEEPEST} levels, or holds a whole number of more than {LONGEST_INTEGER} digits"


def _reason(error: UnicodeError) -> str:
    return shown(str(error), 120)
