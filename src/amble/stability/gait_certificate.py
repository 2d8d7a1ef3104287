"""The certificate of a gait: its closed loop's own orbit, stable and sound in every contact."""

from __future__ import annotations

import hashlib
from dataclasses import replace

from amble.errors import CertificateError, Row, WorkError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import gait_tree
from amble.gait.limits import sensible_rows
from amble.io.codec import dumps
from amble.robot.physical import physical_rows
from amble.simulation import Trace
from amble.stability import Certificate, Spectrum, certify, multipliers, section_distances
from amble.stability.certificate import Progress, finite, row_tree
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.disturbance import disturb
from amble.stability.orbit_conditions import GROUND, LANDING, RECORD, orbit_conditions, velocity_unit
from amble.types import Json, Vector
from amble.verification.check import record_findings

FORMAT = "amble certificate"

CONTENT = ("robot", "pattern", "outputs", "law", "speed", "gains", "limits", "domains", "feedback")
"""Parts of a gait that its certificate depends on."""


def certify_gait(gait: Gait, progress: Progress | None = None, allow_absurd_limits: bool = False) -> Certificate:
    """Certify the full cycle of a gait's closed loop; everything is computed again from the gait.

    Before the closed loop: the robot can be built, the limits are sensible, the record is a motion of that robot under
    the outputs of the gait problem. On the closed loop's own orbit: it is the recorded one, its feet meet the ground.
    A certified gait is disturbed (``disturbance``); what that shows is told, and refuses nothing.

    Args:
        gait: the gait.
        progress: called with what is being computed, in words.
        allow_absurd_limits: certify against limits and gravity that nobody would mean (``gait.limits.sensible_rows``).

    Raises:
        CertificateError: a condition of ``stability.certify`` or one of the above fails.
        FallError: the motion does not come back.
        NotSolvedError: the closed loop has no fixed point near the gait.
        WorkError: the outputs lose their rank along the recorded motion.
    """
    tell = progress or (lambda _: None)
    tell("robot, limits and recorded motion")
    sensible = () if allow_absurd_limits else _sensible(gait)
    conditions = _sound((*physical_rows(gait.robot, gait.pattern.mirrored), *sensible))
    conditions += _recorded(gait, conditions)
    tell("closed loop")
    system = closed_loop(gait)
    found = closed_loop_fixed_point(
        gait, lambda step, residual: tell(f"fixed point, step {step}, residual {residual:.1e}")
    )[1]
    conditions = _sound((*conditions, *orbit_conditions(gait, system, found.state)))
    certificate = certify(system, found.state, conditions, progress=progress)
    return replace(certificate, disturbance=disturb(gait, system, found.state, certificate.spectrum, progress))


def _sound(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """Return rows that hold; what comes after them is computed only then."""
    if any(row.violation > 0.0 for row in rows):
        raise CertificateError(rows)
    return rows


def _sensible(gait: Gait) -> tuple[Row, ...]:
    robot = gait.robot
    return sensible_rows(gait.limits, robot.gravity, robot.mass, robot.leg_length)


def _recorded(gait: Gait, before: tuple[Row, ...]) -> tuple[Row, ...]:
    """Return the worst row of every family of the record; where any row fails, raise with all of them."""
    report = record_findings(gait, RECORD)
    if not report.passed:
        rows = (replace(finding.row, lower=finding.row.lower - finding.slack) for finding in report.findings)
        raise CertificateError((*before, *rows))
    worst = report.worst.items()
    return tuple(
        replace(found.row, name=f"record, {family}: {found.row.name}", lower=found.row.lower - found.slack)
        for family, found in worst
    )


def held_against(gait: Gait) -> Json:
    """Return the bounds that a certificate of the gait rests on, with their units, and which of them are absurd.

    Torques are not conditions of the certificate; their limits are there because a reader takes them for kept.
    """
    limits, robot = gait.limits, gait.robot
    return {
        "friction": limits.friction,
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
    together = [switch.name for switch in gait.pattern.all_switches if len(switch.landing) > 1]
    orders = f"the feet of one switch landing at different times ({', '.join(together)})"
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
    bare = replace(gait, feedback=None)
    _, found = closed_loop_fixed_point(bare)
    return multipliers(closed_loop(bare), found.state)


def distances(gait: Gait, trace: Trace, certificate: Certificate) -> Vector:
    """Return the distance to the certified fixed point at the entry of every simulated cycle, (cycles + 1,)."""
    return section_distances(closed_loop(gait), trace.section, certificate.state)


def certificate_tree(gait: Gait, certificate: Certificate) -> Json:
    """Return a certificate with the gait that it belongs to as a tree for a JSON file."""
    return {
        "format": FORMAT,
        "certified": True,
        "gait": identity(gait),
        "held_against": held_against(gait),
        "does_not_say": list(does_not_say(gait)),
        **certificate.to_json(),
    }


def refusal_tree(gait: Gait, error: WorkError) -> Json:
    """Return why a gait has no certificate as a tree for a JSON file: the reason and the rows, if it came to rows."""
    rows = error.rows if isinstance(error, CertificateError) else ()
    return {
        "format": FORMAT,
        "certified": False,
        "gait": identity(gait),
        "held_against": held_against(gait),
        "does_not_say": list(does_not_say(gait)),
        "refused_because": str(error).splitlines(),
        "conditions": [row_tree(row) for row in rows],
    }


def identity(gait: Gait) -> Json:
    """Return which gait it is: the hash of its content, and the names that a reader knows it by; m/s."""
    tree = gait_tree(gait)
    return {
        "content_hash": _hash(tree),
        "name": gait.pattern.name,
        "robot": gait.robot.name,
        "robot_hash": gait.robot.hash,
        "law": tree["law"],
        "speed_m_s": gait.speed,
    }


def content_hash(gait: Gait) -> str:
    """Return the SHA-256 of what determines the closed loop and what it is held against; not of how it was found."""
    return _hash(gait_tree(gait))


def _hash(tree: Json) -> str:
    return hashlib.sha256(dumps({part: tree[part] for part in CONTENT}).encode()).hexdigest()
