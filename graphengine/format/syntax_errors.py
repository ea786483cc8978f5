"""Reports syntax errors in YAML files, with remedies."""

from __future__ import annotations

from typing import Any

import yaml

from graphengine.format.diagnostics import Findings, Source, Span

_ADVICE: tuple[tuple[str, str], ...] = (
    (
        "mapping values are not allowed",
        "put text that contains ': ' in quotes; keys of one mapping begin in the same column",
    ),
    ("could not find expected ':'", "a key is followed by ':' and a space; text of several words may need quotes"),
    ("did not find expected key", "keys of one mapping begin in the same column"),
    ("expected '-' indicator", "entries of one list begin with '- ' in the same column"),
    ("expected ','", "a bracket is not closed, or a comma is missing"),
    ("expected node content", "a bracket is not closed, or a value is missing"),
    ("tab character", "indent with spaces, not tabs"),
    ("cannot start any token", "put text that begins with this character in quotes"),
    ("alphabetic or numeric character", "put text that begins with '*' or '&' in quotes"),
    ("unexpected end of stream", "a quote is not closed"),
    ("unknown escape character", "in single quotes, a backslash stands for itself; in double quotes, write it twice"),
    ("incompatible YAML document", "remove the line %YAML"),
    ("expected <document start>", "a file contains one mapping, with entries `key: value`"),
)
"""Pairs of a text in a parser's error message, and the remedy for this error."""
_NESTED_TOO_DEEPLY = "exceeded maximum nesting depth"
"""Error message of libyaml 0.2.6 and later (PyYAML 6.0.4), possibly before `document.MAX_DEPTH` levels have been read."""
_FROM_ITS_BEGINNING = ("while scanning a simple key", "while scanning a quoted scalar", "while scanning an a")
"""Beginnings of the parser's `context` text for which the error is reported at the start of the unfinished value."""
_OPENED = {
    "while parsing a flow sequence": "the list that begins here",
    "while parsing a flow mapping": "the mapping that begins here",
    "while parsing a block mapping": "the mapping that begins here",
    "while parsing a block collection": "the list that begins here",
}


def report_syntax(error: yaml.MarkedYAMLError, source: Source, findings: Findings, too_deep: str) -> None:
    """Add a finding for an error of the parser, at the error's position or at the start of the unfinished value.

    `too_deep` is the message for a file whose nesting is too deep for the parser.
    """
    problem, context = str(error.problem or "not YAML"), str(error.context or "")
    spans = [_inside(source, mark) for mark in (error.problem_mark, error.context_mark) if mark]
    span = spans[-1 if context.startswith(_FROM_ITS_BEGINNING) else 0] if spans else Span(source, 1, 1)
    advice = next((text for needle, text in _ADVICE if needle in problem), "")
    if "\t" in source.lines[span.line - 1][span.column - 1 : span.column]:
        advice = "indent with spaces, not tabs"
    related = [(spans[1], _OPENED[context])] if context in _OPENED and len(spans) > 1 else []
    if _NESTED_TOO_DEEPLY in problem:
        findings.add("G105", too_deep, span)
    else:
        findings.add("G102", f"YAML syntax: {problem}", span, advice, related=related)


def _inside(source: Source, mark: Any) -> Span:
    """Return the span at a parser's mark; for a mark below the last line, at the end of the last line."""
    if mark.line < len(source.lines):
        return Span(source, mark.line + 1, mark.column + 1)
    return Span(source, len(source.lines), len(source.lines[-1]) + 1)
