"""What the exported controller evaluates in one stance as one function, and the numbers of a gait as tables in C."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from amble.control import AllocationLaw, ContactLimits, margins
from amble.control.driven_loop import driven_motion
from amble.control.linearisation import linearise
from amble.control.virtual_constraints import VirtualConstraints
from amble.errors import InputError
from amble.export.code import comment
from amble.gait import Gait
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.gait.control_law import Numbers, TorqueLaw
from amble.gait.linearising_law import InputOutputLinearisation, control_of
from amble.hybrid import Stance
from amble.names import identifier
from amble.robot.mirror import SignedPermutation
from amble.types import Vector

FREE = 1e30
"""Torque limit of a joint that has none, N m."""

EARLIEST = 0.5
"""Share of the planned duration before which no flag ends a stance: a foot that has just lifted may still touch."""

LATEST = 2.0
"""Share of the planned duration after which a stance counts as late."""


@dataclass(frozen=True)
class StanceLaw:
    """The law of one solved stance.

    Attributes:
        stance: the stance.
        function: (clock, x, p) -> torques, forces of all feet, smallest pivot, smallest margin to a contact limit.
        parameters: p.
        duration: planned duration, s.
    """

    stance: Stance
    function: ca.Function
    parameters: Vector
    duration: float


def stance_laws(gait: Gait, law: AllocationLaw | None) -> list[StanceLaw]:
    """Write the laws of all solved stances under the gait's control law.

    Raises:
        InputError: the control law gives no torques as expressions, or an allocation law is given and it takes none.
    """
    control, solved = control_of(gait), gait.pattern.solved
    if isinstance(control, InputOutputLinearisation):
        gait = replace(gait, gains=(control.position_gain, control.velocity_gain))
        return [_linearising(gait, law or gait.law, stance) for stance in solved]
    if isinstance(control, TorqueLaw):
        numbers = control.numbers(gait, law)
        return [_driven(gait, control, stance, entry) for stance, entry in zip(solved, numbers, strict=True)]
    raise InputError(f"control law '{control.name}' gives no torques as expressions, so it cannot be exported")


def _driven(gait: Gait, control: TorqueLaw, stance: Stance, numbers: Numbers) -> StanceLaw:
    contacts = gait.pattern.contacts(stance)
    symbols, motion = driven_motion(contacts, control.torques, numbers.parameters.size)
    q = symbols[1][: gait.robot.size]
    limits = ContactLimits(contacts.ground.friction, gait.limits.normal_force)
    margin = ca.mmin(margins(contacts, contacts.points(q), motion.forces, limits))
    results = [ca.densify(motion.torques), ca.densify(contacts.on_every_foot(motion.forces)), ca.SX(1.0), margin]
    name = f"amble_law_{identifier(stance.name)}"
    function = ca.Function(name, symbols, ca.cse(results), ["t", "x", "p"], ["torque", "force", "pivot", "margin"])
    duration = next(part.duration for part in gait.domains if part.name == stance.name)
    if gait.feedback is not None:
        duration = gait.feedback.durations[stance.name]
    return StanceLaw(stance, function, numbers.parameters, float(duration))


def _linearising(gait: Gait, law: AllocationLaw, stance: Stance) -> StanceLaw:
    robot, contacts = gait.robot, gait.pattern.contacts(stance)
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * robot.size)
    q, v = x[: robot.size], x[robot.size :]
    outputs = len(gait.outputs.of(stance.name).coordinates)
    constraints = VirtualConstraints.symbols(outputs, robot.size - 3, REFERENCE_ORDER, gait.outputs.phase)
    loop = linearise(contacts, law, q, v, constraints.phase_rates(robot, stance, t, q, v), constraints)
    limits = ContactLimits(contacts.ground.friction, gait.limits.normal_force)
    margin = ca.mmin(margins(contacts, contacts.points(q), loop.forces, limits))
    function = ca.Function(
        f"amble_law_{identifier(stance.name)}",
        [t, x, constraints.packed()],
        [ca.densify(loop.torques), ca.densify(contacts.on_every_foot(loop.forces)), loop.pivot, margin],
        ["t", "x", "p"],
        ["torque", "force", "pivot", "margin"],
    )
    parameters = loop_parameters(gait, stance.name)
    return StanceLaw(stance, function, parameters, float(parameters[0]))


def torque_limits(gait: Gait) -> Vector:
    """Return what the saturation keeps: the smaller of the robot's and the gait's torque limits, (n_joints,), N m."""
    robot = gait.robot
    found = [min(joint.effort, gait.limits.torques.get(joint.name, np.inf), FREE) for joint in robot.joints]
    return np.array(found, dtype=np.float64)


def tables(gait: Gait, laws: Sequence[StanceLaw], smallest_pivot: float, arguments: int, results: int) -> str:
    """Write all constant tables of a controller.

    Args:
        gait: the gait.
        laws: the laws of the solved stances, in order.
        smallest_pivot: pivot below which rank counts as lost.
        arguments: scratch that the generated code needs for pointers to arguments.
        results: the same for results.
    """
    masks = [sum(1 << gait.robot.foot_names.index(foot) for foot in stance.feet) for stance in gait.pattern.stances]
    lines = [
        f"#define SOLVED {len(laws)}",
        f"#define ARGUMENTS {arguments}",
        f"#define RESULTS {results}",
        f"#define EARLIEST {EARLIEST!r}",
        f"#define LATEST {LATEST!r}",
        f"#define SMALLEST_PIVOT {smallest_pivot!r}",
        "",
        "/* Feet on the ground in every stance, one bit a foot. */",
        f"static const unsigned DOWN[AMBLE_STANCES] = {{{', '.join(f'{mask}u' for mask in masks)}}};",
        numbers("DURATION", "SOLVED", [law.duration for law in laws]),
        numbers("TORQUE_LIMIT", "AMBLE_JOINTS", torque_limits(gait)),
    ]
    for law in laws:
        packed = "duration, numbers of the phase, gains, reference curves, kernel of the output weights"
        what = f"{packed}; matrices column by column"
        lines.append(f"\n/* {comment(law.stance.name)}: {what}. */")
        lines.append(numbers(f"PARAMETERS_{identifier(law.stance.name)}", str(law.parameters.size), law.parameters))
    names = ", ".join(f"PARAMETERS_{identifier(law.stance.name)}" for law in laws)
    lines.append(f"static const double *const PARAMETERS[SOLVED] = {{{names}}};")
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
