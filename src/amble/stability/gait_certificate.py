"""The certificate of a gait: its closed loop's own orbit, stable and sound in every contact."""

from __future__ import annotations

from dataclasses import replace

from amble.control import AllocationLaw
from amble.errors import CertificateError, WorkError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import content_hash, to_dict
from amble.gait.limits import sensible_rows
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport, silent
from amble.residual import Residual
from amble.robot.natural_units import velocity_unit
from amble.robot.plausibility import physical_rows
from amble.simulation import Trace
from amble.simulation.world_axes import in_cycle_axes
from amble.stability.certificate import Certificate, finite, row_to_dict
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.contraction import section_distances
from amble.stability.orbit_conditions import GROUND, LANDING, RECORD, orbit_conditions
from amble.stability.spectrum import Spectrum, multipliers
from amble.types import Json, Vector
from amble.verification.check import check_record

FORMAT, FORMAT_VERSION = "amble certificate", 1


def certified_orbit(
    gait: Gait, allow_absurd_limits: bool = False, progress: Progress | None = None, law: AllocationLaw | None = None
) -> tuple[HybridSystem, Vector, tuple[Residual, ...]]:
    """Return a gait's closed loop, its fixed point and the conditions that hold on that orbit; the rest is stability.

    Before the closed loop: the robot can be built, the limits are sensible, the record is a motion of that robot under
    the outputs of the gait problem. On the closed loop's own orbit: it is the recorded one, its feet meet the ground.

    Args:
        gait: the gait.
        allow_absurd_limits: do not hold limits and gravity against ``gait.limits.sensible_rows``.
        progress: called with what is being computed.
        law: the allocation law of the closed loop, where it is not the gait's.

    Raises:
        CertificateError: one of the conditions fails.
        FallError: the motion does not come back.
        NotSolvedError: the closed loop has no fixed point near the gait.
        WorkError: the outputs lose their rank along the recorded motion.
    """
    notify = progress or silent
    notify(ProgressReport(what="robot, limits and recorded motion"))
    sensible = () if allow_absurd_limits else _sensible(gait)
    conditions = _sound((*physical_rows(gait.robot, gait.pattern.mirrored), *sensible))
    conditions += _recorded(gait, conditions)
    notify(ProgressReport(what="closed loop"))
    system = closed_loop(gait, law)
    found = closed_loop_fixed_point(gait, notify, law)[1]
    orbit = orbit_conditions(gait, system, found.state)
    return system, found.state, _sound((*conditions, *orbit))


def _sound(rows: tuple[Residual, ...]) -> tuple[Residual, ...]:
    """Return rows that hold; what comes after them is computed only then."""
    if not all(row.passed for row in rows):
        raise CertificateError(rows)
    return rows


def _sensible(gait: Gait) -> tuple[Residual, ...]:
    return sensible_rows(gait.limits, gait.pattern.ground.friction, gait.robot)


def _recorded(gait: Gait, before: tuple[Residual, ...]) -> tuple[Residual, ...]:
    """Return the worst row of every kind of the record; where any row fails, raise with all of them."""
    report = check_record(gait, RECORD)
    if not report.passed:
        raise CertificateError((*before, *(row.widened() for row in report.rows)))
    return tuple(
        replace(row.widened(), name=f"record, {kind}: {row.name}", kind="") for kind, row in report.worst.items()
    )


def held_against(gait: Gait) -> Json:
    """Return the bounds that a certificate of the gait rests on, with their units, and which of them are absurd.

    Torques are not conditions of the certificate; their limits are there because a reader takes them for kept.
    """
    limits, robot = gait.limits, gait.robot
    return {
        "friction": gait.pattern.ground.friction,
        "normal_force_N": 0.0,
        "gravity_m_s2": robot.gravity,
        "ground_m": GROUND * robot.leg_length,
        "touchdown_velocity_m_s": -LANDING * velocity_unit(robot),
        "speed_m_s": [gait.speed - RECORD * velocity_unit(robot), gait.speed + RECORD * velocity_unit(robot)],
        "record_relative": RECORD,
        "torque_limits_N_m": {joint: finite(value) for joint, value in limits.torques.items()},
        "absurd": [row.name.removeprefix("sensible ") for row in _sensible(gait) if row.violation > 0.0],
    }


