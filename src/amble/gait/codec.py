"""The description of a gait file: the key, unit and shape of everything that a gait is, for writing and for reading.

Grounds, contacts, phases, allocation laws and costs are written and read by their registries, open from outside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from amble.control import PHASES, DomainOutputs, Outputs, Phase
from amble.control.allocation.registry import LAWS
from amble.control.outputs import controllable
from amble.errors import InputError
from amble.gait.control_law import CONTROL_LAWS
from amble.gait.cost import COSTS, TORQUE_SQUARED, Cost
from amble.gait.impedance import Impedance  # noqa: F401  (registers it)
from amble.gait.limits_codec import limits_codec
from amble.gait.linearising_law import LINEARISATION, InputOutputLinearisation
from amble.gait.record import DomainTrajectory, Feedback, Gait, LagrangeMultipliers, SolverReport
from amble.gait.style import Style  # noqa: F401  (registers it)
from amble.hybrid import CONTACTS, GROUNDS, Contact, GaitPattern, Ground, gait_pattern
from amble.hybrid.landing import LANDING_RULES, SIMULTANEOUS
from amble.io.codec import (
    FLAG,
    TEXT,
    ByName,
    Codec,
    Count,
    Field,
    ListOf,
    Named,
    NameIn,
    Optional,
    Record,
)
from amble.io.quantities import Array, Columns, Number
from amble.numerics.collocation import STAGES
from amble.robot import Robot
from amble.robot.coordinate_units import load_units, units
from amble.robot.files import ROBOT
from amble.types import Json

GAINS = {"position_gain": Number("1/s^2"), "velocity_gain": Number("1/s")}
RULES = {rule: Record(dict, {}) for rule in LANDING_RULES}


def pattern_codec(robot: Robot, ground: Ground, contact: Contact) -> Record:
    """Describe the table of stances of a robot on its ground, its landing rule not yet known."""
    return Record(
        lambda name, mirrored, stances: gait_pattern(robot, stances, mirrored, name, ground, contact, SIMULTANEOUS),
        {"name": TEXT, "mirrored": FLAG, "stances": ListOf(ListOf(NameIn("foot", robot.foot_names)))},
        take=lambda pattern: {**vars(pattern), "stances": [stance.feet for stance in pattern.stances]},
    )


def outputs_codec(pattern: GaitPattern, phase: Phase) -> Record:
    """Describe the outputs of the solved domains of a pattern, without their phase."""
    names = ListOf(NameIn("coordinate", controllable(pattern.robot)))

    def build(order: int, domains: Mapping[str, tuple[str, ...]]) -> Outputs:
        for name, coordinates in domains.items():
            if len(set(coordinates)) != len(coordinates):
                raise InputError(f"the outputs of domain '{name}' in the gait file repeat a coordinate")
        return Outputs(tuple(DomainOutputs(name, domains[name]) for name in solved(pattern)), order, phase)

    return Record(
        build,
        {"order": Count(least=1), "domains": ByName("domain", dict.fromkeys(solved(pattern), names), complete=True)},
        take=lambda outputs: {
            "order": outputs.order,
            "domains": {entry.domain: entry.coordinates for entry in outputs.domains},
        },
    )


class ControlLawCodec(Codec):
    """The gait problem's gains, which input-output linearisation has for its parameters, and any other feedback law.

    The value is the gains and the law, None where it is input-output linearisation with these gains.
    """

    def encode(self, value: Any, place: str) -> Json:
        """Write name, parameters of a law that is not the default, gains."""
        gains, law = value
        if law is not None and law.name == LINEARISATION:
            raise InputError(f"{place}: {LINEARISATION} has the gains of the gait; give those instead of a control law")
        named = {"name": LINEARISATION} if law is None else CONTROL_LAWS.encode(law, place)
        return {**named, **Record(dict, GAINS).encode(dict(zip(GAINS, gains, strict=True)), place)}

    def decode(self, entry: Any, place: str) -> Any:
        """Read gains and law."""
        if not isinstance(entry, dict) or "name" not in entry:
            raise InputError(f"{place} is not an object with a 'name'")
        name = NameIn("control law", CONTROL_LAWS).decode(entry["name"], place)
        own = {key: value for key, value in entry.items() if key not in GAINS}
        parameters: Json = {} if name == LINEARISATION else {"parameters": Record(dict, {}, open=True)}
        found = Record(dict, {"name": TEXT, **parameters, **GAINS}).decode(entry, place)
        gains = tuple(found[key] for key in GAINS)
        return gains, None if name == LINEARISATION else CONTROL_LAWS.decode(own, place)


def mesh_codec(pattern: GaitPattern) -> Named:
    """Describe the collocation mesh of every solved domain: the scheme, by its name, and the intervals."""
    counts = dict.fromkeys(solved(pattern), Count(least=1, most=100_000))
    intervals = Record(dict, {"intervals": ByName("domain", counts, complete=True)})
    return Named("mesh", dict.fromkeys(STAGES, intervals))


def domains_codec(pattern: GaitPattern, outputs: Outputs, mesh: Json) -> ByName:
    """Describe the motion in the solved domains; columns of the motion are the coordinates in the robot's order."""
    robot = pattern.robot
    names, loads = robot.coordinate_names, load_units(robot, robot.joint_names)

    def torques(nodes: int) -> Array:
        return Array("N m", nodes, len(loads)) if set(loads) <= {"N m"} else Columns(loads, nodes)

    numbers = dict.fromkeys(_phase_keys(outputs.phase), _phase_numbers(outputs.phase))
    codecs: dict[str, Codec] = {}
    for switch in pattern.switches:
        name = switch.source.name
        controlled = outputs.of(name).coordinates
        nodes = (STAGES[mesh["name"]] - 1) * int(mesh["intervals"][name]) + 1
        codecs[name] = Record(
            dict,
            {
                "duration": Number("s", positive=True),
                "coefficients": Array(_unit(robot, controlled), len(controlled), outputs.order + 1),
                "times": Array("s", nodes),
                "positions": Columns(units(robot, names), nodes),
                "velocities": Columns(units(robot, names, "/s"), nodes),
                "accelerations": Columns(units(robot, names, "/s^2"), nodes),
                "torques": torques(nodes),
                "forces": Array("N", nodes, pattern.contacts(switch.source).size),
                "impulse": Array("N s", pattern.contacts(switch.target).size if switch.landing else 0),
                **numbers,
            },
            take=vars,
        )
    return ByName("domain", codecs, complete=True)


