"""The baselines are what they claim to be: solutions of the same equations, one with jumps, one without."""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

from amble.control import BoundedMinimumNorm, PseudoInverse
from amble.export.law import stance_laws
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.simulation import simulate

for extra in ("pinocchio", "proxsuite", "quadprog"):
    pytest.importorskip(extra)

from benchmarks.baselines import Task, WholeBodyProgram, basic_solution  # noqa: E402  (its libraries are there)

SAMPLES = 801


@pytest.fixture(scope="module")
def motion(stabilised_gait: Gait) -> tuple[np.ndarray, np.ndarray]:
    """Clock and states of the first stance of the closed loop's own motion, 0.25 ms apart."""
    trace = simulate(closed_loop(stabilised_gait), start_state(stabilised_gait), 1, 1e-10, SAMPLES)
    inside = trace.domain == 0
    return trace.clock[inside], trace.state[inside]


@pytest.fixture(scope="module")
def task(stabilised_gait: Gait) -> Task:
    return Task(stabilised_gait, stabilised_gait.pattern.solved[0])


def largest_steps(torques: np.ndarray) -> tuple[float, float]:
    """Largest change of a torque from sample to sample, and from every second sample to the next."""
    fine, coarse = (float(np.abs(np.diff(torques[::every], axis=0)).max()) for every in (1, 2))
    return fine, coarse


def test_the_basic_solution_jumps(stabilised_gait: Gait, task: Task) -> None:
    """Along a path of postures on which another joint becomes the one that is left out."""
    found, zeroed = [], []
    start, size = start_state(stabilised_gait), stabilised_gait.robot.size
    bend = np.zeros(2 * size)
    bend[6:size] = np.random.default_rng(0).normal(0.0, 0.5, size - 6)
    for share in np.linspace(0.0, 1.0, SAMPLES):
        A, r = (np.asarray(part.full()) for part in task.wide_system(0.1, start + share * bend))
        u, joint = basic_solution(A, r.ravel())
        # backward stable: residual of the size of roundoff
        assert np.max(np.abs(A @ u - r.ravel())) <= 1e-9 * np.max(np.abs(r))
        assert u[joint] == 0.0
        found.append(u)
        zeroed.append(joint)
    fine, coarse = largest_steps(np.array(found))
    assert len(set(zeroed)) > 1
    assert fine > 5.0
    assert fine > 0.9 * coarse  # as large at half the spacing: no slope


@pytest.mark.parametrize("friction", [0.6, 0.45])
def test_the_bounded_law_does_not(
    stabilised_gait: Gait, motion: tuple[np.ndarray, np.ndarray], friction: float
) -> None:
    law = BoundedMinimumNorm(friction, stabilised_gait.limits.normal_force)
    found = stance_laws(stabilised_gait, law)[0]
    torques = [found.function(t, x, found.parameters)[0].full().ravel() for t, x in zip(*motion, strict=True)]
    fine, coarse = largest_steps(np.array(torques))
    assert fine < 1.0
    assert fine < 0.6 * coarse  # a slope: half the spacing, half the step


@pytest.mark.parametrize("solver", ["with_quadprog", "with_proxqp"])
def test_the_whole_body_program_finds_the_closed_form(
    stabilised_gait: Gait, task: Task, motion: tuple[np.ndarray, np.ndarray], solver: str
) -> None:
    """Another model, another formulation, other solvers: the minimum norm where no limit is active."""
    found = stance_laws(stabilised_gait, PseudoInverse())[0]
    with resources.as_file(resources.files("amble.robot.catalogue") / "astro.urdf") as path:
        whole = WholeBodyProgram(task, str(path))
    compared = 0
    for clock, x in list(zip(*motion, strict=True))[::40]:
        program = whole.program(clock, x)
        torques, forces, *_ = (part.full().ravel() for part in found.function(clock, x, found.parameters))
        standing = forces.reshape(-1, 3)[[foot in task.stance.feet for foot in task.robot.foot_names]]
        slope = stabilised_gait.pattern.ground.friction / np.sqrt(2.0)
        if np.any(np.abs(standing[:, :2]) > slope * standing[:, 2:]):
            continue
        compared += 1
        # the program also weighs accelerations and forces, by 1e-8 of the torques; proxqp stops at 1e-6
        assert np.max(np.abs(getattr(whole, solver)(program) - torques)) <= 1e-4
    assert compared > 10
