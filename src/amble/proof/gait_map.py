"""The return map of a gait's closed loop: its solved stances as legs, with what must hold all along them.

Of a mirrored gait it is half a cycle, closed by the mirror.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
from flint import arb

from amble.control.loop_equations import LoopEquations
from amble.control.stance_functions import LOWEST_BASE, STEEPEST, reset
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.control_law import Numbers
from amble.gait.linearising_law import control_of
from amble.hybrid import Contacts, Domain, HybridSystem, Stance, Switch, Transition, impact
from amble.proof.leg import Leg, Surface, reset_tape
from amble.proof.loop_field import LoopField
from amble.proof.loop_tapes import LoopTapes
from amble.proof.margins import Margins
from amble.proof.return_map import ReturnMap
from amble.proof.switched_field import SwitchedField
from amble.proof.turns import turns
from amble.robot import kinematics

ARGUMENTS = ["t", "x", "p"]


def gait_map(gait: Gait, system: HybridSystem, order: int, tolerance: float) -> ReturnMap:
    """Prepare the closed loop of a gait.

    Args:
        gait: the gait.
        system: its compiled closed loop, of the solved stances (``stability.closed_loop_fixed_point``).
        order: Q of the Taylor steps.
        tolerance: size of a step's remainder that the step length aims at.

    Raises:
        InputError: as ``require_provable`` and ``turns``.
    """
    require_provable(gait)
    legs = [
        _leg(gait, switch, domain, transition)
        for switch, (domain, transition) in zip(gait.pattern.switches, system.cycle(), strict=True)
    ]
    return ReturnMap(
        system=system,
        legs=tuple(legs),
        order=order,
        tolerance=tolerance,
        turns=turns(gait, [symmetry.name for symmetry in system.symmetries]),
        record=gait.robot.hash,
    )


def require_provable(gait: Gait) -> None:
    """Refuse what has no proof, before any work.

    Raises:
        InputError: the loop is no solution of linear equations, or a switch has not one landing foot, or it turns.
    """
    if gait.turn:
        raise InputError("the gait turns: its return map is closed by a turn about the vertical: no proof of that")
    for switch in gait.pattern.switches:
        if len(switch.landing) > 1:
            feet = ", ".join(switch.landing)
            raise InputError(
                f"at switch '{switch.name}' feet {feet} land at once (simultaneous guards): no proof of that"
            )
        if not switch.landing:
            raise InputError(f"at switch '{switch.name}' feet leave by their force: no proof of that")
    control = control_of(gait)
    for switch, numbers in zip(gait.pattern.switches, control.numbers(gait, None), strict=True):
        control.equations(gait, switch.source, control.smooth(gait, numbers)[0].parameters.size)


def require_smooth(prepared: ReturnMap, durations: Sequence[float]) -> None:
    """Refuse an orbit that goes on in a domain after the last stretch along which the law is known to be smooth.

    Args:
        prepared: the gait's map.
        durations: of the domains along the orbit, s.

    Raises:
        InputError: it does.
    """
    for leg, duration in zip(prepared.legs, durations, strict=True):
        end = leg.field.ends[-1] if isinstance(leg.field, SwitchedField) else arb("inf")
        if not arb(duration) < end:
            name = leg.domain.name
            raise InputError(
                f"in domain '{name}', {duration:.6g} s long, the control law is not smooth after {float(end):.6g} s "
                "(a breakpoint): no proof of that"
            )


def _leg(gait: Gait, switch: Switch, domain: Domain, transition: Transition) -> Leg:
    """Write a solved stance and the switch that ends it."""
    pattern, robot, stance, control = gait.pattern, gait.robot, switch.source, control_of(gait)
    numbers = Numbers(parameters=domain.parameters, breakpoints=domain.breakpoints)
    stretches = control.smooth(gait, numbers)
    symbols, loop = control.equations(gait, stance, stretches[0].parameters.size)
    x = symbols[1]
    q, v = x[: robot.size], x[robot.size :]
    at = [symbols[0], x, ca.SX.sym("p", domain.parameters.size)]

    gap = pattern.ground.gap(kinematics.foot_position(robot, switch.landing[0], q))
    guard = ca.Function("guard", at, [gap], ARGUMENTS, ["guard"])
    after = reset(pattern.contacts(switch.target), switch, q, v)
    mirrors = pattern.mirrored and switch == pattern.switches[-1]
    state = robot.mirror.state(after) if mirrors else after
    return Leg(
        domain=domain,
        field=_field(loop, symbols, stretches),
        exit=Surface.of(f"guard of '{switch.name}'", guard, transition.direction, transition.dead_time),
        margins=_margins(gait, stance, switch, at, loop),
        landing=_landing_margins(gait, switch, at),
        reset=reset_tape(ca.Function("reset", at, [state], ARGUMENTS, ["state"])),
        parameters=tuple(arb(float(value)) for value in domain.parameters),
        load=loop.load,
    )


def _field(loop: LoopEquations, symbols: Sequence[ca.SX], stretches: Sequence[Numbers]) -> SwitchedField:
    """One set of tapes, with the numbers of every stretch."""
    tapes = LoopTapes.of(loop, symbols, stretches[0].parameters)
    fields = [LoopField(tapes.at(numbers.parameters)) for numbers in stretches]
    ends = [arb(numbers.breakpoints[0]) if numbers.breakpoints else arb("inf") for numbers in stretches]
    return SwitchedField(tuple(fields), tuple(ends))


def _margins(gait: Gait, stance: Stance, switch: Switch, symbols: Sequence[ca.SX], loop: LoopEquations) -> Margins:
    """What must hold all along a stance: contacts, limits, swing feet above the ground, no fall."""
    robot, contacts = gait.robot, gait.pattern.contacts(stance)
    x, z = symbols[1], ca.SX.sym("z", loop.right.shape[0])
    q, v = x[: robot.size], x[robot.size :]
    _, torques, forces = loop.parts(z)
    found = _contact_margins(contacts, forces, q)
    for number, joint in enumerate(robot.joint_names):
        torque, speed = torques[number], v[robot.size - len(robot.joints) + number]
        found[f"torque of '{joint}'"] = 1 - (torque / gait.limits.torques[joint]) ** 2
        found[f"speed of '{joint}'"] = 1 - (speed / gait.limits.speeds[joint]) ** 2
    ground, base = contacts.ground, robot.base.spatial(q)
    rotation = kinematics.base_rotation(base)
    found["height of the base"] = base[2] - ground.height(base[0], base[1]) - LOWEST_BASE * robot.leg_length
    upright = rotation[2, 2] if ground.level else ca.dot(ground.normal(base[:3]), rotation[:, 2])
    found["uprightness of the base"] = upright - STEEPEST
    rising = {}
    for foot in robot.foot_names:
        if foot in stance.feet or foot in switch.landing:
            continue
        gap = ground.gap(kinematics.foot_position(robot, foot, q))
        if foot in _lifted(gait, stance):
            rising[f"height of '{foot}'"] = gap, ca.jtimes(gap, q, v)
        else:
            found[f"height of '{foot}'"] = gap
    return Margins.of([*symbols, z], found, rising)


def _lifted(gait: Gait, stance: Stance) -> tuple[str, ...]:
    """Feet that leave the ground as a stance begins."""
    return next(switch for switch in gait.pattern.all_switches if switch.target == stance).lifting


def _landing_margins(gait: Gait, switch: Switch, symbols: Sequence[ca.SX]) -> Margins:
    """The impulses of the feet that stand after a landing push."""
    robot, landed = gait.robot, gait.pattern.contacts(switch.target)
    x = symbols[1]
    q, v = x[: robot.size], x[robot.size :]
    _, impulse = impact(landed, q, v)
    local = zip(landed.feet, landed.local(impulse, landed.points(q)), strict=True)
    pushes = {f"normal impulse of '{foot}'": landed.contact.normal_force(part) for foot, part in local}
    return Margins.of([*symbols, ca.SX.sym("z", 0)], pushes, {})


def _contact_margins(contacts: Contacts, forces: ca.SX, q: ca.SX) -> dict[str, ca.SX]:
    """Normal forces in N, and mu^2 less the square of the friction used."""
    found = {}
    for foot, local in zip(contacts.feet, contacts.local(forces, contacts.points(q)), strict=True):
        normal = contacts.contact.normal_force(local)
        load = contacts.contact.tangential(local)
        square = load**2 if contacts.contact.moments else ca.sumsqr(local[: local.shape[0] - 1])
        found[f"normal force of '{foot}'"] = normal
        found[f"friction of '{foot}'"] = contacts.ground.friction**2 - square / normal**2
    return found
