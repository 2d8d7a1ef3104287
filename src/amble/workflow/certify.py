"""Certification with the file that says how it ended."""

from __future__ import annotations

from pathlib import Path

from amble.control import AllocationLaw
from amble.errors import WorkError
from amble.gait import Gait
from amble.progress import Progress, ProgressReport, silent
from amble.report import write_results
from amble.stability import Certificate, certify
from amble.stability.gait_certificate import certificate_to_dict, refusal_to_dict


def certify_into(
    gait: Gait,
    out: Path | None,
    *,
    allow_absurd_limits: bool = False,
    law: AllocationLaw | None = None,
    progress: Progress | None = None,
) -> Certificate:
    """Certify a gait and write the certificate; errors as in ``amble.certify``.

    A refusal is written too, in the same place: an older certificate would look as if it belonged to this gait.

    Args:
        gait: the gait.
        out: the file; None writes nothing.
        allow_absurd_limits: see ``amble.certify``.
        law: see ``amble.certify``.
        progress: called with what is being computed, and with the file that was written.
    """
    notify = progress or silent
    try:
        certificate = certify(gait, allow_absurd_limits=allow_absurd_limits, law=law, progress=notify)
    except WorkError as error:
        if out is not None:
            notify(ProgressReport(what="wrote", file=write_results(out, refusal_to_dict(gait, error, law))))
        raise
    if out is not None:
        notify(ProgressReport(what="wrote", file=write_results(out, certificate_to_dict(gait, certificate, law))))
    return certificate
