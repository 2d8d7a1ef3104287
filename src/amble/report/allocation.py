"""Allocation laws side by side: the table of ``amble compare``, its numbers, and the figure of the torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from amble.analysis import Samples, samples_of_gait
from amble.analysis.allocation import AllocationLimits, LawMetrics, allocation_metrics, law_torques
from amble.control.actuator import ACTUATORS
from amble.control.allocation import (
    AllocationLaw,
    BoundedMinimumNorm,
    MinimumPeak,
    MinimumPower,
    PseudoInverse,
)
from amble.control.laws import paper_baseline
from amble.gait import Gait
from amble.report.figures import left_joints, torque_lines
from amble.report.results import finite_or_none
from amble.report.tables import Table
from amble.types import Json

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def every_law(gait: Gait) -> dict[str, AllocationLaw]:
    """Return the laws worth comparing on a gait, by label: both of the paper, least power for each actuator, the rest.

    The bounded law keeps the friction of the ground and the normal force of the gait's limits.
    """
    power = {f"power ({model.name})": MinimumPower(model.name) for model in ACTUATORS}
    return {
        "drop": paper_baseline(gait.pattern),
        "pinv": PseudoInverse(),
        **power,
        "peak": MinimumPeak(),
        "bounded": BoundedMinimumNorm(gait.pattern.ground.friction, gait.limits.normal_force),
    }


def labelled(laws: Sequence[AllocationLaw]) -> dict[str, AllocationLaw]:
    """Label laws by name, and by name and parameters where two have the same name."""
    names = [law.name for law in laws]
    return {law.name if names.count(law.name) == 1 else f"{law.name} ({_values(law.parameters)})": law for law in laws}


def compare_allocations(
    gait: Gait, laws: Mapping[str, AllocationLaw] | None = None, samples: Samples | None = None
) -> tuple[LawMetrics, ...]:
    """Evaluate laws along one motion of a gait.

    Args:
        gait: the gait; its limits are what the laws are held against, torques also against the robot's own.
        laws: label -> law; every law where none is given.
        samples: the motion; the optimised one where none is given.
    """
    joints = gait.robot.joints
    torques = {joint.name: min(joint.effort, gait.limits.torques.get(joint.name, joint.effort)) for joint in joints}
    limits = AllocationLimits(gait.pattern.ground.friction, gait.limits.normal_force, torques)
    motion = samples_of_gait(gait) if samples is None else samples
    return allocation_metrics(motion, laws or every_law(gait), limits, ACTUATORS)


def allocation_table(metrics: Sequence[LawMetrics]) -> Table:
    """Put all laws along one motion side by side."""
    models = list(metrics[0].cot)
    header = (
        "law",
        *(f"CoT ({model})" for model in models),
        "RMS (N m)",
        "peak (N m)",
        "relative peak",
        "friction used",
        "limit active (%)",
        "limit missed (%)",
    )
    rows = tuple(
        (
            entry.law,
            *(f"{entry.cot[model]:.4f}" for model in models),
            f"{entry.rms_torque:.3f}",
            f"{entry.peak_torque:.3f}",
            f"{entry.peak_relative_torque:.3f}",
            f"{entry.friction_used:.3f}",
            f"{100.0 * entry.active:.1f}",
            f"{100.0 * entry.missed:.1f}",
        )
        for entry in metrics
    )
    motion = metrics[0].motion
    note = f"All laws on the same {motion} motion; limits are the gait's and the robot's own."
    return Table(f"Allocation laws along the {motion} motion", header, rows, (note,))


def allocation_results(metrics: Sequence[LawMetrics]) -> Json:
    """Return label -> motion -> metrics, for results.json under "allocation"; N m, N."""
    found: Json = {}
    for entry in metrics:
        numbers = {key: value for key, value in asdict(entry).items() if key not in ("law", "motion")}
        numbers["friction_used"] = finite_or_none(entry.friction_used)
        found.setdefault(entry.law, {})[entry.motion] = numbers
    return found


def allocation_figure(
    gait: Gait, laws: Mapping[str, AllocationLaw] | None = None, samples: Samples | None = None
) -> Figure:
    """Draw the torques of the left legs under every law over one cycle."""
    motion = samples_of_gait(gait) if samples is None else samples
    torques = law_torques(motion, laws or every_law(gait))
    return torque_lines(motion.motion(torques), left_joints(gait.robot))


def _values(parameters: Mapping[str, object]) -> str:
    return ", ".join(str(value) for value in parameters.values())
