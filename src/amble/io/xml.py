"""XML that others wrote: parsed without entities of its own, which make a small file a large text."""

from __future__ import annotations

from xml.etree import ElementTree

ENTITY = "<!ENTITY"
"""How a declaration begins. The parser bounds a text only to a hundred times its size: 8 MB would become 800."""


def parse_xml(content: str | bytes) -> ElementTree.Element:
    """Return the root element.

    Args:
        content: the text, or its bytes in the encoding that they declare.

    Raises:
        ElementTree.ParseError: it is not well-formed.
        ValueError: it declares an entity, or the parser does not know its encoding.
        LookupError: there is no such encoding.
    """
    plain = content if isinstance(content, str) else content.replace(b"\0", b"").decode("latin-1")  # also of UTF-16
    if ENTITY in plain:
        raise ValueError("it declares an entity; write the text where it stands")
    return ElementTree.fromstring(content)
