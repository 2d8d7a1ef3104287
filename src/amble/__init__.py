"""From a robot description to a torque-minimal walking controller with a stability certificate.

Names are imported when they are first used, so that ``import amble`` costs nothing by itself.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Actuator": "amble.control.actuator",
    "AllocationLaw": "amble.control.allocation",
    "AmbleError": "amble.errors",
    "BoundedMinimumNorm": "amble.control.allocation",
    "Certificate": "amble.stability",
    "CertificateError": "amble.errors",
    "DATASHEET": "amble.control.actuator",
    "Domain": "amble.hybrid",
    "DropActuator": "amble.control.allocation",
    "FallError": "amble.errors",
    "Gait": "amble.gait",
    "GaitPattern": "amble.hybrid",
    "GaitProblem": "amble.synthesis",
    "HybridSystem": "amble.hybrid",
    "InputError": "amble.errors",
    "Invariant": "amble.hybrid",
    "Limits": "amble.gait",
    "MinimumPeak": "amble.control.allocation",
    "MinimumPower": "amble.control.allocation",
    "NotSolvedError": "amble.errors",
    "PAPER": "amble.control.actuator",
    "PseudoInverse": "amble.control.allocation",
    "Robot": "amble.robot",
    "Symmetry": "amble.hybrid",
    "Trace": "amble.simulation",
    "Transition": "amble.hybrid",
    "UnknownNameError": "amble.errors",
    "WeightedMinimumNorm": "amble.control.allocation",
    "WorkError": "amble.errors",
    "assess": "amble.stability",
    "certify": "amble.stability",
    "certify_gait": "amble.stability.gait_certificate",
    "check": "amble.verification.check",
    "closed_loop": "amble.gait.closed_loop",
    "compare_laws": "amble.report.assembly",
    "contact_report": "amble.analysis",
    "errors": "amble.errors",
    "export_controller": "amble.export",
    "exported_loop": "amble.export",
    "fixed_point": "amble.stability",
    "gait_pattern": "amble.hybrid",
    "gait_problem": "amble.synthesis",
    "gaits": "amble.hybrid.gaits",
    "joint_outputs": "amble.control.outputs",
    "law_table": "amble.report",
    "load_gait": "amble.gait.files",
    "load_robot": "amble.robot",
    "load_trace": "amble.simulation",
    "monodromy": "amble.stability",
    "multipliers": "amble.stability",
    "paper_baseline": "amble.control.laws",
    "poincare_map": "amble.stability",
    "problem_of": "amble.synthesis.specified",
    "read_specification": "amble.synthesis.specification",
    "robots": "amble.robot.catalogue",
    "save_gait": "amble.gait.files",
    "save_trace": "amble.simulation",
    "simulate": "amble.simulation",
    "simulate_gait": "amble.simulation",
    "stabilize": "amble.stability.stabilize",
    "start_state": "amble.gait.closed_loop",
    "synthesize": "amble.synthesis",
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
