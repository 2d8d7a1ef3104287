"""Allocation laws and baselines along the amble: do the torques jump, and how steep are they?"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import resources

import casadi as ca
import numpy as np

from amble.control import AllocationLaw, BoundedMinimumNorm, MinimumPeak, MinimumPower, PseudoInverse
from amble.export.law import stance_laws
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.simulation import simulate
from amble.types import NodeValues, Vector
from benchmarks.baselines import Task, WholeBodyProgram, basic_solution
from benchmarks.gaits import walking_gait

SAMPLES = 2001
"""States along one stance; also every second, to tell a jump from a slope."""

STANCE = 0


def main() -> None:
    """Print, for every law and baseline: largest step of a torque at two spacings, steepness, time a call."""
    gait = walking_gait()
    clock, states = _states(gait)
    print(f"{gait.pattern.solved[STANCE].name}: {len(clock)} states, {1e6 * clock[1]:.0f} us apart")
    print(
        f"{'':26} {'largest step (N m)':>19} {'at twice the spacing':>21} {'steepness (N m/|dx|)':>21} "
        f"{'zeroed joints':>14} {'from pinv (N m)':>16} {'call (us)':>10}"
    )
    reference: NodeValues | None = None
    for name, (allocate, zeroed) in _rules(gait).items():
        began = time.perf_counter()
        torques = np.array([allocate(t, x) for t, x in zip(clock, states, strict=True)])
        microseconds = 1e6 * (time.perf_counter() - began) / len(clock)
        reference = torques if reference is None else reference
        step, coarse = (float(np.abs(np.diff(torques[::every], axis=0)).max()) for every in (1, 2))
        slopes = np.linalg.norm(np.diff(torques, axis=0), axis=1) / np.linalg.norm(np.diff(states, axis=0), axis=1)
        print(
            f"{name:26} {step:19.4f} {coarse:21.4f} {slopes.max():21.1f} {len(set(zeroed)) or '-':>14} "
            f"{np.abs(torques - reference).max():16.2e} {microseconds:10.1f}"
        )
    print("a slope halves with the spacing, a jump does not; times are of calls from Python, the laws interpreted")
    print("the programs keep the inner friction pyramid, the bounded law the cone itself")


def _states(gait: Gait) -> tuple[Vector, NodeValues]:
    """Clock and state along one stance of the closed loop's own motion."""
    trace = simulate(closed_loop(gait), start_state(gait), 1, 1e-10, SAMPLES)
    inside = trace.domain == STANCE
    return trace.clock[inside], trace.state[inside]


def _rules(gait: Gait) -> dict[str, tuple[Callable[[float, Vector], Vector], list[int]]]:
    """Name -> (clock, state) -> torques, and the joints that a basic solution set to zero so far."""
    task = Task(gait, gait.pattern.solved[STANCE])
    laws: dict[str, AllocationLaw] = {
        "pinv": PseudoInverse(),
        "power (paper)": MinimumPower("paper"),
        "power (datasheet)": MinimumPower("datasheet"),
        "peak": MinimumPeak(),
        "bounded": BoundedMinimumNorm(gait.pattern.ground.friction, gait.limits.normal_force),
        "bounded, friction 0.45": BoundedMinimumNorm(0.45, gait.limits.normal_force),
    }
    rules: dict[str, tuple[Callable[[float, Vector], Vector], list[int]]] = {
        name: (_law(gait, law), []) for name, law in laws.items()
    }
    zeroed: list[int] = []

    def basic(clock: float, x: Vector) -> Vector:
        A, r = (np.asarray(part.full()) for part in task.wide_system(clock, x))
        u, joint = basic_solution(A, r.ravel())
        zeroed.append(joint)
        return u

    rules["basic solution (pivoting)"] = (basic, zeroed)
    with resources.as_file(resources.files("amble.robot.catalogue") / "astro.urdf") as path:
        whole = WholeBodyProgram(task, str(path))
    rules["whole-body QP, quadprog"] = (lambda t, x: whole.with_quadprog(whole.program(t, x)), [])
    rules["whole-body QP, proxqp"] = (lambda t, x: whole.with_proxqp(whole.program(t, x)), [])
    return rules


def _law(gait: Gait, law: AllocationLaw) -> Callable[[float, Vector], Vector]:
    found = stance_laws(gait, law)[STANCE]
    function: ca.Function = found.function
    return lambda clock, x: np.asarray(function(clock, x, found.parameters)[0].full()).ravel()


if __name__ == "__main__":
    main()
