"""The libraries that compute a result, with their versions."""

from __future__ import annotations

import platform
from importlib import metadata

from amble import __version__
from amble.codegen.compiler import compiler

LIBRARIES = ("casadi", "numpy", "scipy")
"""IPOPT is inside casadi."""

OPTIONAL = ("cvxpy", "clarabel")
"""They compute where a gait is stabilised by matrix inequalities (the extra "lmi")."""

NOT_INSTALLED = "not installed"

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
        **{name: _version(name) for name in OPTIONAL},
        "C compiler": NO_COMPILER if found is None else found.version,
    }


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return NOT_INSTALLED
