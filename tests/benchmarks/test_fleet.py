"""The fleet's table: its rows, and a run that goes on where the last one ended."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from amble.errors import CertificateError, NotSolvedError, WorkError
from amble.hybrid import FLAT, POINT
from amble.hybrid.gaits import GAITS
from amble.residual import Residual
from amble.version import __version__
from benchmarks import fleet, fleet_row, robot_files
from benchmarks.fleet import in_process, resumed, rows, table
from benchmarks.fleet_row import Row, reason, robot
from benchmarks.robot_files import FILES


def test_rows_are_fixed_and_different() -> None:
    """Two speeds of every gait that a robot has the legs for."""
    found = rows()
    keys = [(row.robot, row.gait, row.share) for row in found]
    assert len(set(keys)) == len(keys)
    assert {row.gait for row in found if row.robot == "go2"} == {*fleet.FOUR, "pronk"}
    assert {row.gait for row in found if row.robot == "hyq"} == {*fleet.FOUR}
    assert {row.gait for row in found if row.robot == "hexapod"} == {"tripod"}
    assert {row.robot for row in found} == {"astro", "hexapod", "planar biped", *FILES}


def test_an_interrupted_run_goes_on_where_it_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fleet, "release", lambda name: f"{__version__} of {name}")
    place, computed = tmp_path / "fleet.json", list[str]()

    def compute(row: Row) -> Row:
        if len(computed) == 2:
            raise KeyboardInterrupt
        computed.append(row.gait)
        return replace(row, release=f"{__version__} of {row.robot}", status="Solve_Succeeded", solved=True)

    asked = [Row(robot="astro", gait=gait, share=0.1) for gait in ("trot", "amble", "pace")]
    with pytest.raises(KeyboardInterrupt):
        resumed(asked, place, compute)
    assert computed == ["trot", "amble"]
    computed[:] = []
    found = resumed(asked, place, compute)
    assert computed == ["pace"]
    assert [row.gait for row in found] == ["trot", "amble", "pace"]
    assert table(found).count("\n") == 5
    monkeypatch.setattr(fleet, "release", lambda name: f"later than {name}")
    computed[:] = []
    with pytest.raises(KeyboardInterrupt):
        resumed(asked, place, compute)
    assert computed == ["trot", "amble"]  # rows of another release are computed again


def test_a_row_whose_wheel_is_missing_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FILES, "vision60", replace(FILES["vision60"], wheel="no-such-wheel"))
    monkeypatch.setitem(robot_files.HOME, "no-such-wheel", "")
    robot.cache_clear()
    found = fleet_row.computed(Row(robot="vision60", gait="trot", share=0.1), tmp_path)
    robot.cache_clear()
    assert not found.solved
    assert found.status == "the wheel no-such-wheel is not installed"


def test_a_row_that_takes_too_long_is_as_far_as_it_came(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Imports alone take longer than a second of processor time."""
    monkeypatch.setattr(fleet, "LIMIT", 1)
    found = in_process(Row(robot="astro", gait="trot", share=0.1), tmp_path)
    assert not found.solved
    assert found.status in ("not begun", "not solved in time")
    assert found.seconds == 1.0


def test_every_robot_of_a_file_loads() -> None:
    for name, file in FILES.items():
        if not file.absent:
            assert robot(name).foot_names == tuple(file.feet)


def test_the_hexapod_has_its_gait() -> None:
    pattern = GAITS["tripod"](robot("hexapod"), FLAT, POINT)
    assert pattern.mirrored
    assert [len(stance.feet) for stance in pattern.solved] == [3]


def test_the_reason_of_a_refusal_names_the_rows_that_fail() -> None:
    """Tables said '1 of 164 conditions fail'."""
    rows = [Residual(f"row {number}", 0.0, 1.0 + number, 0.5) for number in range(4)]
    held = Residual("held", -1.0, 0.0, 1.0)
    assert reason(CertificateError([held, *rows[:1]])) == (
        "no certificate: 1 of 2 conditions fail: row 0 is 1, at most 0.5"
    )
    assert reason(CertificateError([held, *rows])).endswith(
        "4 of 5 conditions fail: row 3 is 4, at most 0.5; row 2 is 3, at most 0.5; row 1 is 2, at most 0.5; and 1 more"
    )
    assert reason(NotSolvedError("Infeasible", [Residual("knee", -1.0, -1.25, 1.0)])).endswith(
        "Infeasible: knee is -1.25, at least -1"
    )
    assert reason(WorkError("said\nmore")) == "said"
