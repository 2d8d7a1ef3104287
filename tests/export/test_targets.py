"""The exported C under other compilers, analysers and sanitizers, and on another processor: 64-bit ARM under qemu."""

from __future__ import annotations

import platform
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from amble.control import PseudoInverse
from amble.export import export_controller
from amble.gait import Gait
from amble.gait.impedance import Impedance
from tests.tools import program

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
"""For all files; those written by people, not by casadi, have more warnings on top."""

WRITTEN = ("-Wshadow", "-Wstrict-prototypes", "-Wdouble-promotion", "-Wconversion")

HOSTILE = Path(__file__).with_name("hostile.c")
"""Twenty thousand ticks with numbers that are none, clocks that go backwards and flags drawn at random."""

pytestmark = pytest.mark.targets

KINDS = ("linearisation", "impedance", "impedance in float")


@pytest.fixture(scope="module", params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def folders(stabilised_gait: Gait, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    place = tmp_path_factory.mktemp("targets")
    linearising = export_controller(stabilised_gait, PseudoInverse(), place / "linearisation").folder
    impedance = export_controller(replace(stabilised_gait, control=Impedance()), None, place / "impedance").folder
    return {"linearisation": linearising, "impedance": impedance, "impedance in float": impedance}


def flags_of(kind: str) -> tuple[str, ...]:
    return ("-DAMBLE_FLOAT",) if "float" in kind else ()


def sources(folder: Path) -> list[Path]:
    return sorted(folder.glob("amble_*.c"))


def compile_with(compiler: str, output: Path, *arguments: str | Path) -> None:
    linked = () if "-c" in arguments else ("-lm",)
    done = subprocess.run([compiler, *arguments, "-o", output, *linked], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def replayed(*command: str | Path) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " 0 wrong" in done.stdout
    return done.stdout


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_no_compiler_has_anything_to_say(compiler: str, kind: str, folders: dict[str, Path], tmp_path: Path) -> None:
    tool, folder = program((compiler,), "that compiles C", compiler), folders[kind]
    written = [path for path in (*sources(folder), folder / "replay.c") if not path.name.startswith("amble_law_")]
    warnings = WRITTEN[:-1] if "float" in kind else WRITTEN  # the tables are written in double
    for path in written:
        compile_with(tool, tmp_path / "part.o", *STRICT, *warnings, "-O1", *flags_of(kind), "-c", path)
    compile_with(tool, tmp_path / "replay", *STRICT, "-O1", *flags_of(kind), *sources(folder), folder / "replay.c")
    replayed(tmp_path / "replay", folder / "test_vectors.txt")


def test_cppcheck_has_nothing_to_say(kind: str, folders: dict[str, Path]) -> None:
    tool, folder = program(("cppcheck",), "that checks C", "cppcheck"), folders[kind]
    options = (
        "--std=c99",
        "--enable=warning,portability,performance",
        "--error-exitcode=1",
        "--inline-suppr",
        "--quiet",
    )
    defined = flags_of(kind) or ("-UAMBLE_FLOAT",)
    # the generated laws are straight-line arithmetic without a pointer of their own: for minutes nothing is found
    written = [path for path in (*sources(folder), folder / "replay.c") if not path.name.startswith("amble_law_")]
    done = subprocess.run([tool, *options, *defined, *written], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_nothing_is_undefined_whatever_comes_in(kind: str, folders: dict[str, Path], tmp_path: Path) -> None:
    """Address and undefined-behaviour sanitizers over the vectors and over hostile ticks; every torque is a number."""
    tool, folder = program(("gcc",), "that compiles C", "gcc"), folders[kind]
    sanitized = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    common = (*STRICT, *sanitized, *flags_of(kind), f"-I{folder}")
    objects = []
    for path in sources(folder):
        objects.append(tmp_path / path.with_suffix(".o").name)
        # the law's straight-line code does nothing with whole numbers or pointers: what it reads and writes is watched
        generated = ("-O0", "-fno-sanitize=undefined") if path.name.startswith("amble_law_") else ()
        compile_with(tool, objects[-1], *common, *generated, "-c", path)
    which = () if kind == "linearisation" else ("-DIMPEDANCE",)
    compile_with(tool, tmp_path / "replay", *common, *objects, folder / "replay.c")
    compile_with(tool, tmp_path / "hostile", *common, *which, *objects, HOSTILE)
    replayed(tmp_path / "replay", folder / "test_vectors.txt")
    done = subprocess.run([tmp_path / "hostile"], capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    fell_back, sound = map(int, done.stdout.split())
    assert fell_back > 100
    assert sound > 100


def test_another_processor_answers_the_same(kind: str, folders: dict[str, Path], tmp_path: Path) -> None:
    """The bounds are those of the program itself: 1e-12 in double and 1e-4 in float, of the largest torque."""
    tool = program(
        ("aarch64-linux-gnu-gcc",), "that compiles C for ARM", "gcc-aarch64-linux-gnu, libc6-dev-arm64-cross"
    )
    machine, folder = program(("qemu-aarch64",), "that runs ARM code", "qemu-user"), folders[kind]
    assert platform.machine() != "aarch64", "this test shows nothing on an ARM machine"
    compile_with(
        tool, tmp_path / "replay", *STRICT, "-O1", "-static", *flags_of(kind), *sources(folder), folder / "replay.c"
    )
    replayed(machine, tmp_path / "replay", folder / "test_vectors.txt")


def test_it_is_installed_and_found_by_pkg_config(folders: dict[str, Path], tmp_path: Path) -> None:
    cmake, find = program(("cmake",), "that builds", "cmake"), program(("pkg-config",), "that finds", "pkg-config")
    tool, folder, place = program(("gcc",), "that compiles C", "gcc"), folders["impedance"], tmp_path / "installed"
    for command in (
        ["-S", folder, "-B", tmp_path / "build", f"-DCMAKE_INSTALL_PREFIX={place}"],
        ["--build", tmp_path / "build", "--target", "install"],
    ):
        done = subprocess.run([cmake, *command], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    packages = next(place.glob("**/pkgconfig"))
    asked = subprocess.run(
        [find, "--cflags", "--libs", "amble_controller"],
        env={"PKG_CONFIG_PATH": str(packages)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert asked.returncode == 0, asked.stderr
    source = tmp_path / "replay.c"  # away from the header of the folder
    source.write_bytes((folder / "replay.c").read_bytes())
    compile_with(tool, tmp_path / "replay", *STRICT, source, *asked.stdout.split())
    replayed(tmp_path / "replay", folder / "test_vectors.txt")
