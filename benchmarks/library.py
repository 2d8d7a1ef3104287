"""A large library, killed on the way, and what it came to: success, processor time, a sample checked again."""

from __future__ import annotations

import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from amble.verification.check import check
from amble.workflow.library import Library, LibraryEntry, load_library
from amble.workflow.library.axes import read_library

LARGEST_RADIUS = 0.95
SAMPLE, SEED = 100, 14
TURNS = "yaw_rate", "lateral_speed"


def main(arguments: Sequence[str]) -> None:
    """Build a library (arguments: specification, folder, kills; none by default) and say what it came to.

    Raises:
        SystemExit: a gait was lost or made twice, a gait of the sample fails its check, or arguments are missing.
    """
    if len(arguments) not in (2, 3):
        raise SystemExit("python -m benchmarks.library SPEC.toml FOLDER [KILLS]")
    specification, folder = Path(arguments[0]), Path(arguments[1])
    began = time.monotonic()
    built(specification, folder, int(arguments[2]) if len(arguments) == 3 else 0)
    library = load_library(folder)
    print(f"{(time.monotonic() - began) / 3600.0:.2f} h of wall time")
    for line in summary(library.entries):
        print(line)
    failed = checked_again(library)
    print(f"{min(SAMPLE, len(library.certified)) - len(failed)} of a sample pass their check; fail: {failed or 'none'}")
    if failed:
        raise SystemExit(1)


def built(specification: Path, folder: Path, kills: int, workers: int = 2) -> None:
    """Build a library by a command that is killed so many times, evenly over its gaits.

    Raises:
        SystemExit: a record that was there is gone or was written a second time.
    """
    command = [sys.executable, "-m", "amble", "library", str(specification), "--out", str(folder)]
    command += ["--workers", str(workers), "--quiet"]
    size, known = read_library(specification).grid.size, stamps(folder)
    for share in range(1, kills + 1):
        process = subprocess.Popen(command)
        while process.poll() is None and len(stamps(folder)) < size * share // (kills + 1):
            time.sleep(1.0)
        process.kill()
        process.wait()
        known = _kept(folder, known)
    subprocess.run(command, check=True)
    _kept(folder, known)


def stamps(folder: Path) -> dict[str, int]:
    """Return record -> when it was written, ns."""
    return {path.stem: path.stat().st_mtime_ns for path in (folder / "records").glob("*.json")}


def _kept(folder: Path, known: dict[str, int]) -> dict[str, int]:
    there = stamps(folder)
    if changed := [name for name in known if there.get(name) != known[name]]:
        raise SystemExit(f"lost or made twice: {', '.join(changed)}")
    return there


def summary(entries: Sequence[LibraryEntry]) -> list[str]:
    """Say how many gaits there are, what failed where, and what a gait costs."""
    good = [entry for entry in entries if entry.certified and float(entry.numbers["radius"] or 0.0) < LARGEST_RADIUS]
    lines = [f"{len(good)} of {len(entries)} gaits certified with a radius below {LARGEST_RADIUS:g}"]
    for name in entries[0].values:
        tried, there = (Counter(entry.values[name] for entry in each) for each in (entries, good))
        lines.append(f"{name}: " + ", ".join(f"{value:g}: {there[value]} of {tried[value]}" for value in sorted(tried)))
    for what, turns in (("mirrored", False), ("unmirrored", True)):
        lines += _cost(what, [entry for entry in entries if turns == any(entry.values.get(name) for name in TURNS)])
    failed = Counter((entry.stage, entry.reason.splitlines()[0][:80]) for entry in entries if not entry.certified)
    return lines + [f"{count} failed at '{stage}': {reason}" for (stage, reason), count in failed.most_common()]


def _cost(what: str, entries: Sequence[LibraryEntry]) -> Iterable[str]:
    """Say what gaits of one kind cost, each with what failed on the way."""
    if not entries:
        return
    whole = [sum(entry.seconds.values()) for entry in entries]
    certified = max(sum(entry.certified for entry in entries), 1)
    stages = {stage: np.mean([entry.seconds.get(stage, 0.0) for entry in entries]) for stage in entries[0].seconds}
    parts = ", ".join(f"{stage} {seconds:.1f}" for stage, seconds in stages.items())
    yield (
        f"{what}: {sum(whole) / certified:.1f} s of processor time a certified gait, median {np.median(whole):.1f}, "
        f"on average {parts}"
    )


def checked_again(library: Library) -> list[str]:
    """Return the labels of a sample's gaits that fail their check."""
    rng, certified = np.random.default_rng(SEED), library.certified
    chosen = rng.permutation(len(certified))[:SAMPLE]
    return [certified[place].label for place in chosen if not check(library.gait(certified[place])).passed]


if __name__ == "__main__":
    main(sys.argv[1:])
