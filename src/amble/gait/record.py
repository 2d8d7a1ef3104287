"""The gait: synthesis writes it; check, simulation, stability and metrics read it; no solver is needed to use it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from amble.control import AllocationLaw, Outputs
from amble.gait.command import Command
from amble.gait.cost import TORQUE_SQUARED, Cost
from amble.gait.limits import Limits
from amble.gait.validation import check_feedback, check_gait, check_trajectory
from amble.hybrid import GaitPattern
from amble.io.facts import facts_html
from amble.names import check_name
from amble.numerics.collocation import HERMITE_SIMPSON, STAGES
from amble.robot import Robot
from amble.types import Matrix, NodeValues, Vector, frozen

if TYPE_CHECKING:
    from amble.gait.control_law import ControlLaw


@dataclass(frozen=True, kw_only=True)
class DomainTrajectory:
    """The optimised motion in one solved domain, at the nodes of its collocation intervals.

    Attributes:
        name: the domain.
        duration: s.
        coefficients: Bezier coefficients of the outputs, (n_y, order + 1), rad.
        times: clock at the nodes, (n,), s; the first is 0, the last the duration.
        positions: q, (n, n_q), m and rad.
        velocities: (n, n_q).
        accelerations: (n, n_q).
        torques: u, (n, n_joints), N m, or N of prismatic joints.
        forces: contact forces of the stance feet in the robot's foot order, world frame, (n, n_f), N.
        impulse: contact impulse of the feet of the next stance at the end of this domain, world frame, N s; empty
            where no foot lands.
        phase_numbers: what the phase of the outputs needs beside the duration, (k,); time needs nothing.
        scheme: name of the collocation scheme whose nodes these are.
    """

    name: str
    duration: float
    coefficients: Matrix
    times: Vector
    positions: NodeValues
    velocities: NodeValues
    accelerations: NodeValues
    torques: NodeValues
    forces: NodeValues
    impulse: Vector
    phase_numbers: Vector = field(default_factory=lambda: frozen([]))
    scheme: str = HERMITE_SIMPSON

    def __post_init__(self) -> None:
        """Check that the numbers fit together; errors as in ``validation.check_trajectory``."""
        check_trajectory(self)

    @property
    def intervals(self) -> int:
        """Number of collocation intervals."""
        return (self.times.size - 1) // (STAGES[self.scheme] - 1)


@dataclass(frozen=True, kw_only=True)
class Feedback:
    """Outputs re-weighted for stability: y = H (y_a - y_d) (docs/theory/virtual-constraints.md, eq. 1).

    y_a = (roll, pitch, yaw, joints).

    Attributes:
        references: solved domain -> Bezier coefficients of y_d over the phase, on the closed loop's own orbit,
            (n_a, order + 1).
        weights: solved domain -> H, (n_y, n_a).
        durations: solved domain -> duration of the closed loop's own orbit, s.
        start: the fixed point (q, v) at the entry of the first domain, (2 n_q,).
        phase_numbers: solved domain -> what the phase needs beside the duration, on the closed loop's own orbit, (k,);
            empty where it needs nothing.
    """

    references: Mapping[str, Matrix]
    weights: Mapping[str, Matrix]
    durations: Mapping[str, float]
    start: Vector
    phase_numbers: Mapping[str, Vector] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that durations are positive and numbers finite; errors as in ``validation.check_feedback``."""
        check_feedback(self)


@dataclass(frozen=True, kw_only=True)
class SolverReport:
    """How a gait was found: solver status, iterations, wall time in s, problem size, largest violation, objective.

    The linear solver is what solved the solver's linear systems, and why where it was not its first choice; None where
    that is not known.
    """

    solver: str
    status: str
    iterations: int
    seconds: float
    variables: int
    constraints: int
    violation: float
    objective: float
    linear_solver: str | None = None

    def __post_init__(self) -> None:
        """Check the texts."""
        check_name("solver", self.solver)
        check_name("solver's status", self.status)
        if self.linear_solver is not None:
            check_name("linear solver", self.linear_solver)


