"""Simulation of hybrid systems."""

from amble.simulation.files import load_trace, save_trace
from amble.simulation.simulate import simulate
from amble.simulation.trace import Event, Trace

__all__ = ["Event", "Trace", "load_trace", "save_trace", "simulate"]
