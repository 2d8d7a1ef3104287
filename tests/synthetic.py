"""A mirrored amble of ASTRo made of sines: no dynamics behind it, but every shape, name and symmetry of a real one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import cast

import numpy as np

from amble.analysis import Comparison, LawMetrics, Motion, torque_metrics
from amble.control import AllocationLaw, PseudoInverse, joint_outputs
from amble.control.actuator import Actuator
from amble.gait import DomainTrajectory, Gait, Limits
from amble.hybrid import GaitPattern, gait_pattern
from amble.robot import Robot, catalogue
from amble.simulation import Trace
from fuzz.gait_bases import SOLVED

DURATIONS = (0.15, 0.05)
PERIOD = 2.0 * sum(DURATIONS)
SPEED = 0.2
ENTRIES = np.concatenate([[0.0], np.cumsum([*DURATIONS, *DURATIONS])])
Stances = tuple[tuple[str, ...], ...]
STANCES: Stances = (("fr", "rl"), ("fr", "rr"), ("fl", "rr"), ("fl", "rl"))
THREE: Stances = (("fr", "rl", "rr"), ("fr", "rl"), ("fl", "rr", "rl"), ("fl", "rr"))
"""Stances of three feet and of two in turn."""


@cache
def astro() -> Robot:
    """ASTRo, loaded once; its mirror takes a while to verify."""
    return catalogue.astro()


def amble_pattern() -> GaitPattern:
    """The four domains of ASTRo's amble."""
    return gait_pattern(astro(), STANCES, mirrored=True, name="amble")


