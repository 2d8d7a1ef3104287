"""``amble doctor``: what is installed, and what is missing for what."""

from __future__ import annotations

from amble.cli.console import print_table
from amble.cli.output import result, show


def doctor() -> None:
    """Tell compiler, cache, versions and extras, with remedies; exits 1 where the core is not whole."""
    from amble.errors import WorkError
    from amble.workflow.installation import inspect_installation

    found = inspect_installation()
    none = "none (interpreted)"
    said = none if found.compiler is None else f"{found.compiler.path}: {found.compiler.version}"
    rows = [[name, version or "missing"] for name, version in found.versions.items()]
    rows += [["C compiler", said], ["cache", f"{found.cache} ({found.cached / 1e6:.1f} MB)"]]
    for extra, libraries in found.extras.items():
        held = ", ".join(f"{name} {version or 'missing'}" for name, version in libraries.items())
        rows.append([f"extra [{extra}]", held])
    print_table(["what", "found"], rows)
    for sentence in found.advice:
        show(f"- {sentence}")
    result(
        versions=dict(found.versions),
        compiler=None if found.compiler is None else {"path": found.compiler.path, "version": found.compiler.version},
        cache={"folder": str(found.cache), "bytes": found.cached},
        extras={extra: dict(libraries) for extra, libraries in found.extras.items()},
        advice=list(found.advice),
    )
    if found.fault or None in found.versions.values():
        raise WorkError(next(sentence for sentence in found.advice))