def feedback_codec(pattern: GaitPattern, outputs: Outputs) -> Record:
    """Describe the stabilised outputs."""
    robot, names = pattern.robot, pattern.robot.coordinate_names
    observed = len(controllable(robot))
    weight = "1" if "m" not in (unit := _unit(robot, controllable(robot))) else f"{unit} by {unit}"
    weights = {name: Array(weight, len(outputs.of(name).coordinates), observed) for name in solved(pattern)}
    references = dict.fromkeys(solved(pattern), Array(unit, observed, None))
    durations = dict.fromkeys(solved(pattern), Number("s", positive=True))
    numbers = ByName("domain", dict.fromkeys(solved(pattern), _phase_numbers(outputs.phase)), complete=True)
    return Record(
        Feedback,
        {
            "references": ByName("domain", references, complete=True),
            "weights": ByName("domain", weights, complete=True),
            "durations": ByName("domain", durations, complete=True),
            "start": Columns([*units(robot, names), *units(robot, names, "/s")]),
            **dict.fromkeys(_phase_keys(outputs.phase), numbers),
        },
    )


def _unit(robot: Robot, names: Sequence[str]) -> str:
    """Unit of numbers of several coordinates in one array: ``rad``, or ``rad, m`` where some slide."""
    return ", ".join(dict.fromkeys(units(robot, names)))


def _phase_keys(phase: Phase) -> tuple[str, ...]:
    """The key of a phase's numbers, where it has any."""
    return ("phase_numbers",) if phase.numbers else ()


def _phase_numbers(phase: Phase) -> Columns:
    return Columns([number.unit for number in phase.numbers])


