"""How large weights may be where feet land one by one is decided by walks from changed starts."""

from __future__ import annotations

from pathlib import Path

import pytest

from amble.gait import Gait
from amble.gait.files import load_gait
from amble.progress import ProgressReport
from amble.stability.stabilize import NotStabilizedError, Stabilized, stabilization
from amble.stability.trial import PENALTIES, TRIED, came_back

DATA = Path(__file__).parents[1] / "data"
GAIT = load_gait(DATA / "trot-one-by-one.json")


@pytest.mark.parametrize(
    ("back", "taken", "tried"),
    [
        ((TRIED,), 0, 1),
        ((3, TRIED), 1, 2),
        ((3, 9, 9, 8), 1, 4),  # the most, of the largest weights
        ((3, None), 0, 2),  # with smaller weights the orbit stays unstable
    ],
)
def test_the_first_under_which_all_come_back_or_most(
    back: tuple[int | None, ...], taken: int, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[float] = []

    def with_penalty(gait: Gait, free: object, notify: object, near: object, penalty: float) -> Stabilized:
        del free, notify, near
        asked.append(penalty)
        if back[len(asked) - 1] is None:
            raise NotStabilizedError("the orbit stays unstable")
        return Stabilized(gait=gait, steps=(), reason=f"{penalty:g}", parameters=1, free=(), seconds=0.0)

    monkeypatch.setattr("amble.stability.stabilize._with_penalty", with_penalty)
    monkeypatch.setattr("amble.stability.trial.came_back", lambda _: back[len(asked) - 1])
    told: list[ProgressReport] = []
    assert stabilization(GAIT, progress=told.append).reason == f"{PENALTIES[taken]:g}"
    assert asked == list(PENALTIES[:tried])
    assert len(told) == tried - (None in back)


def test_what_is_never_stable_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def unstable(*_: object) -> Stabilized:
        raise NotStabilizedError("the orbit stays unstable: best spectral radius 1.3")

    monkeypatch.setattr("amble.stability.stabilize._with_penalty", unstable)
    with pytest.raises(NotStabilizedError, match=r"best spectral radius 1\.3"):
        stabilization(GAIT)


@pytest.mark.slow
def test_every_start_of_the_stored_trot_comes_back() -> None:
    assert came_back(load_gait(DATA / "stabilised-trot-one-by-one.json")) == TRIED
