"""What expressions do not see: directions along which neither their slopes nor the switches in them change.

A slope alone does not tell: that of sign(x), of floor(x) and of a comparison vanishes.
"""

from __future__ import annotations

import casadi as ca

COMPARED = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE}
"""What they say changes with the difference of their operands."""
DECIDED = {ca.OP_AND: (0, 1), ca.OP_OR: (0, 1), ca.OP_NOT: (0,), ca.OP_IF_ELSE_ZERO: (0,)}
DECIDED |= {ca.OP_SIGN: (0,), ca.OP_FLOOR: (0,), ca.OP_CEIL: (0,), ca.OP_COPYSIGN: (1,)}
"""Which of their operands have a say and no slope."""


def unseen(written: ca.SX, state: ca.SX, along: ca.SX | ca.DM) -> bool:
    """Whether expressions, as they are written, do not change where a state moves along a direction.

    Args:
        written: expressions of the state and of other symbols.
        state: its symbols, (n,).
        along: the direction, (n,), which may depend on the state.
    """
    watched = ca.vertcat(ca.vec(written), switches(written))
    return not ca.sparsify(ca.jtimes(watched, state, along)).nnz()


def switches(written: ca.SX) -> ca.SX:
    """Return what decides the switches in expressions, as a column: a switch changes only where an entry does."""
    symbols = ca.symvar(written)
    function = ca.Function("written", symbols, [written])
    place: dict[int, ca.SX] = {}
    found = []
    for number in range(function.n_instructions()):
        code, operands = function.instruction_id(number), function.instruction_input(number)
        (into, *_) = function.instruction_output(number)
        if code == ca.OP_OUTPUT:
            continue
        if code == ca.OP_INPUT:
            place[into] = symbols[operands[0]]
        elif code == ca.OP_CONST:
            place[into] = ca.SX(function.instruction_constant(number))
        else:
            read = [place[operand] for operand in operands]
            found += [read[0] - read[1]] if code in COMPARED else [read[k] for k in DECIDED.get(code, ())]
            place[into] = ca.SX.unary(code, *read) if len(read) == 1 else ca.SX.binary(code, *read)
    return ca.vertcat(ca.SX(0, 1), *found)
