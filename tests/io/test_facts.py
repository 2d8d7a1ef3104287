"""Tables of facts in HTML: what a name holds is text."""

from amble.io.facts import facts_html, rows_html


def test_facts_are_rows_and_names_are_text() -> None:
    shown = facts_html("a & b", {"<i>": "1\n2", "speed": "0.2 m/s"})
    assert shown == (
        "<table><caption>a &amp; b</caption><tbody><tr><td>&lt;i&gt;</td><td>1\\n2</td></tr>"
        "<tr><td>speed</td><td>0.2 m/s</td></tr></tbody></table>"
    )


def test_a_head_is_there_where_it_is_given() -> None:
    assert "<thead><tr><th>x</th></tr></thead>" in rows_html("t", ("x",), [("1",)])
