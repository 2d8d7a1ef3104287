"""What the index of a library says of a gait: cost, torques, contacts, how it was found, how stable it is."""

from __future__ import annotations

import numpy as np

from amble.analysis import AllocationLimits, actuators_for, samples_of_gait, torque_metrics
from amble.analysis.limit_use import limit_use
from amble.analysis.reallocation import Allocated
from amble.gait import Gait
from amble.report.results import finite_or_none
from amble.stability import Certificate
from amble.stability.stabilize import Stabilized
from amble.types import Json


def gait_numbers(gait: Gait) -> Json:
    """Return the numbers of a motion: per actuator model its cost of transport, torques, base height, contacts."""
    samples = samples_of_gait(gait)
    motion = samples.motion({"own": samples.torques})
    energy = {model.name: torque_metrics(motion, "own", model) for model in actuators_for(gait)}
    torques = next(iter(energy.values()))
    use = limit_use(samples, Allocated(samples.torques, samples.forces), AllocationLimits.of(gait))
    height = samples.positions[:, gait.robot.coordinate_index("z")]
    spent = np.trapezoid(height, samples.times) / (samples.times[-1] - samples.times[0])
    return {
        **{f"cost_of_transport_{name}": finite_or_none(entry.cot) for name, entry in energy.items()},
        "objective": gait.solver.objective,
        "peak_torque_N_m": torques.peak_torque,
        "rms_torque_N_m": torques.rms_torque,
        "period_s": gait.period,
        "distance_m": samples.distance,
        "mean_height_m": float(spent),
        "least_height_m": float(height.min()),
        "largest_height_m": float(height.max()),
        "friction_used": finite_or_none(use.friction_used),
        "least_normal_force_N": use.min_normal_force,
        "iterations": gait.solver.iterations,
        "nodes": sum(len(domain.times) for domain in gait.domains),
        "violation": gait.solver.violation,
        "linear_solver": gait.solver.linear_solver,
    }


def stabilisation_numbers(found: Stabilized) -> Json:
    """Return the numbers of a stabilisation; radii are of a whole gait cycle."""
    return {
        "radius_at_start": found.initial,
        "stabilised_radius": found.radius,
        "stabilised_bound": found.bound,
        "descents": len(found.steps) - 1,
        "free_weights": found.parameters,
    }


def certificate_numbers(certificate: Certificate) -> Json:
    """Return the numbers of a certificate."""
    disturbance = certificate.disturbance
    return {
        "radius": certificate.radius,
        "radius_error": certificate.error,
        "contraction_bound": None if certificate.bound is None else certificate.bound.rate,
        "returns_from": None if disturbance is None else disturbance.returns,
        "growth": None if disturbance is None else disturbance.growth.factor,
        "warnings": len(certificate.warnings),
    }
