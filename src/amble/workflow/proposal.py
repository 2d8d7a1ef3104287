"""A robot, a gait and a speed are enough: the specification they make, short and with every default written out."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from amble.control.outputs import DomainOutputs
from amble.gait.limits import Interval, Limits
from amble.hybrid import SIMULTANEOUS, Plane
from amble.io.quantities import Measured
from amble.robot import Robot, catalogue
from amble.robot.loading import proposed_twins
from amble.robot.srdf import srdf_posture
from amble.synthesis.problem import GaitProblem
from amble.synthesis.specification import (
    PostureSection,
    RobotSection,
    SolverSection,
    Specification,
    specification_of,
)
from amble.synthesis.specified import robot_of

BASE = ("z", "roll", "pitch", "yaw")


def described(
    robot: str,
    feet: Mapping[str, str],
    gait: str,
    speed: float | str,
    symmetrize: bool | None = None,
    *,
    lateral_speed: float | str = 0.0,
    yaw_rate: float | str = 0.0,
    cost: tuple[str, Mapping[str, Any]] | None = None,
) -> Specification:
    """Return the specification of a robot's gait in which everything else has its default.

    Args:
        robot: a name of the catalogue, or a URDF file; a relative one starts from the working folder.
        feet: label -> link or joint of the file; of no use for a robot of the catalogue.
        gait: name of the gait.
        speed: m/s, or text with a unit.
        symmetrize: as in ``[robot]``.
        lateral_speed: to the left, m/s, or text with a unit.
        yaw_rate: rad/s, or text with a unit.
        cost: name of a registered cost and its parameters; the squared torques by default.

    Raises:
        InputError: a value cannot be used.
    """
    section: dict[str, Any] = {"name": robot}
    if robot not in catalogue.names():
        section = {
            "file": os.path.abspath(robot),
            "feet": dict(feet),
            "twins": [list(pair) for pair in proposed_twins(tuple(feet))],
        }
    if symmetrize is not None:
        section["symmetrize"] = symmetrize
    asked = {"name": gait, "speed": speed, "lateral_speed": lateral_speed, "yaw_rate": yaw_rate}
    whole: dict[str, Any] = {"robot": section, "gait": asked}
    if cost is not None:
        whole["cost"] = {"name": cost[0], "parameters": dict(cost[1])}
    return specification_of(whole, Path(robot).name)


def with_file_posture(specification: Specification) -> tuple[Specification, str]:
    """Return a specification that starts from the posture of the SRDF beside the robot's file, and where that is from.

    The same and an empty text where the robot is the catalogue's, a posture is given, or no file states one.
    """
    section = specification.robot
    if section.file is None or specification.posture is not None:
        return specification, ""
    found = srdf_posture(robot_of(section, Path()), section.file)
    if found is None:
        return specification, ""
    angles = {name: Measured(value) for name, value in found.posture.angles.items()}
    posture = PostureSection(height=found.posture.height, angles=angles)
    text = f"group state '{found.state}' of {found.file.name}"
    return specification.model_copy(update={"posture": posture}), text


def written(specification: Specification, problem: GaitProblem, folder: str | Path = ".") -> str:
    """Return the whole specification of a problem as a TOML file with comments, every default written out.

    Args:
        specification: the short one that ``described`` made.
        problem: its problem.
        folder: where the file will be; the robot's file is named from there.
    """
    gait, robot, solver = specification.gait, problem.pattern.robot, SolverSection()
    ground, limits = problem.pattern.ground, problem.limits
    friction = ground.friction if isinstance(ground, Plane) else specification.ground.friction
    lines = [
        f"# {problem.pattern.name.capitalize()} of {robot.name} at {problem.speed:g} m/s, every default written out.",
        '# A quantity is a plain SI number or text with its unit, such as "20 mm". A line that is deleted has the',
        "# default of the robot's size and weight again.",
        "",
        "[robot]",
        *_robot(specification, robot, folder),
        "",
        "[gait]",
        f"name = {_text(str(gait.name))}",
        f"speed = {problem.speed!r}  # mean forward velocity, m/s; negative backwards",
        f"lateral_speed = {problem.lateral_speed!r}  # to the left, m/s",
        f"yaw_rate = {problem.yaw_rate!r}  # of the heading, rad/s",
        f'landing_rule = {_text(problem.pattern.landing_rule)}  # of several feet; "{SIMULTANEOUS}" is an idealisation',
        "",
        "[ground]",
        f"friction = {friction!r}",
        "",
        "[outputs]",
        f"order = {problem.outputs.order}  # of the Bezier curves",
        f"position_gain = {problem.gains[0]!r}  # 1/s^2",
        f"velocity_gain = {problem.gains[1]!r}  # 1/s",
        "",
        "[outputs.free]  # joints that a domain leaves out: as many as it has internal forces, chosen by conditioning",
        *(f"{domain.domain} = {_texts(_left_out(robot, domain))}" for domain in problem.outputs.domains),
        "",
        "[law]",
        f"name = {_text(problem.law.name)}",
        "",
        "[cost]  # minimised: the squared torques, or a style whose weights make their own terms smaller",
        f"name = {_text(problem.cost.name)}",
        f"parameters = {_table(problem.cost.parameters)}",
        *(() if problem.cost.name == "style" else STYLE_EXAMPLE),
        "",
        *_limits(limits, problem),
        "",
        "[posture]  # where the solver starts: a level base and the joints",
        f"height = {problem.posture.height!r}  # m",
        "",
        f"[posture.angles]  # {_unit(robot, 'rad', 'm')}",
        *(f"{_key(name)} = {float(problem.posture.angles[name])!r}" for name in robot.joint_names),
        "",
        "[solver]",
        f"name = {_text(solver.name)}",
        f"intervals = {problem.intervals}  # of a domain; made finer where the check of the gait needs that",
        f"tolerance = {solver.tolerance!r}",
        f"iterations = {solver.iterations}",
    ]
    return "\n".join(lines) + "\n"


def _robot(specification: Specification, robot: Robot, folder: str | Path) -> list[str]:
    section = specification.robot
    if section.name is not None:
        return [f"name = {_text(section.name)}  # of the catalogue"]
    feet = ", ".join(f"{_key(foot.name)} = {_text(foot.frame)}" for foot in robot.feet)
    twins = ", ".join(_texts(pair) for pair in robot.twins)
    symmetrize = section.symmetrize
    if symmetrize is None:
        symmetrize = not _as_read(section, robot)
    return [
        f"file = {_text(os.path.relpath(str(section.file), folder))}  # from the folder of this specification",
        f"feet = {{ {feet} }}  # label = link or joint; f and r: front and rear, l and r: left and right",
        f"twins = [{twins}]  # left and right",
        f"gravity = {robot.gravity!r}  # m/s^2",
        f"symmetrize = {str(symmetrize).lower()}  # whether left and right inertias are averaged",
        f"symmetry_tolerance = {robot.symmetry_tolerance!r}  # relative asymmetry that passes for none",
        *_adaptation(section),
    ]


ROTORS = {"rotor_inertias": "kg m^2 or kg", "dampings": "N m s/rad or N s/m", "dry_frictions": "N m or N"}
EXAMPLES = {
    "base": '"trunk"  # link that is the base',
    "payload": "{ mass = 1.0, position = [0.0, 0.0, 0.1] }  # kg, m; link = a link's name, where it is not the base",
    "rotor_inertia": "1e-3  # kg m^2 at every joint, in place of the file's",
    "damping": "0.1  # N m s/rad, likewise",
    "dry_friction": "0.1  # N m, likewise",
    "friction_width": "0.5  # rad/s over which dry friction changes its sign",
}
"""What may be changed of a file's robot and is not by default: written as comments."""


