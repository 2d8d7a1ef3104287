"""Tables are read whole, with the comment before them, and no further than they may go."""

from __future__ import annotations

from pathlib import Path

import pytest

from amble.errors import InputError
from amble.io import table
from amble.io.table import read_table


def test_rows_are_those_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b'# of a robot\r\ntime,"a, b"\r\n0,"1\n2"\n\n3,4')
    assert read_table(tmp_path / "a.csv", "log") == ("of a robot", [["time", "a, b"], ["0", "1\n2"], [], ["3", "4"]])
    (tmp_path / "b.csv").write_text("#,time\n")
    assert read_table(tmp_path / "b.csv", "log") == ("", [["#", "time"]])
    (tmp_path / "c.csv").write_text("")
    assert read_table(tmp_path / "c.csv", "log") == ("", [])


@pytest.mark.parametrize("text", ["1\n" * 100, "," * 100, "\n" * 200])
def test_cells_are_counted_before_memory_is_full(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table, "MOST_CELLS", 100)
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError, match=r"log '.*' cannot be read: it has more than 100 cells"):
        read_table(tmp_path / "a.csv", "log")


@pytest.mark.parametrize(("content", "says"), [(b"x" * 200_000, "is no table: field larger"), (b"\xff", "in UTF-8")])
def test_what_is_no_table_is_one_sentence(content: bytes, says: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(InputError, match=says) as refused:
        read_table(tmp_path / "a.csv", "log")
    assert str(refused.value).isprintable()


def test_a_large_table_is_refused_without_reading_it(tmp_path: Path) -> None:
    with (tmp_path / "a.csv").open("wb") as stream:
        stream.truncate(2**36)  # sparse: takes no room on the disk
    with pytest.raises(InputError, match="more than 64 MB"):
        read_table(tmp_path / "a.csv", "log")
