"""Simulation of hybrid systems."""

from amble.simulation.files import load_trace, save_trace
from amble.simulation.simulate import simulate
from amble.simulation.trace import Event, Trace
from amble.simulation.walking import simulate_gait

__all__ = ["Event", "Trace", "load_trace", "save_trace", "simulate", "simulate_gait"]
