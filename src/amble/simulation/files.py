"""Traces as files: netCDF with named dimensions, readable in Python, MATLAB and Julia; no pickle.

Layout: dimensions ``sample``, ``state``, ``event``, and ``<signal>_component`` for every signal. Numbers are float64
and int64; names are in attributes as JSON lists (``domain_names``, ``state_names``, ``transition_names``).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, UnknownNameError, shown, shown_path
from amble.io.codec import TEXT, ListOf
from amble.io.reader import parse_json
from amble.io.storage import replacing
from amble.simulation.netcdf import Variable, read_netcdf, write_netcdf
from amble.simulation.trace import Event, Trace

FORMAT = "amble trace"
FORMAT_VERSION = 1
SIGNAL = "signal_"
"""Prefix of the variables that hold signals, so that a signal may have any name."""

LARGEST = 1e100
"""Largest number of a trace, so that products of two are finite; a fall ends with torques beyond what a robot has."""

AXES = {
    "time": 1,
    "clock": 1,
    "domain": 1,
    "cycle": 1,
    "state": 2,
    "event_time": 1,
    "event_transition": 1,
    "event_before": 2,
    "event_after": 2,
}
"""Variables that every trace has, with their number of axes; all finite."""

ATTRIBUTES = (
    *("format", "format_version", "cycles", "ended", "tolerance", "wall_time_s"),
    *("domain_names", "state_names", "transition_names"),
)
"""Attributes that are read, of the file and of its variables."""

KINDS = {int: "a whole number", float: "a finite number", str: "text"}


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
            finite, or above 1e100, or not in range, where a trace has none.
    """
    name = f"trace file '{shown_path(path)}'"
    variables, attributes = read_netcdf(path, "trace file", AXES, SIGNAL, ATTRIBUTES)
    if attributes.get("format") != FORMAT or attributes.get("format_version") != FORMAT_VERSION:
        raise InputError(f"{name} is not an {FORMAT} of version {FORMAT_VERSION}")
    for variable in AXES:
        if variable not in variables:
            raise InputError(f"{name} is not complete: '{variable}' is missing")
    _check_size(variables, name)
    _check_lengths(variables, name)
    trace = _trace(variables, attributes, name)
    _check_numbers(trace, name)
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


def _check_size(variables: Mapping[str, Variable], name: str) -> None:
    """Refuse numbers that no motion has, signals included: they are no numbers, or products of them are infinite."""
    for key, variable in variables.items():
        finite = np.isfinite(variable.values)
        if not np.all(finite & (np.abs(variable.values) <= LARGEST)):
            what = f"numbers above {LARGEST:g}" if np.all(finite) else "numbers that are not finite"
            raise InputError(f"{name} holds {what} in '{shown(key.removeprefix(SIGNAL))}'")


def _check_lengths(variables: Mapping[str, Variable], name: str) -> None:
    """Hold the lengths of all axes against each other."""
    states = len(_names(variables, "state", "state_names", name))
    samples, events = (variables[key].values.shape[0] for key in ("time", "event_time"))
    shapes = {"state": (samples, states), "event_before": (events, states), "event_after": (events, states)}
    for key, variable in variables.items():
        shape = variable.values.shape
        if key.startswith(SIGNAL):
            wanted: tuple[int, ...] = (samples, *shape[1:])
        else:
            wanted = shapes.get(key, (events if key.startswith("event") else samples,))
        if shape != wanted:
            found = " x ".join(map(str, shape))
            raise InputError(f"{name} is not complete: '{shown(key)}' is {found}, not {' x '.join(map(str, wanted))}")
    if samples == 0:
        raise InputError(f"{name} holds no sample")


def _check_numbers(trace: Trace, name: str) -> None:
    """Hold the numbers of domains and cycles against what there is."""
    if not np.all((trace.domain >= 0) & (trace.domain < len(trace.domains))):
        raise InputError(f"{name} names a domain that is not one of its {len(trace.domains)}")
    last = int(trace.cycle.max())
    fits = np.all(trace.cycle >= 0) and 0 <= trace.cycles <= last + 1
    if not fits:
        raise InputError(f"{name} states {trace.cycles} cycles, which its samples do not have")


def _names(variables: Mapping[str, Variable], variable: str, attribute: str, name: str) -> tuple[str, ...]:
    """Return the list of names in an attribute."""
    where = f"{name}: '{attribute}' of '{variable}'"
    text = variables[variable].attributes.get(attribute)
    if not isinstance(text, str):
        raise InputError(f"{where} is missing")
    return ListOf(TEXT).decode(parse_json(text, where), where)


def _attribute(attributes: Mapping[str, Any], key: str, kind: type, name: str) -> Any:
    value = attributes.get(key)
    if type(value) is not kind or (isinstance(value, float) and not isfinite(value)):
        raise InputError(f"{name} is not complete: its attribute '{key}' is missing or not {KINDS[kind]}")
    return value


def _trace(variables: Mapping[str, Variable], attributes: Mapping[str, Any], name: str) -> Trace:
    values = {key: variable.values for key, variable in variables.items()}
    transitions = _names(variables, "event_transition", "transition_names", name)
    numbers = values["event_transition"]
    if not np.all((numbers >= 0) & (numbers < len(transitions))):
        raise InputError(f"{name} names a transition that is not one of its {len(transitions)}")
    events = zip(values["event_time"], numbers, values["event_before"], values["event_after"], strict=True)
    return Trace(
        domains=_names(variables, "domain", "domain_names", name),
        state_names=_names(variables, "state", "state_names", name),
        time=values["time"],
        clock=values["clock"],
        domain=values["domain"],
        cycle=values["cycle"],
        state=values["state"],
        signals={key.removeprefix(SIGNAL): value for key, value in values.items() if key.startswith(SIGNAL)},
        events=tuple(Event(float(time), transitions[int(number)], *sides) for time, number, *sides in events),
        cycles=_attribute(attributes, "cycles", int, name),
        ended=_attribute(attributes, "ended", str, name),
        tolerance=_attribute(attributes, "tolerance", float, name),
        seconds=_attribute(attributes, "wall_time_s", float, name),
    )
