"""Finds the positions of prims in USDA files for findings; binary files have no positions."""

from __future__ import annotations

import re
from pathlib import Path

from graphengine.format.diagnostics import Source, Span

MAX_BYTES = 16_000_000
"""Maximum size of a USDA file that is searched for prims, bytes."""
MAX_PATHS = 50_000_000
"""Maximum length of all prim paths together, characters; the search for prims stops when it is exceeded."""

_TOKEN = re.compile(
    r'''#[^\n]*|"""(?:\\.|[^\\])*?(?:"""|\Z)|@[^@\n]*@?|<[^>\n]*>?|[(){}]'''
    r"""|\b(?:def|over)\s+(?:\w+\s+)?"(?P<name>[^"\n]+)"|"(?:\\[^\n]|[^"\\\n])*"?"""
    r"""|'''(?:\\.|[^\\])*?(?:'''|\Z)|'(?:\\[^\n]|[^'\\\n])*'?""",
    re.DOTALL,
)
"""Matches the beginnings of prims, brackets, and all tokens that may contain brackets: comments, strings, file names, paths.

An unterminated token extends as far as possible, so that the search takes linear time.
"""


class PrimSpans:
    """The spans of the prims in a USD file; binary and too large files have none.

    Args:
        path: USD file.
    """

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
        text = raw.decode("utf-8", "replace") if raw.startswith(b"#usda") and len(raw) <= MAX_BYTES else ""
        self.source = Source(str(path), tuple(text.split("\n")) if text else ())
        self.start = Span(Source(str(path), ()), 1, 1)
        self._spans: dict[str, Span] = {}
        self._read(text)

    def of(self, prim: str) -> Span:
        """Return the span of a prim's name, or the beginning of the file if the prim was not found."""
        return self._spans.get(prim, self.start)

    def of_file(self, name: str) -> Span | None:
        """Return the span of the first reference `@NAME@` to the file `name`; None if the file has no such reference."""
        named = f"@{name}@"
        for number, line in enumerate(self.source.lines, 1):
            if (column := line.find(named)) >= 0:
                return Span(self.source, number, column + 2, len(name))
        return None

    def _read(self, text: str) -> None:
        """Find the prims and their paths from the nesting of `{}`, except in metadata, which is in parentheses."""
        above, begun, parentheses = [""], "", 0
        line, line_start, before, left = 1, 0, 0, MAX_PATHS
        for token in _TOKEN.finditer(text):
            word, name = token[0], token["name"]
            if name is not None and not parentheses:
                begun, at = f"{above[-1]}/{name}", token.start("name")
                line += text.count("\n", before, at)
                line_start = max(line_start, text.rfind("\n", before, at) + 1)
                before, left = at, left - len(begun)
                if left < 0:
                    return
                span = Span(self.source, line, at - line_start + 1, len(name))
                self._spans.setdefault(begun, span)
            elif word in "()":
                parentheses += 1 if word == "(" else -1
            elif word == "{" and not parentheses:
                above.append(begun or above[-1])
                begun = ""
            elif word == "}" and not parentheses and len(above) > 1:
                above.pop()
