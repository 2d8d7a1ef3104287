"""How far long work is: one callback for the whole library, called with one record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class ProgressReport:
    """What long work is at.

    Attributes:
        what: what is being done or was just done, in words.
        done: how many parts of it are done; None where it has no parts.
        of: how many parts there are; None where nobody knows.
        quantity: what ``value`` is; empty where there is none.
        value: a number that tells how well it goes, such as a spectral radius.
        detail: what else there is to say, in words.
        file: a file that was just written.
    """

    what: str
    done: int | None = None
    of: int | None = None
    quantity: str = ""
    value: float | None = None
    detail: str = ""
    file: Path | None = None

    def __str__(self) -> str:
        """Return all of it on one line."""
        if self.file is not None:
            return f"{self.what} {self.file}"
        text = self.what
        if self.done is not None:
            text += f" {self.done}" if self.of is None else f" {self.done} of {self.of}"
        if self.value is not None:
            text += f", {self.quantity} {self.value:.4g}"
        return f"{text}, {self.detail}" if self.detail else text


Progress = Callable[[ProgressReport], None]
"""What a caller hands to long work; it is called now and then, in the thread that works."""


def silent(_: ProgressReport) -> None:
    """Tell nobody."""
