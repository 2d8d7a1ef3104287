"""Cut long straight-line functions of generated C into parts, so that the compiler needs minutes no longer.

Register allocation grows faster than a function's length; the parts are compiled each by itself. What one part computes
and a later one reads passes through an array. Every operation stays as it was and in its order, so the numbers are the
same bit for bit.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import casadi as ca

logger = logging.getLogger("amble")

PART = 500
"""Statements a part. For 77,000 instructions gcc -O1 took 11.5 s with 250, 13.6 with 500, 14.9 with 2000, 56 whole."""

_HEAD = re.compile(
    r"static int (\w+)\(const casadi_real\*\* arg, casadi_real\*\* res, casadi_int\* iw, casadi_real\* w, int mem\) \{"
)
_ASSIGNMENT = re.compile(r"  (a\d+)=(.*);")
_RESULT = re.compile(r"  if \(res\[\d+\]!=0\) res\[\d+\]\[\d+\]=(.*);")
_VARIABLE = re.compile(r"\ba\d+\b")
_DECLARATION = "  casadi_real a"
_LAST = "  return 0;"
_COLUMNS = 12


@dataclass(frozen=True)
class _Statement:
    """One line of C: the variable it assigns (none for a result) and those it reads."""

    line: str
    assigned: str | None
    read: tuple[str, ...]


@dataclass(frozen=True)
class _Part:
    """Consecutive statements, the variables they need from earlier parts, and those that later parts need."""

    statements: Sequence[_Statement]
    needed: frozenset[str]
    assigned: frozenset[str]
    kept: frozenset[str]


def cut_into_parts(text: str, functions: Sequence[ca.Function], size: int = PART) -> str:
    """Cut every straight-line function of more than two parts' length; other functions stay as they are.

    Where a long one could not be cut, since casadi writes it in a form that is not known here, a notice is logged.

    Args:
        text: C text that casadi generated.
        functions: what it was generated from.
        size: statements a part.
    """
    lines = text.split("\n")
    out: list[str] = []
    position = done = 0
    while position < len(lines):
        head = _HEAD.fullmatch(lines[position])
        if head is None:
            out.append(lines[position])
            position += 1
            continue
        end = lines.index("}", position)
        body = lines[position + 1 : end]
        cut = _cut(head.group(1), lines[position], body, size)
        done += cut is not None
        out.extend(cut or lines[position : end + 1])
        position = end + 1
    # inputs, operations and results are one line each; the margin is for those that need none
    long = [f for f in functions if f.is_a("SXFunction") and f.n_instructions() > 4 * size]
    if done < len(long):
        logger.warning(
            "of %d long functions (%s) %d are compiled in parts and the others in one piece, which may take minutes: "
            "casadi %s writes C in a form that amble does not know",
            len(long),
            ", ".join(f.name() for f in long),
            done,
            ca.__version__,
        )
    return "\n".join(out)


def _cut(name: str, head: str, body: Sequence[str], size: int) -> list[str] | None:
    code = [line for line in body if not line.startswith(_DECLARATION)]
    if len(code) <= 2 * size or code[-1] != _LAST:
        return None
    statements = [_parse(line) for line in code[:-1]]
    known = [statement for statement in statements if statement is not None]
    if len(known) < len(statements):
        return None
    parts = _parts(known, size)
    slots: dict[str, int] = {}
    for part in parts:
        for variable in sorted(part.needed | part.kept):
            slots.setdefault(variable, len(slots))
    out = [line for number, part in enumerate(parts) for line in _part_lines(f"{name}_part{number}", part, slots)]
    calls = [f"  {name}_part{number}(arg, res, s);" for number in range(len(parts))]
    return [*out, head, f"  casadi_real s[{max(len(slots), 1)}];", *calls, _LAST, "}"]


def _parse(line: str) -> _Statement | None:
    assignment = _ASSIGNMENT.fullmatch(line)
    if assignment:
        return _Statement(line, assignment.group(1), tuple(_VARIABLE.findall(assignment.group(2))))
    result = _RESULT.fullmatch(line)
    if result:
        return _Statement(line, None, tuple(_VARIABLE.findall(result.group(1))))
    return None


def _parts(statements: Sequence[_Statement], size: int) -> list[_Part]:
    """Group the statements; which variables outlive a part follows backwards from the last one."""
    groups = [statements[start : start + size] for start in range(0, len(statements), size)]
    parts: list[_Part] = []
    alive: frozenset[str] = frozenset()
    for group in reversed(groups):
        needed: set[str] = set()
        assigned: set[str] = set()
        for statement in group:
            needed.update(variable for variable in statement.read if variable not in assigned)
            if statement.assigned:
                assigned.add(statement.assigned)
        parts.append(_Part(group, frozenset(needed), frozenset(assigned), alive & assigned))
        alive = frozenset(needed | (alive - assigned))
    return parts[::-1]


def _part_lines(name: str, part: _Part, slots: dict[str, int]) -> Iterator[str]:
    """C of one part: a variable is fetched just before its first use and stored right after its last assignment."""
    yield f"static __attribute__((noinline)) void {name}(const casadi_real** arg, casadi_real** res, casadi_real* s) {{"
    names = sorted(part.needed | part.assigned)
    for start in range(0, len(names), _COLUMNS):
        yield f"  casadi_real {', '.join(names[start : start + _COLUMNS])};"
    last = {statement.assigned: number for number, statement in enumerate(part.statements) if statement.assigned}
    waiting = set(part.needed)
    for number, statement in enumerate(part.statements):
        for variable in statement.read:
            if variable in waiting:
                waiting.discard(variable)
                yield f"  {variable}=s[{slots[variable]}];"
        yield statement.line
        if statement.assigned in part.kept and last[statement.assigned] == number:
            yield f"  s[{slots[statement.assigned]}]={statement.assigned};"
    yield "}"
