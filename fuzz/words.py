"""What stands in the place of a sound value: scalars, hostile names, and text that no writer of JSON would write."""

from __future__ import annotations

from typing import Any

NAMES = (
    *(
        "",
        " ",
        "a ",
        "a\nb",
        "a\r\nb",
        "\t",
        "\0",
        "\x1b[31m",
        "\x7f",
        "\u2028",
        "\ud800",
        "a\udfff",
        "\u202e",
        "\u200b",
    ),
    *("*/", "/*", "//", "??/", "\\", '"', "'", "%s", "%n", "{0}", "\\g<0>", "$x$", "@TABLES@", "@ROBOT@", "`x`"),
    *("int", "main", "_", "__", "1", "9a", "é", "足", "🦵", "x", "z", "roll", "rate of x", "acceleration of x", "name"),
    *("../../x", "/", "a/b", ".", "nan", "inf", "true", "null", "0", "D1", "D2", "auto", "x" * 101, "x" * 5000),
    *("\n#include <stdlib.h>\n", "<b>", "&amp;", "![a](b)", "| a |", "[red]", ";", "a=b", "a:b", "a,b", "a.b"),
)
"""Names that end comments, lines or strings, that are taken, or that no file can hold."""

NUMBERS = (
    *(0, 1, -1, 2, 3, 7, 100, 10**6, 2**31, 2**63, 10**39, -(10**39), 10**40, 0.0, -0.0, 0.5, -1.5, 1e-9, 1e-308),
    *(5e-324, 1e16, 1e100, 1e154, 1e155, -1e155, 1e300, 1.7976931348623157e308, -1e308, 3.14159, float("inf"), -2.0),
)

SCALARS: tuple[Any, ...] = (
    *NUMBERS,
    *NAMES[:20],
    *(
        None,
        True,
        False,
        "inf",
        "-inf",
        "nan",
        "NaN",
        "1e999",
        "1_0",
        "1 m",
        "5 deg",
        "٣",
        "m",
        "rad",
        "plane",
        "point",
    ),
    *([], {}, [[]], [[], []], [1.0], [1.0, 2.0], [2.0, 1.0], [None], [[1.0], [1.0, 2.0]], [True], ["a"], [[[1.0]]]),
    *({"value": 1.0}, {"value": 1.0, "unit": "m"}, {"name": "plane"}, {"": 1}, {"a": {"b": {"c": []}}}, [{}]),
)

LITERALS = (
    *(
        "9" * 5000,
        "1" + "0" * 400,
        "-" + "9" * 50,
        "9" * 41,
        "1e999",
        "-1e999",
        "1e400",
        "NaN",
        "Infinity",
        "nan",
        "inf",
    ),
    *("01", "1.", ".5", "0x10", "1_0", "+1", "--1", "[" * 300 + "]" * 300, "[" * 100_000, "[" * 33 + "]" * 33, "'a'"),
    *(
        '{"a":' * 300 + "1" + "}" * 300,
        '"\\ud800"',
        '{"\\udfff": 1}',
        "",
        "{",
        "]",
        "tru",
        '"\\x"',
        '"a',
        "\x00",
        "\ufeff",
    ),
    *('{"a": 1, "a": 2}', "// c", "# c", "1979-05-27", "07:32:00", "'''\n'''", "{ a = 1 }", "0o7", "0b1", "1e5", "-0"),
)
"""Text in the place of a value; what is no JSON or TOML is refused by the parser."""

MARK = "@literal@"
"""Stands in a tree where a literal is put when the tree is written."""

ENCODINGS = ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1", "cp037", "shift_jis", "gb2312")
