"""What the examples register is known to their own tests only, so that every other test sees amble as it ships.

Grounds, contacts and phases change nothing where they are not named, and tests elsewhere use them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from amble.control import LAWS
from amble.control.actuator import ACTUATORS
from amble.gait.control_law import CONTROL_LAWS
from amble.gait.cost import COSTS
from amble.hybrid.gaits import GAITS
from amble.io.registry import Lookup
from amble.robot import READERS
from amble.simulation.simulate import simulate  # noqa: F401  (registers the gait's own control law)
from amble.simulation.walk import ENGINES
from amble.synthesis.solve import SOLVERS

OPEN: tuple[Lookup[Any], ...] = (READERS, GAITS, LAWS, ACTUATORS, COSTS, SOLVERS, ENGINES, CONTROL_LAWS)
SHIPPED = [dict(lookup._entries) for lookup in OPEN]
"""Read before the first example is imported: conftest files come before the tests beside them."""

extended: list[dict[str, Any]] = []


def put(entries: list[dict[str, Any]]) -> None:
    for lookup, known in zip(OPEN, entries, strict=True):
        lookup._entries = dict(known)


@pytest.hookimpl
def pytest_collection_finish() -> None:
    """Every test file is imported now, and with it the examples."""
    extended[:] = [dict(lookup._entries) for lookup in OPEN]
    put(SHIPPED)


@pytest.fixture(autouse=True, scope="module")
def registered() -> Iterator[None]:
    put(extended)
    yield
    put(SHIPPED)
