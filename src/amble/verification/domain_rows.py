"""Residuals inside a domain: motion, dynamics, contacts, outputs and allocation law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amble.control.outputs import selection_matrix
from amble.control.phase import DomainPhase
from amble.errors import WorkError
from amble.gait.record import DomainTrajectory, Gait
from amble.hybrid import Contacts, Stance, Switch
from amble.hybrid.contact import AXES
from amble.residual import Residual
from amble.types import IntegerVector, Matrix, Vector
from amble.verification.interpolation import fine_grid, interpolated
from amble.verification.output_dynamics import Effort, OutputDynamics, Record, integrate
from amble.verification.residuals import limit, of_contacts, residuals, size_of, sizes
from amble.verification.stance_model import Motion, Terms, allocated, law_residuals, terms

LOST = 1.0
"""Distance of two motions, as a share of the sizes of their coordinates, at which they have nothing in common."""


@dataclass(frozen=True, kw_only=True)
class SampledDomain:
    """One domain on a fine grid.

    Attributes:
        gait: the gait.
        trajectory: the recorded motion.
        contacts: the stance feet on the ground.
        stance: the stance.
        switch: the switch that ends it.
        loop: the output dynamics.
        times: clock of the grid, (points,), s.
        nodes: indices of the recorded nodes in the grid.
        positions: interpolated q, (points, n_q).
        velocities: interpolated v, (points, n_q).
        terms: the equations of motion at the grid.
        motion: the closed loop's accelerations, torques and forces at the grid, by the gait's law.
    """

    gait: Gait
    trajectory: DomainTrajectory
    contacts: Contacts
    stance: Stance
    switch: Switch
    loop: OutputDynamics
    times: Vector
    nodes: IntegerVector
    positions: Matrix
    velocities: Matrix
    terms: Terms
    motion: Motion

    @property
    def name(self) -> str:
        """Name of the domain."""
        return self.stance.name


def sampled(gait: Gait, number: int, grid: int) -> SampledDomain:
    """Interpolate a domain and solve its closed loop on the grid."""
    trajectory, stance = gait.domains[number], gait.pattern.solved[number]
    weights = selection_matrix(gait.robot, gait.outputs.of(stance.name))
    loop = OutputDynamics(
        weights=weights,
        references=weights.T @ trajectory.coefficients,
        duration=trajectory.duration,
        gains=gait.gains,
        domain=DomainPhase(phase=gait.outputs.phase, robot=gait.robot, stance=stance),
        phase_numbers=trajectory.phase_numbers,
    )
    times = fine_grid(trajectory.times, grid)
    q, v = interpolated(trajectory, times)
    contacts = gait.pattern.contacts(stance)
    at = terms(contacts, q, v)
    motion = allocated(at, loop.solve(at, times, q, v), gait.law)
    nodes = np.arange(len(trajectory.times), dtype=np.int64) * grid
    switch = gait.pattern.switches[number]
    return SampledDomain(
        gait=gait,
        trajectory=trajectory,
        contacts=contacts,
        stance=stance,
        switch=switch,
        loop=loop,
        times=times,
        nodes=nodes,
        positions=q,
        velocities=v,
        terms=at,
        motion=motion,
    )


def domain_residuals(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """Return every residual of a domain but those of its motion in time."""
    return [
        *_clock(domain, tolerance),
        *_phase(domain, tolerance),
        *_nodes(domain, tolerance),
        *_dynamics(domain, tolerance),
        *_contact(domain, tolerance),
        *_outputs(domain, tolerance),
        *_law(domain, tolerance),
    ]


def _clock(domain: SampledDomain, tolerance: float) -> list[Residual]:
    ends = np.array([[domain.trajectory.times[0], domain.trajectory.times[-1] - domain.trajectory.duration]])
    names = [f"{domain.name} clock at the entry", f"{domain.name} clock at the end less the duration"]
    return residuals("clock", names, ends, np.array([np.nan]), tolerance)


def _phase(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """Numbers of the phase against the motion's ends, and that the phase grows; nothing where it is time."""
    numbers = domain.gait.outputs.phase.numbers
    if not numbers:
        return []
    q, v, times = domain.positions, domain.velocities, domain.times
    missed = domain.trajectory.phase_numbers - domain.loop.domain.measured(q[0], q[-1])
    names = [f"{domain.name} phase {number.name}" for number in numbers]
    length = sizes(domain.gait.robot).length
    scale = np.array([length if number.unit == "m" else 1.0 for number in numbers])
    pace = domain.trajectory.duration * domain.loop.desired(times, q, v).pace
    return [
        *residuals("phase", names, missed[None], np.array([np.nan]), tolerance, scale),
        limit("phase", f"{domain.name} rate of the phase times the duration", pace, times, (0.0, np.inf), 0.0),
    ]


def motion_residuals(domain: SampledDomain, tolerance: float, effort: Effort) -> list[Residual]:
    """Interpolated states against the closed loop integrated from the recorded entry; NaN where that is impossible.

    The integration ends where the two are ``LOST`` of their sizes apart: numbers that are no motion need not be
    followed to the end to be told from one.

    Args:
        domain: the domain.
        tolerance: bound of the scaled residuals.
        effort: what the integration may take; it is spent.
    """
    robot, times = domain.gait.robot, domain.times
    least = sizes(robot)
    scale = size_of(domain.trajectory.velocities, least.rates)
    recorded = np.hstack([domain.positions, domain.velocities])
    record = Record(states=recorded, near=max(LOST, tolerance) * np.concatenate([least.positions, scale]))
    try:
        q, v = integrate(domain.contacts, domain.loop, domain.positions[0], domain.velocities[0], times, effort, record)
    except WorkError:
        q = v = np.full_like(domain.positions, np.nan)
    names = [f"{domain.name} motion {name}" for name in robot.coordinate_names]
    rates = [f"{domain.name} motion rate of {name}" for name in robot.coordinate_names]
    reached = len(q)
    return [
        *residuals("motion", names, domain.positions[:reached] - q, times[:reached], tolerance, least.positions),
        *residuals("motion", rates, domain.velocities[:reached] - v, times[:reached], tolerance, scale),
    ]