def solved(pattern: GaitPattern) -> list[str]:
    """Return the names of the domains that a file holds."""
    return [stance.name for stance in pattern.solved]


def solver_codec(cost: Cost) -> Record:
    """Describe the solver's report; its objective has the unit of the cost."""
    return Record(
        SolverReport,
        {
            "solver": TEXT,
            "status": TEXT,
            "iterations": Count(),
            "seconds": Number("s"),
            "variables": Count(),
            "constraints": Count(),
            "violation": Number("scaled"),
            "objective": Number(cost.unit),
            "linear_solver": Optional(TEXT),
        },
    )


def _multipliers(report: SolverReport) -> Optional:
    """One multiplier a variable and one a row of the program."""
    fields = {"bounds": Array("scaled", report.variables), "rows": Array("scaled", report.constraints)}
    return Optional(Record(LagrangeMultipliers, fields))


GAIT_FIELDS: Mapping[str, Field] = {
    "versions": ByName("package", TEXT),
    "robot": ROBOT,
    "ground": GROUNDS,
    "contact": CONTACTS,
    "pattern": lambda known: pattern_codec(known["robot"], known["ground"], known["contact"]),
    "phase": PHASES,
    "outputs": lambda known: outputs_codec(known["pattern"], known["phase"]),
    "control_law": ControlLawCodec(),
    "allocation_law": LAWS,
    "landing_rule": Named("landing rule", RULES),
    "speed": Number("m/s"),
    "lateral_speed": Optional(Number("m/s")),
    "yaw_rate": Optional(Number("rad/s")),
    "limits": lambda known: limits_codec(known["pattern"]),
    "mesh": lambda known: mesh_codec(known["pattern"]),
    "domains": lambda known: domains_codec(known["pattern"], known["outputs"], known["mesh"]),
    "cost": Optional(COSTS),
    "solver": lambda known: solver_codec(known["cost"] or TORQUE_SQUARED),
    "feedback": lambda known: Optional(feedback_codec(known["pattern"], known["outputs"])),
    "multipliers": lambda known: _multipliers(known["solver"]),
}


def _take(gait: Gait) -> Json:
    """Return the parts of a gait as the file divides them."""
    return {
        **vars(gait),
        "robot": gait.robot,
        "ground": gait.pattern.ground,
        "contact": gait.pattern.contact,
        "phase": gait.outputs.phase,
        "control_law": (gait.gains, None if gait.control == InputOutputLinearisation(*gait.gains) else gait.control),
        "allocation_law": gait.law,
        "landing_rule": {"name": gait.pattern.landing_rule},
        "lateral_speed": gait.lateral_speed or None,
        "yaw_rate": gait.yaw_rate or None,
        "cost": None if gait.cost == TORQUE_SQUARED else gait.cost,
        "limits": gait.limits,
        "mesh": {
            "name": gait.scheme,
            "intervals": {domain.name: domain.intervals for domain in gait.domains},
        },
        "domains": {domain.name: domain for domain in gait.domains},
    }


def _build(**parts: Any) -> Gait:
    """Put the parts of a file together."""
    gains, control = parts["control_law"]
    domains, scheme = parts["domains"], parts["mesh"]["name"]
    return Gait(
        pattern=replace(parts["pattern"], landing_rule=parts["landing_rule"]["name"]),
        outputs=parts["outputs"],
        law=parts["allocation_law"],
        speed=parts["speed"],
        lateral_speed=parts["lateral_speed"] or 0.0,
        yaw_rate=parts["yaw_rate"] or 0.0,
        gains=gains,
        limits=parts["limits"],
        domains=tuple(DomainTrajectory(name=name, scheme=scheme, **domains[name]) for name in solved(parts["pattern"])),
        solver=parts["solver"],
        feedback=parts["feedback"],
        versions=parts["versions"],
        multipliers=parts["multipliers"],
        cost=parts["cost"] or TORQUE_SQUARED,
        control=control,
    )


GAIT = Record(_build, GAIT_FIELDS, take=_take)
"""The whole file but for format and format version; codecs that need a part find it before them."""
