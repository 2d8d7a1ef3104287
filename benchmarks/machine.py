"""What every benchmark result must say of the machine it was measured on."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

import amble
from amble.codegen import compiler

PACKAGES = ("casadi", "numpy", "scipy", "mujoco", "pin", "proxsuite", "quadprog")


def describe() -> str:
    """Return processor, cores, load, Python, compiler and package versions, one a line."""
    tool = compiler()
    lines = [
        f"processor: {_processor()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}",
        f"python: {platform.python_version()}, amble {amble.__version__}, "
        + ", ".join(f"{name} {version}" for name in PACKAGES if (version := _version(name))),
        f"compiler: {tool.version if tool else 'none'}",
    ]
    return "\n".join(lines)


def _version(package: str) -> str | None:
    """Version of a package; None where it is not installed, as the baselines' are not for most benchmarks."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or "unknown"
    return next(
        (line.split(":", 1)[1].strip() for line in text.splitlines() if line.startswith("model name")), "unknown"
    )
