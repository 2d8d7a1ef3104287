"""results.json: the numbers behind the tables, as nested dictionaries built from records."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from importlib import metadata
from math import isfinite
from pathlib import Path
from typing import Any

from amble.analysis import Comparison, ContactReport
from amble.codegen.compiler import compiler
from amble.errors import InputError, WorkError, shown_path
from amble.gait import SolverReport
from amble.io.codec import TEXT, ByName
from amble.io.quantities import Bare
from amble.io.reader import read_json
from amble.io.storage import atomic_write
from amble.types import Json
from amble.version import __version__

FORMAT, FORMAT_VERSION = "amble results", 1

METHOD_KEYS = ("peak_torque", "rms_torque", "peak_joint", "mechanical_power", "heat_power", "specific_power")
COSTS_OF_TRANSPORT = ("cot", "cot_error")
"""Infinite where no distance is walked, which JSON does not have: None."""

LIBRARIES = ("casadi", "numpy", "scipy")
"""IPOPT is inside casadi."""

NO_COMPILER = "none, interpreted"


def method_results(comparison: Comparison, actuator: str) -> Json:
    """Return law -> motion -> metrics for one actuator model; torques in N m, powers in W, specific power in m/s."""
    found: Json = {}
    for entry in comparison.metrics:
        energy = entry.energy[actuator]
        costs = {key: finite_or_none(getattr(energy, key)) for key in COSTS_OF_TRANSPORT}
        chosen = {**costs, **{key: getattr(energy, key) for key in METHOD_KEYS}}
        found.setdefault(entry.law, {})[entry.motion] = chosen
    return found


def reduction_results(comparison: Comparison, motion: str, actuator: str) -> Json:
    """Return what the pseudo-inverse saves against the dropped actuator, in percent, with what it refers to."""
    return asdict(comparison.reduction("drop", "pinv", motion, actuator))


def finite_or_none(value: float) -> float | None:
    """Return a number for JSON; None for an infinite one, such as the friction that a pulling foot would need."""
    return value if isfinite(value) else None


def contact_results(report: ContactReport) -> Json:
    """Return the summary of the monitors and the rows outside their bounds; N, m, m/s.

    Friction used is None where a stance foot pulls: no coefficient holds it.
    """
    return {
        "min_normal_force": report.min_normal_force,
        "max_friction": finite_or_none(report.max_friction),
        "max_penetration": report.max_penetration,
        "max_drift": report.max_drift,
        "max_landing_gap": report.max_landing_gap,
        "max_slip": report.max_slip,
        "min_pivot": report.min_pivot,
        "pulling_samples": report.pulls,
        "samples": report.samples,
        "sound_from_cycle": report.sound_from,
        "last_cycle": {
            "min_normal_force": float(report.normal_forces[-1]),
            "max_friction": finite_or_none(float(report.frictions[-1])),
            "max_penetration": float(report.penetrations[-1]),
            "max_drift": float(report.drifts[-1]),
            "max_landing_gap": float(report.landing_gaps[-1]),
        },
        "violations": {
            worst.name: {
                "value": finite_or_none(worst.value),
                "by": finite_or_none(worst.violation),
                "time": worst.time,
                "cycle": worst.cycle,
            }
            for worst in report.violations
        },
    }


def solver_results(report: SolverReport) -> Json:
    """Return how the gait was found; seconds are wall time."""
    return asdict(report)


def write_results(path: str | Path, results: Mapping[str, Any]) -> Path:
    """Write results as JSON, whole or not at all.

    Args:
        path: the file.
        results: nested dictionaries and lists of text, numbers, booleans and None, with text as keys.

    Raises:
        WorkError: where a number is not finite or a value is of another kind; the message names the place.
        InputError: where the place cannot be written.
    """
    faults = list(_faults(results, ""))
    if faults:
        raise WorkError(f"the results are not written, because {'; '.join(faults)}")
    return atomic_write(path, json.dumps(results, indent=2, allow_nan=False) + "\n")


def read_results(path: str | Path) -> Json:
    """Read an earlier results.json; nothing where there is none.

    Raises:
        InputError: it is there, and is not what this release writes.
    """
    if not os.path.lexists(path):
        return {}
    tree = read_json(path, "results file")
    if tree.get("format") != FORMAT or tree.get("format_version") != FORMAT_VERSION:
        raise InputError(
            f"results file '{shown_path(path)}' is not an {FORMAT} of format version {FORMAT_VERSION}; without it "
            "the report is written without what it says of stability, settings and times"
        )
    return tree


def settings_from(results: Mapping[str, Any]) -> dict[str, str]:
    """Return the settings of the run; InputError where they are not text."""
    return ByName("setting", TEXT).decode(results.get("settings", {}), "settings of results.json")


def seconds_from(results: Mapping[str, Any]) -> dict[str, float]:
    """Return the wall times of the run, s; InputError where they are not numbers."""
    return {
        name: float(value)
        for name, value in ByName("step", Bare()).decode(results.get("seconds", {}), "seconds of results.json").items()
    }


def _faults(value: Any, place: str) -> Iterator[str]:
    """Name every place that plain JSON cannot hold."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if not isinstance(key, str):
                yield f"a key below '{place}' is {key!r}, not text"
            else:
                yield from _faults(inner, f"{place}.{key}" if place else key)
    elif isinstance(value, (list, tuple)):
        for index, inner in enumerate(value):
            yield from _faults(inner, f"{place}[{index}]")
    elif isinstance(value, float) and not isfinite(value):
        yield f"'{place}' is {value}"
    elif value is not None and not isinstance(value, (str, bool, int, float)):
        yield f"'{place}' is of type {type(value).__name__}"


def computing_versions() -> dict[str, str]:
    """Return name -> version of everything that computes in this process, the C compiler by its version line.

    Raises:
        InputError: where ``AMBLE_COMPILER`` names a program that does not run.
    """
    found = compiler()
    return {
        "amble": __version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "C compiler": NO_COMPILER if found is None else found.version,
    }
