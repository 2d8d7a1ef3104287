"""The one place where values go into generated text: comments are escaped, templates filled in one pass."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import resources

_GAPS = re.compile(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)")
"""Where a space goes: the ends and beginnings of comments, and trigraphs."""

_PLACE = re.compile(r"@([A-Z_]+)@")


def comment(text: str) -> str:
    """Write a text inside a comment of C: it can neither end the comment nor begin another, nor join two lines.

    Pairs of characters that mean something to the compiler are set apart; a backslash, and what cannot be printed,
    becomes the number of its character. Any other text stays as it is.
    """
    written = "".join(
        letter if letter.isprintable() and letter != "\\" else f"<U+{ord(letter):04X}>" for letter in text
    )
    return _GAPS.sub(" ", written)


def template(name: str) -> str:
    """Read a template of this package."""
    return (resources.files("amble.export") / "templates" / name).read_text(encoding="utf-8")


def filled(text: str, code: Mapping[str, str], comments: Mapping[str, str] | None = None) -> str:
    """Fill the places ``@NAME@`` of a template in one pass: a place inside a value stays text.

    Args:
        text: the template.
        code: name of the place -> code, written by this package.
        comments: name of the place -> any text, escaped for a comment.
    """
    values = {**code, **{name: comment(value) for name, value in (comments or {}).items()}}
    return _PLACE.sub(lambda place: values[place.group(1)], text)
