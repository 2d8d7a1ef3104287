"""What a gait record must be before anything reads it: lengths, counts, clocks and numbers that fit together.

Whether the motion is one of the robot is not judged here but by ``gait.check``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.control.outputs import LARGEST_ORDER, actuated_freedoms, controllable
from amble.control.phase import DomainPhase
from amble.errors import InputError, UnknownNameError, listed
from amble.numerics.collocation import HERMITE_SIMPSON, collocation_scheme, node_positions
from amble.types import frozen

if TYPE_CHECKING:
    from amble.gait.record import DomainTrajectory, Feedback, Gait
    from amble.types import Vector

CLOCK_ROUNDING = 1e-9
"""What the last node's clock may miss of the duration, as a share of it."""


def check_trajectory(domain: DomainTrajectory) -> None:
    """Refuse a recorded motion whose numbers do not fit together.

    Raises:
        InputError: a duration that is not positive, a clock that does not run from 0 to it, fields of different
            lengths, nodes that its scheme does not have, or a number that is not finite or too large.
    """
    place, nodes = f"the motion of domain '{domain.name}'", len(domain.times)
    check_duration(f"the duration of domain '{domain.name}'", domain.duration)
    for field in ("positions", "velocities", "accelerations", "torques", "forces"):
        values = getattr(domain, field)
        if values.ndim != 2 or len(values) != nodes:
            raise InputError(f"{place} has {nodes} nodes, but its {field} have the shape {_shape(values)}")
        _bounded(place, field, values)
    for field in ("coefficients", "times", "impulse"):
        _bounded(place, field, getattr(domain, field))
    _intervals(place, domain)
    _clock(place, domain.times, domain.duration)
    _mesh(place, domain)


def check_feedback(feedback: Feedback) -> None:
    """Refuse stabilised outputs with a duration that is not positive or a number that is not finite or too large.

    Raises:
        InputError: in one sentence.
    """
    for name, duration in feedback.durations.items():
        check_duration(f"the feedback's duration of domain '{name}'", duration)
    for field in ("references", "weights"):
        for name, values in getattr(feedback, field).items():
            _bounded(f"the feedback of domain '{name}'", field, values)
    _bounded("the feedback", "start", feedback.start)


def check_gait(gait: Gait) -> None:
    """Refuse a gait whose parts do not fit its robot, its pattern and each other.

    Raises:
        UnknownNameError: an output that the robot does not have.
        InputError: anything else that does not fit, in one sentence.
    """
    numbers = {
        "speed": gait.speed,
        "lateral speed": gait.lateral_speed,
        "yaw rate": gait.yaw_rate,
        "position gain": gait.gains[0],
        "velocity gain": gait.gains[1],
    }
    for what, value in numbers.items():
        if not np.isfinite(value):
            raise InputError(f"the {what} of the gait is {value}, not a finite number")
        if abs(value) > LARGEST_NUMBER:
            raise InputError(f"the {what} of the gait is {value}; numbers of a gait go up to {LARGEST_NUMBER:g}")
    solved = [stance.name for stance in gait.pattern.solved]
    _same("outputs", [entry.domain for entry in gait.outputs.domains], solved)
    _same("motion", [domain.name for domain in gait.domains], solved)
    schemes = {domain.scheme for domain in gait.domains}
    if len(schemes) > 1:
        raise InputError(f"the domains of the gait have the schemes {listed(sorted(schemes))}, not one")
    _check_outputs(gait)
    for number, domain in enumerate(gait.domains):
        _check_shapes(gait, number)
        _check_phase(gait, number, domain.phase_numbers)
    if gait.feedback is not None:
        _check_feedback_shapes(gait, gait.feedback)
        for number, name in enumerate(solved):
            _check_phase(gait, number, gait.feedback.phase_numbers.get(name, frozen([])))


def check_duration(what: str, duration: float) -> None:
    """Refuse a duration that is not a finite positive number."""
    if not 0.0 < duration < np.inf:
        raise InputError(f"{what} is {duration:g} s; it must be positive and finite")


def _clock(place: str, times: Vector, duration: float) -> None:
    if not np.all(np.diff(times) > 0.0):
        raise InputError(f"{place} has a clock that does not run forward")
    if abs(times[0]) > CLOCK_ROUNDING * duration or abs(times[-1] - duration) > CLOCK_ROUNDING * duration:
        raise InputError(f"{place} lasts {duration:g} s, but its clock runs from {times[0]:g} to {times[-1]:g} s")


def _intervals(place: str, domain: DomainTrajectory) -> None:
    """Refuse nodes that are not those of whole intervals."""
    scheme, nodes = collocation_scheme(domain.scheme), len(domain.times)
    inner = scheme.stages - 1
    if nodes <= inner or nodes % inner != 1:
        raise InputError(
            f"{place} has {nodes} nodes; scheme '{scheme.name}' has one and {inner} more for every interval"
        )


