"""A legged motion as plain arrays, the same for an optimised gait and for a simulated trace."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.amounts import LARGEST_NUMBER, check_amount
from amble.analysis.even_samples import evenly_sampled
from amble.analysis.motion import Motion
from amble.errors import InputError, UnknownNameError
from amble.gait import DomainTrajectory, Gait
from amble.hybrid import GaitPattern
from amble.robot import Robot
from amble.robot.natural_units import velocity_unit
from amble.robot.rotation import rotation_about
from amble.robot.turn import VERTICAL, turned
from amble.simulation import Trace
from amble.types import IntegerVector, NodeValues, Vector, frozen

STANDING = 1e-6
"""Mean speed of a gait that steps in place, at most, as a share of sqrt(g l)."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """A motion of a robot, sampled; both sides of every event are there.

    Attributes:
        label: which motion, such as "nominal" or "simulated".
        pattern: the gait pattern, with the robot.
        times: (n,), s.
        segments: number of the domain visit of every sample, from 0, (n,).
        stances: index into ``pattern.visited`` of every sample, (n,).
        cycles: number of the gait cycle of every sample, from 0, (n,).
        positions: q, (n, n_q), m and rad.
        velocities: v, (n, n_q), m/s and rad/s.
        torques: joint torques that were applied, (n, n_joints), N m.
        forces: contact forces of all feet, zero for swing feet, world frame, (n, n_f), N.
    """

    label: str
    pattern: GaitPattern
    times: Vector
    segments: IntegerVector
    stances: IntegerVector
    cycles: IntegerVector
    positions: NodeValues
    velocities: NodeValues
    torques: NodeValues
    forces: NodeValues

    @property
    def robot(self) -> Robot:
        """The robot that moves."""
        return self.pattern.robot

    @property
    def distance(self) -> float:
        """Horizontal distance walked, m: the chords of all cycles; 0 where they make less than ``STANDING``."""
        ends = [np.flatnonzero(self.cycles == cycle)[[0, -1]] for cycle in np.unique(self.cycles)]
        over = self.robot.base.spatial(self.positions)[:, :2]
        chords = [np.hypot(*(over[last] - over[first])) for first, last in ends]
        walked = float(np.sum(chords))
        slowest = STANDING * velocity_unit(self.robot) * float(self.times[-1] - self.times[0])
        return walked if walked > slowest else 0.0

    def local_forces(self, forces: NodeValues) -> NodeValues:
        """Turn contact forces of all feet along this motion into the ground's frames, (n, n_feet, size).

        Args:
            forces: world frame, (n, n_f).
        """
        pattern, shape = self.pattern, (len(self.times), len(self.robot.feet), -1)
        if pattern.ground.level:
            return forces.reshape(shape)
        q = ca.SX.sym("q", self.robot.size)
        points = ca.Function("points", [q], [pattern.all_contacts.points(q)]).map(len(self.times))(self.positions.T)
        frames = pattern.ground.frame(np.asarray(points).T.reshape(shape))
        local: NodeValues = pattern.contact.local(forces.reshape(shape), frames)
        return local

    def coordinate(self, name: str) -> tuple[Vector, Vector]:
        """Return a coordinate and its rate by name, each (n,)."""
        column = self.robot.coordinate_index(name)
        return self.positions[:, column], self.velocities[:, column]

    def only(self, first: int, past: int) -> Samples:
        """Keep the cycles from ``first`` up to but not including ``past``.

        Raises:
            InputError: where the motion holds none of them.
        """
        kept = (self.cycles >= first) & (self.cycles < past)
        if not np.any(kept):
            raise InputError(f"the {self.label} motion has no sample in cycles {first} to {past - 1}")
        return Samples(
            label=self.label,
            pattern=self.pattern,
            times=frozen(self.times[kept]),
            segments=_frozen_integers(self.segments[kept]),
            stances=_frozen_integers(self.stances[kept]),
            cycles=_frozen_integers(self.cycles[kept]),
            positions=frozen(self.positions[kept]),
            velocities=frozen(self.velocities[kept]),
            torques=frozen(self.torques[kept]),
            forces=frozen(self.forces[kept]),
        )

    def motion(self, torques: Mapping[str, NodeValues]) -> Motion:
        """Return the samples as metrics need them, with the torques each law applies on this trajectory.

        Args:
            torques: law name -> joint torques, (n, n_joints), N m, or N of prismatic joints.
        """
        arms = self.robot.torque_arms
        return Motion(
            label=self.label,
            joints=self.robot.joint_names,
            times=self.times,
            segments=self.segments,
            speeds=self.velocities[:, self.robot.base.size :] / arms,
            torques={law: arms * values for law, values in torques.items()},
            distance=self.distance,
            mass=self.robot.mass,
            gravity=self.robot.gravity,
        )


MOST_CYCLES = 10_000


def samples_of_gait(gait: Gait, cycles: int = 1) -> Samples:
    """Lay out whole cycles of the optimised motion at even nodes; a mirrored half is unfolded.

    Positions along x and y continue from half to half; every other coordinate repeats.

    Args:
        gait: the gait.
        cycles: how many cycles, from 1 to 10,000.

    Raises:
        InputError: there are fewer or more.
    """
    check_amount("cycles", cycles, 1, MOST_CYCLES)
    halves = [_solved_part(gait)]
    if gait.pattern.mirrored:
        halves.append(_mirrored(halves[0], gait.pattern))
    visits, turn = len(gait.domains), gait.turn
    parts: list[_Part] = []
    for number in range(cycles * len(halves)):
        part = halves[number % len(halves)]
        part = _turned(part, number * turn, gait.pattern) if turn else part
        part = _follow(parts[-1], part, gait.pattern) if parts else part
        parts.append(part)
    segments = np.concatenate([part.visits + visits * number for number, part in enumerate(parts)])
    return Samples(
        label="nominal",
        pattern=gait.pattern,
        times=frozen(np.concatenate([part.times for part in parts])),
        segments=_frozen_integers(segments),
        stances=_frozen_integers(segments % (visits * len(halves))),
        cycles=_frozen_integers(segments // (visits * len(halves))),
        positions=frozen(np.concatenate([part.positions for part in parts])),
        velocities=frozen(np.concatenate([part.velocities for part in parts])),
        torques=frozen(np.concatenate([part.torques for part in parts])),
        forces=frozen(np.concatenate([part.forces for part in parts])),
    )


def samples_of_trace(trace: Trace, pattern: GaitPattern) -> Samples:
    """Read a simulated motion of a legged robot.

    Args:
        trace: the trace; its domains bear the names of the pattern's stances.
        pattern: the gait pattern that was simulated.

    Raises:
        UnknownNameError: where a domain is no stance of the pattern, or the trace lacks a signal.
        InputError: where the state is not (q, v) of the pattern's robot, or holds a number that no robot has.
    """
    size = pattern.robot.size
    if trace.state.shape[1] != 2 * size:
        raise InputError(f"the trace has {trace.state.shape[1]} states; robot '{pattern.robot.name}' has {2 * size}")
    torques, forces = signal(trace, "torque"), signal(trace, "force")
    for what, values in (("state", trace.state), ("torque", torques), ("force", forces)):
        if not np.all(np.abs(values) <= LARGEST_NUMBER):  # squares of the largest numbers there are have no size
            raise InputError(f"the trace has a {what} that is not finite or above {LARGEST_NUMBER:g}")
    return Samples(
        label="simulated",
        pattern=pattern,
        times=trace.time,
        segments=_frozen_integers(np.concatenate([[0], np.cumsum(_enters(trace))])),
        stances=_frozen_integers(stance_indices(trace, pattern)),
        cycles=trace.cycle,
        positions=frozen(trace.state[:, :size]),
        velocities=frozen(trace.state[:, size:]),
        torques=torques,
        forces=forces,
    )


def stance_indices(trace: Trace, pattern: GaitPattern) -> IntegerVector:
    """Index into ``pattern.visited`` of every sample of a trace, (n,)."""
    names = [stance.name for stance in pattern.visited]
    lookup = []
    for domain in trace.domains:
        if domain not in names:
            raise UnknownNameError("stance", domain, names)
        lookup.append(names.index(domain))
    return np.asarray(lookup, dtype=np.int64)[trace.domain]


def signal(trace: Trace, name: str) -> NodeValues:
    """Look a recorded signal up, (n, width)."""
    if name not in trace.signals:
        raise UnknownNameError("signal", name, trace.signals)
    return trace.signals[name]


def _enters(trace: Trace) -> NDArray[np.bool_]:
    """Whether a new domain visit begins after each sample but the last: a new domain or cycle, or a restarted clock."""
    return (np.diff(trace.domain) != 0) | (np.diff(trace.cycle) != 0) | (np.diff(trace.clock) < 0.0)


@dataclass(frozen=True, kw_only=True)
class _Part:
    """Half a cycle, or a whole one where the gait is not mirrored; ``visits`` numbers the domains from 0."""

    times: Vector
    visits: IntegerVector
    positions: NodeValues
    velocities: NodeValues
    torques: NodeValues
    forces: NodeValues


def _solved_part(gait: Gait) -> _Part:
    """The solved domains at even nodes, one after the other."""
    domains = [evenly_sampled(domain) for domain in gait.domains]
    starts = np.concatenate([[0.0], np.cumsum([domain.duration for domain in domains])])
    counts = [len(domain.times) for domain in domains]
    return _Part(
        times=np.concatenate([start + domain.times for start, domain in zip(starts[:-1], domains, strict=True)]),
        visits=np.repeat(np.arange(len(counts)), counts),
        positions=np.concatenate([domain.positions for domain in domains]),
        velocities=np.concatenate([domain.velocities for domain in domains]),
        torques=np.concatenate([domain.torques for domain in domains]),
        forces=np.concatenate([_forces_of_all_feet(gait, domain) for domain in domains]),
    )


def _forces_of_all_feet(gait: Gait, domain: DomainTrajectory) -> NodeValues:
    """Contact forces of one solved domain with zeros for the swing feet, (n, n_f), N."""
    pattern = gait.pattern
    found = np.zeros((len(domain.times), pattern.all_contacts.size))
    found[:, pattern.contacts(pattern.stance(domain.name)).columns] = domain.forces
    return found


def _mirrored(part: _Part, pattern: GaitPattern) -> _Part:
    mirror = pattern.robot.mirror
    return replace(
        part,
        positions=mirror.position(part.positions.T).T,
        velocities=mirror.position(part.velocities.T).T,
        torques=mirror.torque(part.torques.T).T,
        forces=pattern.all_contacts.mirror(part.forces.T).T,
    )


def _turned(part: _Part, angle: float, pattern: GaitPattern) -> _Part:
    """Turn a part about the vertical, with its forces."""
    positions, velocities = turned(part.positions, part.velocities, angle)
    about = np.asarray(rotation_about(VERTICAL, angle))
    forces = part.forces.reshape(len(part.times), len(pattern.robot.feet), -1).copy()
    forces[..., :3] = forces[..., :3] @ about.T  # moments are about the ground's own axes
    return replace(part, positions=positions, velocities=velocities, forces=forces.reshape(part.forces.shape))


def _follow(before: _Part, part: _Part, pattern: GaitPattern) -> _Part:
    """Shift a part in time and along the ground so that it begins where another ends."""
    positions, base = part.positions.copy(), pattern.robot.base
    missing = before.positions[-1] - positions[0]
    for name, along in pattern.ground.translations.items():
        if name in base.coordinates:
            positions[:, : len(base.axes)] += missing[base.coordinates.index(name)] * along[list(base.axes)]
    return replace(part, times=part.times - part.times[0] + before.times[-1], positions=positions)


def _frozen_integers(values: IntegerVector) -> IntegerVector:
    """Return a read-only copy."""
    copy = np.array(values, dtype=np.int64)
    copy.flags.writeable = False
    return copy
