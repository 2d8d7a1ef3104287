"""A reproduction whose two long steps, synthesis and stabilisation, hand out a stored gait."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import pytest

from amble.gait import Gait
from amble.stability.stabilize import Stabilized, Step

module: Any = importlib.import_module("amble.workflow.reproduce")


def hand_out(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace both steps by the stored gait, without and with its feedback."""

    def stabilised(gait: Gait, **_: object) -> Stabilized:
        steps = tuple(
            Step(number=number, radius=radius, bound=1.1 * radius, length=1.0, drift=0.0, seconds=0.1)
            for number, radius in enumerate((2.3, 0.4))
        )
        return Stabilized(
            gait=replace(gait, feedback=stabilised_gait.feedback),
            steps=steps,
            reason="stored",
            parameters=66,
            free=("roll", "pitch", "yaw"),
            seconds=0.1,
        )

    monkeypatch.setattr(module, "solve", lambda *_, **__: replace(stabilised_gait, feedback=None))
    monkeypatch.setattr(module, "stabilization", stabilised)
