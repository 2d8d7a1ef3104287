"""The public names with their types, for editors and type checkers; the table of ``__init__.py`` holds the same."""

from amble import errors as errors
from amble.analysis import Comparison as Comparison
from amble.analysis import ContactBounds as ContactBounds
from amble.analysis import ContactReport as ContactReport
from amble.analysis import LawChoice as LawChoice
from amble.analysis import ReferenceMotion as ReferenceMotion
from amble.analysis import compare_laws as compare_laws
from amble.analysis import contact_report as contact_report
from amble.analysis import every_law as every_law
from amble.analysis import monitors as monitors
from amble.analysis import reference_motion as reference_motion
from amble.analysis import write_reference as write_reference
from amble.control import LAWS as LAWS
from amble.control import PHASES as PHASES
from amble.control import Outputs as Outputs
from amble.control import Phase as Phase
from amble.control import TimePhase as TimePhase
from amble.control.actuator import ACTUATORS as ACTUATORS
from amble.control.actuator import DATASHEET as DATASHEET
from amble.control.actuator import PAPER as PAPER
from amble.control.actuator import Actuator as Actuator
from amble.control.allocation import AllocationLaw as AllocationLaw
from amble.control.allocation import BoundedMinimumNorm as BoundedMinimumNorm
from amble.control.allocation import DropActuator as DropActuator
from amble.control.allocation import MinimumPeak as MinimumPeak
from amble.control.allocation import MinimumPower as MinimumPower
from amble.control.allocation import PseudoInverse as PseudoInverse
from amble.control.allocation import WeightedMinimumNorm as WeightedMinimumNorm
from amble.control.laws import paper_baseline as paper_baseline
from amble.control.outputs import joint_outputs as joint_outputs
from amble.errors import AmbleError as AmbleError
from amble.errors import CertificateError as CertificateError
from amble.errors import FallError as FallError
from amble.errors import InputError as InputError
from amble.errors import NotSolvedError as NotSolvedError
from amble.errors import UnknownNameError as UnknownNameError
from amble.errors import WorkError as WorkError
from amble.export import export_controller as export_controller
from amble.export import exported_loop as exported_loop
from amble.gait import DomainTrajectory as DomainTrajectory
from amble.gait import Feedback as Feedback
from amble.gait import Gait as Gait
from amble.gait import Limits as Limits
from amble.gait.clearances import Clearances as Clearances
from amble.gait.clearances import Motor as Motor
from amble.gait.closed_loop import closed_loop as closed_loop
from amble.gait.closed_loop import start_state as start_state
from amble.gait.control_law import CONTROL_LAWS as CONTROL_LAWS
from amble.gait.control_law import ControlLaw as ControlLaw
from amble.gait.cost import COSTS as COSTS
from amble.gait.cost import Cost as Cost
from amble.gait.cost import TorqueSquared as TorqueSquared
from amble.gait.files import load_gait as load_gait
from amble.gait.files import save_gait as save_gait
from amble.gait.impedance import Impedance as Impedance
from amble.gait.motion_files import read_motion as read_motion
from amble.gait.motion_files import recorded_gait as recorded_gait
from amble.gait.motion_files import write_motion as write_motion
from amble.gait.plant_errors import PlantErrors as PlantErrors
from amble.gait.style import Style as Style
from amble.gait.unilateral_loop import unilateral_loop as unilateral_loop
from amble.gait.unilateral_state import Push as Push
from amble.gait.unilateral_state import unilateral_start as unilateral_start
from amble.hybrid import CONTACTS as CONTACTS
from amble.hybrid import FLAT as FLAT
from amble.hybrid import GROUNDS as GROUNDS
from amble.hybrid import Contact as Contact
from amble.hybrid import Domain as Domain
from amble.hybrid import Footfall as Footfall
from amble.hybrid import GaitPattern as GaitPattern
from amble.hybrid import Ground as Ground
from amble.hybrid import HeightField as HeightField
from amble.hybrid import HybridSystem as HybridSystem
from amble.hybrid import Invariant as Invariant
from amble.hybrid import Plane as Plane
from amble.hybrid import PointContact as PointContact
from amble.hybrid import Stance as Stance
from amble.hybrid import Symmetry as Symmetry
from amble.hybrid import Transition as Transition
from amble.hybrid import gait_pattern as gait_pattern
from amble.hybrid import gaits as gaits
from amble.hybrid import stance_table as stance_table
from amble.hybrid.gaits import GAITS as GAITS
from amble.progress import Progress as Progress
from amble.progress import ProgressReport as ProgressReport
from amble.report import Table as Table
from amble.report import law_table as law_table
from amble.report.run import RunReport as RunReport
from amble.report.run import write_run as write_run
from amble.robot import READERS as READERS
from amble.robot import Adaptation as Adaptation
from amble.robot import Payload as Payload
from amble.robot import Robot as Robot
from amble.robot import catalogue as robots
from amble.robot import load_robot as load_robot
from amble.robot import symmetrized as symmetrized
from amble.robot.catalogue import Posture as Posture
from amble.simulation import Event as Event
from amble.simulation import Trace as Trace
from amble.simulation import load_trace as load_trace
from amble.simulation import save_trace as save_trace
from amble.simulation import simulate as simulate
from amble.simulation.steering import Steered as Steered
from amble.simulation.walk import ENGINES as ENGINES
from amble.stability import Certificate as Certificate
from amble.stability import FixedPoint as FixedPoint
from amble.stability import Monodromy as Monodromy
from amble.stability import Spectrum as Spectrum
from amble.stability import assess as assess
from amble.stability import certify as certify
from amble.stability import fixed_point as fixed_point
from amble.stability import monodromy as monodromy
from amble.stability import multipliers as multipliers
from amble.stability import poincare_map as poincare_map
from amble.stability.robustness import Robustness as Robustness
from amble.stability.robustness import TrialSettings as TrialSettings
from amble.stability.stabilize import NotStabilizedError as NotStabilizedError
from amble.stability.stabilize import stabilize as stabilize
from amble.synthesis import GaitProblem as GaitProblem
from amble.synthesis import Outcome as Outcome
from amble.synthesis import default_limits as default_limits
from amble.synthesis import gait_problem as gait_problem
from amble.synthesis import refine as refine
from amble.synthesis import standing_posture as standing_posture
from amble.synthesis import sweep as sweep
from amble.synthesis import synthesize as synthesize
from amble.synthesis.imported import imported_gait as imported_gait
from amble.synthesis.solve import SOLVERS as SOLVERS
from amble.synthesis.specification import Specification as Specification
from amble.synthesis.specification import read_specification as read_specification
from amble.synthesis.specified import problem_of as problem_of
from amble.synthesis.synthesize import GaitNotSolvedError as GaitNotSolvedError
from amble.validation import validate as validate
from amble.verification.check import check as check
from amble.verification.residuals import CheckReport as CheckReport
from amble.view import ReplayPage as ReplayPage
from amble.view import replay as replay
from amble.workflow import Library as Library
from amble.workflow import LibraryEntry as LibraryEntry
from amble.workflow import Run as Run
from amble.workflow import Transitions as Transitions
from amble.workflow import build_library as build_library
from amble.workflow import load_library as load_library
from amble.workflow import load_transitions as load_transitions
from amble.workflow import reproduce as reproduce
from amble.workflow import rewrite_report as rewrite_report
from amble.workflow import steer as steer
from amble.workflow import synthesize_specification as synthesize_specification
from amble.workflow import transitions as transitions
from amble.workflow.front import Front as Front
from amble.workflow.front import FrontPoint as FrontPoint
from amble.workflow.front import front as front
from amble.workflow.robustness import robustness as robustness

