"""Residuals of stabilised outputs: the closed loop's own orbit must return to its fixed point."""

from __future__ import annotations

import numpy as np

from amble.gait.record import Feedback, Gait
from amble.hybrid import Switch
from amble.types import Vector
from amble.verification.findings import Finding, residuals
from amble.verification.output_dynamics import OutputDynamics, integrate
from amble.verification.sizes import size_of, sizes
from amble.verification.stance_model import smallest_torques, terms
from amble.verification.switch_rows import NO_TIME, plastic


def feedback_findings(gait: Gait, tolerance: float) -> list[Finding]:
    """Integrate the stabilised loop once around; nothing where the gait is not stabilised."""
    if gait.feedback is None:
        return []
    size = gait.robot.size
    start = np.asarray(gait.feedback.start)
    state, found = start, []
    for switch in gait.pattern.switches:
        state, guard = _passed(gait, gait.feedback, switch, state)
        scale = sizes(gait.robot).length if switch.landing else sizes(gait.robot).force
        found += residuals("feedback", [f"{switch.name} feedback guard at the end"], guard, NO_TIME, tolerance, scale)
    if gait.pattern.mirrored:
        state = gait.robot.mirror.state(state)
    names = gait.robot.coordinate_names
    rows = [f"feedback returns {name}" for name in names] + [f"feedback returns rate of {name}" for name in names]
    least = sizes(gait.robot)
    missed = (state - start) / np.concatenate([least.positions, size_of(start[size:], least.rates)])
    forward = 1 if gait.pattern.mirrored else 2  # a mirrored start keeps its lateral place, others may drift sideways
    kept = [place for place in range(2 * size) if place >= forward]
    return found + residuals("feedback", [rows[place] for place in kept], missed[None, kept], NO_TIME, tolerance)


def _passed(gait: Gait, feedback: Feedback, switch: Switch, state: Vector) -> tuple[Vector, Vector]:
    """Flow through one domain and its reset; return the new state and the guard at the end."""
    robot, name, size = gait.robot, switch.source.name, gait.robot.size
    duration = feedback.durations[name]
    loop = OutputDynamics(feedback.weights[name], feedback.references[name], duration, gait.gains)
    times = np.array([0.0, duration])
    q, v = integrate(robot, switch.source.feet, loop, state[:size], state[size:], times)
    if switch.landing:
        at = terms(robot, switch.target.feet, q[-1:], v[-1:])
        guard = at.positions[0, at.foot(switch.landing[0])][2:]
        return np.concatenate([q[-1], plastic(at)[0]]), guard
    at = terms(robot, switch.source.feet, q[-1:], v[-1:])
    motion = smallest_torques(at, loop.weights, loop.commanded(times[-1:], q[-1:], v[-1:]))
    place = 3 * switch.source.feet.index(switch.lifting[0]) + 2
    return np.concatenate([q[-1], v[-1]]), motion.forces[0, place : place + 1]
