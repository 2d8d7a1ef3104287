"""``python -m fuzz``: draw inputs, have them read, keep and minimise what fails; exit code 1 where anything does."""

from __future__ import annotations

import argparse
import itertools
import json
import os
import random
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from fuzz.minimise import minimised
from fuzz.oracle import slug
from fuzz.pool import Tally, Worker, run
from fuzz.registry import BY_NAME, READERS
from fuzz.worker import WALKER, content_of, suffix_of

FAILURES = Path(__file__).with_name("failures")


def requests(seed: int, count: int | None, only: str | None) -> Iterator[tuple[str, int]]:
    """Yield kinds and seeds of the readers' inputs."""
    draw = random.Random(seed)
    shares = [kind.share for kind in READERS]
    for number in itertools.count() if count is None else range(count):
        yield only or draw.choices(READERS, shares)[0].name, seed + number


def keep(tally: Tally, cache: str) -> None:
    """Minimise one input of every failure, and write it with its seed and what happened."""
    for signature, (kind, seed, verdict) in tally.failures.items():
        content, done = content_of(kind, seed)
        small = content if signature.startswith("hang") else smaller(content, kind, signature, cache)
        FAILURES.mkdir(exist_ok=True)
        path = FAILURES / f"{kind}-{slug(signature)}{suffix_of(kind)}"
        path.write_bytes(small)
        about = {"kind": kind, "seed": seed, "done": done, "signature": signature, "reason": verdict.reason}
        path.with_name(f"{path.name}.about.json").write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
        print(f"FAILED {kind} {seed} ({', '.join(done)}): {signature}\n  kept as {path} ({len(small)} bytes)")


def smaller(content: bytes, kind: str, signature: str, cache: str) -> bytes:
    """Return the smallest part that was found to fail in the same way."""
    worker = Worker(cache)
    try:
        return minimised(content, lambda part: worker.ask(kind, 0, part).signature == signature)
    finally:
        worker.stop()


def main() -> int:
    """Run the fuzzer."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("--inputs", type=int, help="inputs of the readers; endless where not given")
    parser.add_argument("--gaits", type=int, default=0, help="gaits that load, through check, certify and export")
    parser.add_argument("--seconds", type=float, default=86_400.0, help="wall time of each of the two parts")
    parser.add_argument("--seed", type=int, default=0, help="first seed; every input has its own")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", choices=list(BY_NAME), help="one kind of input")
    options = parser.parse_args()
    failures = 0
    with tempfile.TemporaryDirectory(prefix="fuzz-cache-") as cache:
        if options.inputs != 0:
            began = time.monotonic()
            wanted = requests(options.seed, options.inputs, options.only)
            tally = run(wanted, options.workers, options.seconds, cache)
            print(line("readers", "inputs", tally, time.monotonic() - began), flush=True)
            keep(tally, cache)
            failures += tally.counts["failed"]
        if options.gaits:
            began = time.monotonic()
            walkers = ((WALKER, options.seed + number) for number in itertools.count())
            tally = run(walkers, options.workers, options.seconds, cache, loaded=options.gaits)
            print(line("gaits", "inputs", tally, time.monotonic() - began), flush=True)
            for reason, count in tally.reasons.most_common():
                print(f"  {count:6d}  {reason}")
            keep(tally, cache)
            failures += tally.counts["failed"]
    return 1 if failures else 0


def line(what: str, unit: str, tally: Tally, seconds: float) -> str:
    """Return the counts of a part in one line."""
    counts = tally.counts
    return (
        f"{what}: {sum(counts.values())} {unit}, {counts['refused']} refused, {counts['loaded']} loaded, "
        f"{counts['failed']} failures of {len(tally.failures)} kinds, {seconds:.0f} s "
        f"({sum(counts.values()) / max(seconds, 1e-9):.1f} a second)"
    )


if __name__ == "__main__":
    sys.exit(main())
