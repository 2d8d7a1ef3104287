"""A command as a process: signals, streams and exit codes, from the first import to the last line."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from types import FrameType, TracebackType
from typing import Any, TextIO

from amble.errors import AmbleError

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SENTENCES = {
    signal.SIGINT: "interrupted; files that were complete before are as they were",
    signal.SIGTERM: "terminated; files that were complete before are as they were",
}
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "1")
"""The matrices here have tens of rows, for which OpenBLAS's threads only wait for each other, actively: a stabilisation
takes 30 s of wall and 55 s of processor time with two of them, 17 and 15 s with one (docs/decisions.md)."""
AGAIN = 0.05
"""Seconds after which an interruption that an import or a destructor swallowed is raised again."""


class Endings:
    """Handlers of both signals while a block lasts.

    Whatever fails after a signal has arrived fails because of it: libraries turn the exception of Python's handler into
    errors of their own.
    """

    def __init__(self, own_process: bool) -> None:
        self._own_process = own_process
        self._received: signal.Signals | None = None
        self._before: dict[signal.Signals, Any] = {}
        self._hook = sys.unraisablehook

    def __enter__(self) -> Endings:
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.getsignal(number) for number in SIGNALS}
            signal.signal(signal.SIGTERM, self._terminate)
            if self._before[signal.SIGINT] is signal.default_int_handler:  # a background job ignores Ctrl-C
                signal.signal(signal.SIGINT, self._interrupt)
            sys.unraisablehook = self._unraisable
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        if self._before:
            for number, handler in self._before.items():
                # a process that is ending has nothing left to interrupt
                signal.signal(number, signal.SIG_IGN if self._own_process else handler)
            sys.unraisablehook = self._hook

    def ending(self, work: Callable[[], None]) -> int:
        """Do the work, say how it failed and return its exit code; an exception that is not amble's own traces."""
        try:
            work()
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
            if code == 0 or (self._received is None and code != 128 + signal.SIGINT):
                return code
        except AmbleError as error:
            if self._received is None:
                _say(f"error: {error}")
                return error.exit_code
        except BaseException as error:
            if self._received is None and not isinstance(error, KeyboardInterrupt):
                raise
        else:
            return 0
        number = self._received or signal.SIGINT
        _say(SENTENCES[number])
        return 128 + number

    def _interrupt(self, *_: Any) -> None:
        self._received = self._received or signal.SIGINT
        raise KeyboardInterrupt

    def _terminate(self, _: int, frame: FrameType | None) -> None:
        """End as Ctrl-C would at this instant: a solver keeps that until its iteration has ended."""
        self._received = signal.SIGTERM
        handler = signal.getsignal(signal.SIGINT)
        if not callable(handler):
            raise KeyboardInterrupt
        handler(signal.SIGINT, frame)

    def _unraisable(self, unraisable: Any) -> None:
        """Raise an interruption again that had come where no exception can leave, such as a destructor."""
        if self._received is None or not issubclass(unraisable.exc_type, KeyboardInterrupt):
            self._hook(unraisable)
            return
        timer = threading.Timer(AGAIN, _raise_in_main_thread, [self._received])
        timer.daemon = True
        timer.start()


def _raise_in_main_thread(number: signal.Signals) -> None:
    """Send a signal to the thread that handles it, which may be asleep in a call of the system."""
    main = threading.main_thread().ident
    if main is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main, number)
    else:
        signal.raise_signal(number)


def _say(text: str) -> None:
    """Print a line on standard error, with nothing to import that a signal could have cut short."""
    print(text, file=sys.stderr, flush=True)


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


def main(arguments: list[str] | None = None) -> None:
    """Run the program and exit.

    The exit code is 0, 1 (the work failed, or its result could not be printed), 2 (bad usage or input), 130 (Ctrl-C) or
    143 (SIGTERM).

    Args:
        arguments: of the program; those of this process if None, which then ends with it.
    """
    if arguments is None:  # a process of our own, in which numpy was not imported yet
        os.environ.setdefault(*ONE_THREAD)
    with Endings(own_process=arguments is None) as endings, tolerant_streams() as streams:
        code = endings.ending(lambda: _run(arguments))
        raise SystemExit(streams.code_with_losses(code))


def _run(arguments: list[str] | None) -> None:
    # imported here, where Ctrl-C has its sentence already
    from amble.cli.app import app
    from amble.cli.console import log_to_stderr

    log_to_stderr()
    app(arguments, prog_name="amble")
