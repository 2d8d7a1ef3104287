"""Motions in files of other programs: what amble writes comes back as the same gait; what is damaged is refused."""

from __future__ import annotations

import random
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from amble.errors import InputError
from amble.gait.files import content_hash, load_gait, to_dict
from amble.gait.motion_files import read_motion, recorded_gait, write_motion
from amble.gait.recorded import LARGEST, MOST_NAMES
from amble.hybrid.gaits import GAITS
from fuzz.motions import drawer
from tests.gait.example import random_gait
from tests.report.test_any_gait import other

SUFFIXES = (".npz", ".csv", ".mat")
DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("stabilised", [False, True])
def test_a_gait_comes_back_equal(suffix: str, stabilised: bool, tmp_path: Path) -> None:
    gait = random_gait(3, stabilised=stabilised)
    found = recorded_gait(read_motion(write_motion(gait, tmp_path / f"gait{suffix}")))
    assert to_dict(found) == to_dict(gait)
    assert content_hash(found) == content_hash(gait)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", ["turning-trot", "stabilised-trot-one-by-one"])
def test_a_stored_gait_comes_back_equal(suffix: str, name: str, tmp_path: Path) -> None:
    """Solved and stabilised: one that turns, and one whose feet land one by one."""
    gait = load_gait(DATA / f"{name}.json")
    found = recorded_gait(read_motion(write_motion(gait, tmp_path / f"gait{suffix}")))
    assert to_dict(found) == to_dict(gait)
    assert content_hash(found) == content_hash(gait)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_motion_is_written_alike_at_every_time(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = write_motion(random_gait(3), tmp_path / f"first{suffix}").read_bytes()
    monkeypatch.setattr(time, "asctime", lambda: "another date")
    assert write_motion(random_gait(3), tmp_path / f"second{suffix}").read_bytes() == first


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", ["walk", "running trot"])
def test_any_stance_and_flight(suffix: str, name: str, tmp_path: Path) -> None:
    gait = other(name)
    assert name in GAITS
    found = recorded_gait(read_motion(write_motion(gait, tmp_path / f"gait{suffix}")))
    assert to_dict(found) == to_dict(gait)


def test_an_edited_motion_is_the_gait_that_the_file_says(tmp_path: Path) -> None:
    gait = random_gait(4)
    place = write_motion(gait, tmp_path / "gait.npz")
    with np.load(place) as file:
        arrays = dict(file)
    arrays["D1.positions"] = arrays["D1.positions"] + 0.25
    np.savez(place, **arrays)
    found = recorded_gait(read_motion(place))
    np.testing.assert_array_equal(found.domains[0].positions, gait.domains[0].positions + 0.25)
    np.testing.assert_array_equal(found.domains[1].positions, gait.domains[1].positions)


def test_matlab_sees_the_fields_of_frost(tmp_path: Path) -> None:
    gait = random_gait(5)
    found = loadmat(write_motion(gait, tmp_path / "gait.mat"))["gait"]
    assert found.shape == (1, len(gait.domains))
    for entry, domain in zip(found.ravel(), gait.domains, strict=True):
        np.testing.assert_array_equal(entry["tspan"], domain.times[None])
        np.testing.assert_array_equal(entry["states"]["x"][0, 0], domain.positions.T)
        np.testing.assert_array_equal(entry["inputs"]["u"][0, 0], domain.torques.T)


def test_edges_between_the_domains_of_frost_are_left_out(tmp_path: Path) -> None:
    """FROST has an entry for every edge too, with one sample."""
    t, x = np.linspace(0.0, 0.3, 7), np.random.default_rng(0).normal(size=(4, 7))
    entries = np.empty((1, 4), dtype=[("tspan", object), ("states", object)])
    for place in range(4):
        count = 7 if place % 2 == 0 else 1
        span = t[None] if count > 1 else np.zeros((0, 0))
        entries[0, place] = (span, {"x": x[:, :count], "dx": -x[:, :count], "ddx": 2.0 * x[:, :count]})
    savemat(tmp_path / "gait.mat", {"gait": entries})
    motion = read_motion(tmp_path / "gait.mat")
    assert [domain.name for domain in motion.domains] == ["", ""]
    np.testing.assert_array_equal(motion.domains[1].positions, x.T)
    assert motion.domains[0].velocities is not None
    np.testing.assert_array_equal(motion.domains[0].velocities, -x.T)
    assert motion.domains[0].torques is None
    with pytest.raises(InputError, match="does not say of which robot"):
        recorded_gait(motion)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("gait.npz", b"no archive", "is no npz file"),
        ("gait.mat", b"no mat file" * 20, "is no mat file"),
        ("gait.csv", b"time,x\n0,1\n", "begin with domain and time"),
        ("gait.csv", b"domain,time,x\nD1,0,1\nD1,1,2\nD1,0.5,3\n", "run forward"),
        ("gait.csv", b"domain,time,x\nD1,0,1\nD1,1,two\nD1,2,3\n", "are not all numbers"),
        ("gait.csv", b"domain,time,x\nD1,0,1\nD1,1,nan\nD1,2,3\n", "not finite"),
        ("gait.csv", b"domain,time,x\nD1,0\n", "row 2 has 2 cells, not 3"),
        ("gait.csv", b"domain,time,x\n", "no domain"),
        ("gait.txt", b"", "no motion by its suffix"),
    ],
)
def test_what_is_no_motion_is_refused_in_a_sentence(name: str, content: bytes, says: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=says):
        read_motion(tmp_path / name)


