from __future__ import annotations

import dataclasses
import os
import random
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.simulation import Trace, load_trace, netcdf, save_trace, simulate
from tests.hybrids import bouncing_ball

ENDLESS = Path(__file__).parents[1] / "data" / "endless-trace.nc"
"""A trace of the bouncing ball with ten bits flipped: HDF5 2.0 never ends to read an attribute of it."""


@pytest.fixture(scope="module")
def trace() -> Trace:
    return simulate(bouncing_ball(), np.array([0.0, 1.0]), 3)


def test_a_trace_reads_back_exactly(trace: Trace, tmp_path: Path) -> None:
    path = save_trace(trace, tmp_path / "trace.nc", {"height": "m", "energy": "J/kg"})
    back = load_trace(path)
    for field in dataclasses.fields(Trace):
        first, second = getattr(trace, field.name), getattr(back, field.name)
        if isinstance(first, np.ndarray):
            assert first.dtype == second.dtype
            assert np.array_equal(first, second)
        elif field.name == "signals":
            assert list(first) == list(second)
            assert all(np.array_equal(first[name], second[name]) for name in first)
        elif field.name == "events":
            assert [(e.time, e.transition) for e in first] == [(e.time, e.transition) for e in second]
            assert all(np.array_equal(a.after, b.after) for a, b in zip(first, second, strict=True))
            assert all(np.array_equal(a.before, b.before) for a, b in zip(first, second, strict=True))
        else:
            assert first == second
    assert np.array_equal(back.section, trace.section)


def test_dimensions_are_named_and_units_are_attributes(trace: Trace, tmp_path: Path) -> None:
    import xarray

    with xarray.open_dataset(save_trace(trace, tmp_path / "t.nc", {"energy": "J/kg", "height": "m"})) as dataset:
        assert dataset["state"].dims == ("sample", "state")
        assert dataset["signal_pair"].dims == ("sample", "pair_component")
        assert dataset["signal_energy"].attrs["units"] == "J/kg"
        assert dataset["state"].attrs["state_units"] == '["m", ""]'
        assert dataset["domain"].attrs["domain_names"] == '["flight"]'


def test_a_trace_that_ended_before_its_first_event_is_kept(tmp_path: Path) -> None:
    short = simulate(bouncing_ball(floor=5.0), np.array([0.0, 1.0]), 3)
    back = load_trace(save_trace(short, tmp_path / "t.nc"))
    assert back.ended == short.ended
    assert back.events == ()


def test_an_unknown_unit_name_is_refused(trace: Trace, tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="known: height, velocity, energy, pair"):
        save_trace(trace, tmp_path / "t.nc", {"hight": "m"})
    assert not list(tmp_path.iterdir())


