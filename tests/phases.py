"""Gaits whose curves are named over another phase."""

from __future__ import annotations

from dataclasses import replace

from examples.extending.phase_configuration import ConfigurationPhase

from amble.control.phase import DomainPhase
from amble.gait import Gait


def on_phase(gait: Gait, coefficients: dict[str, dict[str, float]]) -> Gait:
    """The gait with its curves named over another phase, with the numbers of its own motion."""
    phase, domains = ConfigurationPhase(coefficients), []
    for stance, domain in zip(gait.pattern.solved, gait.domains, strict=True):
        numbers = DomainPhase(phase=phase, robot=gait.robot, stance=stance).measured(*domain.positions[[0, -1]])
        domains.append(replace(domain, phase_numbers=numbers))
    return replace(gait, outputs=replace(gait.outputs, phase=phase), domains=tuple(domains))