BOMBS: dict[str, tuple[dict[str, Any], str]] = {
    "bytes": ({"D1.times": np.zeros(LARGEST + 1, np.uint8)}, "unpacks to more than"),
    "arrays": ({f"D{n}.times": np.zeros(0) for n in range(MOST_NAMES + 1)}, "holds more than 1000 arrays"),
    "coordinates": ({"coordinates": np.zeros(MOST_NAMES + 1, "U1")}, "its coordinates are no names, or more than 1000"),
    "one number": ({"D1.times": np.arange(3.0), "D1.positions": np.array(1.0)}, "its positions are no table"),
    "long numbers": ({"D1.times": np.arange(3.0), "D1.positions": np.ones((3, 18), np.longdouble)}, "not all numbers"),
    "large numbers": ({"D1.times": np.arange(3.0), "D1.positions": np.full((3, 18), 1e300)}, "a number above 1e"),
    "numbers": ({"coordinates": np.zeros(3)}, "its coordinates are no names"),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_small_file_does_not_fill_the_memory(name: str, tmp_path: Path) -> None:
    """A file of 0.3 MB took 2.4 GB."""
    arrays, says = BOMBS[name]
    np.savez_compressed(tmp_path / "a.npz", **arrays)
    with pytest.raises(InputError, match=says):
        read_motion(tmp_path / "a.npz")


def test_a_table_of_many_domains_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("domain,time,x\n" + "".join(f"D{n},0,1\n" for n in range(MOST_NAMES + 1)))
    with pytest.raises(InputError, match="has more than 1000 domains"):
        read_motion(tmp_path / "a.csv")


def test_a_mat_file_of_many_domains_is_refused(tmp_path: Path) -> None:
    gait = np.zeros((1, 2 * MOST_NAMES + 1), dtype=[("tspan", object), ("states", object)])
    gait["tspan"], gait["states"] = [0.0], [0.0]
    savemat(tmp_path / "a.mat", {"gait": gait})
    with pytest.raises(InputError, match="has more than 1000 domains"):
        read_motion(tmp_path / "a.mat")


def test_a_gait_that_lacks_an_array_is_refused(tmp_path: Path) -> None:
    motion = read_motion(write_motion(random_gait(6), tmp_path / "gait.npz"))
    short = replace(motion, domains=(replace(motion.domains[0], torques=None), *motion.domains[1:]))
    with pytest.raises(InputError, match="has no torques of domain 'D1'"):
        recorded_gait(short)
    with pytest.raises(InputError, match="other domains"):
        recorded_gait(replace(motion, domains=motion.domains[:1]))


@pytest.mark.parametrize(
    ("suffix", "count"), [(".npz", 60), (".csv", 60), (".mat", 3), pytest.param(".mat", 100, marks=pytest.mark.slow)]
)
def test_a_damaged_motion_is_a_gait_or_one_sentence(suffix: str, count: int, tmp_path: Path) -> None:
    """Damage drawn by the fuzzer; a flipped bit of one mat file in some hundred ended the process in SciPy's reader."""
    draw, refused = drawer(suffix), 0
    for seed in range(count):
        (tmp_path / f"motion{suffix}").write_bytes(draw(random.Random(f"motion {seed}"))[0])
        try:
            recorded_gait(read_motion(tmp_path / f"motion{suffix}"))
        except InputError as error:
            refused += 1
            said = str(error)
        else:
            said = "a gait"
        assert said.isprintable()
    assert refused >= count // 3
