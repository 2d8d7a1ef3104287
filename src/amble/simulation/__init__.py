"""Simulation of hybrid systems."""

from amble.simulation.simulate import simulate
from amble.simulation.trace import Event, Trace

__all__ = ["Event", "Trace", "simulate"]
