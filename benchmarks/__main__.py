"""Run every benchmark, or those that are named."""

from __future__ import annotations

import importlib
import pkgutil
import sys

import benchmarks
from benchmarks.machine import describe


def names() -> list[str]:
    """Return the names of all modules of this package that have a ``main``."""
    found = [module.name for module in pkgutil.iter_modules(benchmarks.__path__) if not module.name.startswith("_")]
    return [name for name in found if hasattr(importlib.import_module(f"benchmarks.{name}"), "main")]


def run(wanted: list[str]) -> int:
    """Run benchmarks; exit code 2 for a name that does not exist."""
    known = names()
    for name in wanted:
        if name not in known:
            print(f"unknown benchmark '{name}'; known: {', '.join(known)}", file=sys.stderr)
            return 2
    print(describe())
    for name in wanted or known:
        module = importlib.import_module(f"benchmarks.{name}")
        print(f"\n== {name}: {(module.__doc__ or '').splitlines()[0]}")
        module.main()
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
