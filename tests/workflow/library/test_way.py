"""What is done next, and from which start: neighbours that are settled, whatever failed in between."""

from __future__ import annotations

from pathlib import Path

from amble.workflow.library.entry import Made
from amble.workflow.library.files import LibraryEntry, write_entry
from amble.workflow.library.grid import Grid
from amble.workflow.library.way import Way

LINE = Grid(names=("speed",), values=((0.1, 0.2, 0.3, 0.4, 0.5),), first=(1,))


def entry(speed: float, file: str | None, certified: bool = True) -> LibraryEntry:
    return LibraryEntry(values={"speed": speed}, certified=certified, stage="certify", reason="", file=file, start=None)


def test_neighbours_wait_for_each_other(tmp_path: Path) -> None:
    way = Way(tmp_path, LINE)
    assert way.next() == (1,)
    assert way.next() is None  # all others are waiting for it
    assert way.task((1,)).start is None
    way.settle((1,), entry(0.2, "gaits/a.json"))
    assert {way.next(), way.next()} == {(0,), (2,)}
    assert way.next() is None
    assert (way.settled, way.size, way.failed) == (1, 5, 0)


def test_the_start_is_the_nearest_that_was_solved_the_weights_those_of_the_nearest_certified(tmp_path: Path) -> None:
    way = Way(tmp_path, LINE)
    way.settle((1,), entry(0.2, "gaits/a.json"))
    way.settle((2,), entry(0.3, "failed/b.json", certified=False))
    way.settle((3,), entry(0.4, None, certified=False))
    task = way.task((4,))
    assert (task.start, task.weights) == ("failed/b.json", "gaits/a.json")
    assert way.failed == 2


def test_what_is_recorded_is_not_done_again(tmp_path: Path) -> None:
    write_entry(tmp_path, {"speed": 0.2}, None, Made(stage="solve", reason="no luck"))
    way = Way(tmp_path, LINE)
    assert way.settled == way.failed == 1
    assert {way.next(), way.next()} == {(0,), (2,)}
    assert Way(tmp_path, LINE, again=True).next() == (1,)


def test_a_chain_takes_what_it_begins_from_as_it_is(tmp_path: Path) -> None:
    """The first gait of the chain upwards begins at once; without its neighbour it begins with a walk of its own."""
    way = Way(tmp_path, LINE, within=(2,))
    assert way.size == 3
    assert way.next() == (2,)
    assert way.task((2,)).start is None
    assert way.next() is None
    write_entry(tmp_path, {"speed": 0.2}, None, Made(stage="solve", reason="no luck"))
    assert Way(tmp_path, LINE, within=(2,)).next() == (2,)
