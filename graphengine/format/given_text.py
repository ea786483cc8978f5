"""The text of a scene or graph that a program passes in place of a file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_UNSAFE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff\ud800-\udfff]")
"""Characters that JSON leaves as they are, and that YAML does not allow or takes for the end of a line."""


@dataclass(frozen=True, slots=True)
class GivenText:
    """A text that is read like the content of a file.

    Attributes:
        label: name of the text, which messages show and which stands for the name of the file: `<text>` or `<dict>`.
        data: the text, in UTF-8.
        keyed: whether messages show the path of a key in place of line and column; each value begins on a line of its own.
    """

    label: str
    data: bytes
    keyed: bool = False

    @classmethod
    def of_mapping(cls, mapping: Mapping[str, Any]) -> GivenText:
        """Return the text of a mapping of JSON types."""
        text = json.dumps(mapping, indent=1, ensure_ascii=False)
        escaped = _UNSAFE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
        return cls("<dict>", escaped.encode(), keyed=True)

    @classmethod
    def of_text(cls, text: str) -> GivenText:
        """Return a YAML text."""
        return cls("<text>", text.encode("utf-8", "surrogatepass"))
