"""Traces as files: netCDF with named dimensions, readable in Python, MATLAB and Julia; no pickle.

Layout: dimensions ``sample``, ``state``, ``event``, and ``<signal>_component`` for every signal. Numbers are float64
and int64; names are in attributes as JSON lists (``domain_names``, ``state_names``, ``transition_names``).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from amble.errors import InputError, UnknownNameError
from amble.simulation.trace import Event, Trace
from amble.storage import replacing

if TYPE_CHECKING:
    import xarray

FORMAT = "amble trace"
FORMAT_VERSION = 1
SIGNAL = "signal_"
"""Prefix of the variables that hold signals, so that a signal may have any name."""

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
        InputError: where the file cannot be written there.
    """
    known = dict(units or {})
    for name in known:
        if name not in trace.state_names and name not in trace.signals:
            raise UnknownNameError("state or signal", name, [*trace.state_names, *trace.signals])
    with replacing(path) as temporary:
        _dataset(trace, known).to_netcdf(temporary, engine="h5netcdf")
    return Path(path)


def load_trace(path: str | Path) -> Trace:
    """Read a trace; the system that was simulated is not needed.

    Raises:
        InputError: in one sentence, where the file is missing, truncated, not a trace, or has numbers that are not
            finite where a trace has none.
    """
    import xarray

    path = Path(path)
    if not path.is_file():
        raise InputError(f"trace file '{path}' does not exist")
    try:
        with xarray.open_dataset(path, engine="h5netcdf", decode_cf=False) as dataset:
            dataset.load()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise InputError(f"trace file '{path}' is not a netCDF file, or it is damaged") from error
    if dataset.attrs.get("format") != FORMAT or int(dataset.attrs.get("format_version", 0)) != FORMAT_VERSION:
        raise InputError(f"file '{path}' is not an {FORMAT} of version {FORMAT_VERSION}")
    try:
        trace = _trace(dataset)
        values = {name: dataset[name].values for name in FINITE}
    except (KeyError, ValueError, IndexError, TypeError) as error:
        raise InputError(f"trace file '{path}' is not complete: {error}") from error
    for name, value in values.items():
        if not np.all(np.isfinite(value)):
            raise InputError(f"trace file '{path}' holds numbers that are not finite in '{name}'")
    return trace


def _dataset(trace: Trace, units: Mapping[str, str]) -> xarray.Dataset:
    import xarray

    seconds = {"units": "s"}
    transitions = list(dict.fromkeys(event.transition for event in trace.events))
    size = len(trace.state_names)
    before, after = (
        np.array([getattr(event, side) for event in trace.events]).reshape(-1, size) for side in ("before", "after")
    )
    numbers = np.array([transitions.index(event.transition) for event in trace.events], dtype=np.int64)
    variables: dict[str, Any] = {
        "time": ("sample", trace.time, seconds),
        "clock": ("sample", trace.clock, {**seconds, "long_name": "time since the entry of the domain"}),
        "domain": ("sample", trace.domain, {"domain_names": json.dumps(trace.domains)}),
        "cycle": ("sample", trace.cycle),
        "state": (("sample", "state"), trace.state, _state_attributes(trace, units)),
        "event_time": ("event", np.array([event.time for event in trace.events], dtype=np.float64), seconds),
        "event_transition": ("event", numbers, {"transition_names": json.dumps(transitions)}),
        "event_before": (("event", "state"), before),
        "event_after": (("event", "state"), after),
    }
    for name, value in trace.signals.items():
        unit = {"units": units[name]} if name in units else {}
        variables[SIGNAL + name] = (("sample", f"{name}_component"), value, unit)
    attributes = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "cycles": trace.cycles,
        "ended": trace.ended,
        "tolerance": trace.tolerance,
        "wall_time_s": trace.seconds,
    }
    return xarray.Dataset(variables, attrs=attributes)


def _state_attributes(trace: Trace, units: Mapping[str, str]) -> dict[str, str]:
    attributes = {"state_names": json.dumps(trace.state_names)}
    if any(name in units for name in trace.state_names):
        attributes["state_units"] = json.dumps([units.get(name, "") for name in trace.state_names])
    return attributes


def _trace(dataset: xarray.Dataset) -> Trace:
    transitions = json.loads(dataset["event_transition"].attrs["transition_names"])
    events = zip(
        dataset["event_time"].values,
        dataset["event_transition"].values,
        dataset["event_before"].values,
        dataset["event_after"].values,
        strict=True,
    )
    return Trace(
        domains=tuple(json.loads(dataset["domain"].attrs["domain_names"])),
        state_names=tuple(json.loads(dataset["state"].attrs["state_names"])),
        time=dataset["time"].values,
        clock=dataset["clock"].values,
        domain=dataset["domain"].values,
        cycle=dataset["cycle"].values,
        state=dataset["state"].values,
        signals={
            str(name).removeprefix(SIGNAL): variable.values
            for name, variable in dataset.data_vars.items()
            if str(name).startswith(SIGNAL)
        },
        events=tuple(Event(float(time), transitions[int(number)], *sides) for time, number, *sides in events),
        cycles=int(dataset.attrs["cycles"]),
        ended=str(dataset.attrs["ended"]),
        tolerance=float(dataset.attrs["tolerance"]),
        seconds=float(dataset.attrs["wall_time_s"]),
    )
