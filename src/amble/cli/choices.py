"""Options that several commands share."""

from __future__ import annotations

import typer

from amble.defaults import METHODS, Method


def _method(text: str) -> Method:
    if text not in METHODS:
        raise typer.BadParameter(f"'{text}' is not one of {', '.join(METHODS)}")
    return text


METHOD_OPTION = typer.Option(
    help="What chooses the weights: the paper's bilinear matrix inequalities.",
    parser=_method,
    metavar=f"[{'|'.join(METHODS)}]",
)
