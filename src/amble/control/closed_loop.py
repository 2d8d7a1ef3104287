"""The closed loop of one stance as compiled functions of clock, state and parameters (t, x, p)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from amble.codegen import compile_all
from amble.control.allocation import AllocationLaw
from amble.control.linearisation import Linearised, linearise
from amble.control.loop_equations import LoopEquations, linearised_equations
from amble.control.outputs import controllable
from amble.control.phase import Phase, TimePhase
from amble.control.sensitivity import sensitivity
from amble.control.stance_functions import ARGUMENTS, fall_margin, function, guard, reset, signals
from amble.control.virtual_constraints import VirtualConstraints
from amble.errors import InputError
from amble.hybrid import Contacts, GaitPattern, Stance, Switch
from amble.robot import Robot


@dataclass(frozen=True, kw_only=True)
class Flow:
    """Compiled functions of the motion in one stance; all take (t, x, p).

    Attributes:
        field: dx/dt.
        variation: (d field / d x, R, E), with the response R and the error slope E of ``sensitivity``.
        signals: torque, force (all feet), foot and foot_velocity (all feet), pivot.
        admissibility: margin to a fall.
    """

    field: ca.Function
    variation: ca.Function
    signals: ca.Function
    admissibility: ca.Function

    @property
    def jacobian(self) -> ca.Function:
        """Slope of the field in x, the first result of ``variation``."""
        symbols = [ca.MX.sym(name, self.variation.numel_in(i)) for i, name in enumerate(ARGUMENTS)]
        return ca.Function("jacobian", symbols, [self.variation.call(symbols)[0]], ARGUMENTS, ["jacobian"])


@dataclass(frozen=True, kw_only=True)
class StanceLoop(Flow):
    """Compiled functions of one stance and of the switch that ends it; all take (t, x, p).

    Attributes:
        guard: gap of the landing foot above the ground, or mean normal force of the lifting feet less ``lift_off``.
        reset: state after the impact, in the same coordinates.
        push: of a guard that is a force, its slope in what feedback acts through, (1, n): commanded accelerations w,
            or the torques where the law gives these. None where the guard is a gap.
    """

    guard: ca.Function
    reset: ca.Function
    push: ca.Function | None = None


def stance_loops(
    pattern: GaitPattern,
    law: AllocationLaw,
    outputs: Sequence[int],
    order: int,
    phase: Phase | None = None,
    lift_off: float = 0.0,
) -> tuple[StanceLoop, ...]:
    """Compile the closed loops of the solved stances of a pattern.

    Args:
        pattern: the stances, with the robot and its ground.
        law: the allocation law.
        outputs: number of outputs of each solved stance.
        order: order of the reference curves; the parameters are packed as in ``VirtualConstraints.packed``.
        phase: the phase of the references; time where none is given.
        lift_off: normal force at which feet leave the ground where none lands, N.

    Raises:
        InputError: the law or the phase is not hashable.
    """
    phase = phase or TimePhase()
    _require_hash(f"allocation law '{law.name}'", law)
    _require_hash(f"phase '{phase.name}'", phase)
    sources: dict[str, Sequence[ca.Function]] = {}
    derivatives: dict[str, tuple[str, ...]] = {}
    for switch, count in zip(pattern.switches, outputs, strict=True):
        name = switch.source.name
        contacts, landed = pattern.contacts(switch.source), pattern.contacts(switch.target)
        force = lift_off if switch.leaving else 0.0
        flow = _flow_functions(contacts, law, switch.source, count, order, phase)
        events = _event_functions(contacts, landed, law, switch, count, order, phase, force)
        sources |= {f"loop_{name}": (*flow, *events[2:]), f"switch_{name}": events[:2]}
        derivatives[f"switch_{name}"] = ("jac",)
    native = compile_all(sources, derivatives)
    names = [switch.source.name for switch in pattern.switches]
    return tuple(StanceLoop(**native[f"loop_{name}"], **native[f"switch_{name}"]) for name in names)


def stance_equations(
    contacts: Contacts, law: AllocationLaw, stance: Stance, outputs: int, order: int, phase: Phase
) -> tuple[list[ca.SX], LoopEquations]:
    """Write the closed loop of a stance as linear equations over symbols (t, x, p); errors as those equations'."""
    q, v, symbols, constraints = _arguments(contacts.robot, outputs, order, phase)
    rates = constraints.phase_rates(contacts.robot, stance, symbols[0], q, v)
    return symbols, linearised_equations(contacts, law, (q, v), rates, constraints)


