"""What is installed: compiler, cache, versions and extras, and what of them is missing for what."""

from __future__ import annotations

import importlib.metadata
import platform
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from amble.codegen import Compiler, cache_folder, compiler
from amble.errors import WorkError
from amble.version import __version__

DEVELOPMENT = ("all", "bench", "docs", "lint", "test")
"""Extras that are no users', or only others together."""

CORE = ("casadi", "h5py", "numpy", "pydantic", "rich", "scipy", "typer")

REQUIREMENT = re.compile(r"""^(?P<library>[A-Za-z0-9._-]+).*?extra\s*==\s*["'](?P<extra>[\w-]+)["']""")

TRIAL = "double amble_trial(void) { return 1.0; }\n"


@dataclass(frozen=True, kw_only=True)
class Installation:
    """What ``inspect_installation`` finds.

    Attributes:
        versions: "amble", "python" and every library of the core -> version; None where it is missing.
        compiler: the C compiler; None where there is none, and everything is interpreted.
        fault: why the compiler cannot be used; empty where it can, or where there is none.
        cache: folder of compiled code.
        cached: bytes in it.
        extras: extra -> its libraries -> version; None where a library is missing. Empty where the package is not
            installed but run from its sources.
    """

    versions: Mapping[str, str | None]
    compiler: Compiler | None
    fault: str
    cache: Path
    cached: int
    extras: Mapping[str, Mapping[str, str | None]]

    @property
    def advice(self) -> tuple[str, ...]:
        """One sentence for everything that is missing, with the remedy."""
        found = [f"{name} is missing: pip install {name}" for name, version in self.versions.items() if version is None]
        if self.fault:
            found.append(f"the C compiler cannot be used: {self.fault}")
        elif self.compiler is None:
            found.append("there is no C compiler: everything is interpreted, 5 to 15 times as slow; install cc or gcc")
        for extra, libraries in self.extras.items():
            missing = [name for name, version in libraries.items() if version is None]
            if missing:
                found.append(f"extra '{extra}' is not complete ({', '.join(missing)}): pip install 'amble[{extra}]'")
        return tuple(found)


def inspect_installation() -> Installation:
    """Look at compiler, cache, versions and extras; the compiler builds and loads one function.

    Raises:
        InputError: where ``AMBLE_COMPILER`` or ``AMBLE_CACHE`` names what does not exist.
        WorkError: on a system that is not POSIX.
    """
    found, cache = compiler(), cache_folder()
    return Installation(
        versions={"amble": __version__, "python": platform.python_version(), **{name: _version(name) for name in CORE}},
        compiler=found,
        fault="" if found is None else _fault(found),
        cache=cache,
        cached=sum(path.stat().st_size for path in cache.glob("*") if path.is_file()),
        extras=_extras(),
    )


def _fault(found: Compiler) -> str:
    """Why a compiler cannot build a library of one function; empty where it can."""
    with tempfile.TemporaryDirectory(prefix="amble-doctor-") as folder:
        source = Path(folder) / "trial.c"
        source.write_text(TRIAL, encoding="utf-8")
        try:
            found.build(source, source.with_suffix(".so"), names=("amble_trial",))
        except (OSError, WorkError) as error:
            return str(error)
    return ""


def _version(library: str) -> str | None:
    try:
        return importlib.metadata.version(library)
    except importlib.metadata.PackageNotFoundError:
        return None


def _extras() -> dict[str, dict[str, str | None]]:
    try:
        lines = importlib.metadata.requires("amble") or []
    except importlib.metadata.PackageNotFoundError:
        return {}
    found: dict[str, dict[str, str | None]] = {}
    for match in filter(None, map(REQUIREMENT.match, lines)):
        if match["extra"] not in DEVELOPMENT:
            found.setdefault(match["extra"], {})[match["library"]] = _version(match["library"])
    return found
