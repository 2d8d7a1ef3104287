"""What the stability analysis found, as entries of results.json, and back for the figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amble.errors import InputError
from amble.report.run import Stability
from amble.report.stability_table import stability_table
from amble.report.versions import computing_versions
from amble.stability import Certificate, Spectrum
from amble.stability.stabilize import Stabilized
from amble.types import Json, Vector, frozen

KEYS = (
    "spectral_radius",
    "stabilization",
    "stability_versions",
    "multipliers",
    "contraction",
    "section_error",
    "section_error_perturbed",
    "section_distances",
    "perturbed",
)
"""Entries of results.json that a report without new stability analysis keeps."""


def stability_of(
    before: Spectrum,
    stabilized: Stabilized,
    certificate: Certificate,
    near: Vector,
    apart: Vector,
    perturbed: Json,
) -> Stability:
    """Collect the record.

    Args:
        before: multipliers of the full cycle under the outputs of the gait problem.
        stabilized: what the stabilisation returned.
        certificate: of the stabilised gait, full cycle.
        near: distance to the fixed point at the entry of every cycle simulated from the orbit, (cycles + 1,).
        apart: the same, simulated from a perturbed start.
        perturbed: what ``assembly.perturbed_results`` says of the perturbed start.
    """
    after, mode = certificate.spectrum.multipliers, certificate.mode
    results: Json = {
        "spectral_radius": {
            "initial": float(before.radius),
            "stabilized": float(certificate.radius),
            "error": float(certificate.error),
            "contraction_bound": None if certificate.bound is None else certificate.bound.rate,
        },
        "stabilization": {
            "seconds": stabilized.seconds,
            "steps": len(stabilized.steps) - 1,
            "parameters": stabilized.parameters,
            "bound": stabilized.bound,
            "reason": stabilized.reason,
        },
        "stability_versions": computing_versions(),
        "multipliers": {"initial": _pairs(before.multipliers), "stabilized": _pairs(after)},
        "contraction": None
        if mode is None
        else {"measured": mode.rate, "predicted": mode.predicted, "relative_difference": mode.difference},
        "section_error": float(near[-1]),
        "section_error_perturbed": float(apart[-1]),
        "section_distances": [float(value) for value in apart],
        "perturbed": perturbed,
    }
    return Stability(before.multipliers, after, float(certificate.radius), frozen(apart), results)


def stability_from(results: Mapping[str, Any]) -> Stability | None:
    """Rebuild the record from results.json; None where the run had no stability analysis.

    Raises:
        InputError: the entries are there but not what ``stability_of`` writes.
    """
    entries = {key: results[key] for key in KEYS if key in results}
    if not entries:
        return None
    try:
        before, after = (_complex(entries["multipliers"][which]) for which in ("initial", "stabilized"))
        radius = float(entries["spectral_radius"]["stabilized"])
        stability_table(entries)
        return Stability(before, after, radius, frozen(entries["section_distances"]), entries)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"the stability entries of results.json are not complete: {error}") from None


def _pairs(values: NDArray[np.complex128]) -> list[list[float]]:
    return [[float(value.real), float(value.imag)] for value in values]


def _complex(pairs: list[list[float]]) -> NDArray[np.complex128]:
    return np.array([complex(real, imaginary) for real, imaginary in pairs])
