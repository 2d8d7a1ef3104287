"""A simulated gait that turns, in the world's axes: its closed loop turns every cycle's state back (``Gait.turn``)."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from amble.gait import Gait
from amble.gait.cycle_end import turning_steps
from amble.robot.turn import turned_state
from amble.simulation.trace import Trace
from amble.types import NodeValues, Vector

VECTORS = ("force", "foot", "foot_velocity")
"""Signals of all feet that begin with components along x and y; moments are about the normal."""


def in_world_axes(gait: Gait, trace: Trace) -> Trace:
    """Turn the motion of every cycle forth by the turns of the cycles before it; yaw goes on continuously.

    Args:
        gait: the gait; where it goes straight the trace is returned as it is.
        trace: of its closed loop, in the axes that turn at the end of every cycle.
    """
    turning = turning_steps(gait)
    if not turning:
        return trace
    done = np.cumsum([0, *(event.transition in turning for event in trace.events)])
    arc = np.concatenate([[0], np.cumsum((np.diff(trace.domain) != 0) | (np.diff(trace.cycle) != 0))])
    angles = gait.turn * done[arc]
    before = _states(gait, np.array([event.before for event in trace.events]), gait.turn * done[:-1])
    after = _states(gait, np.array([event.after for event in trace.events]), gait.turn * done[1:])
    events = zip(trace.events, before, after, strict=True)
    signals = {
        name: _vectors(values, angles, len(gait.robot.feet)) if name in VECTORS else values
        for name, values in trace.signals.items()
    }
    return replace(
        trace,
        state=_states(gait, trace.state, angles),
        signals=signals,
        events=tuple(replace(event, before=first, after=then) for event, first, then in events),
    )


def in_cycle_axes(gait: Gait, section: NodeValues) -> NodeValues:
    """Turn the entries of the first domain of a trace in the world's axes back into those of their cycles.

    Args:
        gait: the gait.
        section: ``Trace.section``, (cycles + 1, 2 n_q).
    """
    return section if gait.turn == 0.0 else _states(gait, section, -gait.turn * np.arange(float(len(section))))


def _states(gait: Gait, states: NodeValues, angles: Vector) -> NodeValues:
    if not len(states):
        return states
    x, angle = ca.SX.sym("x", 2 * gait.robot.size), ca.SX.sym("angle")
    turn = ca.Function("turn", [x, angle], [turned_state(x, angle)]).map(len(states))
    return np.asarray(turn(states.T, angles[None])).T


def _vectors(values: NodeValues, angles: Vector, feet: int) -> NodeValues:
    turned = values.reshape(len(values), feet, -1).copy()
    x, y = turned[..., 0].copy(), turned[..., 1].copy()
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    turned[..., 0], turned[..., 1] = cosine * x - sine * y, sine * x + cosine * y
    return turned.reshape(values.shape)
