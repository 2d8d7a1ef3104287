"""A disk that is full while a result is written: one sentence, exit code 1, the old result, and nothing else.

A limit to the size of files stands for the disk: the system refuses the same calls.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

DATA = Path(__file__).parents[1] / "data"
BIPED = str(DATA / "biped-of-small-basin.json")

RUN = """
import json, os, resource, sys
from amble.cli import main

def run(arguments):
    try:
        main(arguments)
    except SystemExit as ended:
        return ended.code
    return 0

resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
_, most = resource.getrlimit(resource.RLIMIT_FSIZE)
for arguments, sizes in json.loads(sys.argv[1]):
    if (code := run([*arguments, "--quiet"])) != 0:
        raise SystemExit(f"{arguments} ended with {code}")
    for size in sizes:
        print("limit", size, file=sys.stderr, flush=True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, most))
        code = run([*arguments, "--quiet"])
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        print("code", code, file=sys.stderr, flush=True)
"""

COMMANDS: dict[str, tuple[tuple[str, ...], tuple[int, ...]]] = {
    "simulate": (("simulate", BIPED, "--cycles", "1", "--out", "out.nc"), (0, 2000, 25_000)),
    "export": (("export", BIPED, "--out", "out"), (0, 5000)),
    "motion as npz": (("export", BIPED, "--out", "out.npz"), (5000,)),
    "motion as text": (("export", BIPED, "--out", "out.csv"), (0, 2000)),
    "motion for MATLAB": (("export", BIPED, "--out", "out.mat"), (0, 2000)),
    "specification": (("init", "astro", "--gait", "amble", "--speed", "0.2", "--out", "out.toml"), (0, 100)),
    "page": (("view", BIPED, "--cycles", "1", "--out", "out.html"), (0, 20_000)),
    "figure": (("compare", BIPED, "--law", "pinv", "--figure", "out"), (0, 5000)),
}


QUICK = ("simulate", "motion as npz", "specification")


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
@pytest.mark.parametrize("names", [QUICK, pytest.param(tuple(COMMANDS), marks=pytest.mark.slow)], ids=["some", "all"])
def test_every_result_on_a_full_disk_is_one_sentence(names: tuple[str, ...], tmp_path: Path) -> None:
    """HDF5 printed forty lines and ended with a segmentation fault."""
    wanted = json.dumps([COMMANDS[name] for name in names])
    done = subprocess.run(
        [sys.executable, "-c", RUN, wanted], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    limits = done.stderr.split("limit ")
    assert limits[0] == ""
    assert len(limits) == 1 + sum(len(COMMANDS[name][1]) for name in names)
    for text in limits[1:]:
        _, sentence, code = text.splitlines()
        assert sentence.startswith("error: cannot write 'out"), text
        assert sentence.endswith("File too large"), text
        assert code == "code 1", text
    suffixes = {path.suffix for path in tmp_path.iterdir()}
    assert suffixes == {Path(COMMANDS[name][0][-1]).suffix for name in names} | ({".png", ".pdf"} & suffixes)
    assert not [path for path in tmp_path.rglob("*") if path.name.startswith(".") or path.stat().st_size == 0]
