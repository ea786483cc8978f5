"""Isaac Sim scripts as recorded graphs: those of plain literals are evaluated, every other one is run in a process of its own."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from graphengine.diagnostics import Findings, Source, Span
from graphengine.omnigraph.answers import AnswerError, AnswerReader
from graphengine.omnigraph.places import Script
from graphengine.omnigraph.plain import evaluate
from graphengine.omnigraph.recorded import RecordedGraph
from graphengine.world.description.confinement import ProcessError, ask

MAX_BYTES = 2_000_000
"""Of a script."""
SECONDS = 10.0
"""That a script may run."""
STARTING_SECONDS = 20.0
"""That its process gets beside, to start and to answer."""
_PROCESS = "graphengine.omnigraph.script_process"


def read_script(
    path: Path,
    findings: Findings,
    arguments: Sequence[str] = (),
    allowed: Sequence[Path] = (),
    seconds: float = SECONDS,
) -> list[RecordedGraph]:
    """The graphs that a script builds; what it does beside, and what is wrong with it, goes to the findings.

    Args:
        path: the script.
        findings: G401 among them if it cannot be imported.
        arguments: what it finds in `sys.argv`.
        allowed: folders that it may read, beside its own.
        seconds: that it may run.
    """
    start = Span(Source(str(path), ()), 1, 1)
    with path.open("rb") as file:
        raw = file.read(MAX_BYTES + 1)
    if len(raw) > MAX_BYTES:
        findings.add("G401", f"a script of more than {MAX_BYTES // 1_000_000} MB", start)
        return []
    try:
        text = raw.decode("utf-8-sig")
        script = Script(str(path), text)
    except SyntaxError as error:
        source = Source(str(path), tuple(text.split("\n")))
        place = Span(source, error.lineno or 1, error.offset or 1)
        findings.add("G401", f"this is no Python: {error.msg}", place)
        return []
    except (ValueError, RecursionError, MemoryError) as error:
        findings.add("G401", f"this is no Python: {str(error) or type(error).__name__}", start)
        return []
    recorder = evaluate(script) if not arguments else None
    if recorder is not None and recorder.graphs:
        for finding in recorder.findings.items:
            findings.put(finding)
        return _with_nodes(recorder.graphs.values(), findings)
    request = {
        "path": str(path),
        "text": text,
        "arguments": list(arguments),
        "allowed": [str(folder.resolve()) for folder in allowed],
        "seconds": seconds,
    }
    return _run(path, request, findings)


def _run(path: Path, request: dict[str, Any], findings: Findings) -> list[RecordedGraph]:
    """Run it on an empty stage; if it fails or builds nothing there, on one that holds every prim it asks for."""
    empty, full = Findings(), Findings()
    told = empty
    graphs, may_differ = _run_once(path, {**request, "prims_exist": False}, empty)
    if may_differ and (empty.errors or not graphs):
        others, _ = _run_once(path, {**request, "prims_exist": True}, full)
        if others and not full.errors:
            told, graphs = full, others
            findings.add(
                "N302", "prims that the script asks for are taken to be there", Span(Source(str(path), ()), 1, 1)
            )
    for finding in told.items:
        findings.put(finding)
    return [] if told.errors else _with_nodes(graphs, findings)


def _with_nodes(graphs: Iterable[RecordedGraph], findings: Findings) -> list[RecordedGraph]:
    """Those that are not empty."""
    kept = []
    for graph in graphs:
        if graph.nodes:
            kept.append(graph)
        else:
            findings.add("N302", f"the graph {graph.path} has no nodes and is left out", graph.span)
    return kept


def _run_once(path: Path, request: dict[str, Any], findings: Findings) -> tuple[list[RecordedGraph], bool]:
    """What it builds on one kind of stage, and whether it may do better on another."""
    reader = AnswerReader(path, request["text"])
    try:
        answer = ask(_PROCESS, json.dumps(request).encode(), request["seconds"] + STARTING_SECONDS)
        return reader.read(answer, findings), reader.may_differ
    except (ProcessError, AnswerError) as error:
        findings.add("G401", f"the script cannot be run: {error}", Span(Source(str(path), ()), 1, 1))
        return [], False
