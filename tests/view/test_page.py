"""The page of a replay: one file, nothing from elsewhere, and what it shows in a browser."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.simulation import simulate
from amble.view import ReplayPage, replay, replay_fragment
from amble.view.meshes import Mesh
from tests.browser import screenshot, share_of_ink

LARGEST = 5_000_000
"""Bytes of a page with ten cycles."""


@pytest.fixture(scope="module")
def page(stabilised_gait: Gait) -> ReplayPage:
    return replay(stabilised_gait)


def test_a_page_is_one_file_that_asks_for_nothing(page: ReplayPage, tmp_path: Path) -> None:
    written = page.write(tmp_path / "replay.html")
    text = written.read_text(encoding="utf-8")
    assert len(text) < LARGEST / 2
    assert page.replays[0].cycles == 10
    assert not re.search(r"(?:src|href)\s*=|@import|url\(|https?:|fetch\(|XMLHttpRequest|import\(", text)


def test_two_motions_stand_side_by_side(stabilised_gait: Gait) -> None:
    trace = simulate(stabilised_gait, cycles=2)
    found = replay(stabilised_gait, trace, cycles=2)
    assert [each.label for each in found.replays] == ["astro, amble, optimised", "astro, amble, simulated"]
    assert found.html().count('"poses": "') == 2


def test_names_are_text_and_nothing_more(stabilised_gait: Gait) -> None:
    """A robot's name comes from a file."""
    name = "</script><b>&"
    robot = replace(stabilised_gait.robot, name=name)
    gait = replace(stabilised_gait, pattern=replace(stabilised_gait.pattern, robot=robot))
    text = replay(gait, cycles=1).html()
    assert name not in text
    assert "</script><b>" not in text
    assert text.count("</script>") == 2
    assert "&lt;/script&gt;&lt;b&gt;&amp;" in text


def test_a_notebook_shows_it_apart(page: ReplayPage) -> None:
    shown = page._repr_html_()
    assert shown.startswith('<iframe srcdoc="')
    assert shown.count("<") == 2


@pytest.mark.parametrize("count", [0, 3])
def test_one_motion_or_two(page: ReplayPage, count: int) -> None:
    with pytest.raises(InputError, match=f"one motion or two side by side, not {count}"):
        replay_fragment(count * page.replays, "name")


def test_a_browser_draws_it_and_the_slider_moves_it(page: ReplayPage, tmp_path: Path) -> None:
    """A blank page, or a program that stops at its first error, fails here."""
    written = page.write(tmp_path / "replay.html")
    early, late = (screenshot(written, tmp_path, f"t={time}") for time in (0.05, 0.2))
    # the stage without controls and label: rows from 60 to 480 of 600
    for picture in (early, late):
        assert share_of_ink(picture[60:470]) > 0.02
    moved = np.any(np.abs(early[60:470].astype(int) - late[60:470].astype(int)) > 30, axis=-1)
    assert 0.002 < np.mean(moved) < 0.5


def test_a_page_without_motion_shows_less(page: ReplayPage, tmp_path: Path) -> None:
    """The measure of the test above tells an empty stage from a drawn one."""
    text = page.html().replace("items.sort((a, b)", "[].sort((a, b)")
    (tmp_path / "empty.html").write_text(text, encoding="utf-8")
    drawn, empty = (
        screenshot(file, tmp_path, "t=0.1")[60:470]
        for file in (page.write(tmp_path / "a.html"), tmp_path / "empty.html")
    )
    assert share_of_ink(drawn) > share_of_ink(empty) + 0.01


@pytest.mark.slow
def test_a_mesh_is_drawn_in_the_place_of_bones(page: ReplayPage, tmp_path: Path) -> None:
    """An upright plate of a leg length about the base covers more than its bones, and a far one shows its absence."""
    half = 0.5 * page.replays[0].robot.leg_length
    corners = half * np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])
    plate = Mesh(link=0, vertices=corners, faces=np.array([[0, 1, 2], [0, 2, 3]]))
    shares = []
    far = replace(plate, vertices=corners + np.array([0.0, 0.0, -1e3]))
    for meshes in ((), (plate,), (far,)):
        shown = replace(page, replays=(replace(page.replays[0], meshes=meshes),))
        shares.append(share_of_ink(screenshot(shown.write(tmp_path / "page.html"), tmp_path, "t=0.1")[60:470]))
    assert shares[1] > shares[0] + 0.01, shares
    assert shares[2] < shares[0], shares
