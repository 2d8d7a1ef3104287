"""A mirrored gait as one of all its stances: the second half, which the mirror stands for, is written out.

A gait that goes straight is mirrored and one that turns is not; written out, the first is of the same kind as the
second, so that a turn can start from it and a law can be interpolated between both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from amble.control import Outputs
from amble.control.outputs import DomainOutputs, controllable
from amble.errors import InputError
from amble.gait.record import DomainTrajectory, Feedback, Gait
from amble.hybrid import Stance, Switch
from amble.robot.mirror import SignedPermutation
from amble.types import NodeValues, Vector, frozen


def unfolded(gait: Gait) -> Gait:
    """Return a mirrored gait without its mirror: the same motion under the same law; another gait as it is.

    Multipliers are left out: the problem of all stances has other rows.

    Raises:
        InputError: the gait has a control law of its own, or a phase that reads the configuration: of them it is not
            known what they are in the mirror.
    """
    if not gait.pattern.mirrored:
        return gait
    if gait.control is not None:
        raise InputError(f"a gait under control law '{gait.control.name}' has no known form without its mirror")
    if gait.outputs.phase.numbers:
        raise InputError(f"a gait on phase '{gait.outputs.phase.name}' has no known form without its mirror")
    pattern, solved = gait.pattern, gait.pattern.solved
    twins = dict(zip((stance.name for stance in solved), pattern.stances[len(solved) :], strict=True))
    second = [_image(gait, number, stance) for number, stance in enumerate(twins.values())]
    outputs = [_images(gait, entry, twins[entry.domain])[0] for entry in gait.outputs.domains]
    durations = {twins[name].name: pair for name, pair in gait.limits.durations.items() if name in twins}
    return replace(
        gait,
        pattern=replace(pattern, mirrored=False),
        outputs=Outputs((*gait.outputs.domains, *outputs), gait.outputs.order, gait.outputs.phase),
        limits=replace(gait.limits, durations={**gait.limits.durations, **durations}),
        domains=(*gait.domains, *_following(gait, second)),
        feedback=None if gait.feedback is None else _whole(gait, gait.feedback, twins),
        multipliers=None,
    )


def _image(gait: Gait, number: int, stance: Stance) -> DomainTrajectory:
    """Mirror a solved domain onto its twin."""
    mirror, domain, pattern = gait.robot.mirror, gait.domains[number], gait.pattern
    _, order, sign = _images(gait, gait.outputs.of(domain.name), stance)
    switch = pattern.all_switches[number + len(pattern.solved)]
    motion = domain.positions, domain.velocities, domain.accelerations
    positions, velocities, accelerations = (frozen(mirror.position(rows.T).T) for rows in motion)
    return replace(
        domain,
        name=stance.name,
        coefficients=frozen(sign[:, None] * domain.coefficients[order]),
        positions=positions,
        velocities=velocities,
        accelerations=accelerations,
        torques=frozen(mirror.torque(domain.torques.T).T),
        forces=_forces(gait, domain.forces, pattern.solved[number], stance),
        impulse=_impulse(gait, domain.impulse, number, switch),
    )


def _images(gait: Gait, entry: DomainOutputs, stance: Stance) -> tuple[DomainOutputs, list[int], Vector]:
    """Return the mirrored outputs of a domain, from which of its own they come, and with which sign."""
    names, mirror = controllable(gait.robot), _orientation(gait)
    places = [int(np.flatnonzero(mirror.index == names.index(name))[0]) for name in entry.coordinates]
    order = sorted(range(len(places)), key=lambda row: places[row])
    coordinates = tuple(names[places[row]] for row in order)
    return DomainOutputs(stance.name, coordinates), order, mirror.sign[[places[row] for row in order]]


def _orientation(gait: Gait) -> SignedPermutation:
    """The mirror of y_a: the base's orientation and the joints."""
    coordinates, axes = gait.robot.mirror.coordinates, len(gait.robot.base.axes)
    return SignedPermutation(coordinates.index[axes:] - axes, coordinates.sign[axes:])


def _forces(gait: Gait, forces: NodeValues, stance: Stance, twin: Stance) -> NodeValues:
    """Mirror forces of a stance's feet onto those of its twin, rows of (n, n_f)."""
    every = np.zeros((len(forces), gait.pattern.all_contacts.size))
    every[:, gait.pattern.contacts(stance).columns] = forces
    image = gait.pattern.all_contacts.mirror(every.T).T
    return frozen(image[:, gait.pattern.contacts(twin).columns])


def _impulse(gait: Gait, impulse: Vector, number: int, switch: Switch) -> Vector:
    if not switch.landing:
        return impulse
    return frozen(_forces(gait, impulse[None], gait.pattern.switches[number].target, switch.target)[0])


def _following(gait: Gait, second: list[DomainTrajectory]) -> list[DomainTrajectory]:
    """Let the second half begin where the first ends, along the ground."""
    base = gait.robot.base
    missing, shift = gait.domains[-1].positions[-1] - second[0].positions[0], np.zeros(gait.robot.size)
    for name, along in gait.pattern.ground.translations.items():
        if name in base.coordinates:
            shift[: len(base.axes)] += missing[base.coordinates.index(name)] * along[list(base.axes)]
    return [replace(domain, positions=frozen(domain.positions + shift)) for domain in second]


def _whole(gait: Gait, feedback: Feedback, twins: Mapping[str, Stance]) -> Feedback:
    """Mirror references and weights: y = H (S y_a - y_d) = H S (y_a - S y_d)."""
    mirror, references, weights = _orientation(gait), dict(feedback.references), dict(feedback.weights)
    for name, twin in twins.items():
        _, order, sign = _images(gait, gait.outputs.of(name), twin)
        references[twin.name] = frozen(mirror(feedback.references[name]))
        weights[twin.name] = frozen(sign[:, None] * (feedback.weights[name] @ mirror.matrix)[order])
    durations = {twin.name: feedback.durations[name] for name, twin in twins.items()}
    return replace(
        feedback,
        references=references,
        weights=weights,
        durations={**feedback.durations, **durations},
    )
