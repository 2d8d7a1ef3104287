"""Limits along a domain: contact forces, swing feet, positions, speeds, torques, accelerations, duration."""

from __future__ import annotations

import numpy as np

from amble.residual import Residual
from amble.verification.clearance_rows import clearance_residuals
from amble.verification.domain_rows import SampledDomain
from amble.verification.residuals import limit, sizes


def limit_residuals(domain: SampledDomain, tolerance: float, slack: float) -> list[Residual]:
    """Return the limits of a domain.

    Args:
        domain: the domain on its grid.
        tolerance: what the ground may miss, as a share of the leg length, and the bounds of the duration, s.
        slack: what any other limit may miss, as a share of its size: the gait problem imposes it at its nodes only.
    """
    bounds = domain.gait.limits.durations.get(domain.name, (0.0, np.inf))
    duration = np.array([domain.trajectory.duration])
    return [
        limit("duration", f"{domain.name} duration", duration, np.array([np.nan]), bounds, tolerance),
        *_forces(domain, slack),
        *_swing(domain, tolerance, slack),
        *_positions(domain, slack),
        *_rates(domain, slack),
        *clearance_residuals(domain, slack),
    ]


def _forces(domain: SampledDomain, slack: float) -> list[Residual]:
    """Normal force and the true friction cone of every stance foot."""
    contact, friction, times = domain.contacts.contact, domain.contacts.ground.friction, domain.times
    limits, progress = domain.gait.limits, times / domain.trajectory.duration
    size, least, found = sizes(domain.gait.robot).force, limits.normal_force, []
    for foot in domain.stance.feet:
        force = domain.terms.local_force(foot, domain.motion.forces)
        normal, used = contact.normal_force(force), contact.friction_used(force)
        bounds, most = (least, np.inf), (0.0, friction)
        if limits.standing_force is not None:
            over = normal - limits.least_normal_force(foot in domain.switch.leaving, progress)
            name, miss = f"{domain.name} normal force {foot} over its bound", slack * (size + limits.standing_force)
            found.append(limit("normal force", name, over, times, (0.0, np.inf), miss))
        found += [
            limit("normal force", f"{domain.name} normal force {foot}", normal, times, bounds, slack * (size + least)),
            limit("friction", f"{domain.name} friction {foot}", used, times, most, slack * friction),
        ]
    return found


def _swing(domain: SampledDomain, tolerance: float, slack: float) -> list[Residual]:
    """Swing feet: never under the ground, and at the clearance in the middle of their swing."""
    least, times, found = domain.gait.limits.clearance, domain.times, []
    length = sizes(domain.gait.robot).length
    for foot in domain.gait.robot.foot_names:
        if foot in domain.stance.feet:
            continue
        height = domain.terms.gap(foot)
        name = f"{domain.name} height {foot}"
        found.append(limit("penetration", name, height, times, (0.0, np.inf), tolerance * length))
        middle = middle_of_swing(domain, foot)
        if 0.0 <= middle <= 1.0:
            when = np.array([middle * domain.trajectory.duration])
            at_middle = np.interp(when, times, height)
            name = f"{domain.name} clearance {foot}"
            found.append(limit("clearance", name, at_middle, when, (least, np.inf), slack * least))
    return found


def middle_of_swing(domain: SampledDomain, foot: str) -> float:
    """Phase of the domain at which a foot is half through its swing, every domain of the swing counting the same.

    Outside [0, 1] where the middle lies in another domain.
    """
    stances = domain.gait.pattern.stances
    here = next(place for place, stance in enumerate(stances) if stance.name == domain.name)
    around = len(stances)
    before = next((n for n in range(around) if foot in stances[here - n - 1].feet), around)
    after = next((n for n in range(around) if foot in stances[(here + n + 1) % around].feet), around)
    return 0.5 * (before + 1 + after) - before


def _positions(domain: SampledDomain, slack: float) -> list[Residual]:
    robot, ground, found = domain.gait.robot, domain.contacts.ground, []
    for name, bounds in domain.gait.limits.positions.items():
        place = robot.coordinate_index(name)
        values = domain.positions[:, place]
        if name == "z":
            x, y = robot.base.spatial(domain.positions)[:, :2].T
            values = values - ground.height(x, y)
        kept = slack * float(sizes(robot).positions[place])
        found.append(limit("position", f"{domain.name} position {name}", values, domain.times, bounds, kept))
    return found


def _rates(domain: SampledDomain, slack: float) -> list[Residual]:
    """Speeds, torques and accelerations against symmetric limits."""
    robot, limits, times = domain.gait.robot, domain.gait.limits, domain.times
    joints = robot.joint_names
    most = limits.accelerations(robot)
    found = []
    for kind, names, values, largest in (
        ("speed", joints, domain.velocities[:, robot.base.size :], limits.speeds),
        ("torque limit", joints, domain.motion.torques, limits.torques),
        ("acceleration limit", robot.coordinate_names, domain.motion.accelerations, most),
    ):
        for column, name in enumerate(names):
            if name in largest:
                bounds = (-largest[name], largest[name])
                row = f"{domain.name} {kind} {name}"
                found.append(limit(kind, row, values[:, column], times, bounds, slack * largest[name]))
    return found
