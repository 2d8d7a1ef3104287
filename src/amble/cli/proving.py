"""``amble prove``: enclosures instead of estimates, for a gait or a hybrid system written in Python."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import options
from amble.cli.console import progress
from amble.cli.output import result, show, wrote
from amble.errors import InputError, shown
from amble.io.plugins import named_object

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.hybrid import HybridSystem
    from amble.proof import Proof
    from amble.types import Vector


def prove(
    system: Annotated[
        str,
        typer.Argument(
            help="Gait file; or MODULE:NAME or FILE.py:NAME of a pair (HybridSystem, start), or of a function that "
            "returns one.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option(help="Where to write the proof (JSON).")] = Path("proof.json"),
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    verify: Annotated[
        Path | None,
        typer.Option(
            help="Verify this proof of the system instead: nothing is searched, nothing written.", show_default=False
        ),
    ] = None,
    bits: Annotated[
        int | None,
        typer.Option(min=64, max=1024, help="Precision of the arithmetic.", show_default="128"),
    ] = None,
    order: Annotated[
        int | None, typer.Option(min=4, max=40, help="Order of the Taylor steps.", show_default="20; 24 for a gait")
    ] = None,
    basin: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            max=1.0,
            help="Largest radius that is tried for the basin; 0 for none.",
            show_default="0.01; 4e-10 for a gait",
        ),
    ] = None,
) -> None:
    """Prove that a system has a periodic orbit, whether it is exponentially stable, and from how far it attracts."""
    from amble.optional import require

    require("flint", "proof", "proofs")
    from amble.proof import load_proof, save_proof
    from amble.proof import verify as verified
    from amble.proof.sentences import sentences

    subject = _subject(system, control)
    if verify is not None:
        with progress("verifying") as notify:
            verified(load_proof(verify), subject[0] if isinstance(subject, tuple) else subject, notify)
        result(verified=True)
        show(f"every enclosure of '{verify}' was computed again and holds")
        return
    proof = _proved(subject, bits, order, basin)
    for line in sentences(proof):
        show(line)
    result(stable=proof.stable, proved=proof.proved.model_dump(mode="json"))
    wrote(save_proof(out, proof))


def _proved(
    subject: Gait | tuple[HybridSystem, Vector], bits: int | None, order: int | None, basin: float | None
) -> Proof:
    """Prove, with what is not given as it is usual for a gait or a system."""
    from dataclasses import replace

    from amble.proof import GAIT_SETTINGS, Settings, prove, prove_gait

    usual = Settings() if isinstance(subject, tuple) else GAIT_SETTINGS
    tried = usual.basin if basin is None else basin
    settings = replace(usual, bits=bits or usual.bits, order=order or usual.order, basin=tried)
    with progress("proving") as notify:
        if isinstance(subject, tuple):
            return prove(*subject, settings, notify)
        return prove_gait(subject, settings, notify)


def _subject(argument: str, control: str | None) -> Gait | tuple[HybridSystem, Vector]:
    """Read a gait file, or find a system with its start in Python."""
    from amble.gait.files import load_gait

    if Path(argument).suffix.lower() == ".json":
        return options.under(load_gait(argument), control)
    if control is not None:
        raise InputError("--control is another feedback law of a gait; a system in Python is proved as it is written")
    import numpy as np

    from amble.hybrid import HybridSystem

    found = named_object(argument)
    pair = found() if callable(found) else found
    if not (isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], HybridSystem)):
        raise InputError(f"'{shown(argument)}' is no pair (HybridSystem, start)")
    start = np.asarray(pair[1], dtype=np.float64).reshape(-1)
    if start.size != pair[0].state_size:
        raise InputError(f"the start of '{shown(argument)}' has {start.size} numbers, the system {pair[0].state_size}")
    return pair[0], start
