"""Formats of findings besides plain text: with colours for terminals, and as annotations for GitHub Actions."""

from __future__ import annotations

import os
import re
from pathlib import Path

from graphengine.format.diagnostics import CODES, Finding
from graphengine.format.wording import printable

COLOURS = {"error": "1;31", "warning": "1;33", "note": "1;36"}
"""A dict from severities to parameters of the escape sequence SGR: bold red, bold yellow, bold cyan."""


def coloured(finding: Finding, text: str) -> str:
    """Return the rendered text of a finding with its severity, code and carets in the colour of the severity."""
    start, reset = f"\x1b[{COLOURS[finding.severity]}m", "\x1b[0m"
    title = f"{finding.severity} {finding.code}"
    text = text.replace(title, f"{start}{title}{reset}", 1)
    return re.sub(r"^( {7}\| *)(\^+)$", rf"\g<1>{start}\g<2>{reset}", text, flags=re.MULTILINE)


def annotation(finding: Finding, root: Path) -> str:
    """Return the workflow command with which GitHub Actions shows a finding at its line in a pull request.

    Args:
        finding: the finding.
        root: root folder of the repository, to which the path in the command is relative.
    """
    properties = {"title": f"{finding.code}: {CODES[finding.code]}"}
    if (span := finding.span) is not None:
        path = os.path.realpath(span.source.path)
        path = os.path.relpath(path, root) if Path(path).is_relative_to(root) else path
        place = {"file": path, "line": span.line, "col": span.column, "endColumn": span.column + span.length}
        properties = {name: str(value) for name, value in place.items()} | properties
    related = [f"{span}: {label}" for span, label in finding.related]
    text = "\n".join([finding.message, *finding.help, *related])
    given = ",".join(f"{name}={_escaped(value, ':,')}" for name, value in properties.items())
    return f"::{finding.severity.replace('note', 'notice')} {given}::{_escaped(text)}"


def _escaped(text: str, more: str = "") -> str:
    """Return the text with `%`, line ends and the characters in `more` encoded for GitHub's runner."""
    encoded = (f"%{ord(c):02X}" if c in f"%\r\n{more}" else c for c in text)
    return printable("".join(encoded))


def repository_root() -> Path:
    """Return the root folder of the repository around the working directory.

    It is `GITHUB_WORKSPACE` in GitHub Actions, else the nearest folder with `.git`, else the working directory.
    """
    if workspace := os.environ.get("GITHUB_WORKSPACE"):
        return Path(os.path.realpath(workspace))
    here = Path.cwd().resolve()
    return next((folder for folder in (here, *here.parents) if (folder / ".git").exists()), here)
