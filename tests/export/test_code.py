"""C text for strict compilers: straight-line code, code with calls inside, and text of a form nobody knows."""

from __future__ import annotations

import ctypes
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiler
from amble.control import BoundedMinimumNorm, MinimumPower
from amble.errors import InputError, WorkError
from amble.export import export_controller
from amble.export.code import Code, c_code, comment, filled
from amble.gait import Gait
from tests.control.allocation.stances import chooser, samples
from tests.hostile import ATTACK, hostile_name, with_names

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared")

pytestmark = pytest.mark.skipif(compiler() is None, reason="there is no C compiler")

WARNED = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wtrigraphs", "-Wcomment")
needs_compiler = pytest.mark.skipif(compiler() is None, reason="there is no C compiler")


def evaluate(code: Code, folder: Path, values: list[np.ndarray], sizes: list[int], level: str) -> list[np.ndarray]:
    """Compile strictly at a level of optimisation and call once."""
    tool = compiler()
    assert tool is not None
    (folder / "code.c").write_text(code.text)
    subprocess.run([tool.path, *STRICT, level, "-o", "code.so", "code.c", "-lm"], cwd=folder, check=True)
    function = getattr(ctypes.CDLL(str(folder / "code.so")), code.name)
    function.argtypes = (ctypes.c_void_p,) * 4
    results = [np.zeros(size) for size in sizes]
    pointers = ctypes.POINTER(ctypes.c_double)
    arg = (pointers * code.arguments)(*[value.ctypes.data_as(pointers) for value in values])
    res = (pointers * code.results)(*[result.ctypes.data_as(pointers) for result in results])
    integers, work = np.zeros(max(1, code.integers), dtype=np.int64), np.zeros(max(1, code.work))
    assert function(arg, res, integers.ctypes.data, work.ctypes.data) == 0
    return results


@pytest.mark.parametrize("count", [2, 3, 4])
@pytest.mark.parametrize("law", [MinimumPower(), BoundedMinimumNorm(0.6, 5.0)], ids=lambda law: law.name)
def test_laws_in_c_answer_as_in_python(law: MinimumPower, count: int, tmp_path: Path) -> None:
    function = chooser("astro", count, law)
    names = [f"a{i}" for i in range(function.n_in())]
    dense = [ca.MX.sym(name, *function.size_in(i)) for i, name in enumerate(names)]
    whole = ca.Function("law", dense, [ca.densify(part) for part in function.call(dense)])
    code = c_code(whole, "A law.")
    assert "malloc" not in code.text
    sample = samples("astro", count, 1, seed=12, spread=0.1)[0]
    parts = (sample.torques, sample.torque_basis, sample.forces, sample.force_basis, sample.speeds)
    values = [np.ascontiguousarray(part.ravel(order="F")) for part in parts]
    # the optimiser warns of more; for the longer codes it takes ten times as long
    level = "-O1" if count == 2 else "-O0"
    found = evaluate(code, tmp_path, values, [whole.numel_out(i) for i in range(whole.n_out())], level)
    expected = function.call([ca.DM(part) for part in parts])
    for ours, theirs in zip(found, expected, strict=True):
        # the compiler may round sums of the interior-point steps another way
        assert ours == pytest.approx(np.asarray(theirs.full()).ravel(), rel=1e-7, abs=1e-7)


def test_text_of_an_unknown_form_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    symbol = ca.SX.sym("x")
    monkeypatch.setattr(
        "amble.export.code.cut_into_parts", lambda text, _: text.replace("CASADI_SYMBOL_EXPORT", "EXTERN")
    )
    with pytest.raises(WorkError, match="unknown form"):
        c_code(ca.Function("f", [symbol], [symbol**2]), "A square.")


def test_ordinary_text_stays_as_it_is() -> None:
    for text in ("fl_hip_roll, fl_knee", "Law of stance D1, feet fr, rl.", "hüfte (left) #2; a/b * c? 'x'"):
        assert comment(text) == text


