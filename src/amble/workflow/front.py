"""Torque against robustness over several gaits of one robot: which of them no other one beats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import pi

import numpy as np

from amble.analysis import actuators_for, samples_of_gait, torque_metrics
from amble.analysis.pareto import undominated
from amble.errors import InputError
from amble.gait import Gait
from amble.progress import Progress, ProgressReport, silent
from amble.stability.input_gains import CycleMap
from amble.stability.push_response import PushResponse, push_response
from amble.types import Json

DIRECTIONS = 16
"""Of the pushes."""


@dataclass(frozen=True, kw_only=True)
class FrontPoint:
    """A gait on the plane of torque and robustness.

    Attributes:
        name: of the gait.
        rms_torque: over the joints and the cycle, N m.
        push: impulse on the base of which, to first order, half of all directions and phases cost no contact, N s.
        radius: spectral radius of a gait cycle.
        friction_used: largest friction that a foot uses.
        best: whether no other gait has at most its torque and bears at least its push.
    """

    name: str
    rms_torque: float
    push: float
    radius: float
    friction_used: float
    best: bool = False


@dataclass(frozen=True, kw_only=True)
class Front:
    """Gaits of one robot with what they cost and bear.

    Attributes:
        points: from the least torque on.
        robot: name of the robot.
        friction: of the ground that is walked on.
    """

    points: tuple[FrontPoint, ...]
    robot: str
    friction: float

    def cheapest(self, push: float) -> FrontPoint:
        """Return the gait of least torque that bears a push.

        Raises:
            InputError: none does.
        """
        bearing = [point for point in self.points if point.push >= push]
        if not bearing:
            most = max(point.push for point in self.points)
            raise InputError(f"no gait bears a push of {push:g} N s; the most is {most:.3g} N s")
        return min(bearing, key=lambda point: point.rms_torque)

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        points = [asdict(point) for point in self.points]
        return {"robot": self.robot, "friction": self.friction, "points": points}


def front(gaits: Mapping[str, Gait], friction: float = 0.8, progress: Progress | None = None) -> Front:
    """Compute what gaits cost and bear.

    The push follows from the linearisation of a walk on ground that pushes only (docs/theory/robustness.md, section 6).

    Args:
        gaits: stabilised gaits of one robot, by name.
        friction: of the ground that all are walked on.
        progress: called with every gait.

    Raises:
        InputError: there is no gait, they are of different robots, one is not stable, or the friction is not positive.
        FallError: a walk with a small push does not come back.
    """
    if len({gait.robot.hash for gait in gaits.values()}) != 1:
        raise InputError("a front needs gaits of one robot, at least one")
    if not 0.0 < friction < np.inf:
        raise InputError(f"the friction of the ground is {friction:g}; it must be a positive number")
    notify, found = progress or silent, list[FrontPoint]()
    for number, (name, gait) in enumerate(gaits.items()):
        notify(ProgressReport(what=f"push of {name}", done=number, of=len(gaits)))
        found.append(_point(name, gait, friction))
    best = undominated([point.rms_torque for point in found], [point.push for point in found])
    points = [FrontPoint(**(asdict(point) | {"best": on})) for point, on in zip(found, best, strict=True)]
    robot = next(iter(gaits.values())).robot.name
    return Front(points=tuple(sorted(points, key=lambda point: point.rms_torque)), robot=robot, friction=friction)


def _point(name: str, gait: Gait, friction: float) -> FrontPoint:
    try:
        cycle = CycleMap.of(gait)
    except InputError as error:
        raise InputError(f"gait '{name}': {error}") from None
    response, samples = push_response(cycle, friction), samples_of_gait(gait)
    torques = torque_metrics(samples.motion({"own": samples.torques}), "own", next(iter(actuators_for(gait))))
    return FrontPoint(
        name=name,
        rms_torque=torques.rms_torque,
        push=median_push(response),
        radius=cycle.spectrum.radius,
        friction_used=response.friction_used,
    )


def median_push(response: PushResponse) -> float:
    """Return the median over phases and directions of the impulse at which the first contact is lost, N s."""
    angles = 2.0 * pi * np.arange(DIRECTIONS) / DIRECTIONS
    losses = [response.by_contact(place, float(angle)) for place in range(len(response.phases)) for angle in angles]
    return float(np.median(losses))
