"""A film holds every frame of the replay; the encoder is stood in for by a program that keeps what it is given."""

from __future__ import annotations

import stat
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError, WorkError
from amble.gait import Gait
from amble.view import ReplayPage, replay
from amble.view.movie import write_movie
from tests.cli.run import exit_code

pytest.importorskip("mujoco")

GAIT = str(Path(__file__).parents[1] / "data" / "stabilised-amble.json")


def encoder(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """Put a program called ffmpeg first in the path."""
    program = folder / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\nfor last; do :; done\n{script}\n", encoding="utf-8")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(program.parent), prepend=":")


@pytest.fixture
def page(stabilised_gait: Gait) -> ReplayPage:
    return replay(stabilised_gait, cycles=1)


SMALL = """
import sys
import amble
from amble.view import movie
movie.WIDTH, movie.HEIGHT, movie.RATE = 96, 64, 10
gait = amble.load_gait(sys.argv[1])
movie.write_movie(amble.replay(gait, gait, cycles=1), sys.argv[2])
"""


@pytest.mark.slow
def test_every_frame_is_drawn_and_the_robot_moves(
    page: ReplayPage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a process of its own, because the way in which MuJoCo draws is settled when it is imported."""
    encoder(tmp_path, monkeypatch, 'cat > "$last"')
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    film = tmp_path / "film.mp4"
    command = (sys.executable, "-c", SMALL, GAIT, str(film))
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    if "renderer cannot draw here" in done.stderr:
        pytest.skip(done.stderr.splitlines()[-1])
    assert done.returncode == 0, done.stderr
    frames = np.frombuffer(film.read_bytes(), dtype=np.uint8).reshape(-1, 64, 96, 3)
    assert len(frames) == round(2.0 * page.replays[0].times[-1] * 10)
    np.testing.assert_array_equal(frames[:, :, :48], frames[:, :, 48:])
    assert np.std(frames[0].astype(float)) > 5.0
    assert np.any(frames[0] != frames[-1])


def test_a_film_that_cannot_be_made_is_one_sentence(
    page: ReplayPage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    heights = page.replays[0].ground.heights.copy()
    heights[0, 0] = 0.1
    hill = replace(page.replays[0], ground=replace(page.replays[0].ground, heights=heights))
    encoder(tmp_path, monkeypatch, "exit 3")
    with pytest.raises(InputError, match="a film shows level ground"):
        write_movie(replace(page, replays=(hill,)), tmp_path / "film.mp4")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert exit_code("view", GAIT, "--cycles", "1", "--mp4", str(tmp_path / "film.mp4")) == 1
    assert "ffmpeg, which was not found" in capsys.readouterr().err
    assert not (tmp_path / "film.mp4").exists()


@pytest.mark.slow
def test_a_failing_encoder_leaves_no_file(page: ReplayPage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    encoder(tmp_path, monkeypatch, "echo no such codec >&2; exit 3")
    with pytest.raises(WorkError, match=r"ffmpeg failed: no such codec|renderer cannot draw here"):
        write_movie(page, tmp_path / "film.mp4")
    assert not (tmp_path / "film.mp4").exists()
