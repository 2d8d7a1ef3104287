"""What is told of a large library, and that records which change are seen."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from amble.workflow.library import LibraryEntry
from amble.workflow.library.axes import read_library
from benchmarks import library

SPECIFICATIONS = Path(library.__file__).parent / "libraries"


def entry(yaw_rate: float, radius: float | None) -> LibraryEntry:
    certified = radius is not None
    return LibraryEntry(
        values={"yaw_rate": yaw_rate},
        certified=certified,
        stage="certify" if certified else "solve",
        reason="" if certified else "Infeasible_Problem_Detected\nrow 7",
        file=None,
        start=None,
        numbers={"radius": radius},
        seconds={"solve": 1.0, "certify": 3.0} if certified else {"solve": 2.0},
    )


def test_the_summary_counts_success_and_cost() -> None:
    lines = library.summary([entry(0.0, 0.5), entry(0.0, 0.96), entry(0.1, 0.3), entry(0.1, None)])
    assert lines[0] == "2 of 4 gaits certified with a radius below 0.95"
    assert lines[1] == "yaw_rate: 0: 1 of 2, 0.1: 1 of 2"
    assert lines[2].startswith("mirrored: 4.0 s of processor time a certified gait, median 4.0, on average solve 1.0")
    assert lines[3].startswith("unmirrored: 6.0 s of processor time a certified gait")  # with what failed
    assert lines[4:] == ["1 failed at 'solve': Infeasible_Problem_Detected"]


def test_a_record_that_was_written_again_is_told(tmp_path: Path) -> None:
    (tmp_path / "records").mkdir()
    record = tmp_path / "records" / "speed_0.2.json"
    record.touch()
    known = library.stamps(tmp_path)
    assert library._kept(tmp_path, known) == known
    os.utime(record, ns=(1, 1))
    with pytest.raises(SystemExit, match=r"lost or made twice: speed_0\.2"):
        library._kept(tmp_path, known)


def test_the_specification_of_astro_is_large_enough() -> None:
    grid = read_library(SPECIFICATIONS / "astro-amble.toml").grid
    assert grid.size == 2295
    apart = {name: min(b - a for a, b in zip(row, row[1:])) for name, row in zip(grid.names, grid.values)}  # noqa: B905, RUF007
    assert apart == pytest.approx({"yaw_rate": 0.05, "speed": 0.025, "height": 0.005})
    assert grid.at(grid.first) == pytest.approx({"yaw_rate": 0.0, "speed": 0.2, "height": 0.34})
