"""The impedance law as C99 for motor drivers: tables, no model, joints and contacts as the only sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.export.code import build_rules, filled, template
from amble.export.law import YOUNG, numbers, speed_limits, torque_limits, whole_numbers
from amble.export.stances import exported_stances, switch_tables
from amble.export.vectors import A_STANCE, DAMPING, DISTURBANCE, OK, SATURATED, SEED
from amble.gait import Gait
from amble.gait.impedance import HOLD, Impedance, references, unpacked
from amble.gait.landing_stances import landings
from amble.gait.linearising_law import control_of
from amble.numerics.pieces import ORDER
from amble.types import Matrix, Vector

LONGEST = 0.25
"""Longest step of the controller's clock, and of silence for its watchdog, as a share of the shortest domain."""

LATE, NOT_FINITE = 4, 32
"""Statuses of a step, as the header lists them."""

REAL = "AMBLE_REAL"


@dataclass(frozen=True, kw_only=True)
class DomainTable:
    """The packed parameters of one solved domain, or of a stance between landings, by their parts.

    See ``gait.impedance``.

    Attributes:
        duration: planned, s; between landings that of the next domain.
        end: of the pieces, s.
        hold: when the references stand still, s.
        stiffness: P, (n_joints,), N m/rad, or N/m of prismatic joints.
        damping: D, (n_joints,), N m s/rad, or N s/m.
        places: starts and half lengths of the pieces, (2, n), s.
        angles: coefficients, (n n_joints (ORDER + 1),), rad or m.
        torques: the same of the feed-forward, N m or N.
        packed: all of it.
    """

    duration: float
    end: float
    hold: float
    stiffness: Vector
    damping: Vector
    places: Matrix
    angles: Vector
    torques: Vector
    packed: Vector

    @classmethod
    def of(cls, packed: Vector, arms: Vector, duration: float) -> DomainTable:
        """Take packed parameters apart; arms are those of the robot's joints (``Robot.torque_arms``)."""
        ends, P, D, places, (angles, torques) = unpacked(packed, arms.size)
        return cls(
            duration=duration,
            end=float(ends[0]),
            hold=float(ends[1]),
            stiffness=P / arms**2,
            damping=D / arms**2,
            places=places,
            angles=angles.ravel(),
            torques=torques.ravel(),
            packed=packed,
        )


def impedance_texts(gait: Gait, control: Impedance, law: AllocationLaw | None) -> tuple[dict[str, str], dict[str, str]]:
    """Return what the templates leave open in code, and the test vectors: name -> text.

    Errors as in ``Impedance.numbers``.
    """
    arms = gait.robot.torque_arms
    domains = [
        DomainTable.of(entry.parameters, arms, float(entry.parameters[1]) / HOLD)
        for entry in control.numbers(gait, law)
    ]
    between = control.landing_numbers(gait, law)
    for stance, following in landings(gait):
        planned = domains[gait.pattern.solved.index(following)].duration
        domains.append(DomainTable.of(between[stance.name].parameters, arms, planned))
    peak, lines = vectors(gait, lambda law, _: domains[law], np.random.default_rng(SEED))
    return {**impedance_code(gait, [domains]), "AXES": "0"}, {"test_vectors.txt": "\n".join([repr(peak), *lines, ""])}


def impedance_code(gait: Gait, nodes: Sequence[Sequence[DomainTable]]) -> dict[str, str]:
    """Return what the templates leave open in code but for the axes: name -> text.

    Args:
        gait: the gait, or one of several with the same stances and window of lift-offs.
        nodes: the tables of every gait, in the order of the grid.
    """
    earliest, latest = control_of(gait).lift_offs or (0.0, math.inf)
    return {
        "JOINT_COUNT": str(len(gait.robot.joints)),
        "FOOT_COUNT": str(len(gait.robot.feet)),
        "GAIT_STANCES": str(len(gait.pattern.stances)),
        "STANCE_COUNT": str(len(gait.pattern.visited)),
        "HOLD": f"{HOLD:g}",
        "EARLIEST_LIFT_OFF": repr(float(earliest)),
        "LATEST_LIFT_OFF": repr(float(latest)) if math.isfinite(latest) else "HUGE_VAL",
        "LONGEST": repr(LONGEST * min(domain.duration for domains in nodes for domain in domains)),
        "DAMPING": repr(DAMPING),
        "TABLES": _tables(gait, nodes),
    }


def impedance_files(code: Mapping[str, str], comments: Mapping[str, str], content: str) -> dict[str, str]:
    """File name -> text of the controller with a content id, without the test vectors."""
    test = filled(template("same_export.c"), {"CONTENT": content})
    inside = {**code, "CONTENT": content}
    return {
        "amble_controller.h": filled(template("impedance.h"), inside, comments),
        "amble_controller.c": filled(template("impedance.c"), inside, comments) + test,
        "replay.c": template("impedance_replay.c"),
        "CMakeLists.txt": build_rules([]),
    }


