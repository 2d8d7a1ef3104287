"""The look through a built site finds what is wrong, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.check_site import complaints

SOUND = """<html><head><link rel="stylesheet" href="style.css"><link rel="canonical" href="https://example.org/">
<script src="program.js"></script></head><body id="top"><a href="other.html#place">o</a><a href="#top">t</a>
<a href="https://example.org/">out</a><img src="data:image/png;base64,AA=="></body></html>"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "index.html").write_text(SOUND, encoding="utf-8")
    (tmp_path / "other.html").write_text('<p id="place">here</p>', encoding="utf-8")
    (tmp_path / "program.js").touch()
    (tmp_path / "style.css").write_text("a { background: url(data:image/png;base64,AA==) }", encoding="utf-8")
    return tmp_path


def test_a_sound_site_passes(site: Path) -> None:
    assert complaints(site) == []


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ('<script src="https://cdn.example.org/x.js"></script>', "loads https://cdn.example.org/x.js"),
        ('<script src="//cdn.example.org/x.js"></script>', "loads //cdn.example.org/x.js"),
        ('<link rel="stylesheet" href="https://fonts.example.org/f.css">', "loads https://fonts"),
        ("<style>@import 'https://example.org/s.css';</style>", "loads https://example.org/s.css"),
        ('<p style="background: url(http://example.org/p.png)">', "loads http://example.org/p.png"),
        ('<script src="gone.js"></script>', "loads 'gone.js', which is not there"),
        ('<a href="gone.html">g</a>', "links to 'gone.html', which is not there"),
        ('<a href="other.html#gone">g</a>', "that page has no such place"),
        ('<a href="#gone">g</a>', "that page has no such place"),
    ],
)
def test_what_is_wrong_is_named(site: Path, text: str, complaint: str) -> None:
    (site / "bad.html").write_text(text, encoding="utf-8")
    (found,) = complaints(site)
    assert found.startswith("bad.html: ")
    assert complaint in found


def test_a_font_of_a_style_file_is_found(site: Path) -> None:
    (site / "style.css").write_text("@font-face { src: url('https://fonts.example.org/f.woff2') }", encoding="utf-8")
    assert complaints(site) == ["style.css: loads https://fonts.example.org/f.woff2"]


def test_an_empty_folder_is_no_site(tmp_path: Path) -> None:
    assert len(complaints(tmp_path)) == 1
