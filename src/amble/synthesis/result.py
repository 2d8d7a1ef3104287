"""From the solver's variables to the gait record, and back as a starting point."""

from __future__ import annotations

from importlib import metadata

import numpy as np
from numpy.typing import NDArray

from amble.errors import InputError
from amble.gait import DomainTrajectory, Gait
from amble.synthesis.initial_guess import phase_curves
from amble.synthesis.landing_rows import fill_landings
from amble.synthesis.layout import DomainLayout, Layout, resampled
from amble.synthesis.problem import GaitProblem
from amble.synthesis.solve import Solution
from amble.types import frozen
from amble.version import __version__

RECORDED = ("casadi", "numpy")
"""Packages whose versions go into the gait, beside amble's own."""


def to_gait(problem: GaitProblem, layout: Layout, solution: Solution) -> Gait:
    """Read a gait out of the solver's variables."""
    natural = solution.variables * layout.scale
    return Gait(
        pattern=problem.pattern,
        outputs=problem.outputs,
        law=problem.law,
        speed=problem.speed,
        lateral_speed=problem.lateral_speed,
        yaw_rate=problem.yaw_rate,
        gains=problem.gains,
        limits=problem.limits,
        domains=tuple(_trajectory(problem, domain, natural) for domain in layout.domains),
        solver=solution.report,
        feedback=None,
        versions={"amble": __version__, **{name: metadata.version(name) for name in RECORDED}},
        multipliers=solution.multipliers,
        cost=problem.cost,
    )


def from_gait(problem: GaitProblem, gait: Gait, layout: Layout) -> NDArray[np.float64]:
    """Return unscaled start variables that follow a gait of the same structure, on this layout's nodes, (n_x,).

    The phase and the controlled coordinates may be others: the curves are then fitted again.

    Raises:
        InputError: the gait has other stances, joints or output curves, or the phase does not grow along its motion.
    """
    expected = [(d.stance, d.coefficients.size, d.q.shape[1], d.impulse.size) for d in layout.domains]
    given = [
        (gait.pattern.stance(d.name), d.coefficients.size, d.positions.shape[1], d.impulse.size) for d in gait.domains
    ]
    if expected != given:
        raise InputError("the gait to start from has other stances, joints or output curves than the problem")
    start = np.zeros(layout.size)
    for domain, known in zip(layout.domains, gait.domains, strict=True):
        phases = known.times / known.duration
        start[domain.duration] = known.duration
        start[domain.impulse] = known.impulse
        kinds = {
            "q": known.positions,
            "v": known.velocities,
            "a": known.accelerations,
            "u": known.torques,
            "force": known.forces,
        }
        for kind, samples in kinds.items():
            start[getattr(domain, kind)] = resampled(samples, phases, domain.phases)
        if gait.outputs == problem.outputs:
            numbers, curves = known.phase_numbers, known.coefficients
        else:
            numbers, curves = phase_curves(problem, domain, known.duration, start[domain.q], start[domain.v])
        start[domain.phase_numbers], start[domain.coefficients] = numbers, curves.ravel(order="F")
    start[layout.period] = sum(known.duration for known in gait.domains)
    fill_landings(problem, layout, start)
    return start


def _trajectory(problem: GaitProblem, domain: DomainLayout, natural: NDArray[np.float64]) -> DomainTrajectory:
    duration = float(natural[domain.duration][0])
    outputs = len(problem.outputs.of(domain.stance.name).coordinates)
    coefficients = natural[domain.coefficients].reshape((outputs, problem.outputs.order + 1), order="F")
    return DomainTrajectory(
        name=domain.stance.name,
        duration=duration,
        coefficients=frozen(coefficients),
        times=frozen(domain.phases * duration),
        positions=frozen(natural[domain.q]),
        velocities=frozen(natural[domain.v]),
        accelerations=frozen(natural[domain.a]),
        torques=frozen(natural[domain.u]),
        forces=frozen(natural[domain.force]),
        impulse=frozen(natural[domain.impulse]),
        phase_numbers=frozen(natural[domain.phase_numbers]),
        scheme=problem.scheme,
    )
