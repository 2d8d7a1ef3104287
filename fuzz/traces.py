"""Trace files: drawn as netCDF, damaged in their HDF5 structure or in their bytes."""

from __future__ import annotations

import random
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.bytes import damaged
from fuzz.words import NAMES


@cache
def _sound() -> bytes:
    from amble.simulation import Trace, save_trace
    from amble.simulation.trace import Event

    samples, random_numbers = 12, np.random.default_rng(0)
    trace = Trace(
        domains=("D1", "D2"),
        state_names=("x", "rate of x"),
        time=np.linspace(0.0, 1.0, samples),
        clock=np.linspace(0.0, 1.0, samples),
        domain=np.arange(samples) % 2,
        cycle=np.arange(samples) // 6,
        state=random_numbers.normal(size=(samples, 2)),
        signals={"force": random_numbers.normal(size=(samples, 3))},
        events=tuple(Event(0.5 * k, "D1->D2", np.zeros(2), np.ones(2)) for k in range(1, 3)),
        cycles=1,
        ended="completed",
        tolerance=1e-8,
        seconds=0.1,
    )
    with tempfile.TemporaryDirectory() as folder:
        return save_trace(trace, Path(folder) / "trace.nc", {"x": "m"}).read_bytes()


def _value(draw: random.Random) -> Any:
    shape = draw.choice(((), (0,), (12,), (12, 2), (3,), (12, 3), (2, 2, 2), (1, 12)))
    kind = draw.choice(("f8", "f4", "f2", "i8", "i1", "u8", "c16", "S3", "bool", ">f8"))
    fill = draw.choice((0, 1, -1, 2**31, np.nan, np.inf, 1e308))
    with np.errstate(all="ignore"):
        return np.full(shape, fill).astype(kind)


def _change(file: Any, draw: random.Random) -> str:
    import h5py

    kind = draw.choice(("attribute", "attribute", "replace", "replace", "delete", "rename", "link", "number", "extra"))
    name = draw.choice(list(file) or ["time"])
    holder = draw.choice((file, file.get(name, file)))
    if kind == "attribute":
        key = draw.choice((*holder.attrs, "format", "format_version", "cycles", "domain_names", "state_names"))
        values = (*NAMES[:4], "[]", "[1]", '["D1"]', '["a", "a"]', "[" * 300, "9" * 5000, 1, 2**31, -1, 0.5, np.nan)
        holder.attrs[key] = draw.choice((*values, _value(draw), np.bytes_(b"\xff"), h5py.Empty("f8"), True))
    elif kind in ("replace", "extra"):
        new = name if kind == "replace" else draw.choice(("signal_a", "signal_", "signal_\u202e", "a", "time2"))
        kept = dict(file[name].attrs) if kind == "replace" and name in file else {}
        file.pop(new, None)
        dataset = file.create_dataset(new, data=_value(draw))
        for key in ("domain_names", "state_names", "transition_names"):
            if key in kept:
                dataset.attrs[key] = kept[key]
    elif kind == "delete":
        file.pop(name, None)
    elif kind == "rename" and name in file:
        file.move(name, draw.choice(("a", f"signal_{name}", "signal_x y", "é")))
    elif kind == "link":
        file.pop(name, None)
        links = (h5py.SoftLink("/time"), h5py.SoftLink("/nowhere"), h5py.ExternalLink("/etc/passwd", "/a"))
        file[name] = draw.choice(links)
    elif name in file and hasattr(file[name], "size") and file[name].size and file[name].dtype.kind in "if":
        number = draw.choice((0, -1, 7, 2**40) if file[name].dtype.kind == "i" else (np.nan, np.inf, -1e308, 0.0))
        held = np.array(file[name][...], dtype=object)
        held.flat[min(3, held.size - 1)] = number
        with np.errstate(all="ignore"):
            file[name][...] = held.astype(file[name].dtype)
    return f"{kind} of {name}"


def draw_trace(draw: random.Random) -> tuple[bytes, list[str]]:
    """A trace with damage to its structure, its bytes or both."""
    import io

    import h5py

    content, done = _sound(), []
    if draw.random() < 0.7:
        stream = io.BytesIO(content)
        for _ in range(draw.choice((1, 1, 2, 3))):
            try:
                with h5py.File(stream, "r+") as file:
                    done.append(_change(file, draw))
            except (OSError, ValueError, TypeError, KeyError, RuntimeError, UnicodeError):
                done.append("what HDF5 does not write")
                break
        content = stream.getvalue()
    if not done or draw.random() < 0.2:
        content, what = damaged(content, draw)
        done.append(what)
    return content, done


def read_trace(path: Path) -> Any:
    """Load a trace, ask for its section, and write it again."""
    from amble.simulation import load_trace, save_trace

    trace = load_trace(path)
    _ = trace.section
    save_trace(trace, path.with_suffix(".again"))
    return trace