def _require_hash(what: str, value: object) -> None:
    try:
        hash(value)
    except TypeError:
        raise InputError(f"{what} has no hash; make it a frozen dataclass of such values") from None


@lru_cache(maxsize=64)
def _flow_functions(
    contacts: Contacts, law: AllocationLaw, stance: Stance, outputs: int, order: int, phase: Phase
) -> tuple[ca.Function, ...]:
    """Write the motion in one stance as functions; the phase is that of the stance named, whose curves are followed."""
    q, v, symbols, constraints = _arguments(contacts.robot, outputs, order, phase)
    size = contacts.robot.size
    loop = _loop(contacts, law, stance, symbols, constraints)
    slope = sensitivity(contacts, loop, q, v, constraints)
    above = ca.horzcat(ca.SX(size, size), ca.SX.eye(size))
    slopes = {
        "jacobian": ca.densify(ca.vertcat(above, slope.acceleration)),
        "response": ca.densify(slope.response),
        "error": ca.densify(slope.error),
    }
    return (
        function("field", symbols, {"rate": ca.vertcat(v, loop.acceleration)}),
        function("variation", symbols, slopes),
        function("signals", symbols, signals(contacts, q, v, loop)),
        function("admissibility", symbols, {"margin": fall_margin(contacts, q)}),
    )


@lru_cache(maxsize=32)
def _event_functions(
    contacts: Contacts,
    landed: Contacts,
    law: AllocationLaw,
    switch: Switch,
    outputs: int,
    order: int,
    phase: Phase,
    lift_off: float,
) -> tuple[ca.Function, ...]:
    """Write the event that ends one stance as functions: guard, reset, and of a guard that is a force its push."""
    q, v, symbols, constraints = _arguments(contacts.robot, outputs, order, phase)
    pushed = ca.SX.sym("pushed", len(controllable(contacts.robot))) if switch.leaving else None
    loop = _loop(contacts, law, switch.source, symbols, constraints, pushed)
    crossing, after = guard(contacts, switch, q, loop, lift_off), reset(landed, switch, q, v)
    same = function("reset", symbols, {"state": after})
    if pushed is None:
        return function("guard", symbols, {"guard": crossing}), same
    zero = ca.DM.zeros(pushed.shape)
    crossing, slope = ca.substitute([crossing, ca.densify(ca.jacobian(crossing, pushed))], [pushed], [zero])
    return function("guard", symbols, {"guard": crossing}), same, function("push", symbols, {"push": slope})


def _arguments(
    robot: Robot, outputs: int, order: int, phase: Phase
) -> tuple[ca.SX, ca.SX, list[ca.SX], VirtualConstraints]:
    """Symbols q and v, then (t, x, p), and p by its parts."""
    x = ca.SX.sym("x", 2 * robot.size)
    constraints = VirtualConstraints.symbols(outputs, len(controllable(robot)), order, phase)
    return x[: robot.size], x[robot.size :], [ca.SX.sym("t"), x, constraints.packed()], constraints


def _loop(
    contacts: Contacts,
    law: AllocationLaw,
    stance: Stance,
    symbols: list[ca.SX],
    constraints: VirtualConstraints,
    pushed: ca.SX | None = None,
) -> Linearised:
    size = contacts.robot.size
    t, x, _ = symbols
    phase = constraints.phase_rates(contacts.robot, stance, t, x[:size], x[size:])
    return linearise(contacts, law, x[:size], x[size:], phase, constraints, pushed)
