"""The closed loop of one stance under torques that are a function of the state, compiled as that of ``closed_loop``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca

from amble.codegen import compile_all
from amble.control.closed_loop import Flow, StanceLoop
from amble.control.stance_functions import fall_margin, function, guard, reset, signals
from amble.hybrid import Contacts, GaitPattern, Switch
from amble.hybrid.constrained_dynamics import StandingEquations, selection
from amble.robot import dynamics

Torques = Callable[[Contacts, ca.SX, ca.SX, ca.SX, ca.SX], ca.SX]
"""A feedback law of one stance: (contacts, t, q, v, p) -> joint torques, (n_joints,), N m."""


@dataclass(frozen=True, kw_only=True)
class DrivenMotion:
    """What torques do to a standing robot: accelerations and contact forces follow from the equations of motion.

    Attributes:
        acceleration: q'', (n_q,).
        torques: u, (n_joints,), N m.
        forces: contact forces of the stance feet, world frame, (n_f,), N.
        equations: the factored equations of motion.
        pivot: 1: no outputs are decoupled, so none can lose their rank.
    """

    acceleration: ca.SX
    torques: ca.SX
    forces: ca.SX
    equations: StandingEquations
    pivot: float = 1.0


def driven_loops(
    pattern: GaitPattern, torques: Torques, sizes: Sequence[int], lift_off: float = 0.0
) -> tuple[StanceLoop, ...]:
    """Compile the closed loops of the solved stances of a pattern under torques of the state alone.

    Their ``variation`` holds the slope of the field in x, and the response of the accelerations to the torques.

    Args:
        pattern: the stances, with the robot and its ground.
        torques: the feedback law; it has a hash.
        sizes: number of parameters p of each solved stance.
        lift_off: normal force at which feet leave the ground where none lands, N.
    """
    sources: dict[str, Sequence[ca.Function]] = {}
    derivatives: dict[str, tuple[str, ...]] = {}
    for switch, size in zip(pattern.switches, sizes, strict=True):
        name, contacts, landed = switch.source.name, pattern.contacts(switch.source), pattern.contacts(switch.target)
        force = lift_off if switch.leaving else 0.0
        events = _driven_events(contacts, landed, torques, switch, size, force)
        sources[f"loop_{name}"] = (*_driven_flow(contacts, torques, size), *events[2:])
        sources[f"switch_{name}"] = events[:2]
        derivatives[f"switch_{name}"] = ("jac",)
    native = compile_all(sources, derivatives)
    names = [switch.source.name for switch in pattern.switches]
    return tuple(StanceLoop(**native[f"loop_{name}"], **native[f"switch_{name}"]) for name in names)


def driven_flow(contacts: Contacts, torques: Torques, size: int) -> Flow:
    """Compile the motion on some feet alone, without the events of a stance; arguments as in ``driven_loops``."""
    return Flow(**compile_all({"loop": _driven_flow(contacts, torques, size)})["loop"])


def driven_motion(
    contacts: Contacts, torques: Torques, size: int, at: list[ca.SX] | None = None
) -> tuple[list[ca.SX], DrivenMotion]:
    """Write what a feedback law does to a robot that stands on some feet, over symbols (t, x, p), or at those given."""
    robot = contacts.robot
    symbols = at or [ca.SX.sym("t"), ca.SX.sym("x", 2 * robot.size), ca.SX.sym("p", size)]
    q, v = symbols[1][: robot.size], symbols[1][robot.size :]
    u, equations = torques(contacts, symbols[0], q, v, symbols[2]), StandingEquations.of(contacts, q)
    force, contact = selection(robot) @ u - dynamics.bias(robot, q, v), -contacts.bias(q, v)
    acceleration, forces = equations.solve(force, contact)
    return symbols, DrivenMotion(acceleration=acceleration, torques=u, forces=forces, equations=equations)


def driven_slopes(contacts: Contacts, symbols: list[ca.SX], motion: DrivenMotion) -> dict[str, ca.SX]:
    """Perturb D a + h - J^T lambda = B u and J a + Jdot v = 0 in q and v, instead of differentiating their solution.

    Returns:
        The slope of the field, and the response of the accelerations to the torques, (n_q, n_joints).
    """
    # shorthand
    robot, x = contacts.robot, symbols[1]
    q, v, B = x[: robot.size], x[robot.size :], selection(robot)

    a, lam = ca.SX.sym("a", robot.size), ca.SX.sym("lambda", contacts.size)
    force = dynamics.inverse_dynamics(robot, q, v, a) - contacts.jacobian(q).T @ lam
    contact = contacts.jacobian(q) @ a + contacts.bias(q, v)
    slopes = ca.Function("slopes", [x, a, lam], [ca.jacobian(force, x), ca.jacobian(contact, x)])
    moved, turned = slopes(x, motion.acceleration, motion.forces)
    slope, _ = motion.equations.solve(B @ ca.jacobian(motion.torques, x) - moved, -turned)
    response, _ = motion.equations.solve(B, ca.SX(contact.shape[0], B.shape[1]))
    above = ca.horzcat(ca.SX(robot.size, robot.size), ca.SX.eye(robot.size))
    return {"jacobian": ca.densify(ca.vertcat(above, slope)), "response": ca.densify(response)}


@lru_cache(maxsize=64)
def _driven_flow(contacts: Contacts, torques: Torques, size: int) -> tuple[ca.Function, ...]:
    symbols, motion = driven_motion(contacts, torques, size)
    half = contacts.robot.size
    q, v = symbols[1][:half], symbols[1][half:]
    return (
        function("field", symbols, {"rate": ca.vertcat(v, motion.acceleration)}),
        function("variation", symbols, driven_slopes(contacts, symbols, motion)),
        function("signals", symbols, signals(contacts, q, v, motion)),
        function("admissibility", symbols, {"margin": fall_margin(contacts, q)}),
    )


@lru_cache(maxsize=32)
def _driven_events(
    contacts: Contacts, landed: Contacts, torques: Torques, switch: Switch, size: int, lift_off: float
) -> tuple[ca.Function, ...]:
    symbols, motion = driven_motion(contacts, torques, size)
    half = contacts.robot.size
    q, v = symbols[1][:half], symbols[1][half:]
    here, after = guard(contacts, switch, q, motion, lift_off), reset(landed, switch, q, v)
    events = function("guard", symbols, {"guard": here}), function("reset", symbols, {"state": after})
    if not switch.leaving:
        return events
    B, forces = selection(contacts.robot), ca.SX.sym("forces", contacts.size)
    _, response = motion.equations.solve(B, ca.SX(contacts.size, B.shape[1]))
    slope = ca.jacobian(guard(contacts, switch, q, replace(motion, forces=forces), lift_off), forces) @ response
    return *events, function("push", symbols, {"push": ca.densify(slope)})
