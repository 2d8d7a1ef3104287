"""What a gait claims of its motion, held against its closed loop's own orbit: entry, durations, speed, feet at ground.

Sizes are shares of the leg length l, and of sqrt(g l) for velocities.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.analysis import ContactBounds, contact_report
from amble.gait import Gait
from amble.gait.closed_loop import start_state
from amble.hybrid import HybridSystem
from amble.residual import Residual
from amble.robot import kinematics
from amble.robot.natural_units import natural_units, velocity_unit
from amble.simulation import Trace, simulate
from amble.simulation.world_axes import in_world_axes
from amble.types import Vector

TOLERANCE = 1e-10
"""Of the integrator, for the cycle that is looked at."""

RECORD = 1e-3
"""How far the orbit may be from what is recorded, as a share of its size: a transcription on a coarse mesh stays within
it, a motion of another gait does not."""

GROUND = 1e-3
"""Largest distance of a foot on the ground from the ground, as a share of the leg length."""

LANDING = 1e-3
"""Smallest speed downwards of a landing foot, as a share of sqrt(g l): a foot that grazes has no touchdown time."""


def orbit_conditions(gait: Gait, system: HybridSystem, state: Vector) -> tuple[Residual, ...]:
    """Return what must hold on the cycle from a fixed point: the gait's claims, and every contact.

    Limits of joints are not conditions of the model's validity; the report shows them.

    Args:
        gait: the gait.
        system: its closed loop over the full cycle.
        state: the fixed point at the entry of the first domain, (2 n_q,).
    """
    trace = in_world_axes(gait, simulate(system, state, 1, TOLERANCE))
    if not trace.completed:
        return (Residual(f"the cycle is completed: {trace.ended}", 1.0, float(trace.cycles), 1.0),)
    margin = GROUND * gait.robot.leg_length
    bounds = replace(
        ContactBounds.of_gait(gait, penetration=margin, drift=margin, touchdown=margin), torques={}, speeds={}
    )
    return (
        *entry_rows(gait, state),
        *_duration_rows(gait, trace),
        *_speed_rows(gait, trace),
        *_ground_rows(gait, trace, margin),
        *_lift_off_rows(gait, trace),
        *_rising_rows(gait, system, trace),
        *contact_report(trace, gait.pattern, bounds).rows,
    )


def entry_rows(gait: Gait, state: Vector) -> list[Residual]:
    """Return the recorded entry, and the feedback's start, less the fixed point; lengths in l, times in sqrt(l / g).

    Args:
        gait: the gait.
        state: the fixed point at the entry of the first domain, (2 n_q,).
    """
    first, names = gait.domains[0], gait.robot.coordinate_names
    units = natural_units(gait.robot, gait.robot.leg_length)
    starts = {"recorded entry": np.concatenate([first.positions[0], first.velocities[0]])}
    if gait.feedback is not None:
        starts["start of the feedback"] = start_state(gait)
    rows = []
    for what, start in starts.items():
        missed = (start - state) / units
        labels = [*names, *(f"rate of {name}" for name in names)]
        rows += [
            Residual(f"{what} less the fixed point, {label}", -RECORD, float(value), RECORD)
            for label, value in zip(labels, missed, strict=True)
        ]
    return rows


def _duration_rows(gait: Gait, trace: Trace) -> list[Residual]:
    """Durations on the orbit against those recorded, and those that the feedback's references run over."""
    stances, solved = gait.pattern.stances, len(gait.pattern.solved)
    rows = []
    for number, stance in enumerate(stances):
        walked = float(trace.clock[trace.domain == number][-1])
        trajectory = gait.domains[number % solved]
        claims = {"recorded": trajectory.duration}
        if gait.feedback is not None:
            claims["of the feedback"] = gait.feedback.durations[trajectory.name]
        rows += [
            Residual(
                f"{stance.name} duration against that {what}", (1.0 - RECORD) * claim, walked, (1.0 + RECORD) * claim
            )
            for what, claim in claims.items()
        ]
    return rows


