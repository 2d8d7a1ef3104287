"""Residuals of stabilised outputs: the closed loop's own orbit must return to its fixed point."""

from __future__ import annotations

import numpy as np

from amble.control.phase import DomainPhase
from amble.gait.record import Feedback, Gait
from amble.hybrid import Switch
from amble.residual import Residual
from amble.robot.turn import turned
from amble.types import Vector, frozen
from amble.verification.output_dynamics import Effort, OutputDynamics, integrate
from amble.verification.residuals import residuals, size_of, sizes
from amble.verification.stance_model import terms
from amble.verification.switch_rows import NO_TIME, plastic


def feedback_residuals(gait: Gait, tolerance: float) -> list[Residual]:
    """Integrate the stabilised loop once around; nothing where the gait is not stabilised."""
    if gait.feedback is None:
        return []
    size = gait.robot.size
    start = np.asarray(gait.feedback.start)
    state, found, effort = start, [], Effort.of(len(gait.domains))
    for switch in gait.pattern.switches:
        state, guards = _passed(gait, gait.feedback, switch, state, effort)
        landed = [f"{switch.name} feedback {name} at the end" for name in guards]
        scale = sizes(gait.robot).length if switch.landing else 1.0  # forces are given over the weight
        found += residuals("feedback", landed, np.array([*guards.values()]).T, NO_TIME, tolerance, scale)
    if gait.pattern.mirrored:
        state = gait.robot.mirror.state(state)
    if gait.turn:
        state = np.concatenate([part[0] for part in turned(state[None, :size], state[None, size:], -gait.turn)])
    # a mirrored start keeps its lateral place, others may drift sideways
    axes, forward = list(gait.robot.base.axes), 1 if gait.pattern.mirrored or not gait.robot.base.in_space else 2
    names = gait.robot.coordinate_names
    rows = [f"feedback returns {name}" for name in names] + [f"feedback returns rate of {name}" for name in names]
    least, missed = sizes(gait.robot), state - start
    for place, along in enumerate(gait.pattern.ground.translations.values()):
        if place < forward:
            missed[: len(axes)] -= missed[place] * along[axes]
    missed /= np.concatenate([least.positions, size_of(start[size:], least.rates)])
    kept = [place for place in range(2 * size) if place >= forward]
    return found + residuals("feedback", [rows[place] for place in kept], missed[None, kept], NO_TIME, tolerance)


def _passed(
    gait: Gait, feedback: Feedback, switch: Switch, state: Vector, effort: Effort
) -> tuple[Vector, dict[str, Vector]]:
    """Flow through one domain and its reset; return the new state and what is zero at the end, by name."""
    name, size, contacts = switch.source.name, gait.robot.size, gait.pattern.contacts(switch.source)
    duration = feedback.durations[name]
    loop = OutputDynamics(
        weights=feedback.weights[name],
        references=feedback.references[name],
        duration=duration,
        gains=gait.gains,
        domain=DomainPhase(phase=gait.outputs.phase, robot=gait.robot, stance=switch.source),
        phase_numbers=feedback.phase_numbers.get(name, frozen([])),
    )
    times = np.array([0.0, duration])
    q, v = integrate(contacts, loop, state[:size], state[size:], times, effort)
    if switch.landing:
        at = terms(gait.pattern.contacts(switch.target), q[-1:], v[-1:])
        return np.concatenate([q[-1], plastic(at)[0]]), {f"height {foot}": at.gap(foot) for foot in switch.landing}
    at = terms(contacts, q[-1:], v[-1:])
    motion = loop.solve(at, times[-1:], q[-1:], v[-1:])
    forces = [contacts.contact.normal_force(at.local_force(foot, motion.forces)) for foot in switch.leaving]
    missed = np.mean(forces, axis=0) - gait.limits.normal_force
    weight = gait.robot.mass * gait.robot.gravity
    return np.concatenate([q[-1], v[-1]]), {
        f"lift-off force of {', '.join(switch.leaving)} over the weight": missed / weight
    }
