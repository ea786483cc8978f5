"""All generated pages, and the command that writes them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from tests.cli.harness import ROOT
from tests.docs.generate import diagnostics, keys, limits, nodes, python_api, verbs

REFERENCE = ROOT / "docs/reference"
_NOTE = "<!-- Written by `python -m tests.docs.generate`. -->\n\n"


def pages() -> Iterator[tuple[Path, str]]:
    """Yield path and text of each generated file."""
    for module in (verbs, keys, diagnostics, python_api, limits, nodes):
        for name, text in module.pages():
            yield REFERENCE / name, text if name.endswith(".svg") else _NOTE + _without_escaped_bars(text)


def _without_escaped_bars(text: str) -> str:
    """Return a page whose tables have the word `or` in the place of bars: the site shows the backslash before a bar in code."""
    return re.sub(r" ?\\\| ?", " or ", text)


def write() -> int:
    """Write the pages, and remove files of node types that are gone; return the number of files."""
    written = set()
    for path, text in pages():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        written.add(path)
    for path in set((REFERENCE / "nodes").rglob("*.*")) - written:
        path.unlink()
    return len(written)
