"""Start-up time, and time and peak memory of the whole reproduction."""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile

from benchmarks.figures import Figure, show, timed

RUNS = 7


def measure() -> list[Figure]:
    """Measure fresh interpreters."""
    nothing, _ = timed(lambda: _python("-c", "pass"), RUNS)
    imported, _ = timed(lambda: _python("-c", "import amble"), RUNS)
    used, _ = timed(lambda: _python("-c", "import amble; amble.synthesize, amble.simulate"), RUNS)
    usage, _ = timed(lambda: _python("-m", "amble", "--help"), RUNS)
    found = [
        Figure("python, nothing", nothing, "s", runs=RUNS),
        Figure("import amble", imported, "s", most=0.5, runs=RUNS),
        Figure("import amble, with synthesis and simulation", used, "s", runs=RUNS),
        Figure("amble --help", usage, "s", most=0.3, runs=RUNS),
    ]
    with tempfile.TemporaryDirectory() as folder:
        seconds, _ = timed(lambda: _python("-m", "amble", "reproduce", "--out", folder), 1)
    # the largest of all children so far; none of the others comes near
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0**2
    return [
        *found,
        Figure("amble reproduce", seconds, "s", note="gait, certificate, 2 x 500 cycles, table, figures"),
        Figure("amble reproduce, peak memory", peak, "GB", most=2.0),
    ]


def _python(*arguments: str) -> None:
    subprocess.run([sys.executable, *arguments], capture_output=True, check=True)


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
