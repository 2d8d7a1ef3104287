"""A quadruped's URDF written for tests, 11 kg with legs of 0.4 m, and what files in use have in them."""

from __future__ import annotations

from pathlib import Path

FEET = {"fl": "lf_foot", "fr": "rf_foot", "rl": "lh_foot", "rr": "rh_foot"}
PLACES = {"lf": (1, 1), "rf": (1, -1), "lh": (-1, 1), "rh": (-1, -1)}


def inertial(mass: float, center: str, moments: str) -> str:
    """An inertial element with a diagonal inertia."""
    xx, yy, zz = moments.split()
    return (
        f'<inertial><origin xyz="{center}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/></inertial>'
    )


def joint(name: str, parent: str, child: str, at: str, axis: str, inside: str = "", kind: str = "revolute") -> str:
    """A joint with limits."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{at}"/>'
        f'<axis xyz="{axis}"/><limit lower="-2.6" upper="2.6" effort="20" velocity="25"/>{inside}</joint>'
    )


def urdf(
    extra: str = "",
    inside: str = "",
    abad: str | None = None,
    base: str = "trunk",
    heavier: float = 1.0,
    out: float = 0.0,
) -> str:
    """Return the file.

    Args:
        extra: further elements.
        inside: further elements of every leg joint.
        abad: inertial element of the links between hip and thigh.
        base: name of the base link.
        heavier: factor on the mass of the left front thigh.
        out: how far the left front hip is too far out, m.
    """
    parts = [f'<link name="{base}">{inertial(6.0, "0 0 0", "0.04 0.09 0.11")}</link>']
    for leg, (x, y) in PLACES.items():
        wrong = leg == "lf"
        hip = inertial(0.5, f"0 {0.02 * y} 0", "0.0003 0.0003 0.0003") if abad is None else abad
        thigh = inertial(0.6 * (heavier if wrong else 1.0), "0 0 -0.08", "0.00208 0.00208 0.00016")
        parts += [
            f'<link name="{leg}_abad">{hip}</link><link name="{leg}_thigh">{thigh}</link>',
            f'<link name="{leg}_shank">{inertial(0.15, "0 0 -0.09", "0.000505 0.000505 1e-05")}</link>',
            f'<link name="{leg}_foot"/>',
            joint(f"{leg}_hx", base, f"{leg}_abad", f"{0.19 * x} {0.06 * y + out * wrong} 0", "1 0 0", inside),
            joint(f"{leg}_hy", f"{leg}_abad", f"{leg}_thigh", f"0 {0.07 * y} 0", "0 1 0", inside),
            joint(f"{leg}_kn", f"{leg}_thigh", f"{leg}_shank", "0 0 -0.2", "0 1 0", inside),
            joint(f"{leg}_ankle", f"{leg}_shank", f"{leg}_foot", "0 0 -0.2", "1 0 0", kind="fixed"),
        ]
    return f'<?xml version="1.0"?><robot name="padda">{"".join(parts)}{extra}</robot>'


def urdf_of_four_joints() -> str:
    """Return the file with a fourth joint in every leg: an ankle that pitches, and a toe of 8 cm below it."""
    text, tips = urdf(), []
    for leg in PLACES:
        fixed = joint(f"{leg}_ankle", f"{leg}_shank", f"{leg}_foot", "0 0 -0.2", "1 0 0", kind="fixed")
        text = text.replace(fixed, joint(f"{leg}_ankle", f"{leg}_shank", f"{leg}_meta", "0 0 -0.2", "0 1 0"))
        tips += [
            f'<link name="{leg}_meta">{inertial(0.05, "0 0 -0.04", "4e-5 4e-5 2e-6")}</link>',
            joint(f"{leg}_tip", f"{leg}_meta", f"{leg}_foot", "0 0 -0.08", "1 0 0", kind="fixed"),
        ]
    return text.replace("</robot>", "".join(tips) + "</robot>")


def write(folder: Path, *args: str, **kwargs: object) -> Path:
    """Write the file into a folder."""
    file = folder / "padda.urdf"
    file.write_text(urdf(*args, **kwargs))  # type: ignore[arg-type]
    return file
