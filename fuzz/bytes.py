"""Damage to bytes: flipped, cut, doubled, moved, in another encoding."""

from __future__ import annotations

import random

from fuzz.words import ENCODINGS


def damaged(content: bytes, draw: random.Random) -> tuple[bytes, str]:
    """Return the content with one thing changed, and what."""
    kind = draw.choice(("flip", "flip", "put", "cut", "drop", "double", "move", "encode", "append"))
    at = draw.randrange(len(content) + 1)
    piece = content[at : at + draw.choice((1, 2, 8, 64, 1000))]
    if kind == "flip" and at < len(content):
        changed = bytearray(content)
        for _ in range(draw.choice((1, 1, 1, 4, 16))):
            changed[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
        return bytes(changed), "flip"
    if kind == "put":
        return content[:at] + draw.randbytes(draw.randrange(1, 9)) + content[at:], f"put at {at}"
    if kind == "cut":
        return content[:at], f"cut at {at}"
    if kind == "drop":
        return content[:at] + content[at + len(piece) :], f"drop {len(piece)} at {at}"
    if kind == "double":
        return content[:at] + piece + content[at:], f"double {len(piece)} at {at}"
    if kind == "move":
        to = draw.randrange(len(content) + 1)
        return content[:to] + piece + content[to + len(piece) :], f"move {len(piece)} from {at} to {to}"
    if kind == "encode":
        encoding = draw.choice(ENCODINGS)
        return content.decode("utf-8", "replace").encode(encoding, "replace"), f"encode as {encoding}"
    return content + draw.choice((b"\x00", b"\n\n", b"}", b"\xff", content[:100])), "append"