__version__: str
__all__ = [
    "ACTUATORS",
    "CONTACTS",
    "CONTROL_LAWS",
    "COSTS",
    "DATASHEET",
    "ENGINES",
    "FLAT",
    "GAITS",
    "GROUNDS",
    "LAWS",
    "PAPER",
    "PHASES",
    "READERS",
    "SOLVERS",
    "Actuator",
    "Adaptation",
    "AllocationLaw",
    "AmbleError",
    "BoundedMinimumNorm",
    "Certificate",
    "CertificateError",
    "CheckReport",
    "Clearances",
    "Comparison",
    "Contact",
    "ContactBounds",
    "ContactReport",
    "ControlLaw",
    "Cost",
    "Domain",
    "DomainTrajectory",
    "DropActuator",
    "Event",
    "FallError",
    "Feedback",
    "FixedPoint",
    "Footfall",
    "Front",
    "FrontPoint",
    "Gait",
    "GaitNotSolvedError",
    "GaitPattern",
    "GaitProblem",
    "Ground",
    "HeightField",
    "HybridSystem",
    "Impedance",
    "InputError",
    "Invariant",
    "LawChoice",
    "Library",
    "LibraryEntry",
    "Limits",
    "MinimumPeak",
    "MinimumPower",
    "Monodromy",
    "Motor",
    "NotSolvedError",
    "NotStabilizedError",
    "Outcome",
    "Outputs",
    "Payload",
    "Phase",
    "Plane",
    "PlantErrors",
    "PointContact",
    "Posture",
    "Progress",
    "ProgressReport",
    "PseudoInverse",
    "Push",
    "ReferenceMotion",
    "ReplayPage",
    "Robot",
    "Robustness",
    "Run",
    "RunReport",
    "Specification",
    "Spectrum",
    "Stance",
    "Steered",
    "Style",
    "Symmetry",
    "Table",
    "TimePhase",
    "TorqueSquared",
    "Trace",
    "Transition",
    "Transitions",
    "TrialSettings",
    "UnknownNameError",
    "WeightedMinimumNorm",
    "WorkError",
    "__version__",
    "assess",
    "build_library",
    "certify",
    "check",
    "closed_loop",
    "compare_laws",
    "contact_report",
    "default_limits",
    "errors",
    "every_law",
    "export_controller",
    "exported_loop",
    "fixed_point",
    "front",
    "gait_pattern",
    "gait_problem",
    "gaits",
    "imported_gait",
    "joint_outputs",
    "law_table",
    "load_gait",
    "load_library",
    "load_robot",
    "load_trace",
    "load_transitions",
    "monitors",
    "monodromy",
    "multipliers",
    "paper_baseline",
    "poincare_map",
    "problem_of",
    "read_motion",
    "read_specification",
    "recorded_gait",
    "reference_motion",
    "refine",
    "replay",
    "reproduce",
    "rewrite_report",
    "robots",
    "robustness",
    "save_gait",
    "save_trace",
    "simulate",
    "stabilize",
    "stance_table",
    "standing_posture",
    "start_state",
    "steer",
    "sweep",
    "symmetrized",
    "synthesize",
    "synthesize_specification",
    "transitions",
    "unilateral_loop",
    "unilateral_start",
    "validate",
    "write_motion",
    "write_reference",
    "write_run",
]
