"""What the stability analysis found, as entries of results.json, and back for the figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amble.analysis import monitors
from amble.gait import Gait
from amble.io.codec import TEXT, ByName, Codec, Count, Optional, Record
from amble.io.quantities import Bare
from amble.report.results import computing_versions, finite_or_none
from amble.report.run import Stability
from amble.simulation import Trace
from amble.stability import Certificate, Spectrum
from amble.stability.stabilize import Stabilized
from amble.types import Json, Matrix, Vector, frozen

NUMBER, PAIRS = Bare(), Bare(None, 2)

PERTURBED = Record(
    dict,
    {
        "size": NUMBER,
        "cycles": Count(),
        "sound_from_cycle": Optional(Count()),
        "before_sound": Optional(Record(dict, {"max_friction": NUMBER, "min_normal_force": NUMBER}, open=True)),
    },
    open=True,
)

CONTRACTION = {"predicted": NUMBER, "measured": NUMBER, "relative_difference": NUMBER}

ENTRIES: Mapping[str, Codec] = {
    "spectral_radius": Record(
        dict, {"initial": NUMBER, "stabilized": NUMBER, "error": NUMBER, "contraction_bound": Optional(NUMBER)}
    ),
    "stabilization": Optional(Record(dict, {}, open=True)),
    "stability_versions": Optional(ByName("library", TEXT)),
    "multipliers": Record(dict, {"initial": PAIRS, "stabilized": PAIRS}),
    "contraction": Optional(Record(dict, CONTRACTION)),
    "section_error": Optional(NUMBER),
    "section_error_perturbed": Optional(NUMBER),
    "section_distances": Bare(None),
    "perturbed": Optional(PERTURBED),
}
"""Entries of results.json that a report without new stability analysis keeps, and what the page needs of them."""


def perturbed_results(gait: Gait, trace: Trace, size: float, seed: int) -> Json:
    """Return what is known of a simulation from a perturbed start; N, 1, m.

    ``before_sound`` is about the cycles before the contacts are sound; None where they are from the start.
    """
    report = monitors(gait, trace)
    until = report.sound_from
    return {
        "size": size,
        "seed": seed,
        "cycles": trace.cycles,
        "ended": trace.ended,
        "sound_from_cycle": until,
        "before_sound": None
        if until == 0
        else {
            "min_normal_force": float(report.normal_forces[:until].min()),
            "max_friction": finite_or_none(float(report.frictions[:until].max())),
        },
        "min_normal_force": report.min_normal_force,
        "max_friction": finite_or_none(report.max_friction),
        "max_penetration": report.max_penetration,
    }


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
        perturbed: what ``perturbed_results`` says of the perturbed start.
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
    entries = {key: results[key] for key in ENTRIES if key in results}
    if not entries:
        return None
    found = Record(dict, ENTRIES).decode(entries, "stability entries of results.json")
    before, after = (_complex(found["multipliers"][which]) for which in ("initial", "stabilized"))
    radius = float(found["spectral_radius"]["stabilized"])
    return Stability(before, after, radius, found["section_distances"], entries)


def _pairs(values: NDArray[np.complex128]) -> list[list[float]]:
    return [[float(value.real), float(value.imag)] for value in values]


def _complex(pairs: Matrix) -> NDArray[np.complex128]:
    return pairs[:, 0] + 1j * pairs[:, 1]
