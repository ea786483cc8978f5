"""What a script's process tells: graphs and findings as JSON. It is read as carefully as any file of a stranger."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from graphengine.diagnostics import CODES, Findings, Source, Span, printable
from graphengine.omnigraph.omniverse.recorder import Recorder
from graphengine.omnigraph.recorded import (
    EVALUATORS,
    PIPELINE_STAGES,
    RecordedGraph,
    RecordedNode,
    RecordedValue,
    RecordedWire,
)

MAX_ANSWER = 64_000_000
"""Bytes."""
MAX_SOURCE = 8_000_000
_TOLD = ("G401", "W302", "N301", "N302")


class AnswerError(Exception):
    """An answer that is none."""


def write_answer(recorder: Recorder, *, may_differ: bool, stopped: bool) -> str:
    """What a recorder knows as JSON, whether it may be otherwise on another stage, and whether the script failed on its way."""
    findings = [[f.code, f.message, _place(f.span), list(f.help)] for f in recorder.findings.items]
    known = (graph for graph in recorder.graphs.values() if graph.nodes or graph.path not in recorder.opened)
    graphs = [_graph(graph) for graph in known]
    answer = {
        "graphs": graphs,
        "namespaces": recorder.namespaces,
        "findings": findings,
        "may_differ": may_differ,
        "stopped": stopped,
    }
    return json.dumps(answer)


def _place(span: Span | None) -> list[Any] | None:
    return [span.source.path, span.line, span.column, span.length] if span is not None else None


def _value(value: RecordedValue) -> list[Any]:
    return [value.data, value.type, _place(value.span)]


def _graph(graph: RecordedGraph) -> dict[str, Any]:
    nodes = [
        [
            node.name,
            node.type,
            {name: _value(value) for name, value in node.values.items()},
            node.attributes,
            node.position,
            _place(node.span),
        ]
        for node in graph.nodes.values()
    ]
    return {
        "path": graph.path,
        "evaluator": graph.evaluator,
        "pipeline_stage": graph.pipeline_stage,
        "nodes": nodes,
        "wires": [[w.source, w.source_port, w.target, w.target_port, _place(w.span)] for w in graph.wires],
        "variables": {name: _value(value) for name, value in graph.variables.items()},
        "span": _place(graph.span),
    }


class AnswerReader:
    """Reads an answer.

    Args:
        script: the file that was run; places lie in it or beside it.
        text: what it holds.
    """

    def __init__(self, script: Path, text: str) -> None:
        self.folder = script.absolute().parent
        self.graphs: list[RecordedGraph] = []
        self.may_differ = False
        """Whether the script may do better on another stage."""
        self.stopped = False
        """Whether the script failed after it had built graphs."""
        self.namespaces: dict[str, str] = {}
        """`isaac:namespace` by prim."""
        self.sources: dict[str, Source] = {str(script): Source(str(script), tuple(text.split("\n")))}

    def read(self, answer: bytes, findings: Findings) -> None:
        """Take in an answer; what the process found is added to the findings.

        Raises:
            AnswerError: it is no answer.
        """
        if len(answer) > MAX_ANSWER:
            raise AnswerError(f"it builds more than {MAX_ANSWER // 1_000_000} MB")
        try:
            data = json.loads(answer)
            self.graphs = [self._graph(graph) for graph in data["graphs"]]
            self.may_differ, self.stopped = data["may_differ"] is True, data["stopped"] is True
            self.namespaces = {_text(path): _text(name) for path, name in data["namespaces"].items()}
            for code, message, place, advice in data["findings"]:
                known = code if code in _TOLD and code in CODES else "W302"
                findings.add(known, printable(_text(message)), self._span(place), *map(printable, map(_text, advice)))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            raise AnswerError("it spoils the answer of the process that runs it") from None

    def _span(self, place: Any) -> Span | None:
        if place is None:
            return None
        path, line, column, length = place
        return Span(self._source(_text(path)), _count(line), _count(column), _count(length))

    def _source(self, path: str) -> Source:
        if path not in self.sources:
            beside = Path(path).resolve().is_relative_to(self.folder.resolve())
            if not beside or not Path(path).is_file():
                raise ValueError(path)
            with Path(path).open("rb") as file:
                text = file.read(MAX_SOURCE).decode("utf-8", "replace")
            self.sources[path] = Source(path, tuple(text.split("\n")))
        return self.sources[path]

    def _value(self, value: Any) -> RecordedValue:
        data, kind, place = value
        return RecordedValue(_data(data), _text(kind), self._span(place))

    def _graph(self, data: Any) -> RecordedGraph:
        graph = RecordedGraph(
            _text(data["path"]), data["evaluator"], data["pipeline_stage"], span=self._span(data["span"])
        )
        if graph.evaluator not in EVALUATORS or graph.pipeline_stage not in PIPELINE_STAGES:
            raise ValueError(graph.evaluator)
        for name, kind, values, attributes, position, place in data["nodes"]:
            node = RecordedNode(_text(name), _text(kind), span=self._span(place))
            node.values = {_text(key): self._value(value) for key, value in values.items()}
            node.attributes = {_text(key): _text(value) for key, value in attributes.items()}
            if position is not None:
                x, y = position
                node.position = float(x), float(y)
            graph.nodes[node.name] = node
        for source, source_port, target, target_port, place in data["wires"]:
            start, end = (_text(source), _text(source_port)), (_text(target), _text(target_port))
            graph.wires.append(RecordedWire(*start, *end, self._span(place)))
        graph.variables = {_text(name): self._value(value) for name, value in data["variables"].items()}
        return graph


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(value)
    return value


def _count(value: Any) -> int:
    if not isinstance(value, int) or value < 0 or value > 1 << 31:
        raise ValueError(value)
    return value


def _data(value: Any) -> Any:
    """A value of an attribute, which holds no mappings."""
    if isinstance(value, list):
        return [_data(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(value)