def test_templates_are_filled_in_one_pass() -> None:
    assert filled("@A@ @B@", {"A": "@B@"}, {"B": "@A@ */"}) == "@B@ @A@ * /"
    with pytest.raises(KeyError):
        filled("@UNKNOWN@", {})


@needs_compiler
def test_a_comment_holds_any_text() -> None:
    """Comments of 500 texts in a row leave the compiler nothing to see, and nothing to warn of."""
    random = np.random.default_rng(6)
    texts = [hostile_name(random) for _ in range(500)]
    lines = [f"/* {comment(text)} */\n/* {comment(text)}\n */" for text in [*texts, *("*" * n + "/" for n in range(4))]]
    assert preprocessed("\n".join([*lines, "int x;"])) == "int x;"


def preprocessed(text: str) -> str:
    """What a strict compiler sees: no comment, no line number."""
    tool = compiler()
    assert tool is not None
    command = [tool.path, *WARNED, "-E", "-P", "-xc", "-"]
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.decode().strip()


def program(folder: Path) -> dict[str, str]:
    """Name of every exported file -> what counts in it."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
    found = re.search(r"^#define AMBLE_CONTENT (\w+)$", texts["amble_controller.h"], re.M)
    assert found is not None
    # the id of the content counts comments too; an undefined name is 0 to the preprocessor
    texts = {name: text.replace(found.group(1), "0") for name, text in texts.items()}
    alone = {
        name: "\n".join(line for line in text.splitlines() if "#include" not in line) for name, text in texts.items()
    }
    return {name: preprocessed(text) if name.endswith((".c", ".h")) else text for name, text in alone.items()}


@needs_compiler
def test_names_change_no_program(stabilised_gait: Gait, tmp_path: Path) -> None:
    """Exports under three draws of hostile names compile strictly and equal the plain one but for their comments."""
    export_controller(stabilised_gait, None, tmp_path / "plain")
    plain, tool = program(tmp_path / "plain"), compiler()
    assert tool is not None
    random = np.random.default_rng(7)
    for number in range(3):
        written = export_controller(with_names(stabilised_gait, random), None, tmp_path / str(number))
        assert program(written.folder) == plain
        sources = [path.name for path in written.sources]
        subprocess.run([tool.path, *STRICT, "-fsyntax-only", *sources], cwd=written.folder, check=True)


@needs_compiler
def test_stances_of_any_name_are_exported(stabilised_gait: Gait, tmp_path: Path) -> None:
    """A stance names functions, files and tables; one from Python may have any name."""
    new = {stance.name: f"*/ {stance.name} ??/ ../" for stance in stabilised_gait.pattern.stances}
    gait, feedback = stabilised_gait, stabilised_gait.feedback
    assert feedback is not None
    tables = {
        key: {new[name]: value for name, value in getattr(feedback, key).items()}
        for key in ("references", "weights", "durations")
    }
    stances = tuple(replace(stance, name=new[stance.name]) for stance in gait.pattern.stances)
    domains = tuple(replace(domain, domain=new[domain.domain]) for domain in gait.outputs.domains)
    changed = replace(
        gait,
        pattern=replace(gait.pattern, stances=stances),
        outputs=replace(gait.outputs, domains=domains),
        domains=tuple(replace(domain, name=new[domain.name]) for domain in gait.domains),
        feedback=replace(feedback, **tables),
    )
    written = export_controller(changed, None, tmp_path)
    assert all(
        path.parent == tmp_path and path.name.replace(".", "").replace("_", "").isalnum() for path in written.files
    )
    tool = compiler()
    assert tool is not None
    sources = [path.name for path in written.sources]
    subprocess.run([tool.path, *STRICT, "-fsyntax-only", *sources], cwd=tmp_path, check=True)


def test_the_attack_is_no_name(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="the name of a robot has characters that cannot be printed"):
        replace(stabilised_gait.robot, name=ATTACK)
