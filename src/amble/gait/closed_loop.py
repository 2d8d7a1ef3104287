"""A gait as a hybrid system: the closed loop of its stances, for simulation and stability analysis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.control.closed_loop import StanceLoop, stance_loops
from amble.control.phase import DomainPhase
from amble.errors import InputError
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.gait.control_law import CONTROL_LAWS, ControlLaw
from amble.gait.landing_domains import between, entering, follows, landing_domain, landing_steps, landing_transition
from amble.gait.mirrored_loop import mirrored_domain, mirrored_result, mirrored_transition
from amble.gait.record import Gait
from amble.hybrid import Domain, HybridSystem, Stance, Switch, Symmetry, Transition
from amble.io.quantities import units
from amble.robot import Robot, kinematics
from amble.robot.parts import RATE
from amble.types import Vector, frozen

SIGNALS = {"torque": "N m", "force": "N", "foot": "m", "foot_velocity": "m/s", "pivot": "1"}
"""Signals that the closed loop records, with their units."""

PROBES, PRESERVED = 3, 1e-9
"""Configurations at which a symmetry is held against the phase, and the slope, relative, that counts as none."""


def closed_loop(
    gait: Gait,
    law: AllocationLaw | None = None,
    half: bool = False,
    control: ControlLaw | None = None,
    orders: Mapping[str, Sequence[str]] | None = None,
) -> HybridSystem:
    """Close the loop of a gait.

    Args:
        gait: the gait; with feedback its stabilised outputs are used, else those of the gait problem.
        law: another allocation law than the gait's.
        half: of a mirrored gait only the solved half: the last reset also mirrors, and one cycle of the system is half
            a gait cycle. Otherwise all stances, the second half through mirrored copies of the same compiled code.
        control: the feedback law; by default input-output linearisation with the gait's own gains.
        orders: where feet land one by one: name of a switch -> its feet in the one order that is followed. A foot that
            is past the ground when its turn comes is stopped at once.

    Raises:
        InputError: another allocation law for a feedback law that does not allocate, or one that has no motion between
            the landings of a switch.
    """
    pattern = gait.pattern
    control = control or InputOutputLinearisation(*gait.gains)
    loops = control.loops(gait, law)
    stances = zip(loops, pattern.solved, strict=True)
    solved = [_solved_domain(gait, control, loop, stance) for loop, stance in stances]
    whole = pattern.mirrored and not half
    domains = [*solved]
    if whole:
        for loop, stance, original in zip(loops, pattern.stances[len(solved) :], solved, strict=True):
            domains.append(mirrored_domain(pattern, loop, stance.name, original))
    domains += _landing_domains(gait, control, law or gait.law, whole)
    transitions = _transitions(gait, loops, {domain.name: domain for domain in domains}, half, orders or {})
    names = (*gait.robot.coordinate_names, *(f"{RATE}{name}" for name in gait.robot.coordinate_names))
    entered = {transition.target for transition in transitions}  # one order of landing leaves the other domains out
    kept = tuple(domain for domain in domains if domain.name in entered)
    symmetries = tuple(symmetry for symmetry in _symmetries(gait) if control.keeps(gait, symmetry))
    return HybridSystem(kept, tuple(transitions), symmetries, names)


def _transitions(
    gait: Gait,
    loops: Sequence[StanceLoop],
    known: Mapping[str, Domain],
    half: bool,
    orders: Mapping[str, Sequence[str]],
) -> list[Transition]:
    """All switches; a switch whose feet land one by one is several."""
    pattern, found = gait.pattern, list[Transition]()
    whole = pattern.mirrored and not half
    switches = pattern.all_switches if whole else pattern.switches
    for number, switch in enumerate(switches):
        loop, last = loops[number % len(loops)], number == len(switches) - 1
        if len(landing_steps(gait, switch)) > 1:
            mirrors = last and pattern.mirrored and not whole
            found += _landings(gait, known, switch, mirrors, orders.get(switch.name))
        elif number < len(loops):
            found.append(_transition(gait, loop, switch, last, half))
        else:
            found.append(mirrored_transition(gait.robot, loop, switch))
    return found


@dataclass(frozen=True)
class InputOutputLinearisation(ControlLaw):
    """Torques that make the outputs obey y'' + K_d y' + K_p y = 0 (paper, eq. 7 and 8).

    Attributes:
        position_gain: K_p, 1/s^2.
        velocity_gain: K_d, 1/s.
    """

    units: ClassVar[Mapping[str, str]] = {"position_gain": "1/s^2", "velocity_gain": "1/s"}

    position_gain: float
    velocity_gain: float

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "input-output linearisation"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The gains."""
        return {"position_gain": self.position_gain, "velocity_gain": self.velocity_gain}

    def loops(self, gait: Gait, allocation: AllocationLaw | None) -> tuple[StanceLoop, ...]:
        """Compile the loops; the gains are among the parameters, so that loops of all gains share their code."""
        return stance_loops(
            gait.pattern,
            allocation or gait.law,
            [len(gait.outputs.of(stance.name).coordinates) for stance in gait.pattern.solved],
            REFERENCE_ORDER,
            gait.outputs.phase,
            gait.limits.normal_force,
        )

    def packed(self, gait: Gait, domain: str) -> Vector:
        """Pack the virtual constraints with these gains."""
        return loop_parameters(replace(gait, gains=(self.position_gain, self.velocity_gain)), domain)

    def breakpoints(self, gait: Gait, stance: Stance) -> tuple[float, ...]:
        """Return those of the phase."""
        return gait.outputs.phase.breakpoints(stance, float(self.packed(gait, stance.name)[0]))

    def keeps(self, gait: Gait, symmetry: Symmetry) -> bool:
        """Whether no output sees a turn, and the phase none of the symmetries."""
        return (symmetry.name != "yaw" or not _sees_orientation(gait)) and keeps_phase(gait, symmetry)


