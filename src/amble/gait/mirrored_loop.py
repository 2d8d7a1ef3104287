"""The mirrored half of a closed loop: the same compiled code between two mirrors of the state."""

from __future__ import annotations

from typing import Any

import casadi as ca

from amble.control.closed_loop import StanceLoop
from amble.control.stance_functions import ARGUMENTS
from amble.hybrid import Domain, GaitPattern, Switch, Transition
from amble.robot import Robot


def mirrored_domain(pattern: GaitPattern, name: str, original: Domain) -> Domain:
    """Return the mirror image of a domain: mirror the state, evaluate the same code, mirror the result."""
    robot = pattern.robot
    t, x, p = _symbols(original.field)
    image, mirror = robot.mirror.state(x), ca.MX(_state_matrix(robot))

    def mirrored(what: str, value: ca.MX, result: str) -> ca.Function:
        return ca.Function(f"mirrored_{what}", [t, x, p], [value], ARGUMENTS, [result])

    signals, jacobian, margin = original.signals, original.jacobian, original.admissibility
    if signals is not None:
        recorded = dict(zip(signals.name_out(), signals(t, image, p), strict=True))
        values = [_mirrored_signal(pattern, name, value) for name, value in recorded.items()]
        signals = ca.Function("mirrored_signals", [t, x, p], values, ARGUMENTS, list(recorded))
    if jacobian is not None:
        jacobian = mirrored("jacobian", mirror @ jacobian(t, image, p) @ mirror, "jacobian")
    if margin is not None:
        margin = mirrored("admissibility", margin(t, image, p), "margin")
    return Domain(
        name=name,
        field=mirrored("field", robot.mirror.state(original.field(t, image, p)), "rate"),
        parameters=original.parameters,
        signals=signals,
        jacobian=jacobian,
        admissibility=margin,
        breakpoints=original.breakpoints,
    )


def mirrored_transition(robot: Robot, loop: StanceLoop, switch: Switch) -> Transition:
    """Return the mirror image of the switch that ends a stance."""
    t, x, p = _symbols(loop.field)
    image = robot.mirror.state(x)
    guard = ca.Function("mirrored_guard", [t, x, p], [loop.guard(t, image, p)], ARGUMENTS, ["guard"])
    after = robot.mirror.state(loop.reset(t, image, p))
    reset = ca.Function("mirrored_reset", [t, x, p], [after], ARGUMENTS, ["state"])
    return Transition(source=switch.source.name, target=switch.target.name, guard=guard, reset=reset, direction=-1)


def _mirrored_signal(pattern: GaitPattern, name: str, value: ca.MX) -> ca.MX:
    if name == "pivot":
        return value
    mirror = pattern.robot.mirror
    known = {"torque": mirror.joints, "force": pattern.all_contacts.mirror}
    return known.get(name, mirror.forces)(value)


def _state_matrix(robot: Robot) -> ca.DM:
    once = ca.DM(robot.mirror.coordinates.matrix)
    return ca.diagcat(once, once)


def _symbols(function: ca.Function) -> tuple[Any, Any, Any]:
    return tuple(ca.MX.sym(name, function.numel_in(i)) for i, name in enumerate(ARGUMENTS))
