"""What holds for every input: it is read, or refused in one printable sentence; nothing else is said or seen."""

from __future__ import annotations

import hashlib
import re
import resource
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LONGEST_SENTENCE = 5000
SECONDS = 10
"""Processor time of one input."""

MEMORY = 2**30
"""Bytes of one process."""


@dataclass(frozen=True)
class Verdict:
    """What became of an input.

    Attributes:
        outcome: "loaded", "refused" or "failed".
        reason: the sentence, or the traceback.
        signature: of a failure, the same for the same fault: kind of error and the place it comes from.
    """

    outcome: str
    reason: str = ""
    signature: str = ""


def judged(read: Callable[[Path], Any], path: Path, exit_codes: tuple[int, ...] = (2,)) -> Verdict:
    """Read a file under the rules.

    Args:
        read: the reader.
        path: the file.
        exit_codes: of the errors that are allowed; those of the work are lines, others one sentence.
    """
    from amble.errors import AmbleError

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = read(path)
    except AmbleError as error:
        return _refusal(error, exit_codes)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return Verdict("failed", traceback.format_exc(), _signature(error))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if peak > MEMORY and peak > before * 1024:
        return Verdict("failed", f"{peak / 2**20:.0f} MB of memory", "memory")
    return Verdict("loaded", "; ".join(found) if isinstance(found, list) else "")


def _refusal(error: Any, exit_codes: tuple[int, ...]) -> Verdict:
    text, code = str(error), error.exit_code
    lines = text.splitlines() if code == 1 else [text]
    where = _signature(error)
    if code not in exit_codes:
        return Verdict("failed", traceback.format_exc(), f"exit code {code}: {where}")
    if not text.strip() or len(text) > LONGEST_SENTENCE or not all(line.isprintable() for line in lines):
        return Verdict("failed", text[: 2 * LONGEST_SENTENCE], f"no printable sentence: {where}")
    return Verdict("refused", text)


def _signature(error: BaseException) -> str:
    """Kind of error and the last places in amble on the way to it."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/amble/" in frame.filename]
    places = [f"{frame.filename.rpartition('/amble/')[2]}:{frame.name}" for frame in frames[-2:]]
    return f"{type(error).__name__} in {' > '.join(places)}"


def slug(signature: str) -> str:
    """Return a short file name for a signature."""
    digest = hashlib.sha256(signature.encode()).hexdigest()[:8]
    return f"{re.sub(r'[^A-Za-z0-9]+', '-', signature)[:50].strip('-')}-{digest}"