CONTROL_LAWS.register("input-output linearisation", InputOutputLinearisation)


def _solved_domain(gait: Gait, control: ControlLaw, loop: StanceLoop, stance: Stance) -> Domain:
    parameters = control.packed(gait, stance.name)
    return Domain(
        name=stance.name,
        field=loop.field,
        parameters=parameters,
        signals=loop.signals,
        jacobian=loop.jacobian,
        admissibility=loop.admissibility,
        breakpoints=control.breakpoints(gait, stance),
    )


def _transition(gait: Gait, loop: StanceLoop, switch: Switch, last: bool, half: bool) -> Transition:
    """The switch that ends a solved stance; the last of a half cycle leads to the first, mirrored if the gait is."""
    mirrors = half and gait.pattern.mirrored and last
    target = gait.pattern.stances[0].name if half and last else switch.target.name
    reset = mirrored_result(gait.robot, loop.reset) if mirrors else loop.reset
    return Transition(source=switch.source.name, target=target, guard=loop.guard, reset=reset, direction=-1)


def _landing_domains(gait: Gait, control: ControlLaw, law: AllocationLaw, whole: bool) -> list[Domain]:
    """The domains between landings into every solved stance; with the mirrored half, into the mirrored ones too."""
    pattern, found = gait.pattern, list[Domain]()
    if not any(between(gait, entering(gait, number)) for number in range(len(pattern.solved))):
        return found
    if not isinstance(control, InputOutputLinearisation):
        raise InputError(f"control law '{control.name}' has no motion between landings; feet must land simultaneously")
    gait = replace(gait, gains=(control.position_gain, control.velocity_gain))
    for number in range(len(pattern.solved)):
        switch = entering(gait, number)
        for stance in between(gait, switch):
            domain, flow = landing_domain(gait, law, number, stance)
            found.append(domain)
            if whole:
                twin = _twin(gait, pattern.all_switches[number - 1 + len(pattern.solved)], stance)
                found.append(mirrored_domain(pattern, flow, twin.name, domain))
    return found


