"""A proof as a file has it, whose numbers follow from nothing: for what only reads and shows one."""

from __future__ import annotations

from typing import Any

from amble.proof import Proof


def forged(system: str = "0" * 64, proved: dict[str, Any] | None = None, **found: Any) -> Proof:
    """Of three states, one of them a translation and one a turn."""
    pair = ("1234567e-7", "1234568e-7")
    tree = {
        **{"system": system, "half": True, "software": {"amble": "0"}, "basin_limit": ""},
        "found": {
            **{"order": 20, "bits": 128, "centre": ["1p-7", "1p-3", "0p0"], "radii": ["1p-60"] * 3},
            **{"steps": [["1p-5", "3p-6"], ["1p-5"]], "weight": [[1.0]], "rate": 0.5},
            **{"basin_weight": [], "basin_size": None, "basin_steps": []},
            **found,
        },
        "proved": {
            **{"state": {"x": pair, "y": pair, "z": pair}, "shift": {"x": pair}, "durations": [pair, pair]},
            "margins": [
                {"normal force of 'fl'": "61204e-3", "friction of 'fl'": "12e-3", "height of the base": "1e-1"},
                {"normal force of 'hr'": "4321e-3", "friction of 'hr'": "13e-3"},
            ],
            **{"multipliers": [(pair, pair)], "unstable": None, "basin_rate": None, "basin_extent": []},
            "distance": {
                **{"force_N": "226709e-19", "moment_N_m": "2e-15", "foot_acceleration_m_s2": "76e-17"},
                **{"foot_m": "19e-18", "impulse_N_s": "57e-19"},
            },
            **(proved or {}),
        },
    }
    return Proof.model_validate(tree, strict=False)
