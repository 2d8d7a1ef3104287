"""Limits, domains, feedback and solver report inside a gait file; each is written and read side by side."""

from __future__ import annotations

from amble.control import Outputs
from amble.control.outputs import controllable
from amble.gait.limits import Limits
from amble.gait.record import DomainTrajectory, Feedback, LagrangeMultipliers, SolverReport
from amble.gait.units import unit_of, units
from amble.hybrid import GaitPattern
from amble.io.codec import Reader, quantity, table
from amble.robot import Robot
from amble.types import Json

LANDING_AXES = ("x", "y", "z")


def limits_tree(limits: Limits) -> Json:
    """Write the bounds."""
    return {
        "durations": {name: quantity(interval, "s") for name, interval in limits.durations.items()},
        "positions": {name: quantity(interval, unit_of(name)) for name, interval in limits.positions.items()},
        "speeds": {name: quantity(value, "rad/s") for name, value in limits.speeds.items()},
        "torques": {name: quantity(value, "N m") for name, value in limits.torques.items()},
        "acceleration": quantity(limits.acceleration, "m/s^2, rad/s^2"),
        "touchdown_velocity": {
            axis: quantity(interval, "m/s")
            for axis, interval in zip(LANDING_AXES, limits.touchdown_velocity, strict=True)
        },
        "normal_force": quantity(limits.normal_force, "N"),
        "clearance": quantity(limits.clearance, "m"),
    }


def limits_from(reader: Reader, pattern: GaitPattern) -> Limits:
    """Read the bounds."""
    reader.expect(
        "durations", "positions", "speeds", "torques", "acceleration", "touchdown_velocity",
        "normal_force", "clearance",
    )  # fmt: skip
    robot = pattern.robot
    durations = reader.inside("durations").expect_among("domain", [stance.name for stance in pattern.solved])
    positions = reader.inside("positions").expect_among("coordinate", robot.coordinate_names)
    speeds = reader.inside("speeds").expect_among("joint", robot.joint_names)
    torques = reader.inside("torques").expect_among("joint", robot.joint_names)
    landing = reader.inside("touchdown_velocity").expect(*LANDING_AXES)
    along_x, along_y, along_z = (landing.pair(axis, "m/s", infinite=True) for axis in LANDING_AXES)
    return Limits(
        durations={name: durations.pair(name, "s") for name in durations.names()},
        positions={name: positions.pair(name, unit_of(name), infinite=True) for name in positions.names()},
        speeds={name: speeds.number(name, "rad/s", infinite=True) for name in speeds.names()},
        torques={name: torques.number(name, "N m", infinite=True) for name in torques.names()},
        acceleration=reader.number("acceleration", "m/s^2, rad/s^2", infinite=True),
        touchdown_velocity=(along_x, along_y, along_z),
        normal_force=reader.number("normal_force", "N", infinite=True),
        clearance=reader.number("clearance", "m", infinite=True),
    )


def domain_tree(domain: DomainTrajectory, robot: Robot) -> Json:
    """Write the motion in one domain; columns of the motion are the coordinates in the robot's order."""
    names = robot.coordinate_names
    return {
        "duration": quantity(domain.duration, "s"),
        "coefficients": quantity(domain.coefficients, "rad"),
        "times": quantity(domain.times, "s"),
        "positions": table(domain.positions, units(names)),
        "velocities": table(domain.velocities, units(names, "/s")),
        "accelerations": table(domain.accelerations, units(names, "/s^2")),
        "torques": quantity(domain.torques, "N m"),
        "forces": quantity(domain.forces, "N"),
        "impulse": quantity(domain.impulse, "N s"),
    }


