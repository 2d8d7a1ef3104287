"""Seeds of drawn tests: a few for `make test`, more for `make slow`."""

from __future__ import annotations

from typing import Any

import pytest


def seeds(quick: int, every: int) -> list[Any]:
    """Return the seeds below ``every``; those from ``quick`` on are slow."""
    return [*range(quick), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(quick, every))]
