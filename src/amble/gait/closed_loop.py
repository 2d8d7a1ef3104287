"""A gait as a hybrid system: the closed loop of its stances, for simulation and stability analysis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.control.closed_loop import Flow, StanceLoop
from amble.gait.control_law import ControlLaw, Numbers, TorqueLaw
from amble.gait.cycle_end import closed_reset, closing
from amble.gait.landing_domains import continued, landing_domain, landing_transition
from amble.gait.landing_stances import between, entering, follows, landing_steps, twin
from amble.gait.linearising_law import control_of
from amble.gait.mirrored_loop import mirrored_domain, mirrored_transition
from amble.gait.record import Gait
from amble.hybrid import Domain, HybridSystem, Stance, Switch, Symmetry, Transition
from amble.robot import Robot, kinematics
from amble.robot.coordinate_units import units
from amble.robot.parts import RATE
from amble.types import Vector, frozen

SIGNALS = {"torque": "N m", "force": "N", "foot": "m", "foot_velocity": "m/s", "pivot": "1"}
"""Signals that the closed loop records, with their units."""


def closed_loop(
    gait: Gait,
    law: AllocationLaw | None = None,
    half: bool = False,
    control: ControlLaw | None = None,
    orders: Mapping[str, Sequence[str]] | None = None,
) -> HybridSystem:
    """Close the loop of a gait.

    A gait that turns repeats itself modulo its turn: the reset that ends a cycle turns the state back by ``Gait.turn``,
    so states are in axes that are the world's at the entry of the first cycle and turn at the end of each.

    Args:
        gait: the gait; with feedback its stabilised outputs are used, else those of the gait problem.
        law: another allocation law than the gait's.
        half: of a mirrored gait only the solved half: the last reset also mirrors, and one cycle of the system is half
            a gait cycle. Otherwise all stances, the second half through mirrored copies of the same compiled code.
        control: another feedback law than the gait's.
        orders: where feet land one by one: name of a switch -> its feet in the one order that is followed, smoothly on
            to where another comes first (``landing_domains.continued``).

    Raises:
        InputError: another allocation law for a feedback law that does not allocate.
    """
    pattern = gait.pattern
    control = control or control_of(gait)
    numbers = control.numbers(gait, law)
    loops = control.loops(gait, law, numbers)
    solved = [
        _domain(stance.name, loop, entry) for stance, loop, entry in zip(pattern.solved, loops, numbers, strict=True)
    ]
    whole = pattern.mirrored and not half
    domains = [*solved]
    if whole:
        twins = pattern.stances[len(solved) :]
        domains += [mirrored_domain(pattern, stance.name, domain) for stance, domain in zip(twins, solved, strict=True)]
    domains += _landing_domains(gait, loops, solved, whole, (control, control.landing_numbers(gait, law)))
    known = {domain.name: domain for domain in domains}
    transitions = _transitions(gait, loops, known, half, orders or {})
    names = (*gait.robot.coordinate_names, *(f"{RATE}{name}" for name in gait.robot.coordinate_names))
    entered = {transition.target for transition in transitions}  # one order of landing leaves the other domains out
    kept = tuple(domain for domain in known.values() if domain.name in entered)
    return HybridSystem(kept, tuple(transitions), symmetries(gait, control), names)


def _transitions(
    gait: Gait,
    loops: Sequence[StanceLoop],
    known: dict[str, Domain],
    half: bool,
    orders: Mapping[str, Sequence[str]],
) -> list[Transition]:
    """All switches; one whose feet land one by one is several. Domains of one order alone are added to those known."""
    pattern, found = gait.pattern, list[Transition]()
    whole = pattern.mirrored and not half
    switches = pattern.all_switches if whole else pattern.switches
    for number, switch in enumerate(switches):
        loop, last = loops[number % len(loops)], number == len(switches) - 1
        if len(landing_steps(gait, switch)) > 1:
            found += _landings(gait, known, switch, last and not whole, orders.get(switch.name))
        elif number < len(loops):
            found.append(_transition(gait, loop, switch, last, half))
        else:
            found.append(mirrored_transition(gait.robot, loop, switch))
    return found


def _domain(name: str, flow: Flow, numbers: Numbers) -> Domain:
    return Domain(
        name=name,
        field=flow.field,
        parameters=numbers.parameters,
        signals=flow.signals,
        jacobian=flow.jacobian,
        admissibility=flow.admissibility,
        breakpoints=numbers.breakpoints,
    )


def _transition(gait: Gait, loop: StanceLoop, switch: Switch, last: bool, half: bool) -> Transition:
    """The switch that ends a solved stance; the last of a half cycle leads to the first, mirrored if the gait is."""
    passed = closing(gait) if last and (half or not gait.pattern.mirrored) else None
    target = gait.pattern.stances[0].name if half and last else switch.target.name
    reset = loop.reset if passed is None else closed_reset(loop.reset, passed)
    return Transition(source=switch.source.name, target=target, guard=loop.guard, reset=reset, direction=-1)


def _landing_domains(
    gait: Gait,
    loops: Sequence[StanceLoop],
    solved: Sequence[Domain],
    whole: bool,
    own: tuple[ControlLaw, Mapping[str, Numbers]],
) -> list[Domain]:
    """The domains between landings into every solved stance; with the mirrored half, into the mirrored ones too.

    ``own`` is the control law and what it is between landings, where it is not the law of the next stance.
    """
    control, numbers = own
    pattern, found = gait.pattern, list[Domain]()
    for number, (loop, following) in enumerate(zip(loops, solved, strict=True)):
        for stance in between(gait, entering(gait, number)):
            if stance.name in numbers and isinstance(control, TorqueLaw):
                entry = numbers[stance.name]
                domain = _domain(stance.name, control.landing_flow(pattern.contacts(stance), entry), entry)
            else:
                domain = landing_domain(pattern, loop, following, pattern.solved[number], stance)
            found.append(domain)
            if whole:
                image = twin(gait, pattern.all_switches[number - 1 + len(solved)], stance)
                found.append(mirrored_domain(pattern, image.name, domain))
    return found


def _landings(
    gait: Gait, known: dict[str, Domain], switch: Switch, ends: bool, order: Sequence[str] | None
) -> list[Transition]:
    """All landings of a switch, in every order or in one.

    Where it ends the cycle of the system, the first of them mirrors the state, or turns it back.
    """
    found, mirrors = list[Transition](), ends and gait.pattern.mirrored
    for step in landing_steps(gait, switch):
        if order is not None and not follows(step, switch, order):
            continue
        first, target = step.source == switch.source, step.target
        source, foot, down = step.source, step.landing[0], step.target.feet
        if mirrors:
            entered = entering(gait, 0)
            target = twin(gait, entered, target)
            if not first:
                feet = gait.robot.mirror.feet
                source, foot, down = twin(gait, entered, source), feet[foot], target.feet
        contacts = gait.pattern.contacts(Stance(target.name, down))
        passed = closing(gait) if ends and first else None
        landing = landing_transition(contacts, foot, known[source.name], target.name, first, passed)
        if order is None or first:
            found.append(landing)
            continue
        back, both_ways = continued(known[source.name], landing)
        known[back.name] = back
        found += both_ways
    return found


def start_state(gait: Gait) -> Vector:
    """Return the state at the entry of the first domain, (2 n_q,): the closed loop's own where it is known."""
    if gait.feedback is not None:
        return gait.feedback.start
    first = gait.domains[0]
    return frozen(np.concatenate([first.positions[0], first.velocities[0]]))


