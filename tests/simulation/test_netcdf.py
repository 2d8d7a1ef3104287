"""netCDF files: xarray is the independent reader and writer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray

from amble.errors import InputError
from amble.simulation.netcdf import Variable, read_netcdf, write_netcdf


def random_variables(events: int) -> dict[str, Variable]:
    """Every case of the format: a name shared with a dimension, many attributes, whole numbers, an empty axis."""
    random = np.random.default_rng(4)
    many = {f"attribute {number}": f"text {number} \N{GREEK SMALL LETTER ALPHA}" for number in range(20)}
    return {
        "time": Variable(dimensions=("sample",), values=random.normal(size=5), attributes={"units": "s"}),
        "state": Variable(dimensions=("sample", "state"), values=random.normal(size=(5, 3)), attributes=many),
        "number": Variable(dimensions=("event",), values=np.arange(events), attributes={}),
        "before": Variable(dimensions=("event", "state"), values=random.normal(size=(events, 3)), attributes={}),
    }


@pytest.mark.parametrize("events", [0, 2])
def test_xarray_reads_the_same_numbers_dimensions_and_attributes(tmp_path: Path, events: int) -> None:
    variables, path = random_variables(events), tmp_path / "a.nc"
    write_netcdf(path, variables, {"count": 7, "share": 0.1, "word": "a"})
    with xarray.open_dataset(path, engine="h5netcdf", decode_cf=False) as dataset:
        assert {name: dataset.attrs[name] for name in ("count", "share", "word")} == {
            "count": 7,
            "share": 0.1,
            "word": "a",
        }
        assert set(dataset.variables) == set(variables)
        for name, variable in variables.items():
            assert dataset[name].dims == variable.dimensions
            assert dataset[name].dtype == variable.values.dtype
            assert np.array_equal(dataset[name].values, variable.values)
            assert dataset[name].attrs == variable.attributes


@pytest.mark.parametrize("events", [0, 2])
def test_what_xarray_wrote_is_read(tmp_path: Path, events: int) -> None:
    variables, path = random_variables(events), tmp_path / "a.nc"
    content = {name: (list(each.dimensions), each.values, each.attributes) for name, each in variables.items()}
    xarray.Dataset(content, attrs={"count": 7, "word": "a"}).to_netcdf(path, engine="h5netcdf")
    axes = {name: variable.values.ndim for name, variable in variables.items()}
    wanted = [key for each in variables.values() for key in each.attributes]
    back, attributes = read_netcdf(path, "file", axes, "signal_", ["count", "word", *wanted])
    assert attributes == {"count": 7, "word": "a"}
    assert set(back) == set(variables)
    for name, variable in variables.items():
        assert np.array_equal(back[name].values, variable.values)
        assert {key: back[name].attributes[key] for key in variable.attributes} == variable.attributes


def test_a_dimension_has_one_size(tmp_path: Path) -> None:
    two = {
        name: Variable(dimensions=("sample",), values=np.zeros(size), attributes={})
        for name, size in (("a", 2), ("b", 3))
    }
    with pytest.raises(ValueError, match="'sample' has the sizes 2 and 3"):
        write_netcdf(tmp_path / "a.nc", two, {})


def test_a_name_with_a_slash_is_refused(tmp_path: Path) -> None:
    slash = {"a/b": Variable(dimensions=("sample",), values=np.zeros(2), attributes={})}
    with pytest.raises(InputError, match="'a/b' cannot be the name of a netCDF variable"):
        write_netcdf(tmp_path / "a.nc", slash, {})
    assert not list(tmp_path.iterdir())