STYLE_EXAMPLE = ('# name = "style"', "# parameters = { power = 0.1, attitude = 10.0, touchdown_speed = 0.01 }")
"""Another cost, as comments."""


def _adaptation(section: RobotSection) -> list[str]:
    """What is different from the file's robot, and what may be."""
    lines = [
        f"locked = {_table(section.locked)}  # joint = angle, rad, or place, m, at which it is held",
        f"base_rotation = {_value(section.base_rotation)}  # of x forward, z up in the base link, rad",
        f"foot_offsets = {_table(section.foot_offsets)}  # foot = its point in the frame that it names, m",
        f"foot_radius = {section.foot_radius!r}  # m, of round feet",
        f"planar = {_value(section.planar)}  # whether the base moves in the plane of x and z alone",
        f"file_drives = {_value(section.file_drives)}  # whether the file's rotors, damping and dry friction are used",
        *(f"{key} = {_table(getattr(section, key))}  # joint = {unit}" for key, unit in ROTORS.items()),
    ]
    for key, example in EXAMPLES.items():
        given = getattr(section, key)
        if isinstance(given, BaseModel):
            given = given.model_dump(exclude_none=True)
        lines.append(f"# {key} = {example}" if given is None else f"{key} = {_value(given)}")
    return lines


def _table(entries: Mapping[str, Any]) -> str:
    inside = ", ".join(f"{_key(name)} = {_value(entry)}" for name, entry in entries.items())
    return f"{{ {inside} }}" if inside else "{}"


