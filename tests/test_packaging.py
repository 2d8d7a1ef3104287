"""What is built for others: the wheel holds the package, the sdist everything that its own tests need."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import amble

ROOT = Path(__file__).parents[1]
NAME = f"amble-{amble.__version__}"
NEEDED = (
    ".ci/run",
    ".github/workflows/ci.yml",
    ".pre-commit-config.yaml",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "LICENSE",
    "Makefile",
    "README.md",
    "benchmarks/__main__.py",
    "examples/rimless_wheel.py",
    "pyproject.toml",
    "requirements.txt",
    "src/amble/py.typed",
    "tests/data/stabilised-amble.json",
)

SOME_TESTS = (
    "tests/test_public.py",
    "tests/numerics",
    "tests/stability/test_walkers.py",
    "tests/benchmarks/test_main.py",
)
"""Tests that run in the unpacked sdist; all would take as long as the suite."""


def run(*command: str, where: Path, path: Path | None = None) -> str:
    """Run a program and return what it printed; it finds modules in ``path`` first."""
    environment = {**os.environ, "PYTHONPATH": str(path or "")}
    done = subprocess.run(command, cwd=where, env=environment, capture_output=True, text=True, check=False, timeout=500)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist, and the wheel that was built from it."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT), where=folder)
    return folder


@pytest.fixture(scope="module")
def unpacked(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tree of the sdist."""
    folder = tmp_path_factory.mktemp("sdist")
    with tarfile.open(built / f"{NAME}.tar.gz") as archive:
        archive.extractall(folder, filter="data")
    return folder / NAME


def files_under(folder: Path) -> set[str]:
    """Every file below a folder, but what running Python leaves there."""
    paths = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {path.as_posix() for path in paths if "__pycache__" not in path.parts}


def test_the_sdist_holds_what_its_tests_need(unpacked: Path) -> None:
    assert set(NEEDED) - files_under(unpacked) == set()
    assert [place for place in SOME_TESTS if not (unpacked / place).exists()] == []
    assert os.access(unpacked / ".ci" / "run", os.X_OK)


@pytest.mark.skipif(not (ROOT / ".git").exists() or shutil.which("git") is None, reason="not a clone")
def test_the_sdist_holds_every_file_of_the_clone(unpacked: Path) -> None:
    tracked = run("git", "ls-files", "-z", where=ROOT).split("\0")
    present = {name for name in tracked if name and (ROOT / name).exists()}
    assert present - files_under(unpacked) == set()


def test_the_wheel_holds_the_package_and_nothing_else(built: Path) -> None:
    with zipfile.ZipFile(built / f"{NAME}-py3-none-any.whl") as archive:
        names = {name for name in archive.namelist() if not name.startswith(f"{NAME}.dist-info/")}
    assert names == {f"amble/{name}" for name in files_under(ROOT / "src" / "amble")}


def test_the_wheel_runs_outside_of_the_clone(built: Path, tmp_path: Path) -> None:
    """Its own dependencies are those of this environment; the package is the installed one."""
    wheel, target = built / f"{NAME}-py3-none-any.whl", tmp_path / "target"
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--no-deps", "--no-index")
    run(*pip, "--target", str(target), str(wheel), where=tmp_path)
    where = run(sys.executable, "-c", "import amble; print(amble.__file__)", where=tmp_path, path=target)
    assert Path(where.strip()) == target / "amble" / "__init__.py"
    assert "reproduce" in run(sys.executable, "-m", "amble", "--help", where=tmp_path, path=target)
    assert "astro" in run(sys.executable, "-m", "amble", "robots", where=tmp_path, path=target)


@pytest.mark.slow
def test_the_tests_of_the_sdist_run(unpacked: Path) -> None:
    pytest_of = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider")
    run(*pytest_of, "--collect-only", where=unpacked, path=unpacked / "src")
    assert " passed" in run(*pytest_of, *SOME_TESTS, where=unpacked, path=unpacked / "src")


def test_the_citation_names_this_version() -> None:
    assert f"\nversion: {amble.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_the_changelog_dates_this_version_and_tells_each_kind_of_change_once() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(rf"^## \[{re.escape(amble.__version__)}\] - \d{{4}}-\d\d-\d\d$", text, re.MULTILINE)
    for section in text.split("\n## [")[1:]:
        kinds = re.findall(r"^### (.+)$", section, re.MULTILINE)
        assert len(kinds) == len(set(kinds)), section[:40]


def test_those_who_receive_a_release_accept_it(built: Path) -> None:
    pytest.importorskip("twine", reason="twine comes with the extra test")
    archives = sorted(str(path) for path in built.iterdir())
    assert len(archives) == 2
    said = run(sys.executable, "-m", "twine", "check", "--strict", *archives, where=built)
    assert said.count("PASSED") == 2


def test_the_conda_recipe_says_what_the_package_says() -> None:
    rattler = pytest.importorskip("rattler_build", reason="py-rattler-build comes with the extra test")
    recipe = rattler.Stage0Recipe.from_file(str(ROOT / "recipe.yaml")).to_dict()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert recipe["context"]["version"] == amble.__version__
    needed = [line.replace(" ", "") for line in recipe["requirements"]["run"]]
    assert needed == [f"python{project['requires-python']}", *project["dependencies"]]
    with pytest.raises(rattler.RecipeParseError):
        rattler.Stage0Recipe.from_yaml("package: [")
