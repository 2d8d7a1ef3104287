"""Around a solver at work: progress after every iteration, Ctrl-C that stops it between two of them, one thread."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import threading
from collections.abc import Iterator
from typing import Any

import casadi as ca
import numpy as np

from amble.progress import Progress, ProgressReport
from amble.synthesis.program import GaitProgram

LOADED = "libcasadi-tp-openblas.so.0"
"""Name of the OpenBLAS in casadi's wheels for Linux."""


class Watch(ca.Callback):
    """Casadi's hook into every iteration."""

    def __init__(self, program: GaitProgram, progress: Progress | None, projected: int = 0) -> None:
        ca.Callback.__init__(self)
        self._program, self._progress = program, progress
        self._count, self._interrupted, self._projected = 0, False, projected
        self.construct("watch", {})

    def get_n_in(self) -> int:
        """As many inputs as a solver has outputs."""
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        """One output: whether to stop."""
        return 1

    def get_name_in(self, i: int) -> str:
        """Return the name of an output of the solver."""
        return str(ca.nlpsol_out(i))

    def get_name_out(self, _: int) -> str:
        """Return the name of the only output."""
        return "stop"

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the size of an output of the solver."""
        sizes = {"f": 1, "x": self._program.layout.size, "lam_x": self._program.layout.size}
        rows = len(self._program.program.row_names)
        sizes |= {"g": rows, "lam_g": rows, "lam_p": self._program.parameters.size}
        return ca.Sparsity.dense(sizes[ca.nlpsol_out(i)], 1)

    def eval(self, arguments: list[ca.DM]) -> list[int]:
        """Report an iteration; stop the solver where Ctrl-C has arrived."""
        if self._progress is not None:
            try:
                self._report(self._progress, {ca.nlpsol_out(i): value for i, value in enumerate(arguments)})
            except KeyboardInterrupt:
                self._interrupted = True
        self._count += 1
        return [int(self._interrupted)]

    @contextlib.contextmanager
    def keeping_interrupts(self) -> Iterator[None]:
        """Keep Ctrl-C until the block has ended: inside the solver it would end as one more solver failure.

        Raises:
            KeyboardInterrupt: at the end, where Ctrl-C arrived.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def keep(*_: Any) -> None:
            self._interrupted = True

        before = signal.signal(signal.SIGINT, keep)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
        if self._interrupted:
            raise KeyboardInterrupt

    def _report(self, progress: Progress, values: dict[str, ca.DM]) -> None:
        nlp = self._program.program
        g = np.array(values["g"]).ravel()
        excess = nlp.excess(g)
        worst = int(np.argmax(excess))
        unit = "" if nlp.row_units[worst] == "1" else f" {nlp.row_units[worst]}"
        missed = f"{nlp.row_scale[worst] * excess[worst]:.2g}{unit}"
        moved = f", {self._projected} start values moved onto their bounds" if self._projected else ""
        progress(
            ProgressReport(
                what="iteration",
                done=self._count,
                quantity="objective",
                value=nlp.cost_scale * float(values["f"]),
                detail=f"worst row '{nlp.row_names[worst]}' violated by {missed}{moved}",
            )
        )


@contextlib.contextmanager
def single_threaded() -> Iterator[None]:
    """Let the OpenBLAS that casadi ships with use one thread inside the block, and as many as before afterwards.

    Measured on the amble with 15 intervals and two busy cores: 0.36 s of processor time an iteration with two threads,
    0.10 s with one. Where casadi was built with another BLAS nothing changes.
    """
    library = loaded_blas()
    if library is None:
        yield
        return
    before = int(library.openblas_get_num_threads())
    library.openblas_set_num_threads(1)
    try:
        yield
    finally:
        library.openblas_set_num_threads(before)


def loaded_blas() -> ctypes.CDLL | None:
    """Find the OpenBLAS that IPOPT has loaded; by its name alone, for a file's path might load a second copy."""
    ca.has_nlpsol("ipopt")  # loads it as well
    try:
        library = ctypes.CDLL(LOADED, mode=getattr(os, "RTLD_NOLOAD", 0) | getattr(os, "RTLD_NOW", 0))
    except OSError:
        return None
    return library if hasattr(library, "openblas_set_num_threads") else None