def _value(value: Any) -> str:
    """Return a value as TOML has it on one line."""
    if isinstance(value, Mapping):
        return _table(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return _text(value) if isinstance(value, str) else repr(value)


def _as_read(section: RobotSection, robot: Robot) -> bool:
    """Whether a robot is that of its section, not one with left and right averaged."""
    return robot_of(section, Path()) == robot


def _limits(limits: Limits, problem: GaitProblem) -> list[str]:
    robot = problem.pattern.robot
    tenth = round(0.1 * robot.leg_length, 6)
    touchdown = dict(zip("xyz", limits.touchdown_velocity, strict=True))
    return [
        "[limits]",
        f"clearance = {limits.clearance!r}  # m, of every swing foot at the middle of its swing",
        f"normal_force = {limits.normal_force!r}  # N, the least of every stance foot",
        *(
            []
            if limits.standing_force is None
            else [f"standing_force = {limits.standing_force!r}  # N, of feet that stay"]
        ),
        f"acceleration = {limits.acceleration!r}  # rad/s^2, of every angle; of lengths times the leg length",
        f"node_margins = {str(problem.node_margins).lower()}  # margins of positions, accelerations and forces",
        "",
        "[limits.durations]  # of every domain, s",
        *_ranges(limits.durations),
        "",
        "[limits.base]  # z above the ground, m; angles, rad",
        *_ranges({name: limits.positions[name] for name in BASE if name in limits.positions}),
        "",
        f"[limits.joints]  # {_unit(robot, 'rad', 'm')}",
        *_ranges({name: limits.positions[name] for name in robot.joint_names if name in limits.positions}),
        "",
        f"[limits.speeds]  # {_unit(robot, 'rad/s', 'm/s')}",
        *_sizes(limits.speeds),
        "",
        f"[limits.torques]  # {_unit(robot, 'N m', 'N')}",
        *_sizes(limits.torques),
        "",
        "[limits.touchdown_velocity]  # of a landing foot just before the impact: forward, to the left, upward, m/s",
        *_ranges(touchdown),
        "",
        "# [limits.clearances]  # rows for parts that may touch; these are a tenth of the leg length",
        f"# knees = {tenth!r}  # m above the ground, joints of legs but for those that hang on the base",
        f"# corners = {tenth!r}  # m above the ground, lower corners of the base's box",
        "# box = [0.3, 0.2, 0.1]  # m, lengths of the box about the base's origin",
        f"# legs = {tenth!r}  # m, of left feet and joints from their right twins",
        "",
        "# [limits.motor]  # line of torque over speed of all motors; of single ones in [limits.motors], by joint",
        '# stall_torque = "40 N m"',
        '# no_load_speed = "30 rad/s"',
    ]


def _unit(robot: Robot, turning: str, sliding: str) -> str:
    """Return the unit of numbers of joints, as a comment."""
    return f"{turning}; of joints that slide {sliding}" if any(j.prismatic for j in robot.joints) else turning


def _left_out(robot: Robot, outputs: DomainOutputs) -> list[str]:
    return [joint for joint in robot.joint_names if joint not in outputs.coordinates]


def _ranges(ranges: Mapping[str, Interval]) -> list[str]:
    finite = {name: (float(low), float(high)) for name, (low, high) in ranges.items() if isfinite(low + high)}
    return [f"{_key(name)} = [{low!r}, {high!r}]" for name, (low, high) in finite.items()]


def _sizes(sizes: Mapping[str, float]) -> list[str]:
    return [f"{_key(name)} = {float(size)!r}" for name, size in sizes.items() if isfinite(size)]


def _key(name: str) -> str:
    bare = name.replace("_", "").replace("-", "")
    return name if bare.isascii() and bare.isalnum() else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _texts(texts: Iterable[str]) -> str:
    return f"[{', '.join(map(_text, texts))}]"