def _tables(gait: Gait, nodes: Sequence[Sequence[DomainTable]]) -> str:
    robot, pattern, domains = gait.robot, gait.pattern, nodes[0]
    first = np.cumsum([0, *(domain.places.shape[1] for domain in domains)])
    joints = robot.mirror.joints if pattern.mirrored else None
    index = np.arange(len(robot.joints)) if joints is None else joints.index
    sign = np.ones(len(robot.joints)) if joints is None else joints.sign

    def table(name: str, part: Callable[[DomainTable], float | Vector]) -> str:
        values = np.concatenate([np.ravel(part(domain)) for each in nodes for domain in each])
        return numbers(name, str(values.size), values, REAL)

    return "\n".join(
        [
            f"#define LAWS {len(domains)}",
            f"#define COEFFICIENTS {ORDER + 1}",
            f"#define YOUNG {YOUNG!r}",
            f"#define PIECES {first[-1]}",
            "#define CURVES (PIECES * AMBLE_JOINTS * COEFFICIENTS)",
            "",
            *switch_tables(gait),
            *(["/* In what follows one gait after the other, in the order of the grid. */"] if len(nodes) > 1 else []),
            "/* Planned duration, end of the curves, and when the references stand still, s. */",
            table("DURATION", lambda domain: domain.duration),
            table("END", lambda domain: domain.end),
            table("HOLD", lambda domain: domain.hold),
            "/* Pieces of a law: FIRST[law] up to FIRST[law + 1]; their begin and half length, s. */",
            whole_numbers("FIRST", "LAWS + 1", first),
            table("BEGINS", lambda domain: domain.places[0]),
            table("HALVES", lambda domain: domain.places[1]),
            "/* Coefficients of the powers of xi, -1 to 1 over a piece: piece by piece, joint by joint; rad, N m. */",
            table("ANGLES", lambda domain: domain.angles),
            table("TORQUES", lambda domain: domain.torques),
            "/* Law by law, joint by joint: N m/rad, N m s/rad. */",
            table("STIFFNESS", lambda domain: domain.stiffness),
            table("DAMPING", lambda domain: domain.damping),
            numbers("TORQUE_LIMIT", "AMBLE_JOINTS", torque_limits(gait), REAL),
            numbers("SPEED_LIMIT", "AMBLE_JOINTS", speed_limits(gait), REAL),
            "/* The left-right mirror: a -> sign * a[index]. */",
            whole_numbers("JOINT_INDEX", "AMBLE_JOINTS", index),
            numbers("JOINT_SIGN", "AMBLE_JOINTS", sign, REAL),
            "",
        ]
    )


def vectors(
    gait: Gait,
    table: Callable[[int, float], DomainTable],
    generator: np.random.Generator,
    commands: Sequence[float] = (),
) -> tuple[float, list[str]]:
    """Return the largest torque of the references, and a line a call: stance, commands, clock, angles, rates, answer.

    Clocks go on beyond the curves, but where the controller ends a stance itself before that.

    Args:
        gait: the gait.
        table: of a law by its place, at a clock in s.
        generator: of the disturbances.
        commands: with which the controller enters.
    """
    joints, lines, peak = len(gait.robot.joints), list[str](), 0.0
    for number, entry in enumerate(exported_stances(gait)):
        last = table(entry.law, math.inf)
        t, p = ca.SX.sym("t"), ca.SX.sym("p", last.packed.size)
        function = ca.Function("references", [t, p], list(references(p, joints, t)))
        latest = 0.98 * (control_of(gait).lift_offs or (0.0, math.inf))[1] if entry.lifts else math.inf
        for clock in map(float, np.linspace(0.0, min(1.02 * last.hold, latest * last.duration), A_STANCE)):
            here = table(entry.law, clock)
            answer = [np.asarray(part).ravel() for part in function(clock, here.packed)]
            answer += [here.stiffness, here.damping]
            if entry.mirrored:
                mirror = gait.robot.mirror.joints
                answer = [mirror(part) for part in answer[:3]] + [part[mirror.index] for part in answer[3:]]
            peak = max(peak, float(np.abs(answer[2]).max()))
            stance = " ".join([str(number), *(repr(float(value)) for value in commands)])
            lines.append(_line(gait, stance, clock, here, answer, generator))
    return peak, lines


def _line(
    gait: Gait, stance: str, clock: float, table: DomainTable, answer: list[Vector], generator: np.random.Generator
) -> str:
    angle, rate, torque, stiffness, damping = answer
    q = angle + DISTURBANCE * generator.normal(size=angle.size)
    qd = rate + 10.0 * DISTURBANCE * generator.normal(size=angle.size)
    whole = torque - stiffness * (q - angle) - damping * (qd - rate)
    limit = torque_limits(gait)
    status = (SATURATED if np.any(np.abs(whole) > limit) else OK) | (LATE if clock >= table.hold else OK)
    values = _flat([q, qd, angle, rate, torque, stiffness, damping, np.clip(whole, -limit, limit)])
    return " ".join([stance, repr(clock), *values, str(status)])


def _flat(parts: Sequence[Vector]) -> Iterator[str]:
    return (repr(float(value)) for part in parts for value in part)
