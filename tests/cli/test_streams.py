"""Closed, full and narrow streams: the work is done, and the exit code says what was lost."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

GAIT = Path(__file__).parents[1] / "data" / "stabilised-amble.json"
COMPARE = f"compare {GAIT} --law pinv --out result.json"
INIT = "init astro --gait amble --speed 0.2 --out result.json"
"""Quicker: it prints one line."""
AMBLE = f"{sys.executable} -m amble"

pytestmark = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no full device")


def shell(command: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        check=False,
        timeout=120,
    )


@pytest.mark.parametrize(
    ("command", "streams", "code", "says"),
    [
        (COMPARE, ">/dev/full", 1, b"error: cannot write to standard output: No space left on device\n"),
        (INIT, "</dev/null 1<&0", 1, b"error: cannot write to standard output: Bad file descriptor\n"),
        pytest.param(INIT, ">/dev/full 2>/dev/full", 1, b"", marks=pytest.mark.slow),
        pytest.param(COMPARE, "2>/dev/full", 0, b"", marks=pytest.mark.slow),
        pytest.param(INIT, ">&-", 0, b"", marks=pytest.mark.slow),
        pytest.param(INIT, "2>&-", 0, b"", marks=pytest.mark.slow),
        (INIT, ">&- 2>&- <&-", 0, b""),
        (INIT, "| true", 0, b""),
        (COMPARE, "| head -1", 0, b""),
    ],
)
def test_the_work_is_done_whatever_the_streams(
    command: str, streams: str, code: int, says: bytes, tmp_path: Path
) -> None:
    done = shell(f"{AMBLE} {command} {streams}", tmp_path)
    assert done.returncode == code
    assert (tmp_path / "result.json").stat().st_size > 100
    said = done.stderr.replace(b"comparing ...\n", b"")
    assert said == says
    assert os.listdir(tmp_path) == ["result.json"]


@pytest.mark.parametrize(
    "streams", [">/dev/full", ">&- 2>&-", pytest.param("2>&-", marks=pytest.mark.slow), "2>/dev/full"]
)
def test_a_failure_keeps_its_exit_code(streams: str, tmp_path: Path) -> None:
    assert shell(f"{AMBLE} check missing.json {streams}", tmp_path).returncode == 2
    assert shell(f"{AMBLE} --nonsense {streams}", tmp_path).returncode == 2


@pytest.mark.parametrize("command", ["--help", "--version", "robots"])
def test_lost_help_is_a_sentence(command: str, tmp_path: Path) -> None:
    done = shell(f"{AMBLE} {command} >/dev/full", tmp_path)
    assert done.returncode == 1
    assert done.stderr == b"error: cannot write to standard output: No space left on device\n"


@pytest.mark.parametrize("environment", [{"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, {}])
@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "ascii:strict"])
def test_characters_that_do_not_fit_are_degraded(environment: dict[str, str], encoding: str) -> None:
    code = (
        "from amble.cli.process import tolerant_streams as t\nwith t():\n  print('a \\u2500 b \\ud800'); print('next')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment, "PYTHONIOENCODING": encoding},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stdout.splitlines()) == (0, [b"a ? b ?", b"next"])


@pytest.mark.parametrize("encoding", ["ascii:strict", pytest.param("latin-1", marks=pytest.mark.slow)])
def test_a_table_whose_characters_do_not_fit_is_printed(encoding: str, tmp_path: Path) -> None:
    """The table of ``compare`` has a line of '─' and units with a middle dot or a superscript."""
    environment = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = shell(f"{AMBLE} {COMPARE}", tmp_path, PYTHONIOENCODING=encoding, **environment)
    assert done.returncode == 0
    assert b"Traceback" not in done.stderr
    assert b"wrote result.json" in done.stdout
