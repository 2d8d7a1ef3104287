from __future__ import annotations

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.simulation import Trace, load_trace, save_trace, simulate
from tests.hybrids import bouncing_ball


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
    with pytest.raises(InputError, match="does not exist"):
        load_trace(tmp_path / "none.nc")


def test_another_netcdf_file_is_refused(tmp_path: Path) -> None:
    import xarray

    xarray.Dataset({"a": ("b", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="not an amble trace"):
        load_trace(tmp_path / "a.nc")


@pytest.mark.parametrize("name", ["time", "state"])
def test_a_number_that_is_not_finite_is_refused(trace: Trace, tmp_path: Path, name: str) -> None:
    values = np.array(getattr(trace, name))
    values[2] = np.nan
    path = save_trace(dataclasses.replace(trace, **{name: values}), tmp_path / "t.nc")
    with pytest.raises(InputError, match=f"not finite in '{name}'"):
        load_trace(path)


def test_a_missing_variable_is_refused(trace: Trace, tmp_path: Path) -> None:
    import xarray

    path = save_trace(trace, tmp_path / "t.nc")
    with xarray.open_dataset(path, decode_cf=False) as dataset:
        dataset.load()
    dataset.drop_vars("clock").to_netcdf(tmp_path / "u.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"not complete.*clock"):
        load_trace(tmp_path / "u.nc")


def test_text_in_the_place_of_numbers_is_refused(trace: Trace, tmp_path: Path) -> None:
    path = save_trace(trace, tmp_path / "t.nc")
    with h5py.File(path, "a") as file:
        del file["clock"]
        file["clock"] = ["a"] * len(trace.time)
    with pytest.raises(InputError, match="does not hold numbers in 'clock'"):
        load_trace(path)


@pytest.mark.parametrize("version", [[1, 2], "one", 2])
def test_another_version_is_refused_whatever_it_is(trace: Trace, tmp_path: Path, version: object) -> None:
    path = save_trace(trace, tmp_path / "t.nc")
    with h5py.File(path, "a") as file:
        file.attrs["format_version"] = version
    with pytest.raises(InputError, match="not an amble trace of version 1"):
        load_trace(path)


def test_more_numbers_than_memory_holds_are_refused(trace: Trace, tmp_path: Path) -> None:
    """A file may claim any size: what was never written takes no room in it."""
    path = save_trace(trace, tmp_path / "t.nc")
    with h5py.File(path, "a") as file:
        file.create_dataset("signal_huge", shape=(2**50,), dtype="f8", chunks=(1024,))
    with pytest.raises(InputError, match="damaged"):
        load_trace(path)
