"""Run every benchmark, or those that are named."""

from __future__ import annotations

import contextlib
import importlib
import inspect
import io
import pkgutil
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType

import benchmarks
from benchmarks.figures import Figure, show
from benchmarks.machine import describe
from benchmarks.report import write_report


def names() -> list[str]:
    """Return the names of all modules of this package that have a ``main`` without arguments."""
    found = [module.name for module in pkgutil.iter_modules(benchmarks.__path__) if not module.name.startswith("_")]
    return [name for name in found if _is_benchmark(importlib.import_module(f"benchmarks.{name}"))]


def _is_benchmark(module: ModuleType) -> bool:
    main = getattr(module, "main", None)
    needed = inspect.signature(main).parameters.values() if main else ()
    return main is not None and all(parameter.default is not parameter.empty for parameter in needed)


QUICK = "--quick"
"""Option: fewer rows of the benchmarks that have a shorter form."""


def run(arguments: list[str]) -> int:
    """Run benchmarks; exit code 2 for a name that does not exist.

    The report is written after every benchmark, so that an interrupted run keeps what was finished.
    """
    known, quick = names(), QUICK in arguments
    wanted = [argument for argument in arguments if argument != QUICK]
    for name in wanted:
        if name not in known:
            print(f"unknown benchmark '{name}'; known: {', '.join(known)}", file=sys.stderr)
            return 2
    machine = describe()
    print(machine)
    figures: dict[str, list[Figure]] = {}
    texts: dict[str, str] = {}
    written: list[Path] = []
    for name in wanted or known:
        module = importlib.import_module(f"benchmarks.{name}")
        print(f"\n== {name}: {(module.__doc__ or '').splitlines()[0]}", flush=True)
        if hasattr(module, "measure"):
            shorter = quick and "quick" in inspect.signature(module.measure).parameters
            figures[name] = module.measure(quick=True) if shorter else module.measure()
            show(figures[name])
        else:
            texts[name] = _printed(module.main)
        written = write_report(machine, figures, texts)
    print()
    for path in written:
        print(f"wrote {path}")
    print(_summary(figures))
    return 0


def _summary(figures: Mapping[str, Sequence[Figure]]) -> str:
    """Say which limits were missed."""
    limited = [(name, figure) for name, found in figures.items() for figure in found if figure.verdict]
    missed = [f"{name}: {figure.name}" for name, figure in limited if figure.verdict != "met"]
    return f"{len(limited) - len(missed)} of {len(limited)} limits met" + "".join(f"\nMISSED {one}" for one in missed)


def _printed(main: Callable[[], None]) -> str:
    """Run a benchmark that prints its own table; print it and return it."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        main()
    print(text.getvalue(), end="")
    return text.getvalue()


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
