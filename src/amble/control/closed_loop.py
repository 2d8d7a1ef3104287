"""The closed loop of one stance as compiled functions of clock, state and parameters (t, x, p)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from amble.codegen import compile_all
from amble.control.allocation import AllocationLaw
from amble.control.linearisation import Linearised, linearise
from amble.control.sensitivity import sensitivity
from amble.control.virtual_constraints import VirtualConstraints
from amble.errors import InputError
from amble.hybrid import Switch, impact
from amble.robot import Robot, kinematics

LOWEST_BASE = 0.05
"""A base below this height above the ground has fallen, as a share of the leg length."""

STEEPEST = 0.3
"""A base whose vertical axis has a smaller component along the world's has fallen over."""

ARGUMENTS = ["t", "x", "p"]


@dataclass(frozen=True, kw_only=True)
class StanceLoop:
    """Compiled functions of one stance and of the switch that ends it; all take (t, x, p).

    Attributes:
        field: dx/dt.
        variation: (d field / d x, R, E), with the response R and the error slope E of ``sensitivity``.
        signals: torque, force (all feet), foot and foot_velocity (all feet), pivot.
        admissibility: margin to a fall.
        guard: height of the landing foot, or normal force of the lifting foot.
        reset: state after the impact, in the same coordinates.
    """

    field: ca.Function
    variation: ca.Function
    signals: ca.Function
    admissibility: ca.Function
    guard: ca.Function
    reset: ca.Function

    @property
    def jacobian(self) -> ca.Function:
        """Slope of the field in x, the first result of ``variation``."""
        symbols = [ca.MX.sym(name, self.variation.numel_in(i)) for i, name in enumerate(ARGUMENTS)]
        return ca.Function("jacobian", symbols, [self.variation(*symbols)[0]], ARGUMENTS, ["jacobian"])


def stance_loops(
    robot: Robot, law: AllocationLaw, switches: Sequence[Switch], outputs: Sequence[int], order: int
) -> tuple[StanceLoop, ...]:
    """Compile the closed loops of stances.

    Args:
        robot: the robot.
        law: the allocation law.
        switches: the switch that ends each stance; it names the stance too.
        outputs: number of outputs of each stance.
        order: order of the reference curves; the parameters are packed as in ``VirtualConstraints.packed``.

    Raises:
        InputError: the law is not hashable.
    """
    try:
        hash(law)
    except TypeError:
        raise InputError(
            f"allocation law '{law.name}' has no hash; make it a frozen dataclass of such values"
        ) from None
    sources: dict[str, Sequence[ca.Function]] = {}
    derivatives: dict[str, tuple[str, ...]] = {}
    for switch, count in zip(switches, outputs, strict=True):
        name = switch.source.name
        flow, events = _functions(robot, law, switch, count, order)
        sources |= {f"loop_{name}": flow, f"switch_{name}": events}
        derivatives[f"switch_{name}"] = ("jac",)
    native = compile_all(sources, derivatives)
    names = [switch.source.name for switch in switches]
    return tuple(StanceLoop(**native[f"loop_{name}"], **native[f"switch_{name}"]) for name in names)


@lru_cache(maxsize=32)
def _functions(
    robot: Robot, law: AllocationLaw, switch: Switch, outputs: int, order: int
) -> tuple[tuple[ca.Function, ...], tuple[ca.Function, ...]]:
    """Write the functions of one stance as expressions: those of the flow, and those of the event that ends it."""
    feet = switch.source.feet
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * robot.size)
    q, v = x[: robot.size], x[robot.size :]
    constraints = VirtualConstraints.symbols(outputs, robot.size - 3, order)
    p = constraints.packed()
    loop = linearise(robot, feet, law, q, v, t, constraints)
    slope = sensitivity(robot, feet, loop, q, v, t, constraints)
    jacobian = ca.densify(
        ca.vertcat(ca.horzcat(ca.SX(robot.size, robot.size), ca.SX.eye(robot.size)), slope.acceleration)
    )
    signals = _signals(robot, feet, q, v, loop)
    margin = ca.fmin(q[2] - LOWEST_BASE * robot.leg_length, kinematics.base_rotation(q)[2, 2] - STEEPEST)
    guard, after = _guard(robot, switch, q, loop), _reset(robot, switch, q, v)
    symbols = [t, x, p]
    slopes = {"jacobian": jacobian, "response": ca.densify(slope.response), "error": ca.densify(slope.error)}
    flow = (
        _function("field", symbols, {"rate": ca.vertcat(v, loop.acceleration)}),
        _function("variation", symbols, slopes),
        _function("signals", symbols, signals),
        _function("admissibility", symbols, {"margin": margin}),
    )
    events = _function("guard", symbols, {"guard": guard}), _function("reset", symbols, {"state": after})
    return flow, events


def _function(name: str, symbols: list[ca.SX], results: dict[str, ca.SX]) -> ca.Function:
    """Write a function of t, x and p without common subexpressions."""
    return ca.Function(name, symbols, ca.cse(list(results.values())), ARGUMENTS, list(results))


def _signals(robot: Robot, feet: tuple[str, ...], q: ca.SX, v: ca.SX, loop: Linearised) -> dict[str, ca.SX]:
    """What a simulation records: world frame, all feet in the robot's order, zero force at swing feet."""
    forces = [
        loop.forces[3 * feet.index(foot) : 3 * feet.index(foot) + 3] if foot in feet else ca.SX.zeros(3)
        for foot in robot.foot_names
    ]
    return {
        "torque": ca.densify(loop.torques),
        "force": ca.vertcat(*forces),
        "foot": ca.vertcat(*[kinematics.foot_position(robot, foot, q) for foot in robot.foot_names]),
        "foot_velocity": ca.vertcat(*[kinematics.foot_jacobian(robot, foot, q) @ v for foot in robot.foot_names]),
        "pivot": loop.pivot,
    }


def _guard(robot: Robot, switch: Switch, q: ca.SX, loop: Linearised) -> ca.SX:
    """Height of the first landing foot; without landing the normal force of the first lifting foot."""
    if switch.landing:
        return kinematics.foot_position(robot, switch.landing[0], q)[2]
    return loop.forces[3 * switch.source.feet.index(switch.lifting[0]) + 2]


def _reset(robot: Robot, switch: Switch, q: ca.SX, v: ca.SX) -> ca.SX:
    """Plastic impact that stops all feet of the next stance; the identity at a lift-off."""
    if not switch.landing:
        return ca.vertcat(q, v)
    velocity, _ = impact(robot, switch.target.feet, q, v)
    return ca.densify(ca.vertcat(q, velocity))
