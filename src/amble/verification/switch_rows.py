"""Residuals and limits of the switch that ends a domain: guard, touchdown, impact, periodicity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from amble.errors import WorkError
from amble.gait.limits import highest_landing
from amble.gait.record import Gait
from amble.hybrid.contact import AXES
from amble.hybrid.landing import steps
from amble.residual import Residual
from amble.robot.turn import turned
from amble.types import Matrix, Vector
from amble.verification.domain_rows import SampledDomain
from amble.verification.residuals import limit, of_contacts, residuals, size_of, sizes
from amble.verification.stance_model import Terms, terms

NO_TIME = np.array([np.nan])


def switch_residuals(gait: Gait, domain: SampledDomain, following: SampledDomain, tolerance: float) -> list[Residual]:
    """Return the rows of one switch; behind the last solved domain follows the (mirrored) first one."""
    last = domain.name == gait.pattern.solved[-1].name
    q, v = following.positions[0], following.velocities[0]
    if last and not gait.command.straight:
        v = turned(q[None], v[None], gait.turn)[1][0]
    if last and gait.pattern.mirrored:
        q, v = gait.robot.mirror.position(q), gait.robot.mirror.position(v)
    found = [*_guard(domain, tolerance), *_lift_off(gait, domain, following, last), *_reset(domain, v, tolerance)]
    found += [*_orders(domain), *_alone(domain, following, last)]
    return found + (_period(gait, domain, q, tolerance) if last else _continuity(domain, q, tolerance))


def _guard(domain: SampledDomain, tolerance: float) -> list[Residual]:
    """The guard is zero at the end and not before; a landing foot comes down within its velocity bounds."""
    at, times, switch = domain.terms, domain.times, domain.switch
    limits, end, least = domain.gait.limits, domain.times[-1:], sizes(domain.gait.robot)
    found: list[Residual] = []
    for foot in switch.landing:
        height, velocity = at.gap(foot), at.local_velocity(foot)[-1:]
        touchdown = [f"{switch.name} touchdown height {foot}"]
        found += residuals("guard", touchdown, height[-1:, None], end, tolerance, least.length)
        inside = slice(1, -1)
        found.append(
            limit("guard", f"{switch.name} height before touchdown {foot}", height[inside], times[inside],
                  (0.0, np.inf), tolerance * least.length)
        )  # fmt: skip
        *tangents, (lower, upper) = limits.touchdown_velocity
        for axis, bounds in enumerate((*tangents, (lower, min(upper, highest_landing(domain.gait.robot))))):
            name = f"{switch.name} touchdown velocity {foot} {AXES[axis]}"
            found.append(limit("touchdown", name, velocity[:, axis], end, bounds, tolerance * least.velocity))
    least_forces = of_contacts(domain.contacts, least.force, least.torque)
    for foot in switch.leaving:
        force = domain.contacts.contact.normal_force(at.local_force(foot, domain.motion.forces))[-1:]
        missed, scale = force - limits.normal_force, size_of(domain.trajectory.forces, least_forces)[0]
        found += residuals("guard", [f"{switch.name} lift-off force {foot}"], missed, end, tolerance, scale)
    return found


def _lift_off(gait: Gait, domain: SampledDomain, following: SampledDomain, last: bool) -> list[Residual]:
    """Feet that leave by their force accelerate away from the ground at the entry of the next domain."""
    found = []
    for foot in domain.switch.leaving:
        twin = gait.robot.mirror.feet[foot] if last and gait.pattern.mirrored else foot
        alone = replace(following.contacts, feet=(twin,))
        at = terms(alone, following.positions[:1], following.velocities[:1])
        acceleration = at.jacobian[0] @ following.trajectory.accelerations[0] + at.contact_bias[0]
        along = alone.contact.local(acceleration, alone.ground.frame(at.positions[0, at.foot(twin)]))
        name = f"{domain.switch.name} acceleration upwards just after lift-off {foot}"
        rise = np.array([alone.contact.normal_force(along) / gait.robot.gravity])
        found.append(limit("lift-off", name, rise, NO_TIME, (0.0, np.inf), 0.0))
    return found


def _reset(domain: SampledDomain, after: Vector, tolerance: float) -> list[Residual]:
    """Plastic impact: D (v+ - v-) = J^T iota, J v+ = 0; both the recorded impulse and one solved for here."""
    gait, switch, trajectory = domain.gait, domain.switch, domain.trajectory
    names, before, least = gait.robot.coordinate_names, domain.velocities[-1], sizes(gait.robot)
    rates = size_of(trajectory.velocities, least.rates)
    if not switch.landing:
        rows = [f"{switch.name} continuity rate of {name}" for name in names]
        return residuals("impact", rows, (after - before)[None], NO_TIME, tolerance, rates)
    at = terms(gait.pattern.contacts(switch.target), domain.positions[-1:], domain.velocities[-1:])
    velocity, impulse = plastic(at)
    momentum = at.mass[0] @ (after - before)
    balance = momentum - at.jacobian[0].T @ trajectory.impulse
    stopped = at.jacobian[0] @ after
    feet, contacts = list(at.contacts.labels), at.contacts
    impulses = of_contacts(contacts, least.impulse, least.impulse * least.length)
    kinds: list[tuple[str, list[str], Matrix, Vector]] = [
        ("momentum", list(names), balance, size_of(momentum, least.loads * least.impulse / least.force)),
        ("rate of", list(names), after - velocity, rates),
        ("stops foot", feet, stopped, of_contacts(contacts, rates[0], rates[-1])),
        ("impulse", feet, trajectory.impulse - impulse, size_of(impulse, impulses)),
    ]
    found: list[Residual] = []
    for kind, labels, values, scale in kinds:
        rows = [f"{switch.name} impact {kind} {label}" for label in labels]
        found += residuals("impact", rows, np.asarray(values)[None], NO_TIME, tolerance, scale)
    return found


def _orders(domain: SampledDomain) -> list[Residual]:
    """What every order of landing needs after each of its impacts; nothing where feet do not land one by one.

    The feet on the ground push, those that were released go up, and those that have still to land go on down.
    """
    gait, switch = domain.gait, domain.switch
    chain = steps(switch, gait.pattern.landing_rule, gait.robot.foot_names)
    found: list[Residual] = []
    for stance in dict.fromkeys(step.target for step in chain) if len(chain) > 1 else ():
        at = terms(gait.pattern.contacts(stance), domain.positions[-1:], domain.velocities[-1:])
        velocity, impulse = plastic(at)
        after = terms(at.contacts, domain.positions[-1:], velocity[None])
        where = f"{switch.name} with {', '.join(f for f in stance.feet if f in switch.landing)} landed"
        for foot in (*stance.feet, *switch.lifting, *(f for f in switch.landing if f not in stance.feet)):
            if foot in stance.feet:
                name, value = "impulse", at.contacts.contact.normal_force(at.local_force(foot, impulse[None]))
            else:
                name, value = "velocity upwards", after.local_velocity(foot)[:, 2]
            bounds = (-np.inf, 0.0) if foot in switch.landing and name != "impulse" else (0.0, np.inf)
            found.append(limit("landing order", f"{where}, {name} {foot}", value, NO_TIME, bounds, 0.0))
    return found


def _alone(domain: SampledDomain, following: SampledDomain, last: bool) -> list[Residual]:
    """Feet that stand between two landings push, within their friction cones, where all land at once."""
    gait, switch, robot = domain.gait, domain.switch, domain.gait.robot
    chain = steps(switch, gait.pattern.landing_rule, robot.foot_names)
    u = following.trajectory.torques[0]
    if last and gait.pattern.mirrored:
        u = robot.mirror.torque(u)
    found: list[Residual] = []
    for stance in dict.fromkeys(step.source for step in chain if step.source != switch.source):
        contacts, q = gait.pattern.contacts(stance), domain.positions[-1:]
        velocity = plastic(terms(contacts, q, domain.velocities[-1:]))[0]
        at = terms(contacts, q, velocity[None])
        forces = _landing_forces(at, [foot for foot in switch.landing if foot not in stance.feet], u)
        where = f"{switch.name} with {', '.join(f for f in stance.feet if f in switch.landing)} landed"
        for foot in stance.feet:
            local = at.local_force(foot, forces[None])
            normal, used = contacts.contact.normal_force(local), contacts.contact.friction_used(local)
            bounds = (gait.limits.normal_force, np.inf)
            found.append(limit("landing force", f"{where}, normal force {foot}", normal, NO_TIME, bounds, 0.0))
            bounds = (0.0, gait.pattern.ground.friction)
            found.append(limit("landing force", f"{where}, friction {foot}", used, NO_TIME, bounds, 0.0))
    return found


def _landing_forces(at: Terms, late: Sequence[str], u: Vector) -> Vector:
    """Contact forces where the legs of late feet keep their joints' rates and all other joints have torques u.

    Of the dense system [D -J^T -S^T; J 0 0; S 0 0] (a, lambda, u_S) = (B u - h, -Jdot v, 0), S the late legs' joints.
    """
    robot, D, J = at.contacts.robot, at.mass[0], at.jacobian[0]
    standing = {joint for foot in at.contacts.feet for joint in robot.legs[foot]}
    hanging = {joint for foot in late for joint in robot.legs[foot]} - standing
    S = np.array([[float(name == joint) for name in robot.coordinate_names] for joint in sorted(hanging)])
    S = S.reshape(len(hanging), len(D))
    held = np.vstack([J, S])
    system = np.block([[D, -held.T], [held, np.zeros((len(held), len(held)))]])
    load = np.concatenate([np.zeros(len(D) - len(u)), u]) - at.bias[0]
    solved = np.linalg.solve(system, np.concatenate([load, -at.contact_bias[0], np.zeros(len(S))]))
    return solved[len(D) : len(D) + len(J)]


def plastic(at: Terms) -> tuple[Vector, Vector]:
    """Velocities after the impact and the impulse, of the dense system [D -J^T; J 0].

    Raises:
        WorkError: the system is singular: no impulse stops the feet.
    """
    D, J, v = at.mass[0], at.jacobian[0], at.velocities[0]
    n, c = len(D), len(J)
    system = np.block([[D, -J.T], [J, np.zeros((c, c))]])
    try:
        solution = np.linalg.solve(system, np.concatenate([D @ v, np.zeros(c)]))
    except np.linalg.LinAlgError:
        raise WorkError(f"no impulse stops the feet {', '.join(at.contacts.feet)} at the end of the motion") from None
    return solution[:n], solution[n:]


def _continuity(domain: SampledDomain, after: Vector, tolerance: float) -> list[Residual]:
    rows = [f"{domain.switch.name} continuity {name}" for name in domain.gait.robot.coordinate_names]
    scale = sizes(domain.gait.robot).positions
    return residuals("continuity", rows, (after - domain.positions[-1])[None], NO_TIME, tolerance, scale)


def _period(gait: Gait, domain: SampledDomain, start: Vector, tolerance: float) -> list[Residual]:
    """The solved domains end where they began, further along the ground: over x by speed times duration."""
    duration, least = sum(part.duration for part in gait.domains), sizes(gait.robot)
    rows = [f"{domain.switch.name} periodicity {name}" for name in gait.robot.coordinate_names[1:]]
    axes = list(gait.robot.base.axes)
    if not gait.command.ahead:
        x, y, angle = gait.command.way(duration)
        away = start[None] - np.array([*start[:3], *np.zeros(start.size - 3)])
        expected = turned(away, np.zeros_like(away), angle)[0][0]
        expected[:3] = start[:3]
        for axis, way in zip("xy", (x, y), strict=True):
            expected[:3] += way * gait.pattern.ground.translations[axis]
        missed = domain.positions[-1] - expected
        names = [f"{domain.switch.name} periodicity x", *rows]
        return residuals("periodicity", names, missed[None], NO_TIME, tolerance, least.positions)
    advance = domain.positions[-1] - start
    distance = advance[0]
    advance[: len(axes)] -= distance * gait.pattern.ground.translations["x"][axes]
    speed = np.array([distance / duration - gait.speed])
    return [
        *residuals("periodicity", rows, advance[None, 1:], NO_TIME, tolerance, least.positions[1:]),
        *residuals("periodicity", ["mean speed less the speed asked for"], speed, NO_TIME, tolerance, least.velocity),
    ]
