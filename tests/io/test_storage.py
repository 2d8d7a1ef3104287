"""Files appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import multiprocessing
import os
import stat
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from amble.errors import InputError, WorkError
from amble.io.storage import atomic_write, check_file, check_folder, confined, replacing, replacing_folder, sweep
from amble.io.storage.files import exchange
from amble.io.storage.places import workplace


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


@pytest.mark.parametrize("exists", [True, False])
def test_a_link_stays_and_its_target_is_replaced(tmp_path: Path, exists: bool) -> None:
    target, link = tmp_path / "store" / "blob", tmp_path / "gait.json"
    target.parent.mkdir()
    if exists:
        target.write_text("old")
    link.symlink_to(Path("store", "blob"))
    with replacing(link) as temporary:
        assert temporary.name == "gait.json"  # what writers look at
        temporary.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o400])
def test_an_existing_file_keeps_its_permissions(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")
    path.chmod(mode)
    if not os.access(path, os.W_OK):
        with pytest.raises(InputError, match="protected"):
            atomic_write(path, "new")
        return
    atomic_write(path, "new")
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_a_new_file_follows_the_umask(tmp_path: Path) -> None:
    (tmp_path / "other").touch()
    path = atomic_write(tmp_path / "file.txt", "text")
    assert path.stat().st_mode == (tmp_path / "other").stat().st_mode


def impossible(folder: Path) -> dict[str, Path | str]:
    (folder / "taken").mkdir()
    (folder / "file").touch()
    (folder / "loop").symlink_to("loop")
    os.mkfifo(folder / "pipe")
    return {
        "current folder": ".",
        "root": "/",
        "nothing": "",
        "folder": folder / "taken",
        "below a file": folder / "file" / "new" / "x.json",
        "loop of links": folder / "loop",
        "pipe": folder / "pipe",
        "device": "/dev/null",
        "long name": folder / "new" / ("n" * 300),
        "system": "/proc/amble/x.json",
        "NUL": f"{folder}/a\0b",
        "surrogate": f"{folder}/a\ud800b",
    }


CASES = ("current folder", "root", "nothing", "folder", "below a file", "loop of links", "pipe", "device", "long name")


@pytest.mark.parametrize("case", [*CASES, "system", "NUL", "surrogate"])
def test_a_place_that_cannot_be_written_is_refused_before_and_after_the_work(tmp_path: Path, case: str) -> None:
    place = impossible(tmp_path)[case]
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InputError, match="cannot write"):
        check_file(place)
    with pytest.raises(InputError, match="cannot write"):
        atomic_write(place, "text")
    assert [path for path in sorted(tmp_path.rglob("*")) if path.name != "new"] == before
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


def test_a_check_leaves_nothing(tmp_path: Path) -> None:
    check_file(tmp_path / "a" / "b" / "file.txt")
    check_folder(tmp_path / "a" / "b")
    check_file("file.txt")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="not a folder"):
        check_folder(os.devnull)


def test_a_lone_surrogate_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'\\ud800', which is no character"):
        atomic_write(tmp_path / "file.txt", "name \ud800")
    assert not os.listdir(tmp_path)


def hold(parent: Path, name: str, report: Connection) -> None:
    """Write half a file and wait to be killed."""
    with replacing(parent / name) as temporary:
        temporary.write_text("half")
        report.send(temporary.parent)
        report.poll(None)


def test_what_a_killed_process_leaves_is_removed_and_what_a_living_one_works_in_is_not(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=hold, args=(tmp_path, "replay.c", there))
    process.start()
    work = here.recv()
    assert work.stat().st_mode & 0o077 == 0
    sweep(tmp_path)
    assert work.is_dir()
    process.kill()
    process.join()
    assert work.is_dir()
    atomic_write(tmp_path / "other.txt", "text")
    assert os.listdir(tmp_path) == ["other.txt"]


def test_a_planted_folder_is_not_followed(tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "file").touch()
    (tmp_path / ".amble-planted").symlink_to(precious)
    sweep(tmp_path)
    assert (precious / "file").exists()


def belongs(name: str) -> bool:
    return name in ("a.c", "b.c")


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def write(folder: Path, **contents: str) -> None:
    with replacing_folder(folder, belongs) as fresh:
        for stem, text in contents.items():
            (fresh / f"{stem}.c").write_text(text)


def test_a_folder_is_replaced_as_a_whole(tmp_path: Path) -> None:
    folder, link = tmp_path / "new" / "code", tmp_path / "link"
    write(folder, a="1", b="1")
    folder.chmod(0o750)
    link.symlink_to(folder)
    write(link, a="2")
    assert files(folder) == {"a.c": "2"}
    assert link.is_symlink()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o750
    assert os.listdir(tmp_path / "new") == ["code"]


def test_an_interrupted_folder_is_the_old_one(tmp_path: Path) -> None:
    write(tmp_path / "code", a="1", b="1")
    with (
        contextlib.suppress(KeyboardInterrupt),
        replacing_folder(tmp_path / "code", belongs) as fresh,
    ):
        (fresh / "a.c").write_text("2")
        raise KeyboardInterrupt
    assert files(tmp_path / "code") == {"a.c": "1", "b.c": "1"}
    assert os.listdir(tmp_path) == ["code"]


@pytest.mark.parametrize("foreign", ["main.c", "b.c/nested", "a.o"])
def test_a_folder_with_the_work_of_others_is_refused(tmp_path: Path, foreign: str) -> None:
    place = tmp_path / "code" / foreign
    place.parent.mkdir(parents=True)
    place.write_text("mine")
    with pytest.raises(InputError, match="was not written by this command"):
        write(tmp_path / "code", a="1")
    assert place.read_text() == "mine"


@pytest.mark.parametrize("place", ["/", ".", "/proc"])
def test_some_folders_are_never_replaced(place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="cannot write"):
        write(Path(place), a="1")


def test_two_folders_are_exchanged_where_the_system_has_no_such_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("new", "target"):
        (tmp_path / name).mkdir()
        (tmp_path / name / name).touch()
    exchange(tmp_path / "new", tmp_path / "target", tmp_path / "aside")
    assert os.listdir(tmp_path / "target") == ["new"]
    monkeypatch.setattr("sys.platform", "other")
    with workplace(tmp_path) as work:
        exchange(tmp_path / "new", tmp_path / "target", work / "aside")
    assert os.listdir(tmp_path / "target") == ["target"]


@pytest.mark.parametrize("link", ["file.txt", "inside", "loop"])
def test_no_link_in_a_confined_folder_leads_out_of_it(link: str, tmp_path: Path) -> None:
    """A run or a library from elsewhere may hold a link in the place of a file that is written there."""
    outside, folder = tmp_path / "outside", tmp_path / "named"
    outside.mkdir()
    (tmp_path / "real").mkdir()
    folder.symlink_to("real")  # what somebody names may be a link
    target = {"file.txt": outside / "victim", "inside": outside, "loop": Path("loop")}[link]
    (folder / link).symlink_to(target)
    place = folder / link / "victim" if link == "inside" else folder / link
    with confined(folder), pytest.raises(InputError, match="leads out of it" if link != "loop" else "cannot write"):
        atomic_write(place, "text")
    assert not list(outside.iterdir())
    if link != "loop":
        assert atomic_write(place, "text").read_text() == "text"  # where it is what somebody names


def test_links_inside_a_confined_folder_are_followed(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").symlink_to("a")
    with confined(tmp_path):
        atomic_write(tmp_path / "b" / "file.txt", "text")
        atomic_write(tmp_path.parent / f"{tmp_path.name}.txt", "of another place")
    assert (tmp_path / "a" / "file.txt").read_text() == "text"
