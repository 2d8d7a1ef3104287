"""Small hybrid systems whose motions are known in closed form."""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.hybrid import Domain, HybridSystem, Symmetry, Transition

GRAVITY = 9.81


def bouncing_ball(restitution: float = 0.8, floor: float | None = None) -> HybridSystem:
    """Height and velocity; one cycle is one flight. With ``floor``, a ball slower than that at its entry is dead."""
    state = ca.SX.sym("x", 2)
    height, velocity = ca.vertsplit(state)
    rate = ca.vertcat(velocity, -GRAVITY)
    energy = velocity**2 / 2 + GRAVITY * height
    admissibility = None if floor is None else energy - floor**2 / 2
    flight = Domain.from_expressions(
        "flight", state, rate, signals={"energy": energy, "pair": 2 * state}, admissibility=admissibility
    )
    bounce = Transition.from_expressions("flight", "flight", state, height, ca.vertcat(0, -restitution * velocity))
    return HybridSystem([flight], [bounce], state_names=("height", "velocity"))


def clockwork(*guards: tuple[str, int, float]) -> HybridSystem:
    """x = clock. Every guard (kind, direction, dead_time) leads to a domain of its own, from where the first follows.

    Kinds: "sine" is sin(x), "line" is x - 1, "nan" is not a number after x = 0.5.
    """
    x = ca.SX.sym("x", 1)
    kinds = {"sine": ca.sin(x), "line": x - 1, "nan": ca.sqrt(0.5 - x) + 1}
    domains = [Domain.from_expressions("first", x, ca.SX(1))]
    transitions = []
    for number, (kind, direction, dead_time) in enumerate(guards):
        name = f"{kind}{number}"
        domains.append(Domain.from_expressions(name, x, ca.SX(1)))
        transitions += [
            Transition.from_expressions("first", name, x, kinds[kind], x, direction, dead_time=dead_time),
            Transition.from_expressions(name, "first", x, x - 100, x * 0, +1),
        ]
    return HybridSystem(domains, transitions)


def blow_up() -> HybridSystem:
    """x' = x^2: from 1 it is infinite at clock 1."""
    x = ca.SX.sym("x", 1)
    domain = Domain.from_expressions("up", x, x**2)
    return HybridSystem([domain], [Transition.from_expressions("up", "up", x, x + 1, x)])


def two_phases() -> HybridSystem:
    """Nonlinear, two domains, parameters, guards and resets that depend on the clock: all that a map can have."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    arguments, names = [t, x, p], ["t", "x", "p"]
    push = ca.Function(
        "push", arguments, [ca.vertcat(x[1], -x[0] + p[0] * ca.sin(3 * t), -p[1] * x[2] + x[0] * x[1])], names, ["r"]
    )
    pull = ca.Function(
        "pull", arguments, [ca.vertcat(1 + 0.1 * ca.cos(x[2]), p[0] * t - x[1], ca.sin(x[0]) - x[2])], names, ["r"]
    )
    leave_push = ca.Function("g1", arguments, [x[0] + 0.2 * t - p[0]], names, ["g"])
    leave_pull = ca.Function("g2", arguments, [x[0] - 1.3 - 0.1 * x[1] + 0.05 * t], names, ["g"])
    land = ca.Function(
        "r1", arguments, [ca.vertcat(0.3 * x[1], 0.5 * x[2] + 0.1 * t, x[0] + p[1] * x[1])], names, ["s"]
    )
    lift = ca.Function("r2", arguments, [ca.vertcat(0.2 * x[1], 1 + 0.3 * x[2] * t, 0.4 * x[1])], names, ["s"])
    return HybridSystem(
        [
            Domain(name="push", field=push, parameters=np.array([0.6, 0.5])),
            Domain(name="pull", field=pull, parameters=np.array([0.7, 0.2])),
        ],
        [
            Transition(source="push", target="pull", guard=leave_push, reset=land, direction=+1),
            Transition(source="pull", target="push", guard=leave_pull, reset=lift, direction=+1),
        ],
    )


def travelling(turn: float, mirror: int) -> HybridSystem:
    """A stable oscillation of two states that drives a point over the plane: x, y and a heading, which are neutral.

    Args:
        turn: by how much the heading turns in a reset, rad.
        mirror: -1 where the reset mirrors y and the heading, else +1.
    """
    state = ca.SX.sym("x", 5)
    phase, lag, x, y, heading = ca.vertsplit(state)
    rate = ca.vertcat(1 + 0.2 * lag, -lag + 0.3 * phase, ca.cos(heading + lag), ca.sin(heading + lag), 0.4 * lag)
    stride = Domain.from_expressions("stride", state, rate)
    after = ca.vertcat(0, 0.6 * lag, x, mirror * y, mirror * (heading + turn))
    step = Transition.from_expressions("stride", "stride", state, phase - 1, after, +1)
    z = ca.SX.sym("z", 5)
    symmetries = [
        Symmetry("x", ca.Function("along_x", [z], [ca.DM([0, 0, 1, 0, 0])])),
        Symmetry("y", ca.Function("along_y", [z], [ca.DM([0, 0, 0, 1, 0])])),
        Symmetry("heading", ca.Function("about_z", [z], [ca.vertcat(0, 0, -z[3], z[2], 1)])),
    ]
    return HybridSystem([stride], [step], symmetries, ("phase", "lag", "x", "y", "heading"))
