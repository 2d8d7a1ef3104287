"""The exported controller against a whole-body quadratic program: microseconds a call, and bytes of code."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np

from amble.codegen import compiler
from amble.codegen.compiler import Compiler
from amble.control import AllocationLaw, BoundedMinimumNorm, MinimumPeak, MinimumPower, PseudoInverse
from amble.export import Exported, export_controller
from amble.gait import Gait
from benchmarks.baselines import Task, WholeBodyProgram
from benchmarks.gaits import walking_gait

REPETITIONS = 200
"""Calls of each test vector."""

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2")


def main() -> None:
    """Print median and 99th percentile of every controller on states of the same gait, and how many times faster."""
    tool = compiler()
    if tool is None:
        print("no C compiler: nothing to compare")
        return
    gait = walking_gait()
    laws = (
        PseudoInverse(),
        MinimumPower("datasheet"),
        MinimumPeak(),
        BoundedMinimumNorm(gait.pattern.ground.friction, gait.limits.normal_force),
    )
    print(f"{'':38} {'median (us)':>12} {'99 % (us)':>10} {'code a domain (KB)':>19}")
    medians = [_exported(gait, law, tool) for law in laws]
    totals = _program(gait)
    for name, total in totals.items():
        print(f"exported {laws[-1].name} against model and {name}: {total / medians[-1]:.1f} times faster (medians)")


def _exported(gait: Gait, law: AllocationLaw, tool: Compiler) -> float:
    """Time an exported controller by the program that comes with it."""
    with tempfile.TemporaryDirectory() as folder:
        exported = export_controller(gait, law, folder)
        sizes = _build(exported, tool)
        command = [str(Path(folder, "replay")), str(Path(folder, "test_vectors.txt")), str(REPETITIONS)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    words = done.stdout.splitlines()[-1].replace(",", "").split()
    median, late = float(words[1]), float(words[5])
    print(f"{f'exported C, {law.name}':38} {median:12.1f} {late:10.1f} {max(sizes) / 1024.0:19.0f}")
    return median


def _build(exported: Exported, tool: Compiler) -> list[int]:
    """Compile strictly; returns the sizes of the stances' object files, bytes."""
    names = [path.name for path in (*exported.sources, exported.folder / "replay.c")]
    subprocess.run([tool.path, *STRICT, "-c", *names], cwd=exported.folder, check=True)
    objects = [Path(name).with_suffix(".o").name for name in names]
    subprocess.run([tool.path, "-o", "replay", *objects, "-lm"], cwd=exported.folder, check=True)
    return [(exported.folder / f"amble_law_{law.stance.name}.o").stat().st_size for law in exported.laws]


def _program(gait: Gait) -> dict[str, float]:
    """Time model evaluation and both solvers along the first stance; returns the medians of their sums."""
    task = Task(gait, gait.pattern.solved[0])
    with resources.as_file(resources.files("amble.robot.catalogue") / "astro.urdf") as path:
        whole = WholeBodyProgram(task, str(path))
    part = gait.domains[0]
    states = [
        (float(clock), np.concatenate([q, v]))
        for clock, q, v in zip(part.times, part.positions, part.velocities, strict=True)
    ]
    programs = [whole.program(clock, x) for clock, x in states]
    solvers = {"quadprog": whole.with_quadprog, "proxqp": whole.with_proxqp}
    model = _timed(lambda i: whole.program(*states[i]), len(states), "model and program, Pinocchio and numpy")
    totals = {}
    for name, solve in solvers.items():

        def once(i: int, solve: Callable[..., object] = solve) -> object:
            return solve(programs[i])

        totals[name] = model + _timed(once, len(states), f"program alone, {name}, from Python")
    inside = [whole.microseconds(program) for program in programs for _ in range(10)]
    median, late = np.percentile(inside, [50.0, 99.0])
    print(f"{'program alone, proxqp, its own clock':38} {median:12.1f} {late:10.1f}")
    return totals


def _timed(call: Callable[[int], object], count: int, what: str) -> float:
    """Print and return the median of the calls for all states, microseconds."""
    seconds = []
    for _ in range(max(1, 3000 // count)):
        for i in range(count):
            began = time.perf_counter()
            call(i)
            seconds.append(time.perf_counter() - began)
    median, late = (1e6 * float(value) for value in np.percentile(seconds, [50.0, 99.0]))
    print(f"{what:38} {median:12.1f} {late:10.1f}")
    return median


if __name__ == "__main__":
    main()
