"""Ctrl-C and SIGTERM: both end a command with one sentence, after its files and folders are in order."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

from amble.errors import AmbleError

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SENTENCES = {
    signal.SIGINT: "interrupted; files that were complete before are as they were",
    signal.SIGTERM: "terminated; files that were complete before are as they were",
}
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
