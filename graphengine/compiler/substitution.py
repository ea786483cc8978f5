"""Replaces `$(name)` in graph files by the values of parameters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from graphengine.compiler.budget import Budget
from graphengine.compiler.filled_document import PARAMETER, FilledDocument, Use, is_literal
from graphengine.format.diagnostics import Findings
from graphengine.format.document import MAX_BYTES, Document, Location, Value
from graphengine.format.spec import FORMAT, GraphSpec
from graphengine.format.spec_reader import Loaded, validate
from graphengine.format.wording import listing, shown
from graphengine.node import types

UNKNOWN: Any = type("Unknown", (), {"__repr__": lambda _: "UNKNOWN"})()
"""Stands for a value that is unknown because of an error that was already reported."""


def fill(
    document: Document, bindings: Mapping[str, Any], findings: Findings, use: Use | None, budget: Budget
) -> Loaded[GraphSpec] | None:
    """Replace `$(name)` in a graph file by the values of parameters, and validate the result; return None if it is invalid.

    Args:
        document: the graph file.
        bindings: values of the parameters, by name; parameters without a value have their default.
        findings: receives the errors.
        use: place where another file uses the graph; None for a file that the user gave.
        budget: size limits of the graph.
    """
    data = document.data
    if not isinstance(data, dict) or data.get("format", FORMAT) == FORMAT:  # other versions differ in keys
        values = _parameter_values(document, bindings, findings, use)
        data = _Filler(values, findings, budget).fill(document.root)
    filled = FilledDocument(document, bindings.keys(), use)
    spec = validate(GraphSpec, filled, data, findings)
    return Loaded(spec, filled) if spec is not None else None


def _parameter_values(
    document: Document, bindings: Mapping[str, Any], findings: Findings, use: Use | None
) -> dict[str, Any]:
    """Return the value of each declared parameter: the value in `bindings` or the default; UNKNOWN for one with an error."""
    declared = document.find("parameters")
    names = declared.data if declared is not None and isinstance(declared.data, dict) else {}
    for name in bindings:
        if name not in names:
            where = use.key_span(name) if use else document.span("graph")
            near = findings.guess(name, names) or listing(names, "parameters")
            findings.add("G111", f"the graph has no parameter {name!r}", where, near)
    values: dict[str, Any] = {}
    for name, value in names.items():
        data = value.to_data()
        values[name] = UNKNOWN
        if not isinstance(data, dict) or not isinstance(data.get("type"), str):
            continue
        try:
            port_type = types.parse(data["type"])
        except ValueError as error:
            findings.add("G211", str(error), document.span("parameters", name, "type"))
            continue
        if name not in bindings and data.get("default") is None:
            message = f"parameter {name!r} of graph {document.source.path} has no default and was given no value"
            remedy = "write a default, or give a value where the graph is used"
            findings.add("G107", message, use.span if use else document.key_span("parameters", name), remedy)
            continue
        given = bindings.get(name, data.get("default"))
        if given is UNKNOWN:  # a parameter of the graph around this one, with a reported error
            continue
        try:
            coerced = types.coerce(given, port_type) if isinstance(port_type, types.PortType) else given
        except (TypeError, ValueError) as error:
            where = document.span("parameters", name, "default")
            if use and name in bindings:
                where = use.value_span(name)
            findings.add("G211", f"parameter {name!r} is a {port_type}: {error}, got {shown(given)}", where)
            continue
        values[name] = coerced[0] if port_type == types.TARGET and len(coerced) == 1 else coerced
    return values


class _Filler:
    """Replaces `$(name)` in plain data by parameter values, within a size budget."""

    def __init__(self, values: Mapping[str, Any], findings: Findings, budget: Budget) -> None:
        self.values = values
        self.texts = {name: str(value) for name, value in values.items() if value is not UNKNOWN}
        self.findings = findings
        self.budget = budget

    def fill(self, value: Value, location: Location = ()) -> Any:
        """Return a value as plain data with `$(name)` replaced, except in keys and where `is_literal` is true.

        Where the value of a parameter is unknown, the result has UNKNOWN for an input of a node, a parameter of a subgraph or
        `every`; elsewhere it omits the key.
        """
        if isinstance(value.data, dict):
            return self._mapping(value.data, location)
        if isinstance(value.data, list):
            items = [self.fill(item, (*location, i)) for i, item in enumerate(value.data)]
            return UNKNOWN if _holds_unknown(items) else items
        if not isinstance(value.data, str) or "$" not in value.data:
            return value.data
        return self._text(value)

    def _mapping(self, data: Mapping[str, Value], location: Location) -> Any:
        filled = {
            key: item.to_data() if is_literal((*location, key), item) else self.fill(item, (*location, key))
            for key, item in data.items()
        }
        if location[:1] == ("nodes",) and location[2:3] in (("inputs",), ("parameters",)):
            return UNKNOWN if len(location) > 3 and _holds_unknown(filled.values()) else filled
        if location[:1] == ("nodes",) and location[2:] == ("every",) and _holds_unknown(filled.values()):
            return UNKNOWN
        return {key: item for key, item in filled.items() if item is not UNKNOWN}

    def _text(self, value: Value) -> Any:
        before, known = self.budget.text, True
        whole = PARAMETER.fullmatch(value.data)
        if whole and whole[1] in self.texts:
            found = self.values[whole[1]]
            self.budget.text += getattr(found, "nbytes", len(self.texts[whole[1]]))
            filled = list(found) if isinstance(found, tuple) else found
        else:

            def replacement(match: re.Match[str]) -> str:
                nonlocal known
                if match[0] == "$$":
                    return "$"
                if match[1] not in self.values:
                    self._tell_unknown(match, value)
                text = self.texts.get(match[1])
                known = known and text is not None
                self.budget.text += len(text or "")
                return text or "" if self.budget.text <= MAX_BYTES else ""

            filled = PARAMETER.sub(replacement, value.data)
        if before <= MAX_BYTES < self.budget.text:
            what = f"the values that replace parameters are larger than {MAX_BYTES // 1_000_000} MB in total"
            self.findings.add("G105", what, value.span, "split the file, or use large parameter values less often")
        return filled if known and self.budget.text <= MAX_BYTES else UNKNOWN

    def _tell_unknown(self, match: re.Match[str], value: Value) -> None:
        if not self.findings.full:
            span = value.span.part(match.start(), len(match[0])) if value.plain else value.span
            near = self.findings.guess(match[1], self.values) or listing(self.values, "parameters")
            self.findings.add("G111", f"the graph has no parameter {match[1]!r}", span, near)


def _holds_unknown(values: Iterable[Any]) -> bool:
    return any(value is UNKNOWN for value in values)
