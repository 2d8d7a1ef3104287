"""The certificate of a gait: its closed loop's own orbit, stable and sound in every contact."""

from __future__ import annotations

import hashlib
from dataclasses import replace

from amble.errors import CertificateError, Row, WorkError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import gait_tree
from amble.gait.tree import dumps
from amble.hybrid import HybridSystem
from amble.metrics import ContactBounds, contact_report
from amble.simulation import Trace, simulate
from amble.stability import Certificate, Spectrum, certify, multipliers, section_distances
from amble.stability.certificate import Progress, row_tree
from amble.stability.own_orbit import own_fixed_point
from amble.types import Json, Vector

FORMAT = "amble certificate"

CONTENT = ("robot", "pattern", "outputs", "law", "speed", "gains", "limits", "domains", "feedback")
"""Parts of a gait that its certificate depends on."""

TOLERANCE = 1e-10
"""Of the integrator, for the cycle on which contacts are looked at."""


def certify_gait(gait: Gait, progress: Progress | None = None) -> Certificate:
    """Certify the full cycle of a gait's closed loop; everything is computed again from the gait.

    Args:
        gait: the gait.
        progress: called with what is being computed, in words.

    Raises:
        CertificateError: a condition of ``stability.certify`` fails, or a contact is violated on the orbit.
        FallError: the motion does not come back.
        NotSolvedError: the closed loop has no fixed point near the gait.
    """
    tell = progress or (lambda _: None)
    tell("closed loop")
    system = closed_loop(gait)
    found = own_fixed_point(gait, lambda step, residual: tell(f"fixed point, step {step}, residual {residual:.1e}"))[1]
    return certify(system, found.state, contact_conditions(gait, system, found.state), progress=progress)


def initial_spectrum(gait: Gait) -> Spectrum:
    """Return the multipliers of the full cycle under the outputs of the gait problem, feedback left out."""
    bare = replace(gait, feedback=None)
    _, found = own_fixed_point(bare)
    return multipliers(closed_loop(bare), found.state)


def distances(gait: Gait, trace: Trace, certificate: Certificate) -> Vector:
    """Return the distance to the certified fixed point at the entry of every simulated cycle, (cycles + 1,)."""
    return section_distances(closed_loop(gait), trace.section, certificate.state)


def contact_conditions(gait: Gait, system: HybridSystem, state: Vector) -> tuple[Row, ...]:
    """Return what must hold in every contact of the cycle from a state: normal forces, friction, heights, drift, rank.

    Limits of joints are not conditions of the model's validity; the report shows them.
    """
    bounds = replace(ContactBounds.of_limits(gait.limits), torques={}, speeds={})
    trace = simulate(system, state, 1, TOLERANCE)
    return tuple(worst.row for worst in contact_report(trace, gait.pattern, bounds).rows)


def certificate_tree(gait: Gait, certificate: Certificate) -> Json:
    """Return a certificate with the gait that it belongs to as a tree for a JSON file."""
    return {"format": FORMAT, "certified": True, "gait": identity(gait), **certificate.to_json()}


def refusal_tree(gait: Gait, error: WorkError) -> Json:
    """Return why a gait has no certificate as a tree for a JSON file: the reason and the rows, if it came to rows."""
    rows = error.rows if isinstance(error, CertificateError) else ()
    return {
        "format": FORMAT,
        "certified": False,
        "gait": identity(gait),
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
