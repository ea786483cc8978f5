"""The text of a scene or graph that a program passes instead of a file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_UNSAFE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff\ud800-\udfff]")
"""Characters that JSON does not escape, and that YAML forbids or reads as line ends."""
_NOT_FINITE = re.compile(r'^( *(?:".*": )?-?)(Infinity|NaN)(,?)$', re.MULTILINE)
"""Lines with a number that JSON and YAML write differently."""


@dataclass(frozen=True, slots=True)
class GivenText:
    """A text that is read like the content of a file.

    Attributes:
        label: name that messages show instead of a file name: `<text>` or `<dict>`.
        data: the text, in UTF-8.
        keyed: whether messages show the path of a key instead of line and column; each value then begins on a new line.
    """

    label: str
    data: bytes
    keyed: bool = False

    @classmethod
    def of_mapping(cls, mapping: Mapping[str, Any]) -> GivenText:
        """Return the text of a mapping of JSON types."""
        text = json.dumps(mapping, indent=1, ensure_ascii=False)
        text = _NOT_FINITE.sub(lambda found: f"{found[1]}.{found[2][:3].lower()}{found[3]}", text)
        escaped = _UNSAFE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
        return cls("<dict>", escaped.encode(), keyed=True)

    @classmethod
    def of_text(cls, text: str) -> GivenText:
        """Return a YAML text."""
        return cls("<text>", text.encode("utf-8", "surrogatepass"))
