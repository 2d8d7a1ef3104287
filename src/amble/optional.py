"""Libraries that not everyone needs: each belongs to an extra of the package, and a missing one says how to install it.

The groups of pyproject.toml are what an extra installs. Here stands only how its absence is told.
"""

from __future__ import annotations

import importlib.util

from amble.errors import MissingExtraError


def require(library: str, extra: str, purpose: str) -> None:
    """Refuse work whose library is not installed; without importing it, so that asking early costs nothing.

    Args:
        library: its import name, such as "matplotlib".
        extra: the extra of amble that installs it.
        purpose: what needs it, the subject of a sentence, in the plural.

    Raises:
        MissingExtraError: where it is not installed.
    """
    if importlib.util.find_spec(library) is None:
        raise MissingExtraError(library, extra, purpose)
