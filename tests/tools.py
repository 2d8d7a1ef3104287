"""Programs that some tests need beside Python; without one they are skipped, with a sentence."""

from __future__ import annotations

import os
import shutil

import pytest


def program(names: tuple[str, ...], use: str, package: str) -> str:
    """Find a program, or skip; ``AMBLE_TOOLS_NEEDED=1``, as in .ci/run, makes a missing one a failure.

    Args:
        names: by which it may be called.
        use: what it is for.
        package: Debian's package.
    """
    found = next((path for path in map(shutil.which, names) if path), None)
    if found is None:
        sentence = f"there is no program {use} ({', '.join(names)}; Debian's package: {package})"
        if os.environ.get("AMBLE_TOOLS_NEEDED") == "1":
            pytest.fail(sentence)
        pytest.skip(sentence)
    return found
