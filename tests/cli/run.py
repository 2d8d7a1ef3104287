"""Running the program in this process."""

from __future__ import annotations

import pytest

from amble.cli import main


def exit_code(*arguments: str) -> int:
    """Run ``amble ARGUMENTS`` and return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    code = ended.value.code
    return code if isinstance(code, int) else 0