def motion(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q and v, (n, 18): forward at SPEED, mirrored after half a period."""
    robot = astro()
    rate = 2.0 * np.pi / PERIOD
    positions, velocities = np.zeros((2, len(times), robot.size))

    def wave(column: int, mean: float, size: float, harmonic: int, lag: float) -> None:
        phase = harmonic * rate * times + lag
        positions[:, column] = mean + size * np.sin(phase)
        velocities[:, column] = size * harmonic * rate * np.cos(phase)

    wave(0, 0.0, 0.002, 2, 0.0)
    positions[:, 0] += SPEED * times
    velocities[:, 0] += SPEED
    wave(1, 0.0, 0.004, 1, 0.2)
    wave(2, 0.3, 0.003, 2, 0.5)
    wave(3, 0.0, 0.03, 1, 0.9)
    wave(4, 0.0, 0.02, 2, 1.3)
    wave(5, 0.0, 0.04, 1, 1.9)
    joints = robot.mirror.joints
    for joint, twin in enumerate(joints.index):
        if joint <= twin:
            wave(6 + joint, 0.4 + 0.1 * joint, 0.2, 1, 0.7 * joint)
            wave(6 + twin, joints.sign[joint] * (0.4 + 0.1 * joint), joints.sign[joint] * 0.2, 1, 0.7 * joint + np.pi)
    return positions, velocities


def torques(times: np.ndarray) -> np.ndarray:
    """Joint torques of the pseudo-inverse's size, (n, 12), N m, mirrored after half a period."""
    joints = astro().mirror.joints
    found = np.zeros((len(times), 12))
    for joint, twin in enumerate(joints.index):
        if joint <= twin:
            phase = 2.0 * np.pi * times / PERIOD + joint
            found[:, joint] = (4.0 + joint) * np.sin(phase)
            found[:, twin] = joints.sign[joint] * (4.0 + joint) * np.sin(phase + np.pi)
    return found


def forces(times: np.ndarray, stance: int, stances: Stances = STANCES) -> np.ndarray:
    """Contact forces of all feet in one stance, (n, 12), N: half the weight each, tilted by 0.2, swing feet zero."""
    robot = astro()
    found = np.zeros((len(times), 4, 3))
    for foot in stances[stance]:
        side = 1.0 if foot.endswith("l") else -1.0
        found[:, robot.foot_names.index(foot)] = [0.0, 21.0 * side, 105.0]
    return found.reshape(len(times), 12)


def synthetic_limits() -> Limits:
    """Limits of the size of ASTRo's."""
    robot = astro()
    return Limits(
        durations={"D1": (0.01, 0.15), "D2": (0.01, 0.15)},
        positions={name: (-3.2, 3.2) for name in robot.coordinate_names[2:]},
        speeds=dict.fromkeys(robot.joint_names, 4.0),
        torques=dict.fromkeys(robot.joint_names, 50.0),
        acceleration=100.0,
        touchdown_velocity=((-0.2, 0.3), (-0.1, 0.1), (-2.0, -0.06)),
        normal_force=10.0,
        clearance=0.02,
    )


def synthetic_gait(nodes: int = 31) -> Gait:
    """The optimised half cycle, D1 and D2."""
    pattern = amble_pattern()
    domains = []
    for number, duration in enumerate(DURATIONS):
        clock = np.linspace(0.0, duration, nodes)
        positions, velocities = motion(clock + ENTRIES[number])
        feet = [pattern.robot.foot_names.index(foot) for foot in pattern.stances[number].feet]
        force = forces(clock, number).reshape(nodes, 4, 3)[:, sorted(feet)].reshape(nodes, 6)
        domains.append(
            DomainTrajectory(
                name=f"D{number + 1}",
                duration=duration,
                coefficients=np.zeros((11, 5)),
                times=clock,
                positions=positions,
                velocities=velocities,
                accelerations=np.zeros_like(positions),
                torques=torques(clock + ENTRIES[number]),
                forces=force,
                impulse=np.zeros(6),
            )
        )
    return Gait(
        pattern=pattern,
        outputs=joint_outputs(pattern, order=4),
        law=cast(AllocationLaw, None),
        speed=SPEED,
        gains=(100.0, 20.0),
        limits=synthetic_limits(),
        domains=tuple(domains),
        solver=SOLVED,
        feedback=None,
        versions={"amble": "0.1.0"},
    )


def three_footed_gait() -> Gait:
    """The same motion on three and two feet in turn, under the pseudo-inverse."""
    gait = synthetic_gait()
    pattern = gait_pattern(astro(), THREE, mirrored=True, name="crawl")
    outputs = joint_outputs(pattern, free={"D1": ["rl_hip_pitch", "rr_hip_pitch", "fr_hip_yaw"]})
    domains = []
    for number, (domain, feet) in enumerate(zip(gait.domains, THREE, strict=False)):
        columns = sorted(astro().foot_names.index(foot) for foot in feet)
        force = forces(domain.times, number, THREE).reshape(-1, 4, 3)[:, columns].reshape(len(domain.times), -1)
        impulse = np.zeros(9 if number else 0)  # D1 ends with a foot that lifts
        coefficients = np.zeros((len(outputs.of(domain.name).coordinates), 5))
        domains.append(replace(domain, forces=force, impulse=impulse, coefficients=coefficients))
    return replace(gait, pattern=pattern, outputs=outputs, law=PseudoInverse(), domains=tuple(domains))


def measured(motions: Sequence[Motion], actuators: Sequence[Actuator]) -> Comparison:
    """Metrics of motions whose torques are given, not those of a law."""
    return Comparison(
        tuple(
            LawMetrics(
                law=law,
                motion=motion.label,
                energy={model.name: torque_metrics(motion, law, model) for model in actuators},
            )
            for motion in motions
            for law in motion.torques
        )
    )


def synthetic_trace(
    cycles: int = 2,
    samples: int = 30,
    change: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    stances: Stances = STANCES,
) -> Trace:
    """Whole cycles of the same motion as a trace; ``change`` (times, states) -> states perturbs it.

    Stance feet stand still at (number of their stance phase, 0, 0), swing feet are 5 cm up until they
    land.
    """
    parts: dict[str, list[np.ndarray]] = {}
    for visit in range(4 * cycles):
        stance, start = visit % 4, ENTRIES[visit % 4] + PERIOD * (visit // 4)
        clock = np.linspace(0.0, (DURATIONS * 2)[stance], samples)
        times = clock + start
        state = np.hstack(motion(times))
        foot = np.zeros((samples, 4, 3))
        for column, name in enumerate(astro().foot_names):
            standing = name in stances[stance]
            foot[:, column] = [visit // 4, column, 0.0] if standing else [0.0, column, 0.05]
            if not standing and name in stances[(stance + 1) % 4]:
                foot[-1, column, 2] = 0.0
            if name == "rl" and stance == 3:  # the stance phase of rl runs on into the next cycle
                foot[:, column, 0] += 1.0
        columns = {
            "time": times,
            "clock": clock,
            "domain": np.full(samples, stance),
            "cycle": np.full(samples, visit // 4),
            "state": state if change is None else change(times, state),
            "torque": torques(times),
            "force": forces(times, stance, stances),
            "foot": foot.reshape(samples, 12),
            "foot_velocity": np.zeros((samples, 12)),
            "pivot": np.full((samples, 1), 2.5),
        }
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    coordinates = astro().coordinate_names
    names = (*coordinates, *(f"d{name}" for name in coordinates))
    whole = {name: np.concatenate(values) for name, values in parts.items()}
    signals = {name: whole.pop(name) for name in ("torque", "force", "foot", "foot_velocity", "pivot")}
    return Trace(
        domains=("D1", "D2", "D3", "D4"),
        state_names=names,
        signals=signals,
        events=(),
        cycles=cycles,
        ended="completed",
        tolerance=1e-8,
        seconds=0.5,
        **whole,
    )
