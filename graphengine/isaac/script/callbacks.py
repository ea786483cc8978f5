"""Runs the callbacks that a script registers, such as physics callbacks, and reports the edits of graphs that they make."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

from graphengine.format.diagnostics import Span
from graphengine.isaac.omniverse.asyncio_stub import finish
from graphengine.isaac.omniverse.frames import TURNS
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.script_notes import Callback
from graphengine.isaac.omniverse.stubs import StubObject
from graphengine.isaac.recorded_graph import RecordedGraph

Lines = tuple[str, int, int]
"""The lines of a function: its file, first line and last line."""


def run_callbacks(recorder: GraphRecorder, note: Callable[[BaseException], None]) -> None:
    """Run each callback of the script `TURNS` times, once per frame; graphs that exist before keep their state.

    Values that callbacks set, and nodes and wires that they add or remove, are reported. Graphs that callbacks build are kept. A
    callback that raises an error is not called again; `note` receives the error if it is raised in the first frame.
    """
    kept = {path: _copy(graph) for path, graph in recorder.graphs.items()}
    recorder.frames.over = True
    failed = set[int]()
    for turn in range(TURNS):
        recorder.frames.number += 1
        for number, callback in enumerate(list(recorder.callbacks)):
            recorder.idle_calls = 0
            try:
                if number not in failed:
                    _call(callback, recorder)
            except (Exception, SystemExit) as error:
                failed.add(number)
                if not turn:
                    note(error)
            except BaseException:  # the script's time is up, or it loops without end
                recorder.findings.add("W302", f"the callback {_name(callback)} of the script does not end in time")
                return _restore(recorder, kept)
    return _restore(recorder, kept)


def lines_of(callbacks: Iterable[Callback]) -> Iterator[Lines]:
    """Yield the lines of the functions that are callbacks."""
    for callback in callbacks:
        code = getattr(inspect.unwrap(_function(callback)), "__code__", None)
        if code is not None:
            yield code.co_filename, code.co_firstlineno, max(line or 0 for *_, line in code.co_lines())


def _function(callback: Callback) -> Any:
    while hasattr(callback, "func"):
        callback = callback.func
    return getattr(callback, "__func__", callback)


def _name(callback: Callback) -> str:
    return str(getattr(_function(callback), "__name__", "function"))


def _call(callback: Callback, recorder: GraphRecorder) -> None:
    """Call a callback with stubs as its required arguments; run a coroutine to its end."""
    positional, named = list[Any](), dict[str, Any]()
    for parameter in inspect.signature(callback).parameters.values():
        stub = StubObject(f"{_name(callback)}.{parameter.name}", recorder)
        if parameter.default is parameter.empty and parameter.kind <= parameter.POSITIONAL_OR_KEYWORD:
            positional.append(stub)
        elif parameter.default is parameter.empty and parameter.kind == parameter.KEYWORD_ONLY:
            named[parameter.name] = stub
    result = callback(*positional, **named)
    if inspect.iscoroutine(result):
        finish(result, recorder)


def _copy(graph: RecordedGraph) -> RecordedGraph:
    nodes = {
        name: replace(node, values=dict(node.values), attributes=dict(node.attributes))
        for name, node in graph.nodes.items()
    }
    return replace(graph, nodes=nodes, wires=list(graph.wires), variables=dict(graph.variables))


def _restore(recorder: GraphRecorder, kept: dict[str, RecordedGraph]) -> None:
    """Restore the graphs from before the callbacks, and report the parts that callbacks added or removed."""
    findings = recorder.findings
    for path, graph in kept.items():
        now = recorder.graphs.get(path, recorder.removed.get(path, graph))
        before, after = _parts(graph), _parts(now)
        known, left = dict(before), dict(after)
        changes = [(f"adds {part}", place) for part, place in after if part not in known]
        changes += [(f"removes {part}", None) for part, _ in before if part not in left]
        for change, place in changes:
            what = f"a callback of the script {change} of {path}; the graph file keeps the previous graph"
            findings.add("W302", what, place)
    new = {path: graph for path, graph in recorder.graphs.items() if path not in kept}
    for path, graph in new.items():
        findings.add("N302", f"a callback of the script builds the graph {path}", graph.span)
    recorder.graphs = kept | new


def _parts(graph: RecordedGraph) -> list[tuple[str, Span | None]]:
    """Return the nodes, wires and variables of a graph, as texts, with their positions."""
    return [
        *((f"the node {name}", node.span) for name, node in graph.nodes.items()),
        *((f"the wire {wire}", wire.span) for wire in graph.wires),
        *((f"the variable {name}", value.span) for name, value in graph.variables.items()),
    ]
