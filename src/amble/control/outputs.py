"""Outputs: which coordinates a domain controls, and the Bezier order of their desired values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from amble.errors import InputError, UnknownNameError
from amble.hybrid import GaitPattern


@dataclass(frozen=True)
class DomainOutputs:
    """The controlled coordinates of one domain, by name (joints, or roll, pitch, yaw), in coordinate order."""

    domain: str
    coordinates: tuple[str, ...]


@dataclass(frozen=True)
class Outputs:
    """The outputs of every solved domain of a pattern and the order of their Bezier curves."""

    domains: tuple[DomainOutputs, ...]
    order: int

    def of(self, domain: str) -> DomainOutputs:
        """Look the outputs of a domain up."""
        for candidate in self.domains:
            if candidate.domain == domain:
                return candidate
        raise UnknownNameError("domain", domain, [d.domain for d in self.domains])
