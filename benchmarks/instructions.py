"""Instructions of one step of the exported controllers, counted by callgrind."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

from amble.codegen import compiler
from amble.codegen.compiler import Compiler
from amble.control import PseudoInverse
from amble.export import export_controller
from amble.gait import Gait
from amble.gait.impedance import Impedance
from benchmarks.gaits import walking_gait

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off")
COLLECTED = re.compile(r"Collected : (\d+)")
REPLAYED = re.compile(r"(\d+) vectors")


def main() -> None:
    """Print the mean over all test vectors, for the linearising law and for joint impedance in double and float."""
    tool, counter = compiler(), shutil.which("valgrind")
    if tool is None or counter is None:
        print("no C compiler, or no valgrind: nothing is counted")
        return
    gait = walking_gait()
    impedance = replace(gait, control=Impedance())
    print(f"{'':38} {'instructions a step':>20}")
    for name, walker, flags in (
        ("exported C, linearisation, pinv", gait, ()),
        ("exported C, impedance, double", impedance, ()),
        ("exported C, impedance, float", impedance, ("-DAMBLE_FLOAT",)),
    ):
        print(f"{name:38} {instructions(walker, tool, counter, flags):20,.0f}", flush=True)


def instructions(gait: Gait, tool: Compiler, counter: str, flags: tuple[str, ...] = ()) -> float:
    """Return the mean number of instructions of ``amble_step`` over the test vectors.

    Args:
        gait: the gait.
        tool: compiles.
        counter: valgrind.
        flags: of the compiler.
    """
    with tempfile.TemporaryDirectory() as place:
        law = PseudoInverse() if gait.control is None else None
        exported = export_controller(gait, law, Path(place) / "controller")
        replay, folder = Path(place) / "replay", exported.folder
        sources = [*exported.sources, folder / "replay.c"]
        subprocess.run([tool.path, *STRICT, *flags, "-o", replay, *sources, "-lm"], check=True)
        command = [counter, "--tool=callgrind", "--toggle-collect=amble_step", f"--callgrind-out-file={place}/out"]
        done = subprocess.run(
            [*command, replay, folder / "test_vectors.txt"], capture_output=True, text=True, check=True
        )
    collected, replayed = COLLECTED.search(done.stderr), REPLAYED.search(done.stdout)
    if collected is None or replayed is None:
        raise RuntimeError(f"callgrind or the replay said something else: {done.stderr[-300:]} {done.stdout}")
    return int(collected[1]) / int(replayed[1])


if __name__ == "__main__":
    main()
