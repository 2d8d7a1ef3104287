"""What several tests of stability share."""

from __future__ import annotations

from dataclasses import replace

import pytest

from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.stability.gain_search import GainSearch


@pytest.fixture(scope="session")
def gain_search(stabilised_gait: Gait) -> GainSearch:
    """ASTRo's amble under default gains."""
    return GainSearch.of(replace(stabilised_gait, control=Impedance()))
