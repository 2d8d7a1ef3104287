"""The libraries that compute a result, with their versions."""

from __future__ import annotations

import platform
from importlib import metadata

from amble.codegen.compiler import compiler
from amble.version import __version__

LIBRARIES = ("casadi", "numpy", "scipy")
"""IPOPT is inside casadi."""

NO_COMPILER = "none, interpreted"


def computing_versions() -> dict[str, str]:
    """Return name -> version of everything that computes in this process, the C compiler by its version line.

    Raises:
        InputError: where ``AMBLE_COMPILER`` names a program that does not run.
    """
    found = compiler()
    return {
        "amble": __version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "C compiler": NO_COMPILER if found is None else found.version,
    }