def _landings(
    gait: Gait, known: Mapping[str, Domain], switch: Switch, mirrors: bool, order: Sequence[str] | None
) -> list[Transition]:
    """All landings of a switch in every order; where the state is mirrored, that is done by the first of them."""
    found = []
    for step in landing_steps(gait, switch):
        if order is not None and not follows(step, switch, order):
            continue
        first, target = step.source == switch.source, step.target
        source, foot, down = step.source, step.landing[0], step.target.feet
        if mirrors:
            entered = entering(gait, 0)
            target = _twin(gait, entered, target)
            if not first:
                twin = gait.robot.mirror.feet
                source, foot, down = _twin(gait, entered, source), twin[foot], target.feet
        found.append(
            landing_transition(gait, foot, down, known[source.name], target.name, first, mirrors=mirrors and first)
        )
    return found


def _twin(gait: Gait, switch: Switch, stance: Stance) -> Stance:
    """Return the stance during the landings of a switch on the mirrored feet of another."""
    feet = {gait.robot.mirror.feet[foot] for foot in stance.feet}
    return next(step.target for step in landing_steps(gait, switch) if set(step.target.feet) == feet)


def start_state(gait: Gait) -> Vector:
    """Return the state at the entry of the first domain, (2 n_q,): the closed loop's own where it is known."""
    if gait.feedback is not None:
        return gait.feedback.start
    first = gait.domains[0]
    return frozen(np.concatenate([first.positions[0], first.velocities[0]]))


def _symmetries(gait: Gait) -> tuple[Symmetry, ...]:
    """Translations along the ground, and on level ground the turn about the vertical."""
    size = 2 * gait.robot.size
    x = ca.SX.sym("x", size)
    found = []
    for name, translation in gait.pattern.ground.translations.items():
        direction = ca.DM.zeros(size)
        direction[:3] = translation
        found.append(Symmetry(name, ca.Function(f"symmetry_{name}", [x], [ca.SX(direction)])))
    if gait.pattern.ground.level:
        found.append(Symmetry("yaw", _turn(gait.robot, x)))
    return tuple(found)


def keeps_phase(gait: Gait, symmetry: Symmetry) -> bool:
    """Whether the phase of every domain has no slope along a symmetry, at random configurations."""
    size = gait.robot.size
    q, numbers = ca.SX.sym("q", size), ca.SX.sym("numbers", len(gait.outputs.phase.numbers))
    states = np.random.default_rng(0).normal(0.0, 0.5, (PROBES, 2 * size))
    for stance in gait.pattern.solved:
        domain = DomainPhase(phase=gait.outputs.phase, robot=gait.robot, stance=stance)
        gradient = domain.rates(ca.SX(1, 1), ca.SX(1.0), q, ca.SX(size, 1), numbers).gradient
        function = ca.Function("gradient", [q, numbers], [ca.densify(gradient)])
        for state in states:
            row = np.asarray(function(state[:size], domain.measured(state[:size], state[size:])))
            direction = np.asarray(symmetry.generator(state))[:size]
            if not abs((row @ direction).item()) <= PRESERVED * np.linalg.norm(row) * np.linalg.norm(direction):
                return False
    return True


def _sees_orientation(gait: Gait) -> bool:
    """Whether any output depends on roll, pitch or yaw, the first three coordinates of y_a."""
    if gait.feedback is not None:
        return any(bool(np.any(weights[:, :3])) for weights in gait.feedback.weights.values())
    return any(name in ("roll", "pitch", "yaw") for domain in gait.outputs.domains for name in domain.coordinates)


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
        **dict(zip(names, units(names), strict=True)),
        **dict(zip(rates, units(names, "/s"), strict=True)),
        **SIGNALS,
    }
