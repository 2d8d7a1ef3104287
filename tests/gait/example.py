"""A gait record with every field filled with random numbers: good for files, no motion that could be walked."""

from __future__ import annotations

import numpy as np

from amble.control import Outputs
from amble.control.allocation import AllocationLaw, PseudoInverse
from amble.control.outputs import joint_outputs
from amble.gait import DomainTrajectory, Feedback, Gait, LagrangeMultipliers, Limits, SolverReport
from amble.hybrid import GaitPattern, Stance
from amble.hybrid.gaits import amble
from amble.robot import catalogue
from amble.types import frozen

NODES = 7


def random_gait(seed: int = 0, law: AllocationLaw | None = None, stabilised: bool = True) -> Gait:
    """Fill a gait of the catalogue's astro."""
    random = np.random.default_rng(seed)
    pattern = amble(catalogue.astro())
    outputs = joint_outputs(pattern, order=4)
    domains = tuple(_domain(random, pattern, stance, outputs) for stance in pattern.solved)
    return Gait(
        pattern=pattern,
        outputs=outputs,
        law=PseudoInverse() if law is None else law,
        speed=0.2,
        gains=(100.0, 20.0),
        limits=_limits(pattern),
        domains=domains,
        solver=SolverReport(
            solver="ipopt",
            status="Solve_Succeeded",
            iterations=39,
            seconds=5.6,
            variables=4588,
            constraints=4523,
            violation=1.2e-9,
            objective=61.25,
        ),
        feedback=_feedback(random, pattern, outputs) if stabilised else None,
        versions={"amble": "0.1.0", "casadi": "3.8.2"},
        multipliers=LagrangeMultipliers(frozen(random.normal(size=4588)), frozen(random.normal(size=4523)))
        if seed
        else None,
    )


def _domain(random: np.random.Generator, pattern: GaitPattern, stance: Stance, outputs: Outputs) -> DomainTrajectory:
    size, joints = pattern.robot.size, len(pattern.robot.joints)
    switch = next(switch for switch in pattern.switches if switch.source is stance)
    draw = random.normal
    duration = float(random.uniform(0.05, 0.15))
    return DomainTrajectory(
        name=stance.name,
        duration=duration,
        coefficients=frozen(draw(size=(len(outputs.of(stance.name).coordinates), outputs.order + 1))),
        times=frozen(np.linspace(0.0, duration, NODES)),
        positions=frozen(draw(size=(NODES, size))),
        velocities=frozen(draw(size=(NODES, size))),
        accelerations=frozen(draw(size=(NODES, size))),
        torques=frozen(draw(size=(NODES, joints))),
        forces=frozen(draw(size=(NODES, 3 * len(stance.feet)))),
        impulse=frozen(draw(size=3 * len(switch.target.feet))),
    )


def _limits(pattern: GaitPattern) -> Limits:
    robot = pattern.robot
    return Limits(
        durations={stance.name: (0.01, 0.15) for stance in pattern.solved},
        positions={"z": (0.3, 0.9), **{joint.name: (joint.lower, joint.upper) for joint in robot.joints}},
        speeds=dict.fromkeys(robot.joint_names, 4.0),
        torques=dict.fromkeys(robot.joint_names, float("inf")),
        acceleration=100.0,
        touchdown_velocity=((-0.2, 0.3), (-0.1, 0.1), (-float("inf"), 0.0)),
        normal_force=10.0,
        clearance=0.02,
    )


def _feedback(random: np.random.Generator, pattern: GaitPattern, outputs: Outputs) -> Feedback:
    observed = 3 + len(pattern.robot.joints)
    solved = [stance.name for stance in pattern.solved]
    controlled = {name: len(outputs.of(name).coordinates) for name in solved}
    return Feedback(
        references={name: frozen(random.normal(size=(observed, 8))) for name in solved},
        weights={name: frozen(random.normal(size=(controlled[name], observed))) for name in solved},
        durations={name: float(random.uniform(0.05, 0.15)) for name in solved},
        start=frozen(random.normal(size=2 * pattern.robot.size)),
    )
