"""Where the variables of a program stand among the unknowns that the structured KKT solver eliminates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.synthesis.elimination import FREE, DomainElimination, owners
from amble.synthesis.program import GaitProgram

Index = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where variables stand, (n_x,) each; ``FREE`` for what has no such place.

    Attributes:
        domain: the domain, for unknowns of nodes.
        stage: the node in its domain.
        node: the node, counted through all domains.
        local: the place in the node.
        read: place of the parameters in the nodes of a domain, (domains, n_x).
        end: place in the end: states at entries, and what belongs to no node.
    """

    domain: Index
    stage: Index
    node: Index
    local: Index
    read: Index
    end: Index

    @classmethod
    def of(cls, program: GaitProgram, domains: Sequence[DomainElimination]) -> Places:
        """Return the places of a program's variables."""
        domain, stage = owners(program)
        node, local, end = np.full((3, domain.size), FREE)
        read = np.full((len(domains), domain.size), FREE)
        offset, ends = 0, stage == FREE
        for number, d in enumerate(domains):
            node[d.unknowns] = offset + np.arange(d.nodes)[:, None]
            local[d.unknowns] = d.places
            read[number, d.parameters[d.read]] = d.states.shape[1] + d.explicit.shape[1] + np.arange(d.read.size)
            ends[d.states[0]] = True
            offset += d.nodes
        end[ends] = np.arange(int(ends.sum()))
        return cls(domain=domain, stage=stage, node=node, local=local, read=read, end=end)

    def in_node(self, number: Index, variables: Index) -> Index:
        """Places of variables in nodes of given domains: of unknowns or parameters that the nodes read."""
        own = self.local[variables]
        return np.where(own >= 0, own, self.read[number, variables])
