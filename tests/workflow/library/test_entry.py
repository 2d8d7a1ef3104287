"""Which neighbour a gait of a library starts from."""

from __future__ import annotations

from dataclasses import replace

from amble.gait import Gait
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.workflow.library.entry import _alike
from tests.conftest import DATA


def test_a_turn_starts_from_a_straight_neighbour_written_out(stabilised_gait: Gait) -> None:
    """And a straight gait, which is solved with its mirror, from no turn."""
    turning = load_gait(DATA / "turning-trot.json")
    assert _alike(None, False) is None
    assert _alike(stabilised_gait, True) is stabilised_gait
    assert _alike(turning, False) is turning
    assert _alike(turning, True) is None
    whole = _alike(stabilised_gait, False)
    assert whole is not None
    assert [domain.name for domain in whole.domains] == ["D1", "D2", "D3", "D4"]
    assert _alike(replace(stabilised_gait, control=Impedance()), False) is None
