"""From a robot description to a torque-minimal walking controller with a stability certificate.

Names are imported when they are first used, so that ``import amble`` costs nothing by itself. Editors and type checkers
read ``__init__.pyi`` instead, which names the same; a test holds the two equal.
"""

from __future__ import annotations

import importlib
from typing import Any

from amble.version import __version__

_HOME = {
    "ACTUATORS": "amble.control.actuator",
    "Actuator": "amble.control.actuator",
    "Adaptation": "amble.robot",
    "AllocationLaw": "amble.control.allocation",
    "AmbleError": "amble.errors",
    "BoundedMinimumNorm": "amble.control.allocation",
    "CONTACTS": "amble.hybrid",
    "CONTROL_LAWS": "amble.gait.control_law",
    "COSTS": "amble.gait.cost",
    "Certificate": "amble.stability",
    "CertificateError": "amble.errors",
    "CheckReport": "amble.verification.residuals",
    "Comparison": "amble.analysis",
    "Clearances": "amble.gait.clearances",
    "Contact": "amble.hybrid",
    "ContactBounds": "amble.analysis",
    "ContactReport": "amble.analysis",
    "ControlLaw": "amble.gait.control_law",
    "Cost": "amble.gait.cost",
    "DATASHEET": "amble.control.actuator",
    "Domain": "amble.hybrid",
    "DomainTrajectory": "amble.gait",
    "DropActuator": "amble.control.allocation",
    "ENGINES": "amble.simulation.walk",
    "Event": "amble.simulation",
    "FLAT": "amble.hybrid",
    "FallError": "amble.errors",
    "Feedback": "amble.gait",
    "FixedPoint": "amble.stability",
    "Footfall": "amble.hybrid",
    "GAITS": "amble.hybrid.gaits",
    "GROUNDS": "amble.hybrid",
    "Gait": "amble.gait",
    "GaitNotSolvedError": "amble.synthesis.synthesize",
    "GaitPattern": "amble.hybrid",
    "GaitProblem": "amble.synthesis",
    "Ground": "amble.hybrid",
    "HeightField": "amble.hybrid",
    "HybridSystem": "amble.hybrid",
    "Impedance": "amble.gait.impedance",
    "InputError": "amble.errors",
    "Invariant": "amble.hybrid",
    "LAWS": "amble.control",
    "LawChoice": "amble.analysis",
    "Library": "amble.workflow",
    "LibraryEntry": "amble.workflow",
    "Limits": "amble.gait",
    "MinimumPeak": "amble.control.allocation",
    "MinimumPower": "amble.control.allocation",
    "Monodromy": "amble.stability",
    "Motor": "amble.gait.clearances",
    "NotSolvedError": "amble.errors",
    "NotStabilizedError": "amble.stability.stabilize",
    "Outcome": "amble.synthesis",
    "Outputs": "amble.control",
    "PAPER": "amble.control.actuator",
    "PHASES": "amble.control",
    "Payload": "amble.robot",
    "Phase": "amble.control",
    "Plane": "amble.hybrid",
    "PlantErrors": "amble.gait.plant_errors",
    "PointContact": "amble.hybrid",
    "Posture": "amble.robot.catalogue",
    "Progress": "amble.progress",
    "ProgressReport": "amble.progress",
    "PseudoInverse": "amble.control.allocation",
    "Push": "amble.gait.unilateral_state",
    "READERS": "amble.robot",
    "ReplayPage": "amble.view",
    "ReferenceMotion": "amble.analysis",
    "Robot": "amble.robot",
    "Robustness": "amble.stability.robustness",
    "Run": "amble.workflow",
    "RunReport": "amble.report.run",
    "SOLVERS": "amble.synthesis.solve",
    "Specification": "amble.synthesis.specification",
    "Spectrum": "amble.stability",
    "Stance": "amble.hybrid",
    "Style": "amble.gait.style",
    "Symmetry": "amble.hybrid",
    "Table": "amble.report",
    "TimePhase": "amble.control",
    "TorqueSquared": "amble.gait.cost",
    "Trace": "amble.simulation",
    "Transition": "amble.hybrid",
    "TrialSettings": "amble.stability.robustness",
    "UnknownNameError": "amble.errors",
    "WeightedMinimumNorm": "amble.control.allocation",
    "WorkError": "amble.errors",
    "assess": "amble.stability",
    "build_library": "amble.workflow",
    "certify": "amble.stability",
    "check": "amble.verification.check",
    "closed_loop": "amble.gait.closed_loop",
    "compare_laws": "amble.analysis",
    "contact_report": "amble.analysis",
    "default_limits": "amble.synthesis",
    "errors": "amble.errors",
    "every_law": "amble.analysis",
    "export_controller": "amble.export",
    "exported_loop": "amble.export",
    "fixed_point": "amble.stability",
    "gait_pattern": "amble.hybrid",
    "gait_problem": "amble.synthesis",
    "gaits": "amble.hybrid.gaits",
    "imported_gait": "amble.synthesis.imported",
    "joint_outputs": "amble.control.outputs",
    "law_table": "amble.report",
    "load_gait": "amble.gait.files",
    "load_library": "amble.workflow",
    "load_robot": "amble.robot",
    "load_trace": "amble.simulation",
    "monitors": "amble.analysis",
    "monodromy": "amble.stability",
    "multipliers": "amble.stability",
    "paper_baseline": "amble.control.laws",
    "poincare_map": "amble.stability",
    "problem_of": "amble.synthesis.specified",
    "read_motion": "amble.gait.motion_files",
    "read_specification": "amble.synthesis.specification",
    "recorded_gait": "amble.gait.motion_files",
    "reference_motion": "amble.analysis",
    "refine": "amble.synthesis",
    "replay": "amble.view",
    "reproduce": "amble.workflow",
    "rewrite_report": "amble.workflow",
    "robots": "amble.robot.catalogue",
    "robustness": "amble.workflow.robustness",
    "save_gait": "amble.gait.files",
    "save_trace": "amble.simulation",
    "simulate": "amble.simulation",
    "stabilize": "amble.stability.stabilize",
    "stance_table": "amble.hybrid",
    "standing_posture": "amble.synthesis",
    "start_state": "amble.gait.closed_loop",
    "sweep": "amble.synthesis",
    "symmetrized": "amble.robot",
    "synthesize": "amble.synthesis",
    "synthesize_specification": "amble.workflow",
    "unilateral_loop": "amble.gait.unilateral_loop",
    "unilateral_start": "amble.gait.unilateral_state",
    "validate": "amble.validation",
    "write_motion": "amble.gait.motion_files",
    "write_reference": "amble.analysis",
    "write_run": "amble.report.run",
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