def does_not_say(gait: Gait) -> tuple[str, ...]:
    """Return what a reader may not take from a certificate of the gait."""
    torques = gait.limits.torques.values()
    range_of = f"{min(torques):g} to {max(torques):g} N m" if torques else "none"
    together = [step.name for step in gait.pattern.steps if len(step.landing) > 1]
    orders = f"the feet of one switch landing at different times ({', '.join(together)}); exported code awaits the last"
    return (
        f"torque limits ({range_of}) or limits of speeds and positions, which `amble check` and `amble simulate` see",
        "disturbances larger than those walked, or others: a few starts are no proof of a basin",
        *([orders] if together else []),
        "uneven ground, less friction, another mass, noise, delay, sampling",
        "a proven error: the error bar of the radius is an estimate",
    )


def bounds_sentences(gait: Gait) -> tuple[str, str]:
    """Say in one sentence what a gait is held against, absurd bounds marked, and in one what that leaves open."""
    held = held_against(gait)
    absurd = f"; ABSURD: {', '.join(held['absurd'])}" if held["absurd"] else ""
    low, high = held["speed_m_s"]
    return (
        f"held against: friction {held['friction']:g}, normal forces above 0, gravity {held['gravity_m_s2']:g} m/s^2, "
        f"feet on the ground within {1e3 * held['ground_m']:.2g} mm, landing feet coming down faster than "
        f"{-1e3 * held['touchdown_velocity_m_s']:.2g} mm/s, speed {low:.4g} to {high:.4g} m/s, the recorded motion "
        f"within {RECORD:g} of its size{absurd}",
        f"it does not say: {'; '.join(does_not_say(gait))}",
    )


def initial_spectrum(gait: Gait) -> Spectrum:
    """Return the multipliers of the full cycle under the outputs of the gait problem, feedback left out."""
    bare = replace(gait, feedback=None, control=None)
    _, found = closed_loop_fixed_point(bare, one_order=True)
    return multipliers(closed_loop(bare), found.state)


def distances(gait: Gait, trace: Trace, certificate: Certificate) -> Vector:
    """Return the distance to the certified fixed point at the entry of every simulated cycle, (cycles + 1,)."""
    return section_distances(closed_loop(gait), in_cycle_axes(gait, trace.section), certificate.state)


def certificate_to_dict(gait: Gait, certificate: Certificate, law: AllocationLaw | None = None) -> Json:
    """Return a certificate with the gait and the allocation law that it belongs to as a tree for a JSON file."""
    return {**_header(True, gait, law), **certificate.to_dict()}


def refusal_to_dict(gait: Gait, error: WorkError, law: AllocationLaw | None = None) -> Json:
    """Return why a gait has no certificate as a tree for a JSON file: the reason and the rows, if it came to rows."""
    rows = error.rows if isinstance(error, CertificateError) else ()
    return {
        **_header(False, gait, law),
        "refused_because": str(error).splitlines(),
        "conditions": [row_to_dict(row) for row in rows],
    }


def identity(gait: Gait) -> Json:
    """Return which gait it is: the hash of its content, and the names that a reader knows it by; m/s."""
    return {
        "content_hash": content_hash(gait),
        "name": gait.pattern.name,
        "robot": gait.robot.name,
        "robot_hash": gait.robot.hash,
        "allocation_law": to_dict(gait)["allocation_law"],
        **({} if gait.control is None else {"control_law": to_dict(gait)["control_law"]}),
        "speed_m_s": gait.speed,
    }


def _header(certified: bool, gait: Gait, law: AllocationLaw | None) -> Json:
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "certified": certified,
        "gait": identity(gait),
        **({} if law is None else {"under_allocation_law": law.name}),
        "held_against": held_against(gait),
        "does_not_say": list(does_not_say(gait)),
    }
