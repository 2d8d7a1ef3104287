"""One family of errors; each carries its evidence and knows the exit code of the command line."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable, Sequence

from amble.residual import Residual, listing, worst_first


def printable(text: str, keep: str = "") -> str:
    """Write what cannot be printed (line ends, control characters, surrogates) as escapes of Python text.

    Messages quote what the user gave; it must not write to the terminal on its own, nor end a sentence.

    Args:
        text: any text.
        keep: characters that stay as they are.
    """
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter in keep else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )


def shown(value: object, most: int = 80) -> str:
    """Return a value from outside as it may stand in a sentence: on one line, printable, not long.

    Text stands as it is where it can, anything else as Python writes it.
    """
    text = value if isinstance(value, str) else reprlib.repr(value)
    text = printable(text)
    return text if len(text) <= most else f"{text[:most]}..."


def shown_path(path: object, most: int = 400) -> str:
    """Return the name of a file or folder as ``shown``; of a long one the end stays, which tells files apart."""
    text = printable(str(path))
    return text if len(text) <= most else f"...{text[-most:]}"


def listed(names: Iterable[str], most: int = 2000) -> str:
    """Return names as they may stand in a sentence: each as ``shown``, and no more than fit into so many characters."""
    parts = [shown(name) for name in names]
    size = 0
    for count, part in enumerate(parts):
        size += len(part) + len(", ")
        if size > most:
            return f"{', '.join(parts[:count])} and {len(parts) - count} more"
    return ", ".join(parts)


class AmbleError(Exception):
    """Base of every error that amble raises on purpose."""

    exit_code = 1


class InputError(AmbleError):
    """What the user gave cannot be used: a file, a name, a unit, a shape or a number; said on one line."""

    exit_code = 2

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class UnknownNameError(InputError):
    """A name that does not exist; the message lists the names that do."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        super().__init__(f"unknown {kind} '{shown(name)}'; known: {listed(self.known) or 'none'}")


class MissingExtraError(InputError):
    """A library that is not installed because the extra of amble that it belongs to was not asked for."""

    def __init__(self, library: str, extra: str, purpose: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(f"{purpose} need {library}, which is not installed: pip install 'amble[{extra}]'")


class WorkError(AmbleError):
    """The work itself failed although the input was sound."""


class NotSolvedError(WorkError):
    """A solver stopped without a solution: its status and the violated rows, worst first.

    Rows that were looked at and all hold are an empty sequence, and the message says so; None where there are no rows.
    """

    def __init__(self, status: str, rows: Sequence[Residual] | None = None, most: int = 8) -> None:
        self.status = status
        self.rows = worst_first(rows or ())
        evidence = [listing(self.rows, most)] if self.rows else [] if rows is None else ["no row is violated"]
        super().__init__("\n".join([f"not solved: {status}", *evidence]))


class FallError(WorkError):
    """A simulated motion left the domain in which its model holds."""


class CertificateError(WorkError):
    """A stability certificate is refused: the rows that were checked; the message lists the worst that fail."""

    def __init__(self, rows: Sequence[Residual], most: int = 20) -> None:
        self.rows = tuple(rows)
        failed = worst_first(row for row in self.rows if not row.passed)
        super().__init__(f"no certificate: {len(failed)} of {len(self.rows)} conditions fail\n{listing(failed, most)}")
