"""Running the program in this process."""

from __future__ import annotations

import logging

import pytest

from amble.cli import main


def exit_code(*arguments: str) -> int:
    """Run ``amble ARGUMENTS`` and return its exit code."""
    logger = logging.getLogger("amble")
    handlers, level = logger.handlers, logger.level
    try:
        with pytest.raises(SystemExit) as ended:
            main(list(arguments))
    finally:
        logger.handlers, logger.level = handlers, level
    code = ended.value.code
    return code if isinstance(code, int) else 0
