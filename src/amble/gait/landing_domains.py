"""The closed loop where feet land one by one: a domain for the feet that have landed so far, in every order.

Between two landings the robot follows the curves of the stance that comes next, on their own clock or phase from the
first of the landings; the clock starts again when the last foot is down. The feet on the ground leave fewer directions
of internal force than that stance has, so as many joints more are controlled: of those that it leaves free, the ones
that the torques move best. Where both feet come down at once such a domain lasts no time, and the state behind it is
that of the impact on all feet (docs/theory/hybrid-model.md, eq. 20).
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from amble.control import AllocationLaw
from amble.control.closed_loop import Flow, landing_events, landing_flow
from amble.control.outputs import actuated_freedoms, controllable
from amble.control.phase import DomainPhase
from amble.control.stance_functions import ARGUMENTS
from amble.control.virtual_constraints import pack
from amble.errors import InputError
from amble.gait.constraints import REFERENCE_ORDER, numbers_of
from amble.gait.control_law import Numbers
from amble.gait.record import Gait
from amble.hybrid import Contacts, Domain, Stance, Switch, Transition, constrained_dynamics
from amble.hybrid.landing import steps
from amble.numerics.bezier import elevate
from amble.types import Matrix, Vector, frozen


def entering(gait: Gait, number: int) -> Switch:
    """Return the switch that enters the solved stance of a number."""
    return gait.pattern.all_switches[number - 1]


def landing_steps(gait: Gait, switch: Switch) -> tuple[Switch, ...]:
    """Return what the gait's rule makes of a switch; see ``hybrid.landing.steps``."""
    return steps(switch, gait.pattern.landing_rule, gait.robot.foot_names)


def between(gait: Gait, switch: Switch) -> tuple[Stance, ...]:
    """Return the stances between the landings of a switch."""
    sources = (step.source for step in landing_steps(gait, switch))
    return tuple(dict.fromkeys(stance for stance in sources if stance != switch.source))


def follows(step: Switch, switch: Switch, order: Sequence[str]) -> bool:
    """Whether a landing of a switch is part of an order of its feet."""
    landed = set() if step.source == switch.source else set(step.source.feet) & set(switch.landing)
    return landed == set(order[: len(landed)]) and step.landing[0] == order[len(landed)]


def linearised_landing(gait: Gait, law: AllocationLaw, number: int, stance: Stance) -> tuple[Flow, Numbers]:
    """Close the loop between landings into a solved stance by input-output linearisation.

    Args:
        gait: the gait.
        law: the allocation law.
        number: of the solved stance that follows.
        stance: the feet on the ground.
    """
    following, contacts = gait.pattern.solved[number], gait.pattern.contacts(stance)
    duration, references, weights, numbers = numbers_of(gait, following.name)
    weights = _completed(gait, number, contacts, weights)
    references = references + _lines(gait, number, numbers) * (gait.feedback is None)
    flow = landing_flow(contacts, law, following, len(weights), REFERENCE_ORDER, gait.outputs.phase)
    parameters = pack(duration, gait.gains, elevate(references, REFERENCE_ORDER), weights, numbers)
    breakpoints = gait.outputs.phase.breakpoints(following, duration)
    return flow, Numbers(parameters=frozen(parameters), breakpoints=breakpoints)


def landing_transition(
    gait: Gait, foot: str, down: Sequence[str], source: Domain, target: str, first: bool, mirrors: bool
) -> Transition:
    """Return the landing of one foot.

    Args:
        gait: the gait.
        foot: that lands.
        down: feet on the ground afterwards.
        source: the domain that it ends.
        target: name of the domain that follows.
        first: whether it is the first landing of its switch.
        mirrors: whether the state is mirrored after it.
    """
    robot = gait.robot
    gap, stopped = landing_events(gait.pattern.contacts(Stance(target, tuple(down))), foot)
    t, x, p = (ca.MX.sym(name, source.field.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    after = robot.mirror.state(stopped(x)) if mirrors else stopped(x)
    return Transition(
        source=source.name,
        target=target,
        guard=ca.Function("landing_gap", [t, x, p], [gap(x)], ARGUMENTS, ["guard"]),
        reset=ca.Function("landing_reset", [t, x, p], [after], ARGUMENTS, ["state"]),
        at_entry=not first,
    )


def _completed(gait: Gait, number: int, contacts: Contacts, weights: Matrix) -> Matrix:
    """Add rows for joints that no output controls until the stance's torques have none left, the best moved first."""
    robot = gait.robot
    wanted = actuated_freedoms(contacts)
    q = ca.SX.sym("q", robot.size)
    moved = ca.Function("moved", [q], [constrained_dynamics(contacts, q, ca.SX(robot.size, 1)).input_map[3:, :]])
    answer = np.asarray(moved(gait.domains[number].positions[0]))
    taken = set(gait.outputs.of(gait.pattern.solved[number].name).coordinates)
    names = controllable(robot)
    left = [place for place, name in enumerate(names) if name in robot.joint_names and name not in taken]
    while len(weights) < wanted:
        if not left:
            raise InputError(f"no joint is left to control while only {', '.join(contacts.feet)} have landed")
        known = np.linalg.qr((weights @ answer).T)[0]
        rest = [np.linalg.norm(row - known @ (known.T @ row)) / np.linalg.norm(row) for row in answer[left]]
        best = left.pop(int(np.argmax(rest)))
        weights = np.vstack([weights, np.eye(len(names))[best]])
    return weights


def _lines(gait: Gait, number: int, numbers: Vector) -> Matrix:
    """Curves of the joints that the gait problem does not control: straight on from the recorded entry, (n_a, 2)."""
    trajectory, stance, size = gait.domains[number], gait.pattern.solved[number], 3
    phase = DomainPhase(phase=gait.outputs.phase, robot=gait.robot, stance=stance)
    ends = slice(0, 1)
    _, pace = phase.along(
        trajectory.times[ends], trajectory.duration, trajectory.positions[ends], trajectory.velocities[ends], numbers
    )
    start, rate = trajectory.positions[0, size:], trajectory.velocities[0, size:] / pace[0]
    taken = set(gait.outputs.of(stance.name).coordinates)
    free = np.array([name not in taken for name in controllable(gait.robot)])
    line = np.column_stack([start, start + rate])
    return elevate(line * free[:, None], gait.outputs.order)
