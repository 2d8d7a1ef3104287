"""C text for strict compilers: straight-line code, code with calls inside, and text of a form nobody knows."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiler
from amble.control import BoundedMinimumNorm, MinimumPower
from amble.errors import WorkError
from amble.export.code import Code, c_code
from tests.control.allocation.stances import chooser, samples

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-fPIC", "-shared")

pytestmark = pytest.mark.skipif(compiler() is None, reason="there is no C compiler")


def evaluate(code: Code, folder: Path, values: list[np.ndarray], sizes: list[int]) -> list[np.ndarray]:
    """Compile strictly and call once."""
    tool = compiler()
    assert tool is not None
    (folder / "code.c").write_text(code.text)
    subprocess.run([tool.path, *STRICT, "-o", "code.so", "code.c", "-lm"], cwd=folder, check=True)
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
    found = evaluate(code, tmp_path, values, [whole.numel_out(i) for i in range(whole.n_out())])
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