def symmetries(gait: Gait, control: ControlLaw) -> tuple[Symmetry, ...]:
    """Return what a feedback law does not see: translations along the ground, on level ground the turn about z."""
    size = 2 * gait.robot.size
    x = ca.SX.sym("x", size)
    found = []
    axes = list(gait.robot.base.axes)
    for name, translation in gait.pattern.ground.translations.items():
        if name not in gait.robot.base.coordinates:
            continue
        direction = ca.DM.zeros(size)
        direction[: len(axes)] = translation[axes]
        found.append(Symmetry(name, ca.Function(f"symmetry_{name}", [x], [ca.SX(direction)])))
    if gait.pattern.ground.level and gait.robot.base.in_space:
        found.append(Symmetry("yaw", _turn(gait.robot, x)))
    return tuple(symmetry for symmetry in found if control.keeps(gait, symmetry))


def _turn(robot: Robot, x: ca.SX) -> ca.Function:
    """Generator of the turn about the world's vertical axis through its origin.

    Position and orientation rates of the base for the angular velocity (0, 0, 1); the velocities follow by the
    tangent lift of that vector field.
    """
    q, v = x[: robot.size], x[robot.size :]
    rotation = kinematics.base_rotation(q)
    columns = [ca.jacobian(ca.vec(rotation), q[3 + k]) for k in range(3)]
    # the skew part of dR/d(angle) R^T is the angular velocity that the angle's rate contributes
    rates = ca.horzcat(*[ca.inv_skew(ca.reshape(column, 3, 3) @ rotation.T) for column in columns])
    angles = ca.solve(rates, ca.SX([0.0, 0.0, 1.0]))
    motion = ca.vertcat(-q[1], q[0], 0.0, angles, ca.SX.zeros(robot.size - 6))
    return ca.Function("symmetry_yaw", [x], [ca.densify(ca.vertcat(motion, ca.jtimes(motion, q, v)))])


def trace_units(gait: Gait) -> dict[str, str]:
    """Return name -> unit of the states and signals of the gait's closed loop, as traces hold them."""
    names = gait.robot.coordinate_names
    rates = [f"{RATE}{name}" for name in names]
    return {
        **dict(zip(names, units(gait.robot, names), strict=True)),
        **dict(zip(rates, units(gait.robot, names, "/s"), strict=True)),
        **SIGNALS,
    }