@dataclass(frozen=True)
class LagrangeMultipliers:
    """Lagrange multipliers of the scaled program at the solution, from which a neighbouring problem starts.

    Attributes:
        bounds: of the bounds of the variables, (n_x,).
        rows: of the rows, (n_g,).
    """

    bounds: Vector
    rows: Vector


@dataclass(frozen=True, kw_only=True)
class Gait:
    """A periodic motion with the control law that realises it.

    Attributes:
        pattern: the cyclic table of stances, with the robot.
        outputs: controlled coordinates and Bezier order.
        law: the allocation law of the torques.
        speed: required mean forward velocity, m/s.
        lateral_speed: required mean velocity to the left, m/s.
        yaw_rate: required mean rate of the heading, rad/s.
        gains: (K_p in 1/s^2, K_d in 1/s) of the output dynamics.
        limits: the bounds the gait was asked to keep.
        domains: the motion in the solved domains.
        solver: how it was found.
        feedback: the stabilised outputs, where ``amble.stabilize`` has run.
        versions: package name -> version that wrote the gait.
        multipliers: the solver's, where it left any.
        cost: what the gait problem minimised.
        control: the feedback law that walks it; input-output linearisation with ``gains`` where it is None.
    """

    pattern: GaitPattern
    outputs: Outputs
    law: AllocationLaw
    speed: float
    gains: tuple[float, float]
    limits: Limits
    domains: tuple[DomainTrajectory, ...]
    solver: SolverReport
    feedback: Feedback | None
    versions: Mapping[str, str]
    multipliers: LagrangeMultipliers | None = None
    cost: Cost = TORQUE_SQUARED
    control: ControlLaw | None = None
    lateral_speed: float = 0.0
    yaw_rate: float = 0.0

    def __post_init__(self) -> None:
        """Check that the parts fit robot, pattern and each other, and the texts that the records inside do not."""
        check_gait(self)
        for package, version in self.versions.items():
            check_name("package", package)
            check_name("version", version)

    @property
    def robot(self) -> Robot:
        """The robot that walks."""
        return self.pattern.robot

    @property
    def command(self) -> Command:
        """The velocities that were asked for."""
        return Command(forward=self.speed, lateral=self.lateral_speed, yaw_rate=self.yaw_rate)

    @property
    def scheme(self) -> str:
        """Name of the collocation scheme of its mesh."""
        return self.domains[0].scheme

    @property
    def period(self) -> float:
        """Duration of one whole gait cycle, s."""
        once = sum(domain.duration for domain in self.domains)
        return 2.0 * once if self.pattern.mirrored else once

    @property
    def turn(self) -> float:
        """Change of the heading in one whole gait cycle, rad."""
        return float(self.command.way(self.period)[2])

    def _repr_html_(self) -> str:
        """Show the gait in a notebook; ``amble.replay`` shows its motion."""
        report = self.solver
        peaks = [max(abs(domain.torques[:, j]).max() for domain in self.domains) for j in range(len(self.robot.joints))]
        largest: dict[str, str] = {}
        for what, unit, slides in (("torque", "N m", False), ("force of a joint", "N", True)):
            own = [peak for peak, joint in zip(peaks, self.robot.joints, strict=True) if joint.prismatic == slides]
            largest |= {f"largest {what}": f"{max(own):.4g} {unit}"} if own else {}
        return facts_html(
            f"{self.pattern.name} of {self.robot.name}",
            {
                "speed": f"{self.speed:g} m/s",
                "period": f"{self.period:.4f} s",
                "stances": ", ".join(stance.name for stance in self.pattern.stances),
                "allocation law": self.law.name,
                **largest,
                "cost": f"{report.objective:.6g} {self.cost.unit}",
                "solver": f"{report.solver}: {report.status}, {report.iterations} iterations, {report.seconds:.2f} s",
                "virtual constraints": "as optimised" if self.feedback is None else "re-weighted for stability",
            },
        )
