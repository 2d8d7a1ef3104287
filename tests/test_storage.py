"""Files appear whole or not at all."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from amble.errors import InputError, WorkError
from amble.storage import atomic_write, replacing


@pytest.mark.parametrize("content", ["Lysø, Grøtli\n", b"\x00\x01"])
def test_content_is_written_and_nothing_is_left_behind(tmp_path: Path, content: str | bytes) -> None:
    path = atomic_write(tmp_path / "new" / "file.txt", content)
    assert path.read_bytes() == (content.encode() if isinstance(content, str) else content)
    assert os.listdir(path.parent) == ["file.txt"]


def test_an_existing_file_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")
    assert atomic_write(path, "new").read_text() == "new"


@pytest.mark.parametrize("exception", [KeyboardInterrupt, ValueError])
def test_an_interruption_leaves_the_last_good_file(tmp_path: Path, exception: type[BaseException]) -> None:
    path = tmp_path / "file.txt"
    path.write_text("good")

    def interrupted() -> None:
        with replacing(path) as temporary:
            temporary.write_text("ha")
            raise exception

    with pytest.raises(exception):
        interrupted()
    assert path.read_text() == "good"
    assert os.listdir(tmp_path) == ["file.txt"]


def test_the_temporary_file_keeps_the_suffix(tmp_path: Path) -> None:
    with replacing(tmp_path / "figure.png") as temporary:
        assert temporary.suffix == ".png"
        temporary.write_bytes(b"")
    assert (tmp_path / "figure.png").exists()


def test_a_file_in_the_way_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "obstacle").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        atomic_write(tmp_path / "obstacle" / "file.txt", "text")


def test_a_folder_in_the_way_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "file.txt").mkdir()
    with pytest.raises(InputError, match="cannot write"):
        atomic_write(tmp_path / "file.txt", "text")


def test_a_full_disk_is_a_work_error(tmp_path: Path) -> None:
    with pytest.raises(WorkError, match="No space left"), replacing(tmp_path / "file.txt"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert not os.listdir(tmp_path)


def test_an_error_of_another_file_is_not_reworded(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "file.txt"):
        (tmp_path / "missing.txt").read_text()
