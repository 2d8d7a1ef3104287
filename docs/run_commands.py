"""Run the console blocks of pages as they are written, one page after the other, in a folder that is empty at first.

``python -m docs.run_commands PAGE ...`` prints every command before it starts and exits with 1 where one fails. A page
says ``# exits with 1`` behind a command that is meant to. What makes or enters an environment is left out: the
commands are those of the environment that runs this. No browser is opened.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCKS = re.compile(r"```console\n(.*?)```", re.DOTALL)

ENVIRONMENT = ("python3 -m venv ", "source ", "pip install ")
"""Beginnings of commands that are left out."""

FAILS = "# exits with 1"


def commands(page: Path) -> list[str]:
    """Return the commands of a page's console blocks in order, without those that make an environment."""
    lines = [line for block in BLOCKS.findall(page.read_text(encoding="utf-8")) for line in block.splitlines()]
    found = [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]
    return [command for command in found if not command.startswith(ENVIRONMENT)]


def run(page: Path, folder: Path) -> list[str]:
    """Run a page's commands in a folder and return a line for every one that did not end as the page says."""
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": programs, "BROWSER": "true"}
    wrong = []
    for command in commands(page):
        print(f"$ {command}", flush=True)
        done = subprocess.run(
            ["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode != (1 if FAILS in command else 0):
            wrong.append(f"{page}: '{command}' ended with {done.returncode}: {done.stderr[-600:].strip()}")
    return wrong


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="amble-docs-") as place:
        failed = [line for name in sys.argv[1:] for line in run(Path(name), Path(place))]
    print("\n".join(failed) or "every command of these pages works")
    sys.exit(1 if failed else 0)
