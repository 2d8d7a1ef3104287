"""A contact of one's own: a small round foot that also resists turning about the ground's normal.

One class, one registration; then files can name it. Sliding and turning share the friction of the patch: the load
|f_t| + |m| / r may be as large as mu f_n.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Any

import casadi as ca

from amble.errors import InputError
from amble.hybrid import CONTACTS, Contact
from amble.hybrid.ground import CASADI, components


@dataclass(frozen=True)
class TorsionalContact(Contact):
    """Three forces and a moment about the normal.

    Attributes:
        radius: effective radius r of the patch, m.

    Raises:
        InputError: the radius is not positive.
    """

    radius: float

    def __post_init__(self) -> None:
        """Refuse a patch without size."""
        if not 0.0 < self.radius < float("inf"):
            raise InputError(f"the radius of the contact is {self.radius:g} m; it must be finite and positive")

    @property
    def name(self) -> str:
        """Name in files."""
        return "torsional"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """What a file holds, besides the name."""
        return {"radius": self.radius}

    @property
    def moments(self) -> tuple[str, ...]:
        """One moment."""
        return ("twist",)

    @property
    def moment_signs(self) -> tuple[float, ...]:
        """A mirror reverses turning about the normal."""
        return (-1.0,)

    def moment_axes(self, frame: Any) -> Any:
        """It acts about the normal."""
        return frame[:, 2] if isinstance(frame, CASADI) else frame[..., 2:]

    def tangential(self, local: Any) -> Any:
        """Return |f_t| + |m| / r."""
        x, y, _, twist = components(local)
        return (x**2 + y**2) ** 0.5 + (twist**2) ** 0.5 / self.radius

    @property
    def sides(self) -> tuple[str, ...]:
        """Four directions of sliding, two of turning."""
        return tuple(f"{side}{turn}" for side in ("+x", "-x", "+y", "-y") for turn in ("+twist", "-twist"))

    def pyramid(self, local: Any, friction: Any) -> ca.SX:
        """sqrt(2) |f_1| + |m| / r and sqrt(2) |f_2| + |m| / r at most mu f_n."""
        x, y, normal, twist = components(local)
        loads = [sqrt(2.0) * side + turn / self.radius for side in (x, -x, y, -y) for turn in (twist, -twist)]
        return ca.vertcat(*[friction * normal - load for load in loads])


CONTACTS.register("torsional", TorsionalContact)
