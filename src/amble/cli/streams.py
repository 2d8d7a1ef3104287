"""Standard output and error that may be closed, full, or unable to hold a character: the work is done all the same."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO


class Tolerant:
    """A text stream that writes what it can: ``?`` for a character it cannot hold, nothing after a failure.

    Attributes:
        failure: the first failure.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write, and answer as if that had worked."""
        if self.failure is None:
            try:
                return self._written(text)
            except OSError as error:
                self._fail(error)
        return len(text)

    def flush(self) -> None:
        """Flush, as far as that works."""
        if self.failure is None:
            try:
                self._stream.flush()
            except OSError as error:
                self._fail(error)

    def _written(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except UnicodeEncodeError:
            encoding = self._stream.encoding or "ascii"
            return self._stream.write(text.encode(encoding, "replace").decode(encoding))

    def _fail(self, error: OSError) -> None:
        """Remember the failure, and send what is still in buffers nowhere: it would fail again as Python ends."""
        self.failure = error
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class Streams:
    """Both streams of a command."""

    def __init__(self, output: Tolerant, error: Tolerant) -> None:
        self._output, self._error = output, error

    def code_with_losses(self, code: int) -> int:
        """Return the exit code of a command; 1 with a sentence where it worked and its output was lost."""
        self._output.flush()
        lost = self._output.failure
        if lost is None or lost.errno == errno.EPIPE:  # a reader that has had enough is no failure
            return code
        self._error.write(f"error: cannot write to standard output: {lost.strerror or lost}\n")
        self._error.flush()
        return code or 1


@contextlib.contextmanager
def tolerant_streams() -> Iterator[Streams]:
    """Make the standard streams tolerant while the block lasts."""
    _occupy()
    before = sys.stdout, sys.stderr
    output, error = (Tolerant(stream or open(os.devnull, "w", encoding="utf-8")) for stream in before)  # noqa: SIM115
    sys.stdout, sys.stderr = output, error
    try:
        yield Streams(output, error)
    finally:
        error.flush()
        sys.stdout, sys.stderr = before


def _occupy() -> None:
    """Open closed descriptors on nothing: a file of the command would get their numbers, and strangers' lines."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
