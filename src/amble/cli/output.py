"""What a command leaves on standard output: text for people, or with ``--json`` one object; with ``--quiet`` nothing.

Every command speaks through ``show``, ``result`` and ``wrote``; ``reporting`` gives it the two options and
``--plugin``.
"""

from __future__ import annotations

import functools
import inspect
import json
import logging
import math
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from amble.errors import AmbleError
from amble.io.plugins import load_plugins

if TYPE_CHECKING:
    from amble.types import Json

INTERRUPTED = 130
"""Exit code of a command that Ctrl-C stopped: 128 + SIGINT."""


@dataclass
class Output:
    """How one command speaks, and what it has found so far.

    Attributes:
        json: whether standard output is one JSON object.
        quiet: whether nothing is said but errors.
        found: what the object will hold.
        files: what was written.
        plugins: modules that were asked for.
    """

    json: bool = False
    quiet: bool = False
    found: Json = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)
    plugins: tuple[str, ...] = ()


_PLAIN = Output()
_CURRENT: ContextVar[Output] = ContextVar("output")


def quiet() -> bool:
    """Whether the running command says nothing but errors."""
    return _CURRENT.get(_PLAIN).quiet


def plugins() -> tuple[str, ...]:
    """Modules that the running command was asked to import: processes that it starts need them too."""
    return _CURRENT.get(_PLAIN).plugins


def show(text: str) -> None:
    """Print a result for people."""
    output = _CURRENT.get(_PLAIN)
    if not (output.json or output.quiet):
        typer.echo(text)


def result(**entries: Any) -> None:
    """Add entries to the JSON object; also those that were known before the work failed are in it."""
    _CURRENT.get(_PLAIN).found.update(entries)


def wrote(path: Path) -> None:
    """Tell of a file that was written."""
    _CURRENT.get(_PLAIN).files.append(path)
    show(f"wrote {path}")


def reporting(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that also takes ``--json``, ``--quiet`` and ``--plugin``."""

    def run(*, as_json: bool, silently: bool, plugins: list[str] | None, **arguments: Any) -> None:
        output = Output(as_json, silently, plugins=tuple(plugins or ()))
        token = _CURRENT.set(output)
        if silently:
            logging.getLogger("amble").setLevel(logging.ERROR)
        try:
            load_plugins(plugins or ())
            command(**arguments)
        except AmbleError as error:
            _finish(command.__name__, output, error.exit_code, error)
            raise
        except KeyboardInterrupt as error:
            _finish(command.__name__, output, INTERRUPTED, error)
            raise
        else:
            _finish(command.__name__, output, 0, None)
        finally:
            _CURRENT.reset(token)

    functools.update_wrapper(run, command)
    del run.__dict__["__wrapped__"]  # else its signature would be taken for that of ``run``
    hints = {**get_type_hints(command, include_extras=True), "as_json": _JSON, "silently": _QUIET, "plugins": _PLUGINS}
    own = [each.replace(annotation=hints[each.name]) for each in inspect.signature(command).parameters.values()]
    added = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hints[name])
        for name, default in (("as_json", False), ("silently", False), ("plugins", None))
    ]
    run.__annotations__ = hints
    run.__signature__ = inspect.Signature([*own, *added])  # type: ignore[attr-defined]
    return run


_JSON = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output and nothing else.")]
_QUIET = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors: no progress, no results.")]

_PLUGINS = Annotated[
    list[str] | None,
    typer.Option(
        "--plugin", help="Module, or Python file, that registers kinds of its own; may be repeated.", show_default=False
    ),
]


def _finish(command: str, output: Output, exit_code: int, error: BaseException | None) -> None:
    if not output.json:
        return
    failure = None if error is None else {"kind": type(error).__name__, "message": str(error) or "interrupted"}
    tree = {
        "command": command,
        "exit_code": exit_code,
        "error": failure,
        "wrote": [str(path) for path in output.files],
        **output.found,
    }
    typer.echo(json.dumps(plain(tree), indent=2, allow_nan=False))


def plain(value: Any) -> Any:
    """Return a tree as plain JSON; a number that is not finite becomes None, anything unknown its text."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value) if math.isfinite(value) else None
    return str(value)
