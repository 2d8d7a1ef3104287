"""Traces as files: netCDF with named dimensions, readable in Python, MATLAB and Julia; no pickle.

Layout: dimensions ``sample``, ``state``, ``event``, and ``<signal>_component`` for every signal. Numbers are float64
and int64; names are in attributes as JSON lists (``domain_names``, ``state_names``, ``transition_names``).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, UnknownNameError
from amble.io.storage import replacing
from amble.simulation.netcdf import Variable, read_netcdf, write_netcdf
from amble.simulation.trace import Event, Trace

FORMAT = "amble trace"
FORMAT_VERSION = 1
SIGNAL = "signal_"
"""Prefix of the variables that hold signals, so that a signal may have any name."""

NUMBERS = "iuf"
"""Kinds of numpy's types that are numbers."""

FINITE = ("time", "clock", "state", "event_time", "event_before", "event_after")


def save_trace(trace: Trace, path: str | Path, units: Mapping[str, str] | None = None) -> Path:
    """Write a trace to a netCDF file in one step; numbers read back exactly.

    Args:
        trace: the trace.
        path: the file, by custom ``.nc``.
        units: state name or signal name -> unit; what is not named gets no unit. Times are in s.

    Returns:
        The path.

    Raises:
        UnknownNameError: where ``units`` names neither a state nor a signal of the trace.
        InputError: where the file cannot be written there, or a signal has a slash in its name.
    """
    known = dict(units or {})
    for name in known:
        if name not in trace.state_names and name not in trace.signals:
            raise UnknownNameError("state or signal", name, [*trace.state_names, *trace.signals])
    with replacing(path) as temporary:
        write_netcdf(temporary, _variables(trace, known), _attributes(trace))
    return Path(path)


def load_trace(path: str | Path) -> Trace:
    """Read a trace; the system that was simulated is not needed.

    Raises:
        InputError: in one sentence, where the file is missing, truncated, not a trace, or has numbers that are not
            finite where a trace has none.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"trace file '{path}' does not exist")
    try:
        variables, attributes = read_netcdf(path)
    except (OSError, ValueError, KeyError, RuntimeError, MemoryError) as error:
        raise InputError(f"trace file '{path}' is not a netCDF file, or it is damaged") from error
    found = [
        str(attributes.get(key)) for key in ("format", "format_version")
    ]  # as text: it may be an array of anything
    if found != [FORMAT, str(FORMAT_VERSION)]:
        raise InputError(f"file '{path}' is not an {FORMAT} of version {FORMAT_VERSION}")
    for name, variable in variables.items():
        if variable.values.dtype.kind not in NUMBERS:
            raise InputError(f"trace file '{path}' does not hold numbers in '{name}'")
    try:
        trace = _trace(variables, attributes)
        values = {name: variables[name].values for name in FINITE}
    except (KeyError, ValueError, IndexError, TypeError) as error:
        raise InputError(f"trace file '{path}' is not complete: {error}") from error
    for name, value in values.items():
        if not np.all(np.isfinite(value)):
            raise InputError(f"trace file '{path}' holds numbers that are not finite in '{name}'")
    return trace


def _variables(trace: Trace, units: Mapping[str, str]) -> dict[str, Variable]:
    seconds = {"units": "s"}
    transitions = list(dict.fromkeys(event.transition for event in trace.events))
    size = len(trace.state_names)
    before, after = (
        np.array([getattr(event, side) for event in trace.events]).reshape(-1, size) for side in ("before", "after")
    )
    times = np.array([event.time for event in trace.events], dtype=np.float64)
    numbers = np.array([transitions.index(event.transition) for event in trace.events], dtype=np.int64)
    states = _state_attributes(trace, units)
    sample, event = ("sample",), ("event",)
    entry = {**seconds, "long_name": "time since the entry of the domain"}
    variables = {
        "time": _variable(sample, trace.time, seconds),
        "clock": _variable(sample, trace.clock, entry),
        "domain": _variable(sample, trace.domain, {"domain_names": json.dumps(trace.domains)}),
        "cycle": _variable(sample, trace.cycle, {}),
        "state": _variable((*sample, "state"), trace.state, states),
        "event_time": _variable(event, times, seconds),
        "event_transition": _variable(event, numbers, {"transition_names": json.dumps(transitions)}),
        "event_before": _variable((*event, "state"), before, {}),
        "event_after": _variable((*event, "state"), after, {}),
    }
    for name, value in trace.signals.items():
        unit = {"units": units[name]} if name in units else {}
        variables[SIGNAL + name] = _variable((*sample, f"{name}_component"), value, unit)
    return variables


def _variable(dimensions: tuple[str, ...], values: np.ndarray, attributes: Mapping[str, str]) -> Variable:
    return Variable(dimensions=dimensions, values=values, attributes=attributes)


def _attributes(trace: Trace) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "cycles": trace.cycles,
        "ended": trace.ended,
        "tolerance": trace.tolerance,
        "wall_time_s": trace.seconds,
    }


def _state_attributes(trace: Trace, units: Mapping[str, str]) -> dict[str, str]:
    attributes = {"state_names": json.dumps(trace.state_names)}
    if any(name in units for name in trace.state_names):
        attributes["state_units"] = json.dumps([units.get(name, "") for name in trace.state_names])
    return attributes


def _trace(variables: Mapping[str, Variable], attributes: Mapping[str, Any]) -> Trace:
    transitions = json.loads(variables["event_transition"].attributes["transition_names"])
    events = zip(
        variables["event_time"].values,
        variables["event_transition"].values,
        variables["event_before"].values,
        variables["event_after"].values,
        strict=True,
    )
    return Trace(
        domains=tuple(json.loads(variables["domain"].attributes["domain_names"])),
        state_names=tuple(json.loads(variables["state"].attributes["state_names"])),
        time=variables["time"].values,
        clock=variables["clock"].values,
        domain=variables["domain"].values,
        cycle=variables["cycle"].values,
        state=variables["state"].values,
        signals={
            name.removeprefix(SIGNAL): variable.values
            for name, variable in variables.items()
            if name.startswith(SIGNAL)
        },
        events=tuple(Event(float(time), transitions[int(number)], *sides) for time, number, *sides in events),
        cycles=int(attributes["cycles"]),
        ended=str(attributes["ended"]),
        tolerance=float(attributes["tolerance"]),
        seconds=float(attributes["wall_time_s"]),
    )
