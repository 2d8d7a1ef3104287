"""Sound gait files to damage: a small robot with every law and every optional part, and a real stabilised amble."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from amble.control import Outputs, joint_outputs
from amble.control.allocation.registry import law_from
from amble.gait import DomainTrajectory, Feedback, Gait, LagrangeMultipliers, Limits, SolverReport
from amble.gait.files import FORMAT, FORMAT_VERSION, to_dict
from amble.hybrid import GaitPattern, gait_pattern
from amble.hybrid.ground import Plane
from amble.types import frozen
from fuzz.robots import biped

NODES = 5
_DATA = Path(__file__).parents[1] / "tests" / "data"
SOUND = {name: _DATA / f"{name}.json" for name in ("biped-of-small-basin", "stabilised-amble")}
"""Stabilised gaits that are certified: of a biped, in 2.5 s, and of ASTRo, in 8 s."""

SOLVED = SolverReport(
    solver="ipopt",
    status="Solve_Succeeded",
    iterations=39,
    seconds=5.6,
    variables=4,
    constraints=3,
    violation=1.2e-9,
    objective=61.25,
)
"""What a solver may have said of a gait that none has found."""

LAWS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("pinv", {}),
    ("weighted", {"weights": {"l_knee": 2.0}}),
    ("drop", {"joints": []}),
    ("power", {"actuator": "datasheet"}),
    ("peak", {}),
    ("bounded", {"friction": 0.5}),
)


@cache
def small(number: int) -> str:
    """Text of a gait file whose numbers are random and no motion; another law, ground and optional parts each."""
    random = np.random.default_rng(number)
    robot = biped()
    ground = Plane(friction=0.7, slope=0.05 * (number % 2))
    table = [["l"], ["r"]] if number % 3 else [["l", "r"], ["l"], ["r", "l"], ["r"]]
    pattern = gait_pattern(robot, table, mirrored=number % 3 != 2, name="walk", ground=ground)
    free = {stance.name: ["l_pitch"] for stance in pattern.solved if len(stance.feet) == 2}
    outputs = joint_outputs(pattern, order=4, free=free)
    law, parameters = LAWS[number % len(LAWS)]
    return _written(
        Gait(
            pattern=pattern,
            outputs=outputs,
            law=law_from(law, parameters),
            speed=0.2,
            gains=(100.0, 20.0),
            limits=loose_limits(pattern),
            domains=tuple(drawn_domain(random, pattern, place, outputs) for place in range(len(pattern.solved))),
            solver=SOLVED,
            feedback=drawn_feedback(random, pattern, outputs) if number % 2 else None,
            versions={"amble": "0.1.0", "casadi": "3.8.2"},
            multipliers=LagrangeMultipliers(frozen(random.normal(size=4)), frozen(random.normal(size=3)))
            if number % 4 == 0
            else None,
        )
    )


def _written(gait: Gait) -> str:
    return json.dumps({"format": FORMAT, "format_version": FORMAT_VERSION, **to_dict(gait)})


def drawn_domain(
    random: np.random.Generator, pattern: GaitPattern, place: int, outputs: Outputs, nodes: int = NODES
) -> DomainTrajectory:
    """Draw the trajectory of a solved domain: every shape, no motion."""
    switch, stance, robot = pattern.switches[place], pattern.solved[place], pattern.robot
    duration = float(random.uniform(0.1, 0.3))

    def drawn(*shape: int) -> Any:
        return frozen(0.3 * random.normal(size=shape))

    return DomainTrajectory(
        name=stance.name,
        duration=duration,
        coefficients=drawn(len(outputs.of(stance.name).coordinates), outputs.order + 1),
        times=frozen(np.linspace(0.0, duration, nodes)),
        positions=drawn(nodes, robot.size),
        velocities=drawn(nodes, robot.size),
        accelerations=drawn(nodes, robot.size),
        torques=drawn(nodes, len(robot.joints)),
        forces=frozen(50.0 + 10.0 * random.normal(size=(nodes, pattern.contacts(stance).size))),
        impulse=drawn(pattern.contacts(switch.target).size if switch.landing else 0),
    )


def loose_limits(pattern: GaitPattern) -> Limits:
    """Limits of a gait that need not keep them."""
    joints = pattern.robot.joint_names
    return Limits(
        durations={stance.name: (0.01, 0.5) for stance in pattern.solved},
        positions={"z": (0.3, 0.9), **dict.fromkeys(joints, (-1.5, 1.5))},
        speeds=dict.fromkeys(joints, 8.0),
        torques=dict.fromkeys(joints, float("inf")),
        acceleration=100.0,
        touchdown_velocity=((-0.2, 0.3), (-0.1, 0.1), (-float("inf"), 0.0)),
        normal_force=10.0,
        clearance=0.02,
    )


def drawn_feedback(random: np.random.Generator, pattern: GaitPattern, outputs: Outputs) -> Feedback:
    """Draw the feedback of a stabilised gait."""
    names = [stance.name for stance in pattern.solved]
    observed = 3 + len(pattern.robot.joints)
    return Feedback(
        references={name: frozen(0.3 * random.normal(size=(observed, 8))) for name in names},
        weights={name: frozen(random.normal(size=(len(outputs.of(name).coordinates), observed))) for name in names},
        durations=dict.fromkeys(names, 0.2),
        start=frozen(0.3 * random.normal(size=2 * pattern.robot.size)),
    )