def _speed_rows(gait: Gait, trace: Trace) -> list[Residual]:
    """The mean velocity along x; where the gait does not go straight ahead, that along y and the turn too."""
    margin, took = RECORD * velocity_unit(gait.robot), float(trace.time[-1] - trace.time[0])
    *way, turn = gait.command.way(took)
    over = gait.robot.base.spatial(trace.section[:, : gait.robot.size])[:, :2]
    walked = (over[-1] - over[0]) / took
    what = ("speed walked against the speed claimed", "speed walked sideways against the speed claimed")
    rows = [
        Residual(name, claim / took - margin, float(value), claim / took + margin)
        for name, claim, value in zip(what, way, walked, strict=True)
    ]
    if gait.command.ahead:
        return rows[:1]
    first, last = (np.asarray(kinematics.base_rotation(row)) for row in (trace.section[0], trace.section[-1]))
    apart = last @ first.T
    turned_by = float(np.arctan2(apart[1, 0] - apart[0, 1], apart[0, 0] + apart[1, 1]))
    missed = float(np.arctan2(np.sin(turned_by - turn), np.cos(turned_by - turn)))
    return [*rows, Residual("turn of a cycle less that claimed", -RECORD, missed, RECORD)]


def _ground_rows(gait: Gait, trace: Trace, margin: float) -> list[Residual]:
    """Stance feet on the ground from entry to end, neither above nor below; landing feet coming down."""
    feet, pattern = gait.robot.foot_names, gait.pattern
    points = trace.signals["foot"].reshape(len(trace.time), len(feet), -1)
    velocities = trace.signals["foot_velocity"].reshape(points.shape)
    gap = pattern.ground.gap(points)
    rate = np.sum(velocities * pattern.ground.normal(points), axis=-1)
    slowest = LANDING * velocity_unit(gait.robot)
    rows = []
    for number, switch in enumerate(pattern.all_switches):
        inside = np.flatnonzero(trace.domain == number)
        for foot in switch.source.feet:
            values = gap[inside, feet.index(foot)]
            worst = float(values[np.argmax(np.abs(values))])
            rows.append(Residual(f"{switch.source.name} {foot} height on the ground", -margin, worst, margin))
        for foot in switch.landing:
            end = inside[-1], feet.index(foot)
            name = f"{switch.name} {foot} touchdown velocity along the normal"
            rows.append(Residual(name, -np.inf, float(rate[end]), -slowest))
    return rows


def _lift_off_rows(gait: Gait, trace: Trace) -> list[Residual]:
    """Feet that leave by force do so at the smallest normal force, each of them."""
    pattern, feet, count = gait.pattern, gait.robot.foot_names, len(trace.time)
    forces = trace.signals["force"].reshape(count, len(feet), -1)
    frames = pattern.ground.frame(trace.signals["foot"].reshape(count, len(feet), -1))
    normal = pattern.contact.normal_force(pattern.contact.local(forces, frames))
    least, margin = gait.limits.normal_force, RECORD * gait.robot.mass * gait.robot.gravity
    rows = []
    for number, switch in enumerate(pattern.all_switches):
        end = np.flatnonzero(trace.domain == number)[-1]
        for foot in switch.leaving:
            value = float(normal[end, feet.index(foot)])
            rows.append(Residual(f"{switch.name} {foot} lift-off force", least - margin, value, least + margin))
    return rows


def _rising_rows(gait: Gait, system: HybridSystem, trace: Trace) -> list[Residual]:
    """Feet that have left by force accelerate away from the ground at once; in g."""
    robot, pattern, visited = gait.robot, gait.pattern, gait.pattern.stances
    rows = []
    for number, switch in enumerate(pattern.all_switches):
        for foot in switch.leaving:
            following = (number + 1) % len(visited)
            domain = next(known for known in system.domains if known.name == visited[following].name)
            x = trace.state[np.flatnonzero(trace.domain == following)[0]]
            rate = np.asarray(domain.field(0.0, x, domain.parameters)).ravel()
            q, v, a = x[: robot.size], x[robot.size :], rate[robot.size :]
            point = np.asarray(kinematics.foot_position(robot, foot, q)).ravel()
            jacobian = np.asarray(kinematics.foot_jacobian(robot, foot, q))
            bias = np.asarray(kinematics.foot_bias(robot, foot, q, v)).ravel()
            up = float(pattern.ground.normal(point) @ (jacobian @ a + bias)) / robot.gravity
            rows.append(Residual(f"{switch.name} {foot} acceleration upwards just after lift-off", 0.0, up, np.inf))
    return rows
