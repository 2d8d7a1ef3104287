"""What the exported controller evaluates in one stance as one function, and the numbers of a gait as tables in C."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from amble.control import AllocationLaw, ContactLimits, margins
from amble.control.driven_loop import driven_motion
from amble.control.landing import landing_motion
from amble.control.linearisation import linearise
from amble.control.outputs import controllable
from amble.control.stance_functions import StanceMotion
from amble.control.virtual_constraints import VirtualConstraints
from amble.errors import InputError
from amble.export.code import comment
from amble.export.stances import switch_tables
from amble.gait import Gait
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.gait.control_law import Numbers, TorqueLaw
from amble.gait.landing_stances import landings
from amble.gait.linearising_law import InputOutputLinearisation, control_of
from amble.hybrid import Stance, impact
from amble.names import identifier
from amble.robot.mirror import SignedPermutation
from amble.types import Vector

FREE = 1e30
"""Torque or speed limit of a joint that has none, N m or rad/s."""

YOUNG = 0.5
"""Share of the planned duration before which every foot of a stance has to touch, and feet that just lifted may."""

LATEST = 2.0
"""Share of the planned duration after which a stance counts as late."""


@dataclass(frozen=True)
class StanceLaw:
    """The law of one solved stance, or of one between the landings into it.

    Attributes:
        stance: the stance.
        function: (clock, x, p) -> torques, forces of all feet, smallest pivot, smallest margin to a contact limit.
        parameters: p.
        duration: planned duration of the solved stance, s.
    """

    stance: Stance
    function: ca.Function
    parameters: Vector
    duration: float


def stance_laws(gait: Gait, law: AllocationLaw | None) -> list[StanceLaw]:
    """Write the laws of all solved stances under the gait's control law, then of those between landings.

    Raises:
        InputError: the control law gives no torques as expressions, or an allocation law is given and it takes none.
    """
    control, solved = control_of(gait), gait.pattern.solved
    stances = [*((stance, stance) for stance in solved), *landings(gait)]
    if isinstance(control, InputOutputLinearisation):
        gait = replace(gait, gains=(control.position_gain, control.velocity_gain))
        return [_linearising(gait, law or gait.law, following, stance) for stance, following in stances]
    if isinstance(control, TorqueLaw):
        numbers = dict(zip((stance.name for stance in solved), control.numbers(gait, law), strict=True))
        between = control.landing_numbers(gait, law)
        return [
            _driven(gait, control, stance if stance.name in between else following, stance,
                    between.get(stance.name, numbers[following.name]), following.name)
            for stance, following in stances
        ]  # fmt: skip
    raise InputError(f"control law '{control.name}' gives no torques as expressions, so it cannot be exported")


def _driven(
    gait: Gait, control: TorqueLaw, following: Stance, stance: Stance, numbers: Numbers, planned: str
) -> StanceLaw:
    """Write the law of a stance; ``following`` is the stance itself where the law has one of its own for it."""
    contacts = gait.pattern.contacts(following)
    symbols = [ca.SX.sym("t"), ca.SX.sym("x", 2 * gait.robot.size), ca.SX.sym("p", numbers.parameters.size)]
    at = _LawPoint.of(gait, following, stance, symbols)
    motion = driven_motion(contacts, control.torques, numbers.parameters.size, at.symbols)[1]
    duration = next(part.duration for part in gait.domains if part.name == planned)
    if gait.feedback is not None:
        duration = gait.feedback.durations[planned]
    return StanceLaw(stance, at.function(gait, motion), numbers.parameters, float(duration))


def _linearising(gait: Gait, law: AllocationLaw, following: Stance, stance: Stance) -> StanceLaw:
    robot, contacts = gait.robot, gait.pattern.contacts(following)
    outputs = len(gait.outputs.of(following.name).coordinates)
    constraints = VirtualConstraints.symbols(outputs, len(controllable(robot)), REFERENCE_ORDER, gait.outputs.phase)
    symbols = [ca.SX.sym("t"), ca.SX.sym("x", 2 * robot.size), constraints.packed()]
    at = _LawPoint.of(gait, following, stance, symbols)
    t, x, _ = at.symbols
    q, v = x[: robot.size], x[robot.size :]
    loop = linearise(contacts, law, q, v, constraints.phase_rates(robot, following, t, q, v), constraints)
    parameters = loop_parameters(gait, following.name)
    return StanceLaw(stance, at.function(gait, loop), parameters, float(parameters[0]))


@dataclass(frozen=True, kw_only=True)
class _LawPoint:
    """Where the law of a solved stance is evaluated for a stance: there, or at its entry behind the impact of all feet.

    Attributes:
        following: the solved stance.
        stance: itself, or one between the landings into it.
        given: symbols of clock, state and parameters.
        symbols: clock, state and parameters at which the law is evaluated.
    """

    following: Stance
    stance: Stance
    given: list[ca.SX]
    symbols: list[ca.SX]

    @classmethod
    def of(cls, gait: Gait, following: Stance, stance: Stance, given: list[ca.SX]) -> _LawPoint:
        symbols = given
        if stance != following:  # docs/theory/hybrid-model.md, eq. 21
            q, v = ca.vertsplit(given[1], gait.robot.size)
            symbols = [ca.SX(1, 1), ca.vertcat(q, impact(gait.pattern.contacts(following), q, v)[0]), given[2]]
        return cls(following=following, stance=stance, given=given, symbols=symbols)

    def function(self, gait: Gait, loop: StanceMotion) -> ca.Function:
        """Write torques, forces, pivot and margin; between landings of the feet on the ground (eq. 22)."""
        contacts, torques, forces = gait.pattern.contacts(self.stance), loop.torques, loop.forces
        q, v = ca.vertsplit(self.given[1], gait.robot.size)
        if self.stance != self.following:
            late = [foot for foot in self.following.feet if foot not in self.stance.feet]
            motion = landing_motion(contacts, late, q, v, torques)
            torques, forces = motion.torques, motion.forces
        limits = ContactLimits(contacts.ground.friction, gait.limits.normal_force)
        margin = ca.mmin(margins(contacts, contacts.points(q), forces, limits))
        results = [ca.densify(torques), ca.densify(contacts.on_every_foot(forces)), ca.SX(loop.pivot), margin]
        name = f"amble_law_{identifier(self.stance.name)}"
        return ca.Function(name, self.given, ca.cse(results), ["t", "x", "p"], ["torque", "force", "pivot", "margin"])


def torque_limits(gait: Gait) -> Vector:
    """Return what the saturation keeps: the smaller of the robot's and the gait's torque limits, (n_joints,), N m."""
    robot = gait.robot
    found = [min(joint.effort, gait.limits.torques.get(joint.name, np.inf), FREE) for joint in robot.joints]
    return np.array(found, dtype=np.float64)


def speed_limits(gait: Gait) -> Vector:
    """Return the smaller of the robot's and the gait's speed limits, (n_joints,), rad/s."""
    found = [min(joint.velocity, gait.limits.speeds.get(joint.name, np.inf), FREE) for joint in gait.robot.joints]
    return np.array(found, dtype=np.float64)


def tables(gait: Gait, laws: Sequence[StanceLaw], smallest_pivot: float, arguments: int, results: int) -> str:
    """Write all constant tables of a controller.

    Args:
        gait: the gait.
        laws: the laws of the solved stances, in order, then of those between landings.
        smallest_pivot: pivot below which rank counts as lost.
        arguments: scratch that the generated code needs for pointers to arguments.
        results: the same for results.
    """
    lines = [
        f"#define LAWS {len(laws)}",
        f"#define ARGUMENTS {arguments}",
        f"#define RESULTS {results}",
        f"#define YOUNG {YOUNG!r}",
        f"#define LATEST {LATEST!r}",
        f"#define SMALLEST_PIVOT {smallest_pivot!r}",
        "",
        *switch_tables(gait),
        numbers("DURATION", "LAWS", [law.duration for law in laws]),
        numbers("TORQUE_LIMIT", "AMBLE_JOINTS", torque_limits(gait)),
        numbers("SPEED_LIMIT", "AMBLE_JOINTS", speed_limits(gait)),
    ]
    for law in laws:
        packed = "duration, numbers of the phase, gains, reference curves, kernel of the output weights"
        what = f"{packed}; matrices column by column"
        lines.append(f"\n/* {comment(law.stance.name)}: {what}. */")
        lines.append(numbers(f"PARAMETERS_{identifier(law.stance.name)}", str(law.parameters.size), law.parameters))
    names = ", ".join(f"PARAMETERS_{identifier(law.stance.name)}" for law in laws)
    lines.append(f"static const double *const PARAMETERS[LAWS] = {{{names}}};")
    return "\n".join([*lines, "", *_mirror(gait), ""])


def numbers(name: str, size: str, values: Iterable[float], kind: str = "double") -> str:
    """Write an array of doubles, or of another kind of real numbers, that read back exactly."""
    return f"static const {kind} {name}[{size}] = {{\n{_wrapped([repr(float(value)) for value in values])}}};"


def whole_numbers(name: str, size: str, values: Iterable[int]) -> str:
    """Write an array of whole numbers."""
    return f"static const int {name}[{size}] = {{\n{_wrapped([str(int(value)) for value in values])}}};"


def _mirror(gait: Gait) -> list[str]:
    """Signed permutations a -> sign * a[index] of coordinates, joints and forces; the identity without a mirror."""
    robot = gait.robot
    sizes = {"COORDINATE": robot.size, "JOINT": len(robot.joints), "FORCE": gait.pattern.all_contacts.size}
    names = {"COORDINATE": "AMBLE_COORDINATES", "JOINT": "AMBLE_JOINTS", "FORCE": "AMBLE_FORCES"}
    if gait.pattern.mirrored:
        mirror = robot.mirror
        maps = {"COORDINATE": mirror.coordinates, "JOINT": mirror.joints, "FORCE": gait.pattern.all_contacts.mirror}
    else:
        maps = {name: SignedPermutation(np.arange(size), np.ones(size)) for name, size in sizes.items()}
    lines = ["/* The left-right mirror: a -> sign * a[index]. */"]
    for name, permutation in maps.items():
        lines.append(whole_numbers(f"{name}_INDEX", names[name], permutation.index))
        lines.append(numbers(f"{name}_SIGN", names[name], permutation.sign))
    return lines


def _wrapped(items: Sequence[str], a_line: int = 6) -> str:
    rows = [", ".join(items[start : start + a_line]) for start in range(0, len(items), a_line)]
    return ",\n".join(f"  {row}" for row in rows)
