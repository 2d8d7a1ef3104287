"""Hostile names, drawn with a seed, and the rule that a name must keep, written down a second time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.gait import Gait, Limits

FRAGMENTS = (
    *("*/", "/*", "//", "??/", "??=", "\\", "*", "/", "?", "\n", "\r\n", "\t", "\0", "\x1b[31m", "\x7f", "\u2028"),
    *("\ud800", "\udfff", "\u202e", "\u200b", "\u00a0", "\u00e9", "\u8db3", "\U0001f9b5", " ", "_", "__", "x", "roll"),
    *("@TABLES@", "@ROBOT@", "@X@", "%s", "%n", "{what}", "{0}", "\\g<0>", "\\1", '"', "'", "\\u000a", "$", "$x$"),
    *("\n#include <stdlib.h>\n", "#define int", "|", "[red]", "[/red]", ":leg:", "<b>", "`touch x`", "$(touch x)", ";"),
    *("../", "rate of ", "a" * 60, "0", "D1", "auto", "&amp;", "![a](b)"),
)


def hostile_name(random: np.random.Generator) -> str:
    """Join up to five fragments; now and then the empty name."""
    return "".join(random.choice(FRAGMENTS, size=random.integers(0, 6)))


def allowed(name: str) -> bool:
    """Whether a text may be a name, as CHANGELOG.md says it."""
    return 0 < len(name) <= 100 and name.isprintable() and name == name.strip()


MARKER = "marker"
"""File that an attack makes in the working folder as soon as the compiled code is loaded."""

ATTACK = f'*/\n#include <stdlib.h>\n__attribute__((constructor)) static void f(void){{if(system(">{MARKER}")){{}}}}/*'
ATTACK_ON_ONE_LINE = (
    f'*/__attribute__((constructor))static void f(void){{int system(const char*);if(system(">{MARKER}")){{}}}}/*'
)
"""Names that end a comment of C and begin another; the second keeps the rule for names."""


def with_names(gait: Gait, random: np.random.Generator) -> Gait:
    """The same gait under other names, hostile but allowed: robot, joints, feet, pattern."""
    robot = gait.robot

    def drawn(names: tuple[str, ...]) -> dict[str, str]:
        found: list[str] = []
        while len(found) < len(names):
            name = hostile_name(random)
            if allowed(name) and name not in (*found, "x", "roll") and not name.startswith("rate of "):
                found.append(name)
        return dict(zip(names, found, strict=True))

    joints, feet = drawn(robot.joint_names), drawn(robot.foot_names)
    title, pattern = drawn(("robot", "gait")).values()
    changed = replace(
        robot,
        name=title,
        joints=tuple(replace(joint, name=joints[joint.name]) for joint in robot.joints),
        feet=tuple(replace(foot, name=feet[foot.name]) for foot in robot.feet),
        twins=tuple((feet[left], feet[right]) for left, right in robot.twins),
    )
    stances = tuple(replace(stance, feet=tuple(feet[foot] for foot in stance.feet)) for stance in gait.pattern.stances)
    limits = gait.limits
    return replace(
        gait,
        pattern=replace(gait.pattern, robot=changed, stances=stances, name=pattern),
        outputs=replace(
            gait.outputs,
            domains=tuple(
                replace(domain, coordinates=tuple(joints[name] for name in domain.coordinates))
                for domain in gait.outputs.domains
            ),
        ),
        limits=Limits(
            **{
                **vars(limits),
                "positions": {joints.get(name, name): pair for name, pair in limits.positions.items()},
                "speeds": {joints[name]: value for name, value in limits.speeds.items()},
                "torques": {joints[name]: value for name, value in limits.torques.items()},
            }
        ),
    )
