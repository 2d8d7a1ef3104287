"""The rule for names, and names as identifiers of generated code: one home, whatever road a name comes by."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable

from amble.errors import InputError

LONGEST = 100
"""Characters of a name at most; the longest of 2,294 names in 69 published URDF files has 56."""

LONGEST_FILE = 255
"""Characters of a file's name at most."""

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", re.ASCII)
"""What C and casadi both take as a name; casadi refuses two underscores in a row."""

_MARK = "name_"
_LONGEST_WORD = 40
_STEM = 20
_DIGITS = 12


def check_name(kind: str, name: str, longest: int = LONGEST) -> None:
    """Refuse what is no name: a name is text on one line that can be printed, of bounded length.

    Which characters a name has is the user's business (``LFoot/FSR``, ``hüfte``); whoever writes names into C, Markdown
    or figures escapes them there. Control characters, line ends, surrogates and invisible characters are no part of a
    name, nor are spaces at its ends.

    Args:
        kind: what is named, for the sentence.
        name: the name.
        longest: characters that it may have.

    Raises:
        InputError: it is no such text.
    """
    if not isinstance(name, str):
        raise InputError(f"the name of a {kind} is {type(name).__name__}, not text")
    if not name:
        raise InputError(f"the name of a {kind} is empty")
    if len(name) > longest:
        raise InputError(f"the name of a {kind} has {len(name)} characters, more than {longest}: '{name[:20]}...'")
    if not name.isprintable() or name != name.strip():
        raise InputError(f"the name of a {kind} has characters that cannot be printed, or spaces at its ends: '{name}'")


def check_distinct(kind: str, names: Iterable[str]) -> None:
    """Refuse a name that occurs twice among names of one kind.

    Raises:
        InputError: a name occurs twice.
    """
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"more than one {kind} is called '{name}'")
        seen.add(name)


def identifier(name: str) -> str:
    """Write a name as part of an identifier of C, casadi or a file name.

    Short words stay as they are; any other name becomes its letters and digits with a mark before and a hash behind, so
    that different names give different identifiers.
    """
    if len(name) <= _LONGEST_WORD and _WORD.fullmatch(name) and not name.startswith(_MARK):
        return name
    stem = "_".join(re.findall(r"[A-Za-z0-9]+", name))[:_STEM].strip("_")
    digest = hashlib.sha256(name.encode("utf-8", "surrogatepass")).hexdigest()[:_DIGITS]
    return f"{_MARK}{stem}_{digest}" if stem else f"{_MARK}{digest}"