def _mesh(place: str, domain: DomainTrajectory) -> None:
    """Refuse nodes that are not where the scheme has them; those of motions from elsewhere may be anywhere."""
    scheme = collocation_scheme(domain.scheme)
    if domain.scheme == HERMITE_SIMPSON:
        return  # the curves between the nodes take them as they are
    missed = np.abs(domain.times / domain.duration - node_positions(scheme, domain.intervals)).max()
    if missed > CLOCK_ROUNDING:
        raise InputError(
            f"the clock of {place} misses the nodes of scheme '{scheme.name}' by {missed:.2g} of the duration"
        )


def _check_outputs(gait: Gait) -> None:
    known = controllable(gait.robot)
    for stance in gait.pattern.solved:
        coordinates = gait.outputs.of(stance.name).coordinates
        for name in coordinates:
            if name not in known:
                raise UnknownNameError(f"output of domain '{stance.name}'", name, known)
        needed = actuated_freedoms(gait.pattern.contacts(stance))
        if len(coordinates) != needed or len(set(coordinates)) != needed:
            raise InputError(
                f"domain '{stance.name}' has {len(set(coordinates))} different outputs of {len(coordinates)}; "
                f"standing on {', '.join(stance.feet) or 'no foot'} it needs {needed}"
            )


def _check_shapes(gait: Gait, number: int) -> None:
    """Fields of one domain against robot, stance and outputs; something must move, and a foot of a stance push."""
    robot, domain, stance = gait.robot, gait.domains[number], gait.pattern.solved[number]
    switch, nodes, outputs = gait.pattern.switches[number], len(domain.times), gait.outputs
    contacts = gait.pattern.contacts(stance)
    wanted = {
        "coefficients": (len(outputs.of(domain.name).coordinates), outputs.order + 1),
        **dict.fromkeys(("positions", "velocities", "accelerations"), (nodes, robot.size)),
        "torques": (nodes, len(robot.joints)),
        "forces": (nodes, contacts.size),
        "impulse": (gait.pattern.contacts(switch.target).size if switch.landing else 0,),
    }
    for field, shape in wanted.items():
        _shaped(f"the {field} of domain '{domain.name}'", getattr(domain, field), shape)
    if not np.any(domain.velocities):
        raise InputError(f"nothing moves in the motion of domain '{domain.name}'")
    normal = [contacts.normal_index(foot) for foot in stance.feet]
    if normal and not np.any(domain.forces[:, normal] > 0.0):
        raise InputError(f"no foot pushes on the ground in the motion of domain '{domain.name}'")


def _check_phase(gait: Gait, number: int, numbers: Vector) -> None:
    """The numbers of the phase in one domain: as many as it needs, and such that it has a value and a rate."""
    phase, stance = gait.outputs.phase, gait.pattern.solved[number]
    if numbers.shape != (len(phase.numbers),):
        raise InputError(
            f"domain '{stance.name}' has {numbers.size} numbers for phase '{phase.name}', not {len(phase.numbers)}"
        )
    if not phase.numbers:
        return
    _bounded(f"domain '{stance.name}'", f"numbers of phase '{phase.name}'", numbers)
    domain, motion = DomainPhase(phase=phase, robot=gait.robot, stance=stance), gait.domains[number]
    found = domain.sampled(motion.times, motion.duration, motion.positions, motion.velocities, numbers)
    if not np.all(np.isfinite(found)):
        given = ", ".join(f"{known.name} = {value:g}" for known, value in zip(phase.numbers, numbers, strict=True))
        raise InputError(f"phase '{phase.name}' of domain '{stance.name}' is not finite with {given}")


def _check_feedback_shapes(gait: Gait, feedback: Feedback) -> None:
    solved, observed = [stance.name for stance in gait.pattern.solved], len(controllable(gait.robot))
    kinds: tuple[Mapping[str, Any], ...] = (feedback.references, feedback.weights, feedback.durations)
    for entries in kinds:
        _same("feedback", entries, solved)
    for name in solved:
        references = feedback.references[name]
        columns = references.shape[-1] if references.ndim else 0
        _shaped(f"the references of domain '{name}'", references, (observed, max(columns, 1)))
        if columns - 1 > LARGEST_ORDER:
            raise InputError(
                f"the order of the references of domain '{name}' is {columns - 1}; the closed loop takes up to "
                f"{LARGEST_ORDER}"
            )
        count = len(gait.outputs.of(name).coordinates)
        _shaped(f"the weights of domain '{name}'", feedback.weights[name], (count, observed))
    _shaped("the start of the feedback", feedback.start, (2 * gait.robot.size,))


def _same(what: str, names: Collection[str], solved: list[str]) -> None:
    if set(names) != set(solved) or len(names) != len(solved):
        raise InputError(f"the {what} of the gait name the domains {listed(names)}, not {listed(solved)}")


def _shaped(what: str, values: Any, shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise InputError(f"{what} have the shape {_shape(values)}, not {' x '.join(map(str, shape))}")


def _shape(values: Any) -> str:
    return " x ".join(map(str, values.shape)) or "of one number"


def _bounded(place: str, field: str, values: Any) -> None:
    if not np.all(np.isfinite(values)):
        raise InputError(f"{place}: its {field} hold a number that is not finite")
    if not np.all(np.abs(values) <= LARGEST_NUMBER):
        raise InputError(f"{place}: its {field} hold a number above {LARGEST_NUMBER:g}")