def domain_from(reader: Reader, name: str, pattern: GaitPattern, outputs: Outputs) -> DomainTrajectory:
    """Read the motion in one domain."""
    reader.expect(
        "duration", "coefficients", "times", "positions", "velocities", "accelerations", "torques", "forces", "impulse"
    )
    robot = pattern.robot
    names = robot.coordinate_names
    times = reader.array("times", "s", (None,))
    nodes = times.size
    switch = next(switch for switch in pattern.switches if switch.source.name == name)
    impulse = pattern.contacts(switch.target).size if switch.landing else 0
    return DomainTrajectory(
        name=name,
        duration=reader.number("duration", "s"),
        coefficients=reader.array("coefficients", "rad", (len(outputs.of(name).coordinates), outputs.order + 1)),
        times=times,
        positions=reader.columns("positions", units(names), nodes),
        velocities=reader.columns("velocities", units(names, "/s"), nodes),
        accelerations=reader.columns("accelerations", units(names, "/s^2"), nodes),
        torques=reader.array("torques", "N m", (nodes, len(robot.joints))),
        forces=reader.array("forces", "N", (nodes, pattern.contacts(pattern.stance(name)).size)),
        impulse=reader.array("impulse", "N s", (impulse,)),
    )


def feedback_tree(feedback: Feedback, robot: Robot) -> Json:
    """Write the stabilised outputs."""
    names = robot.coordinate_names
    return {
        "references": {name: quantity(value, "rad") for name, value in feedback.references.items()},
        "weights": {name: quantity(value, "1") for name, value in feedback.weights.items()},
        "durations": {name: quantity(value, "s") for name, value in feedback.durations.items()},
        "start": table(feedback.start, [*units(names), *units(names, "/s")]),
    }


def feedback_from(reader: Reader, pattern: GaitPattern, outputs: Outputs) -> Feedback:
    """Read the stabilised outputs."""
    reader.expect("references", "weights", "durations", "start")
    solved = [stance.name for stance in pattern.solved]
    references, weights = reader.inside("references").expect(*solved), reader.inside("weights").expect(*solved)
    durations = reader.inside("durations").expect(*solved)
    names = pattern.robot.coordinate_names
    observed = len(controllable(pattern.robot))
    return Feedback(
        references={name: references.array(name, "rad", (observed, None)) for name in solved},
        weights={name: weights.array(name, "1", (len(outputs.of(name).coordinates), observed)) for name in solved},
        durations={name: durations.number(name, "s") for name in solved},
        start=reader.columns("start", [*units(names), *units(names, "/s")], None),
    )


def multipliers_tree(multipliers: LagrangeMultipliers) -> Json:
    """Write the multipliers of the solution."""
    return {"bounds": quantity(multipliers.bounds, "scaled"), "rows": quantity(multipliers.rows, "scaled")}


def multipliers_from(reader: Reader, report: SolverReport) -> LagrangeMultipliers:
    """Read the multipliers of the solution: one a variable and one a row of the program."""
    reader.expect("bounds", "rows")
    return LagrangeMultipliers(
        bounds=reader.array("bounds", "scaled", (report.variables,)),
        rows=reader.array("rows", "scaled", (report.constraints,)),
    )


def solver_tree(report: SolverReport) -> Json:
    """Write how the gait was found."""
    return {
        "solver": report.solver,
        "status": report.status,
        "iterations": report.iterations,
        "seconds": quantity(report.seconds, "s"),
        "variables": report.variables,
        "constraints": report.constraints,
        "violation": quantity(report.violation, "scaled"),
        "objective": quantity(report.objective, "N^2 m^2"),
    }


def solver_from(reader: Reader) -> SolverReport:
    """Read how the gait was found."""
    reader.expect("solver", "status", "iterations", "seconds", "variables", "constraints", "violation", "objective")
    return SolverReport(
        solver=reader.text("solver"),
        status=reader.text("status"),
        iterations=reader.count("iterations"),
        seconds=reader.number("seconds", "s"),
        variables=reader.count("variables"),
        constraints=reader.count("constraints"),
        violation=reader.number("violation", "scaled"),
        objective=reader.number("objective", "N^2 m^2"),
    )
