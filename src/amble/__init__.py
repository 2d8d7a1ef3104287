"""From a robot description to a torque-minimal walking controller with a stability certificate.

Names are imported when they are first used, so that ``import amble`` costs nothing by itself.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "AllocationLaw": "amble.control.allocation",
    "DropActuator": "amble.control.allocation",
    "Gait": "amble.gait",
    "HybridSystem": "amble.hybrid",
    "Limits": "amble.gait",
    "PseudoInverse": "amble.control.allocation",
    "Robot": "amble.robot",
    "Trace": "amble.simulation",
    "check": "amble.gait.check",
    "errors": "amble.errors",
    "gaits": "amble.hybrid.gaits",
    "joint_outputs": "amble.control.outputs",
    "load_gait": "amble.gait.files",
    "load_robot": "amble.robot",
    "robots": "amble.robot.catalogue",
    "save_gait": "amble.gait.files",
    "simulate": "amble.simulation",
}
"""Public name -> module that holds it, or that it is."""

_MODULES = ("errors", "gaits", "robots")
"""Public names that are modules themselves."""

__all__ = ["__version__", *_HOME]  # noqa: PLE0604  (the names of the table)


def __getattr__(name: str) -> Any:
    """Import a public name from its home."""
    if name not in _HOME:
        raise AttributeError(f"module 'amble' has no attribute '{name}'; known: {', '.join(sorted(_HOME))}")
    module = importlib.import_module(_HOME[name])
    value = module if name in _MODULES else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
