"""Parses JSON from untrusted sources, after a check of the number of values and of the nesting."""

from __future__ import annotations

import json
import re
from typing import Any

MAX_BYTES = 1_000_000
"""Default maximum size of a text, bytes."""
MAX_PARTS = 4_000_000
"""Maximum number of `[`, `{` and `,` outside of strings."""
MAX_CONTAINERS = 1_250_000
"""Maximum number of lists and objects; an empty list takes 25 times the memory of its text."""
MAX_DEPTH = 40
"""Maximum nesting depth of lists and objects."""

_STRING = re.compile(rb'"[^"\\]*+(?:\\.[^"\\]*+)*+(?:"|\\?\Z)', re.DOTALL)
_FEW = 100
"""Number of unbalanced brackets up to which Python's parser reports the error, with the error's position."""
_NO_BRACKETS = bytes(set(range(256)).difference(b"[]{}"))


def parse(text: str | bytes, most: int = MAX_BYTES) -> Any:
    """Return the value of a JSON text in UTF-8.

    Args:
        text: any text.
        most: maximum size of the text, bytes.

    Raises:
        ValueError: the text is not JSON, or exceeds a limit.
    """
    data = text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass")
    if len(data) > most:
        raise ValueError(f"it is larger than {most / 1e6:g} MB")
    bare = _STRING.sub(b"", data)
    containers = bare.count(b"[") + bare.count(b"{")
    if containers > MAX_CONTAINERS or containers + bare.count(b",") > MAX_PARTS:
        raise ValueError(f"it has more than {MAX_CONTAINERS} lists and objects, or {MAX_PARTS} values")
    brackets = bare.translate(None, _NO_BRACKETS)
    for _ in range(MAX_DEPTH):  # each pass removes at least the innermost level
        brackets = brackets.replace(b"[]", b"").replace(b"{}", b"")
    if len(brackets) > _FEW or (brackets and brackets.count(b"[") + brackets.count(b"{") == len(brackets) / 2):
        raise ValueError(f"its brackets do not match, or are nested more than {MAX_DEPTH} levels deep")
    return json.loads(data.decode() if isinstance(text, bytes) else text)
