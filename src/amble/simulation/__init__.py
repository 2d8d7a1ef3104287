"""Simulation of hybrid systems."""

from amble.simulation.trace import Event, Trace

__all__ = ["Event", "Trace"]
