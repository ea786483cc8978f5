"""Isaac Sim scripts as recorded graphs: those of plain literals are evaluated, every other one is run in a process of its own."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

from graphengine.diagnostics import Findings, Source, Span
from graphengine.omnigraph.recorded import RecordedGraph
from graphengine.omnigraph.script.answers import AnswerError, AnswerReader
from graphengine.omnigraph.script.places import Script
from graphengine.omnigraph.script.plain import evaluate
from graphengine.world.files.confinement import ProcessError, ask

MAX_BYTES = 2_000_000
"""Of a script."""
SECONDS = 10.0
"""That a script may run."""
STARTING_SECONDS = 20.0
"""That its process gets beside, to start and to answer."""
_PROCESS = "graphengine.omnigraph.script.process"


def read_script(
    path: Path,
    findings: Findings,
    arguments: Sequence[str] = (),
    allowed: Sequence[Path] = (),
    seconds: float = SECONDS,
    namespaces: dict[str, str] | None = None,
    types: Collection[str] = (),
) -> list[RecordedGraph]:
    """The graphs that a script builds; what it does beside, and what is wrong with it, goes to the findings.

    Args:
        path: the script.
        findings: G401 among them if it cannot be imported.
        arguments: what it finds in `sys.argv`.
        allowed: folders that it may read, beside its own.
        seconds: that it may run.
        namespaces: takes `isaac:namespace` by prim.
        types: names of the node types that there are, for scripts that look for them.
    """
    namespaces = {} if namespaces is None else namespaces
    start = Span(Source(str(path), ()), 1, 1)
    with path.open("rb") as file:
        raw = file.read(MAX_BYTES + 1)
    if len(raw) > MAX_BYTES:
        findings.add("G401", f"a script of more than {MAX_BYTES // 1_000_000} MB", start)
        return []
    text = ""
    try:
        text = importlib.util.decode_source(raw)
        script = Script(str(path), text)
    except SyntaxError as error:
        source = Source(str(path), tuple(text.split("\n")))
        place = Span(source, error.lineno, error.offset or 1) if error.lineno else start
        findings.add("G401", f"this is no Python: {error.msg}", place)
        return []
    except (ValueError, RecursionError, MemoryError) as error:
        findings.add("G401", f"this is no Python: {str(error) or type(error).__name__}", start)
        return []
    recorder = evaluate(script) if not arguments else None
    if recorder is not None and recorder.graphs:
        for finding in recorder.findings.items:
            findings.put(finding)
        namespaces.update(recorder.namespaces)
        return _with_nodes(recorder.graphs.values(), findings)
    request = {
        "path": str(path),
        "text": text,
        "arguments": list(arguments),
        "allowed": [str(folder.resolve()) for folder in allowed],
        "seconds": seconds,
        "types": sorted(types),
    }
    reader = _run(path, request, findings)
    namespaces.update(reader.namespaces)
    return _with_nodes(reader.graphs, findings)


def _run(path: Path, request: dict[str, Any], findings: Findings) -> AnswerReader:
    """Run it on an empty stage; if it fails or builds nothing there, on one that holds whatever it asks for."""
    told, chosen = Findings(), AnswerReader(path, request["text"])
    _run_once(path, {**request, "assumed": False}, chosen, told)
    if chosen.may_differ and (told.errors or chosen.stopped or not chosen.graphs):
        again, other = Findings(), AnswerReader(path, request["text"])
        _run_once(path, {**request, "assumed": True}, other, again)
        if other.graphs and not again.errors and (told.errors or not other.stopped):
            told, chosen = again, other
            start = Span(Source(str(path), ()), 1, 1)
            findings.add("N302", "what the script asks for and does not make is taken to be there", start)
    for finding in told.items:
        findings.put(finding)
    if told.errors:
        chosen.graphs, chosen.namespaces = [], {}
    return chosen


def _with_nodes(graphs: Iterable[RecordedGraph], findings: Findings) -> list[RecordedGraph]:
    """Those that are not empty."""
    kept = []
    for graph in graphs:
        if graph.nodes:
            kept.append(graph)
        else:
            findings.add("N302", f"the graph {graph.path} has no nodes and is left out", graph.span)
    return kept


def _run_once(path: Path, request: dict[str, Any], reader: AnswerReader, findings: Findings) -> None:
    """Read what it builds on one kind of stage."""
    try:
        reader.read(ask(_PROCESS, json.dumps(request).encode(), request["seconds"] + STARTING_SECONDS), findings)
    except (ProcessError, AnswerError) as error:
        findings.add("G401", f"the script cannot be run: {error}", Span(Source(str(path), ()), 1, 1))
