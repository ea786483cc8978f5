"""Converts the findings of a check to rows for the page's table of findings."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.format.diagnostics import CODES, Finding
from graphengine.view.live_graphs import place_of

MOST = 1000
"""Maximum number of findings to show."""
_RENDERED = re.compile(
    r"(?:(?P<place>.+?):(?P<column>\d+): )?(?P<severity>error|warning|note) (?P<code>\w+): (?P<message>.*)"
)


def finding_rows(findings: Sequence[Finding | str]) -> list[Mapping[str, Any]]:
    """Return rows with severity, code, message, position and help of findings, errors first; strings are rendered findings."""
    rows = [_row(finding) if isinstance(finding, Finding) else _row_of_text(finding) for finding in findings[:MOST]]
    return sorted(rows, key=lambda row: ("error", "warning", "note").index(row["severity"]))


def _row(finding: Finding) -> Mapping[str, Any]:
    return {
        "severity": finding.severity,
        "code": finding.code,
        "title": CODES[finding.code],
        "message": finding.message,
        "help": "\n".join(finding.help),
        **(place_of(finding.span) if finding.span is not None else {"place": "", "copy": ""}),
    }


def _row_of_text(text: str) -> Mapping[str, Any]:
    first, _, rest = text.partition("\n")
    found = _RENDERED.fullmatch(first)
    if found is None:
        return {"severity": "error", "code": "", "title": "", "message": first, "help": rest, "place": "", "copy": ""}
    place = found["place"] or ""
    return {
        "severity": found["severity"],
        "code": found["code"],
        "title": CODES.get(found["code"], ""),
        "message": found["message"],
        "help": rest,
        "place": f"{place}:{found['column']}" if place else "",
        "copy": place,
    }