def _nodes(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """Recorded accelerations, torques and forces against the closed loop's."""
    robot, trajectory, nodes = domain.gait.robot, domain.trajectory, domain.nodes
    least, contacts = sizes(robot), domain.contacts
    found: list[Residual] = []
    kinds: tuple[tuple[str, Sequence[str], Matrix, Matrix, Vector | float], ...] = (
        (
            "acceleration",
            robot.coordinate_names,
            trajectory.accelerations,
            domain.motion.accelerations,
            least.accelerations,
        ),
        ("torque", robot.joint_names, trajectory.torques, domain.motion.torques, least.torques),
        (
            "force",
            contacts.labels,
            trajectory.forces,
            domain.motion.forces,
            of_contacts(contacts, least.force, least.torque),
        ),
    )
    for kind, labels, recorded, solved, size in kinds:
        names = [f"{domain.name} {kind} {label}" for label in labels]
        found += residuals(kind, names, recorded - solved[nodes], trajectory.times, tolerance, size_of(recorded, size))
    return found


def _dynamics(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """D a + h - B u - J^T lambda of what is recorded."""
    # shorthand
    at, trajectory, nodes = domain.terms, domain.trajectory, domain.nodes
    a, u, lam = trajectory.accelerations, trajectory.torques, trajectory.forces

    balance = np.einsum("pij,pj->pi", at.mass[nodes], a) + at.bias[nodes]
    balance -= np.einsum("pji,pj->pi", at.jacobian[nodes], lam)
    balance[:, domain.gait.robot.base.size :] -= u
    names = [f"{domain.name} dynamics {name}" for name in domain.gait.robot.coordinate_names]
    least = sizes(domain.gait.robot)
    forces = of_contacts(domain.contacts, least.force, least.torque)
    share = max(float(np.max(np.abs(part) / size, initial=0.0)) for part, size in ((u, least.torques), (lam, forces)))
    scale = least.loads * (1.0 + share)
    return residuals("dynamics", names, balance, trajectory.times, tolerance, scale)


def _contact(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """Stance feet: gap to the ground, drift from where they stood at the entry, velocity, acceleration."""
    at, trajectory, nodes, times = domain.terms, domain.trajectory, domain.nodes, domain.times
    least = sizes(domain.gait.robot)
    found: list[Residual] = []
    for foot in domain.stance.feet:
        columns = at.foot(foot)
        place, rate = at.positions[:, columns], at.rates[:, columns]
        drift, velocity = ([f"{domain.name} {what} {foot} {a}" for a in AXES] for what in ("drift", "velocity"))
        ground = [f"{domain.name} ground {foot}"]
        found += residuals("contact", ground, at.gap(foot)[:1], times[:1], tolerance, least.length)
        found += residuals("contact", drift, place - place[0], times, tolerance, least.length)
        scale = size_of(trajectory.velocities, least.rates)[0]
        found += residuals("contact", velocity, rate, times, tolerance, scale)
    acceleration = np.einsum("pij,pj->pi", at.jacobian[nodes], trajectory.accelerations) + at.contact_bias[nodes]
    names = [f"{domain.name} acceleration of foot {label}" for label in domain.contacts.labels]
    scales = size_of(trajectory.accelerations, least.accelerations)
    scale = of_contacts(domain.contacts, scales[0], scales[-1])
    return found + residuals("contact", names, acceleration, trajectory.times, tolerance, scale)


def _outputs(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """Outputs and their rates along the grid, and the output dynamics of the recorded accelerations at the nodes."""
    trajectory, nodes, times = domain.trajectory, domain.nodes, domain.times
    coordinates = domain.gait.outputs.of(domain.name).coordinates
    value, rate = domain.loop.errors(times, domain.positions, domain.velocities)
    q, v = domain.positions[nodes], domain.velocities[nodes]
    dynamics = domain.loop.residuals(times[nodes], q, v, trajectory.accelerations)
    kinds = ("output", "output rate", "output dynamics")
    outputs, changes, answers = ([f"{domain.name} {kind} {name}" for name in coordinates] for kind in kinds)
    least = sizes(domain.gait.robot)
    robot = domain.gait.robot
    places = [robot.coordinate_index(name) for name in coordinates]
    rates = size_of(trajectory.velocities, least.rates)[places]
    accelerations = size_of(trajectory.accelerations, least.accelerations)[places]
    return [
        *residuals("output", outputs, value, times, tolerance, least.positions[places]),
        *residuals("output", changes, rate, times, tolerance, rates),
        *residuals("output", answers, dynamics, trajectory.times, tolerance, accelerations),
    ]


def _law(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """Rows of the allocation law of the recorded torques, with orthonormal internal forces."""
    gait, trajectory, nodes = domain.gait, domain.trajectory, domain.nodes
    at = terms(domain.contacts, domain.positions[nodes], domain.velocities[nodes])
    values = law_residuals(at, trajectory.torques, trajectory.forces, gait.law)
    names = [f"{domain.name} law {gait.law.name} {row}" for row in range(values.shape[1])]
    scale = size_of(gait.robot.torque_arms * trajectory.torques, sizes(gait.robot).torque)
    return residuals("law", names, values, trajectory.times, tolerance, scale)
