"""The YAML 1.2 core schema, which determines the type of a plain scalar: `no` and `12:30:00` are strings, `1e3` is a number."""

from __future__ import annotations

import math
import re
from typing import Any

from graphengine.format.diagnostics import Findings, Span

_NULL = re.compile(r"(?:~|null|Null|NULL|)\Z")
_BOOL = re.compile(r"(?:true|True|TRUE|false|False|FALSE)\Z")
_INT = re.compile(r"(?:[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)\Z")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_NOT_FINITE = re.compile(r"(?:[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))\Z")


def resolve(text: str, span: Span, findings: Findings) -> Any:
    """Return the Python value of a plain scalar; add an error for a number with too many digits."""
    if _NULL.match(text):
        return None
    if _BOOL.match(text):
        return text[0] in "tT"
    if _INT.match(text):
        if len(text) > 40:
            findings.add("G109", "the whole number has more than 40 characters", span)
            return 0
        return int(text, 0 if text[:2] in ("0o", "0x") else 10)
    if _FLOAT.match(text):
        number = float(text)
        if math.isinf(number):
            findings.add("G109", f"{text[:80]} is too large for a number", span, "write infinity as .inf")
            return 0.0
        return number
    return float(text.replace(".", "")) if _NOT_FINITE.match(text) else text
