"""Finds instructions that install this project by its name, which work only once the name is its own on PyPI."""

from __future__ import annotations

import re

_INSTALL = r"(?:\b(?:pip3?|pipx|uv|poetry|conda|mamba|pixi)\b[^\n`#;&|]*?\b(?:install|add|download|wheel)\b|\buvx\b|\bpipx run\b)"
_NAME = r"(?<![\w./~-])['\"]?(?:graphrun|graphengine)(?:\[[\w,]*\])?(?:\s*(?:[=<>~!]=|@)[^\s'\"]*)?['\"]?(?![\w/.-])"
_COMMAND = re.compile(rf"{_INSTALL}[^\n`#;&|]*?{_NAME}")
_REQUIREMENT = re.compile(r"^[\s-]*['\"]?(?:graphrun|graphengine)(?:\[[\w,]*\])?\s*(?:[=<>~!]=|@).*", re.MULTILINE)


def by_name(text: str) -> list[str]:
    """Return the commands and requirements in a text that install `graphrun` or `graphengine` from an index."""
    return [found[0] for pattern in (_COMMAND, _REQUIREMENT) for found in pattern.finditer(text)]