def test_a_damaged_file_is_refused(trace: Trace, tmp_path: Path) -> None:
    path = save_trace(trace, tmp_path / "t.nc")
    content = path.read_bytes()
    for kept in (0, 100, len(content) // 2, len(content) - 200):
        path.write_bytes(content[:kept])
        with pytest.raises(InputError, match=r"damaged|not complete"):
            load_trace(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        load_trace(tmp_path / "none.nc")


def test_another_netcdf_file_is_refused(tmp_path: Path) -> None:
    import xarray

    xarray.Dataset({"a": ("b", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="not an amble trace"):
        load_trace(tmp_path / "a.nc")


@pytest.mark.parametrize("name", ["time", "state", "energy"])
@pytest.mark.parametrize(
    ("value", "what"), [(np.nan, "that are not finite"), (-np.inf, "that are not finite"), (1e300, r"above 1e\+100")]
)
def test_a_number_that_no_motion_has_is_refused(
    trace: Trace, tmp_path: Path, name: str, value: float, what: str
) -> None:
    values = np.array(trace.signals[name] if name in trace.signals else getattr(trace, name))
    values[2] = value
    changed = {"signals": {**trace.signals, name: values}} if name in trace.signals else {name: values}
    path = save_trace(dataclasses.replace(trace, **changed), tmp_path / "t.nc")
    with pytest.raises(InputError, match=f"numbers {what} in '{name}'"):
        load_trace(path)


def test_a_missing_variable_is_refused(trace: Trace, tmp_path: Path) -> None:
    import xarray

    path = save_trace(trace, tmp_path / "t.nc")
    with xarray.open_dataset(path, decode_cf=False) as dataset:
        dataset.load()
    dataset.drop_vars("clock").to_netcdf(tmp_path / "u.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"not complete.*clock"):
        load_trace(tmp_path / "u.nc")


def put(name: str, values: Any) -> Callable[[Any], None]:
    """Make a function that replaces a variable and keeps its attributes."""

    def apply(file: Any) -> None:
        attributes = {
            key: file[name].attrs[key] for key in ("domain_names", "transition_names") if key in file[name].attrs
        }
        del file[name]
        file[name] = values
        file[name].attrs.update(attributes)

    return apply


def note(key: str, value: Any, of: str = "/") -> Callable[[Any], None]:
    """Make a function that replaces an attribute; None removes it."""

    def apply(file: Any) -> None:
        del file[of].attrs[key]
        if value is not None:
            file[of].attrs[key] = value

    return apply


def huge(file: Any) -> None:
    """State more numbers than any memory holds; none of them is stored."""
    del file["time"]
    file.create_dataset("time", shape=(2**50,), dtype="f8", chunks=(1024,))


def packed(file: Any) -> None:
    """State 256 MB of zeros, in a file of a few kB; they took 2.4 GB."""
    del file["time"]
    file.create_dataset("time", shape=(2**25,), dtype="f8", chunks=(2**20,), compression="gzip")


def linked(file: Any) -> None:
    """Put the times into another file."""

    del file["time"]
    file["time"] = h5py.ExternalLink("/etc/passwd", "/time")


def outside(file: Any) -> None:
    """Let the numbers be the bytes of another file."""
    del file["time"]
    file.create_dataset("time", shape=(4,), dtype="f8", external=[("/etc/passwd", 0, 32)])


STATE = "_nc4_non_coord_state"

WRONG = {
    "version in words": (note("format_version", "one"), "not an amble trace of version 1"),
    "version array": (note("format_version", [1, 1]), "not an amble trace of version 1"),
    "no version": (note("format_version", None), "not an amble trace of version 1"),
    "format number": (note("format", 3), "not an amble trace of version 1"),
    "text for times": (put("time", ["a", "b"]), "does not hold numbers in 'time'"),
    "complex states": (put(STATE, np.zeros((3, 2), complex)), "does not hold numbers in 'state'"),
    "truth": (put("clock", np.ones(3, bool)), "does not hold numbers in 'clock'"),
    "records": (put("clock", np.zeros(3, [("a", "f8")])), "does not hold numbers in 'clock'"),
    "axes": (put("time", np.zeros((3, 2))), "has 2 axes in 'time', not 1"),
    "one number": (put("time", 1.0), "has 0 axes in 'time', not 1"),
    "domain out of range": (lambda file: file["domain"].__setitem__(0, 7), "names a domain that is not one of its 1"),
    "domain below zero": (lambda file: file["domain"].__setitem__(0, -1), "names a domain"),
    "transition": (lambda file: file["event_transition"].__setitem__(0, 9), "names a transition that is not one of"),
    "cycle below zero": (lambda file: file["cycle"].__setitem__(0, -1), "cycles, which its samples do not have"),
    "too many cycles": (note("cycles", 1000), "states 1000 cycles, which its samples do not have"),
    "cycles in words": (note("cycles", "many"), "'cycles' is missing or not a whole number"),
    "tolerance": (note("tolerance", float("nan")), "'tolerance' is missing or not a finite number"),
    "no end": (note("ended", None), "'ended' is missing or not text"),
    "no samples": (put("time", np.zeros(0)), "not complete"),
    "another length": (put("clock", np.zeros(3)), "'clock' is 3, not"),
    "signal length": (put("signal_energy", np.zeros((3, 1))), "'signal_energy' is 3 x 1, not"),
    "names no list": (note("domain_names", "flight", of="domain"), "is not JSON"),
    "names of numbers": (note("domain_names", "[1]", of="domain"), "is not a string"),
    "deep names": (note("domain_names", "[" * 500 + "]" * 500, of="domain"), "nested deeper"),
    "names array": (note("domain_names", [1.0, 2.0], of="domain"), "'domain_names' of 'domain' is missing"),
    "state names": (note("state_names", '["a"]', of=STATE), "'state' is .* x 2, not .* x 1"),
    "group": (lambda file: (file.pop("time"), file.create_group("time")), "does not hold 'time' itself"),
    "huge": (huge, "holds more than 128 MB of numbers"),
    "packed": (packed, "holds more than 128 MB of numbers"),
    "link": (linked, "does not hold 'time' itself"),
    "outside": (outside, "does not hold 'time' itself"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_with_a_trace_is_one_sentence(name: str, trace: Trace, tmp_path: Path) -> None:

    damage, message = WRONG[name]
    path = save_trace(trace, tmp_path / "t.nc")
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(InputError, match=message) as caught:
        load_trace(path)
    assert "\n" not in str(caught.value)


def test_a_file_that_keeps_its_library_busy_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(netcdf, "SECONDS", 1)
    begun = time.process_time()
    with pytest.raises(InputError, match="is damaged"):
        load_trace(ENDLESS)
    assert time.process_time() - begun < 1.0  # the time went to the child


@pytest.mark.parametrize("seed", range(12))
def test_flipped_bits_are_refused_or_harmless(
    seed: int, trace: Trace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(netcdf, "SECONDS", 1)
    draw = random.Random(seed)
    path = save_trace(trace, tmp_path / "t.nc")
    content = bytearray(path.read_bytes())
    for _ in range(draw.choice((1, 3, 30, 300))):
        content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    path.write_bytes(content)
    assert "\n" not in sentence(path)


def sentence(path: Path) -> str:
    """Return why a trace is refused, nothing where it is read."""
    try:
        load_trace(path)
    except InputError as error:
        return str(error)
    return ""


def test_a_pipe_is_no_trace(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "t.nc")
    with pytest.raises(InputError, match="a device or a pipe"):
        load_trace(tmp_path / "t.nc")


def test_a_folder_with_modules_beside_the_trace_is_not_imported_from(
    trace: Trace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save_trace(trace, tmp_path / "t.nc")
    (tmp_path / "h5py.py").write_text("raise SystemExit(3)")
    shutil.copy(tmp_path / "h5py.py", tmp_path / "json.py")
    monkeypatch.chdir(tmp_path)
    assert load_trace(path).completed
