"""What the stability analysis found, as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amble.report.tables import Table, number

NOTES = (
    "Of a full cycle; the error bar is an estimate, and the radius before stabilisation has none. Section error: "
    "distance from the fixed point at the end of the last cycle, norm of all states modulo the symmetries.",
)


def stability_table(results: Mapping[str, Any]) -> Table:
    """Summarise the stability entries of results.json; an entry that a run does not have gives no rows.

    Args:
        results: holds the entries that ``stability_results.ENTRIES`` describes, ``spectral_radius`` at least.
    """
    radius = results["spectral_radius"]
    rows = [
        ("spectral radius before stabilisation", number(float(radius["initial"]))),
        ("spectral radius after stabilisation", number(float(radius["stabilized"]))),
        ("its error bar", number(float(radius["error"]), 2)),
    ]
    bound = radius.get("contraction_bound")
    if bound is not None:
        rows.append(("contraction bound of the cycle, verified", number(float(bound))))
    found = results.get("contraction")  # None where the mode decays too fast to be measured
    if found is not None:
        rows += [
            ("leading mode, contraction predicted", number(float(found["predicted"]))),
            ("leading mode, contraction measured in simulation", number(float(found["measured"]))),
            ("relative difference of the two", number(float(found["relative_difference"]), 2)),
        ]
    starts = {"section_error": "start on the orbit", "section_error_perturbed": "perturbed start"}
    known = {key: start for key, start in starts.items() if results.get(key) is not None}
    rows += [(f"section error, {start}", number(float(results[key]), 2)) for key, start in known.items()]
    if results.get("perturbed") is not None:
        rows += _perturbed(results["perturbed"])
    return Table("Stability", ("quantity", "value"), tuple(rows), NOTES)


def _perturbed(found: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Say how the perturbed start did: until its contacts are sound, and the worst of them before that."""
    until = found.get("sound_from_cycle")
    rows = [
        ("perturbed start, change of every state", number(float(found["size"]), 2)),
        ("perturbed start, cycles", str(int(found["cycles"]))),
        ("perturbed start, contacts sound from cycle", "-" if until is None else str(int(until))),
    ]
    before = found.get("before_sound")
    if before is None:
        return rows
    used = before["max_friction"]  # None where a foot pulled
    return [
        *rows,
        ("perturbed start, largest friction used before that", "inf" if used is None else number(float(used))),
        ("perturbed start, smallest normal force before that (N)", number(float(before["min_normal_force"]))),
    ]
