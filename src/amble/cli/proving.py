"""``amble prove``: enclosures instead of estimates, for a hybrid system written in Python."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.console import progress
from amble.cli.output import result, show, wrote
from amble.errors import InputError, shown
from amble.io.plugins import named_object

if TYPE_CHECKING:
    from amble.hybrid import HybridSystem
    from amble.proof import Proof
    from amble.types import Vector


def prove(
    system: Annotated[
        str,
        typer.Argument(
            help="MODULE:NAME or FILE.py:NAME of a pair (HybridSystem, start), or of a function that returns one.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option(help="Where to write the proof (JSON).")] = Path("proof.json"),
    verify: Annotated[
        Path | None,
        typer.Option(
            help="Verify this proof of the system instead: nothing is searched, nothing written.", show_default=False
        ),
    ] = None,
    bits: Annotated[int, typer.Option(min=64, max=1024, help="Precision of the arithmetic.")] = 128,
    order: Annotated[int, typer.Option(min=4, max=40, help="Order of the Taylor steps.")] = 20,
    basin: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Largest radius that is tried for the basin; 0 for none.")
    ] = 1e-2,
) -> None:
    """Prove that a system has a periodic orbit, whether it is exponentially stable, and from how far it attracts."""
    from amble.optional import require

    require("flint", "proof", "proofs")
    from amble.proof import Settings, load_proof, save_proof
    from amble.proof import prove as proved
    from amble.proof import verify as verified

    walker, start = _system(system)
    if verify is not None:
        with progress("verifying"):
            verified(load_proof(verify), walker)
        result(verified=True)
        show(f"every enclosure of '{verify}' was computed again and holds")
        return
    with progress("proving") as notify:
        proof = proved(walker, start, Settings(bits=bits, order=order, basin=basin), progress=notify)
    for line in _sentences(proof):
        show(line)
    result(stable=proof.stable, proved=proof.proved.model_dump(mode="json"))
    wrote(save_proof(out, proof))


def _system(argument: str) -> tuple[HybridSystem, Vector]:
    import numpy as np

    from amble.hybrid import HybridSystem

    if Path(argument).suffix.lower() == ".json":
        raise InputError(
            f"'{shown(argument)}' is a gait: proofs are built for systems written as expressions (MODULE:NAME). The "
            "closed loop of a gait eliminates its torques, which enclosures do not survive; `amble certify` estimates"
        )
    found = named_object(argument)
    pair = found() if callable(found) else found
    if not (isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], HybridSystem)):
        raise InputError(f"'{shown(argument)}' is no pair (HybridSystem, start)")
    start = np.asarray(pair[1], dtype=np.float64).reshape(-1)
    if start.size != pair[0].state_size:
        raise InputError(f"the start of '{shown(argument)}' has {start.size} numbers, the system {pair[0].state_size}")
    return pair[0], start


def _sentences(proof: Proof) -> list[str]:
    """Say what is proved, and what is not."""
    lines = ["proved: exactly one periodic orbit passes the box"]
    lines += [f"  {name} in [{low}, {high}]" for name, (low, high) in proof.proved.state.items()]
    if proof.found.rate is not None:
        lines.append(f"proved: exponentially stable, spectral radius of a cycle at most {proof.found.rate:.10g}")
    elif proof.proved.unstable is not None:
        lines.append(f"proved: unstable, a Floquet multiplier of size at least {proof.proved.unstable}")
    else:
        lines.append("not proved: neither stable nor unstable at this precision")
    if proof.proved.basin_rate is not None:
        reach = ", ".join(f"{value:.3g}" for value in proof.proved.basin_extent)
        lines.append(
            f"proved: attracts from a ball that reaches ({reach}), with at most {proof.proved.basin_rate:.4g} of the "
            "distance left after every cycle"
        )
    return lines
