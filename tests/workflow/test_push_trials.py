"""Trials in pieces: the same in every run, none done twice, none lost."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError, WorkError
from amble.gait import Gait
from amble.gait.unilateral_state import Push
from amble.stability.push_response import impulse_unit, push_duration
from amble.stability.robustness import SURVIVED, TrialSettings
from amble.workflow import push_trials
from amble.workflow.push_trials import PIECE, TrialFolder, drawn, pieces
from amble.workflow.trial_runs import do_trials


class Counting:
    """An engine that a hard push fells, which counts its walks and may break off."""

    def __init__(self, last: int = 10**9) -> None:
        self.walks: list[Push] = []
        self.last = last

    def of(self, gait: Gait) -> Counting:
        self.limit = 0.1 * impulse_unit(gait.robot) / push_duration(gait.robot)
        return self

    def walk(self, push: Push) -> tuple[int, str]:
        if len(self.walks) >= self.last:
            raise KeyboardInterrupt
        self.walks.append(push)
        return (8, SURVIVED) if np.hypot(*push.force[:2]) < self.limit else (1, "fell")


def use(monkeypatch: pytest.MonkeyPatch, engine: Counting) -> None:
    monkeypatch.setattr(push_trials, "ENGINES", {"counting": lambda gait, _: engine.of(gait).walk})


def test_a_trial_is_the_same_however_many_there_are(stabilised_gait: Gait) -> None:
    settings = TrialSettings(seed=3)
    several = [drawn(stabilised_gait, settings, number) for number in range(500)]
    assert drawn(stabilised_gait, settings, 321) == several[321]
    assert drawn(stabilised_gait, replace(settings, seed=4), 321) != several[321]
    impulses, directions, phases = np.array(several).T
    assert 0.0 <= impulses.min() < impulses.max() <= impulse_unit(stabilised_gait.robot)
    assert 0.0 <= directions.min() < 0.1 < 6.2 < directions.max() <= 2.0 * np.pi
    assert 0.0 <= phases.min() < phases.max() < 1.0


def test_an_interrupted_run_goes_on(stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 120 trials the first 70 are done: one piece of 50 is kept, the rest is done, and all are as from one run."""
    folder = TrialFolder(place=tmp_path / "trials", gait=stabilised_gait, settings=TrialSettings())
    broken = Counting(last=70)
    use(monkeypatch, broken)
    with pytest.raises(KeyboardInterrupt):
        do_trials(folder, ["counting"], 120)
    assert [path.name for path in sorted(folder.place.glob("counting-*"))] == ["counting-0000000-0000050.json"]
    whole = Counting()
    use(monkeypatch, whole)
    found = do_trials(folder, ["counting"], 120)["counting"]
    assert len(whole.walks) == 120 - PIECE
    assert do_trials(folder, ["counting"], 120)["counting"] == found
    assert len(whole.walks) == 120 - PIECE
    other = replace(folder, place=tmp_path / "other")
    assert do_trials(other, ["counting"], 120)["counting"] == found
    assert 0 < sum(trial.survived for trial in found) < 120


def test_a_damaged_piece_is_done_again(stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, engine = TrialFolder(place=tmp_path, gait=stabilised_gait, settings=TrialSettings()), Counting()
    use(monkeypatch, engine)
    found = do_trials(folder, ["counting"], 60)
    first, second = (folder.file("counting", piece) for piece in pieces(60))
    first.write_text(first.read_text()[:-40])
    rows = json.loads(second.read_text())
    rows[0]["impulse"] += 1.0
    second.write_text(json.dumps(rows))
    assert do_trials(folder, ["counting"], 60) == found
    assert len(engine.walks) == 120


def test_trials_of_something_else_are_not_mixed(
    stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use(monkeypatch, Counting())
    folder = TrialFolder(place=tmp_path, gait=stabilised_gait, settings=TrialSettings())
    do_trials(folder, ["counting"], 10)
    with pytest.raises(InputError, match="holds trials of another gait, with other settings"):
        do_trials(replace(folder, settings=TrialSettings(seed=2)), ["counting"], 10)
    with monkeypatch.context() as changed:
        changed.setattr(push_trials, "code_key", lambda: "of other sources")
        with pytest.raises(InputError, match="or of other code of amble"):
            do_trials(folder, ["counting"], 10)
    with pytest.raises(UnknownNameError, match="unknown engine 'bullet'"):
        do_trials(folder, ["bullet"], 10)
    for trials, workers in ((0, 1), (1, 0)):
        with pytest.raises(InputError, match="were asked for; a whole number from 1"):
            do_trials(folder, ["counting"], trials, workers)
    for wrong in ({"seed": -1}, {"cycles": 1}, {"friction": 0.0}, {"largest": float("inf")}):
        with pytest.raises(InputError):
            TrialSettings(**wrong)


@pytest.mark.slow
def test_a_worker_that_fails_is_told_of(stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers are processes of their own, which do not know the engine of this test."""
    use(monkeypatch, Counting())
    folder = TrialFolder(place=tmp_path, gait=stabilised_gait, settings=TrialSettings())
    with pytest.raises(WorkError, match="trials in 'counting' failed: unknown engine 'counting'"):
        do_trials(folder, ["counting"], 100, workers=2)


@pytest.mark.slow
def test_workers_do_the_same_as_one_process(stabilised_gait: Gait, tmp_path: Path) -> None:
    settings = TrialSettings(cycles=2)
    found = [
        do_trials(
            TrialFolder(place=tmp_path / str(workers), gait=stabilised_gait, settings=settings),
            ["native"],
            100,
            workers,
        )
        for workers in (1, 2)
    ]
    assert found[0] == found[1]
    assert 0 < sum(trial.survived for trial in found[0]["native"]) < 100


@pytest.mark.parametrize(
    "change", [{"cycles": 0}, {"cycles": "x"}, {"ended": [1]}, {"ended": "a\x1bb", "cycles": 1}, {"cycles": 9}]
)
def test_a_forged_trial_is_done_again(
    change: dict[str, object], stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = TrialFolder(place=tmp_path, gait=stabilised_gait, settings=TrialSettings())
    use(monkeypatch, Counting())
    found = do_trials(folder, ["counting"], 10)["counting"]
    (piece,) = pieces(10)
    file = folder.file("counting", piece)
    rows = json.loads(file.read_text())
    rows[next(place for place, trial in enumerate(found) if trial.survived)].update(change)
    file.write_text(json.dumps(rows))
    assert folder.read("counting", piece) is None
    assert do_trials(folder, ["counting"], 10)["counting"] == found


def test_a_link_in_a_folder_of_trials_is_not_followed(tmp_path: Path, stabilised_gait: Gait) -> None:
    (tmp_path / "mine").write_text("mine")
    place = tmp_path / "out" / "trials"
    place.mkdir(parents=True)
    (place / "gait.json").symlink_to(tmp_path / "mine")
    with pytest.raises(InputError, match="leads out of it"):
        TrialFolder(place=place, gait=stabilised_gait, settings=TrialSettings()).claim()
    assert (tmp_path / "mine").read_text() == "mine"
