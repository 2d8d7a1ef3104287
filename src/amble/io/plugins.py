"""Modules of others: what registers kinds of its own, and objects that the command line names."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

from amble.errors import InputError, shown


def load_plugins(named: Iterable[str]) -> None:
    """Import modules, each by its name or as a Python file; what they register can be named from then on.

    Raises:
        InputError: in one sentence, where there is no such module or it cannot be imported.
    """
    for name in named:
        try:
            _file(Path(name)) if name.endswith(".py") else importlib.import_module(name)
        except Exception as error:  # whatever the code of others raises
            reason = str(error) or type(error).__name__
            raise InputError(f"plugin '{shown(name)}' cannot be imported: {shown(reason, 300)}") from error


def named_object(text: str) -> Any:
    """Return what ``MODULE:NAME`` or ``FILE.py:NAME`` on the command line names.

    Raises:
        InputError: in one sentence, where there is no such thing.
    """
    module, mark, name = text.rpartition(":")
    if not (mark and module and name):
        raise InputError(f"'{shown(text)}' is not MODULE:NAME or FILE.py:NAME")
    try:
        loaded = _file(Path(module)) if module.endswith(".py") else importlib.import_module(module)
        return getattr(loaded, name)
    except Exception as error:  # whatever the code of others raises
        reason = str(error) or type(error).__name__
        raise InputError(f"'{shown(text)}' cannot be loaded: {shown(reason, 300)}") from error


def _file(path: Path) -> ModuleType:
    """Import a file as a module of its own name, once."""
    place = path.resolve()
    known = sys.modules.get(path.stem)
    if known is not None and getattr(known, "__file__", None) == str(place):
        return known
    if known is not None or importlib.util.find_spec(path.stem) is not None:
        raise InputError(f"there is another module of the name '{path.stem}'")
    spec = importlib.util.spec_from_file_location(path.stem, place)
    if spec is None or spec.loader is None:
        raise InputError("it is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[path.stem]
        raise
    return module
