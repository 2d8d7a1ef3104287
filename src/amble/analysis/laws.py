"""Which allocation laws are compared on a gait, and what they do along its motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from amble.analysis.comparison import Comparison, compare
from amble.analysis.limit_use import AllocationLimits
from amble.analysis.motion import Motion
from amble.analysis.reallocation import reallocate
from amble.analysis.samples import Samples, samples_of_gait, samples_of_trace
from amble.control import AllocationLaw, BoundedMinimumNorm, MinimumPeak, MinimumPower, PseudoInverse
from amble.control.actuator import ACTUATORS, PAPER, Actuator
from amble.control.allocation.law import require_effort_limits
from amble.control.laws import paper_baseline
from amble.errors import InputError
from amble.gait import Gait
from amble.robot import catalogue
from amble.simulation import Trace


@dataclass(frozen=True)
class LawChoice:
    """Laws to compare on a gait.

    Attributes:
        laws: label -> law.
        omitted: label -> sentence that says why the law cannot be applied to the gait.
    """

    laws: Mapping[str, AllocationLaw]
    omitted: Mapping[str, str]

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for every law that is left out."""
        return tuple(f"Left out: {label}, because {reason}." for label, reason in self.omitted.items())


def is_papers(gait: Gait) -> bool:
    """Whether a gait is the paper's: the amble of a robot of the catalogue. The paper's numbers belong to no other."""
    return gait.robot.name in catalogue.names() and gait.pattern.name == "amble"


def actuators_for(gait: Gait) -> tuple[Actuator, ...]:
    """Return the registered actuator models that a gait's costs are stated for.

    The paper's own only for its gait, and one that names joints only for a robot that has them.
    """
    fitting = (model for model in ACTUATORS.entries if model.fits(gait.robot.joint_names))
    return tuple(model for model in fitting if model != PAPER or is_papers(gait))


def paper_laws(gait: Gait) -> LawChoice:
    """Return those of the paper's two methods that apply to a gait: one actuator off, and the pseudo-inverse."""
    return _applicable({"drop": lambda: paper_baseline(gait.pattern), "pinv": PseudoInverse})


def every_law(gait: Gait) -> LawChoice:
    """Return the laws worth comparing on a gait: both of the paper, least power for each actuator, the rest.

    The bounded law keeps the friction of the ground and the normal force of the gait's limits. What does not apply,
    such as a law that needs torque limits on a robot without them, is left out with the reason.
    """

    def limited(law: AllocationLaw) -> AllocationLaw:
        require_effort_limits(gait.robot, sorted({foot for stance in gait.pattern.stances for foot in stance.feet}))
        return law

    return _applicable(
        {
            "drop": lambda: paper_baseline(gait.pattern),
            "pinv": PseudoInverse,
            **{f"power ({model.name})": partial(MinimumPower, model) for model in actuators_for(gait)},
            "peak": lambda: limited(MinimumPeak()),
            "bounded": lambda: limited(BoundedMinimumNorm(gait.pattern.ground.friction, gait.limits.normal_force)),
        }
    )


def labelled(laws: Sequence[AllocationLaw]) -> dict[str, AllocationLaw]:
    """Label laws by name, and by name and parameters where two have the same name."""
    names = [law.name for law in laws]
    return {law.name if names.count(law.name) == 1 else f"{law.name} ({_values(law)})": law for law in laws}


def compare_laws(
    gait: Gait, laws: Mapping[str, AllocationLaw] | Sequence[AllocationLaw] | None = None, trace: Trace | None = None
) -> Comparison:
    """Evaluate laws along the optimised motion and, where a trace is given, along the simulated one.

    Args:
        gait: the gait; its limits are what the laws are held against, torques also against the robot's own.
        laws: label -> law, or laws, which are labelled then; every law that applies where none is given.
        trace: a simulation of the gait.

    Raises:
        InputError: ``laws`` is empty, or a law does not fit a stance or the robot.
    """
    motions = [samples_of_gait(gait)]
    if trace is not None:
        motions.append(samples_of_trace(trace, gait.pattern))
    if laws is None:
        laws = every_law(gait).laws
    chosen = laws if isinstance(laws, Mapping) else labelled(laws)
    return compare(motions, chosen, actuators_for(gait), AllocationLimits.of(gait))


def with_laws(samples: Samples, laws: Mapping[str, AllocationLaw]) -> Motion:
    """Return a motion with the torques that each law applies on it, by label."""
    return samples.motion({label: reallocate(samples, [law])[law.name].torques for label, law in laws.items()})


def _applicable(candidates: Mapping[str, Callable[[], AllocationLaw]]) -> LawChoice:
    laws, omitted = {}, {}
    for label, build in candidates.items():
        try:
            laws[label] = build()
        except InputError as error:
            omitted[label] = str(error)
    return LawChoice(laws, omitted)


def _values(law: AllocationLaw) -> str:
    values = law.parameters.values()  # of an actuator model that a user made, its name tells it apart
    return ", ".join(
        str(value["name"] if isinstance(value, Mapping) and "name" in value else value) for value in values
    )
