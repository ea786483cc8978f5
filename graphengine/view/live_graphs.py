"""Describes the graphs of a session, and reads values of ports and variables and computing times of nodes."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graphengine.drawing.view_model import make_graph_view, put_values
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.errors import UsageError
from graphengine.format.files import near
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.profile import Profile
from graphengine.view.wire import GraphDetails

NOISE = 1e-12
"""Smallest absolute value of a number that is not shown as 0."""
MOST_ELEMENTS, LONGEST_TEXT = 8, 200
"""Maximum number of elements of an array, and of characters of a string, to show."""


Executions = Mapping[str, Mapping[str, tuple[int, int, float, int]]]
"""Executions, firings, microseconds per execution and place in the order of execution since the last frame, by graph and node."""


class NodeCosts:
    """Counts and times the node executions in the graphs that viewers have selected."""

    def __init__(self) -> None:
        self._profile = Profile(every=1)
        self._observed: Sequence[GraphRun] = ()
        """Graphs whose nodes are timed at present."""
        self._counted: dict[str, tuple[int, int, float]] = {}
        self._ticks = -1
        self._found: Executions = {}

    def end(self) -> None:
        """Stop timing nodes until the next call of `since_last`."""
        self._profile.end()

    def forget(self) -> None:
        """Exclude the executions up to now from the next result of `since_last`."""
        self._counted |= {node.path: (node.runs, node.fired, node.seconds) for node in self._profile.nodes()}

    def since_last(self, ticks: int, runs: Sequence[GraphRun]) -> Executions:
        """Return what `runs` executed since the last call; if no tick has run since then, what the last call returned."""
        if runs == self._observed and ticks == self._ticks:
            return self._found
        self._ticks = ticks
        if runs != self._observed:
            self._profile.end()
            self._observed = runs
        self._profile.begin_tick(ticks, list(runs))
        found: dict[str, dict[str, tuple[int, int, float, int]]] = {run.name: {} for run in runs}
        for node in sorted(self._profile.nodes(), key=lambda node: node.last):
            graph = next((name for name in found if node.path.startswith(f"{name}/")), None)
            if graph is None:
                continue
            runs_before, fired_before, seconds = self._counted.get(node.path, (0, 0, 0.0))
            self._counted[node.path] = node.runs, node.fired, node.seconds
            ran = node.runs - runs_before
            each = (node.seconds - seconds) / ran * 1e6 if ran else 0.0
            order = sum(1 for other in found[graph].values() if other[0]) + 1 if ran else 0
            found[graph][node.path.removeprefix(f"{graph}/")] = ran, node.fired - fired_before, each, order
        self._found = found
        return found


def summarize(run: GraphRun, robots: Sequence[str], folder: str = "") -> dict[str, Any]:
    """Return name, robot, prim path, file and variables of a graph; the robot is empty if the scene itself has the graph.

    Args:
        run: run of the graph.
        robots: names of all robots.
        folder: prefix to remove from file paths, for files that were extracted from a recording into this folder.
    """
    graph = run.executor.graph
    robot, _, short = graph.name.partition("/")
    belongs = robot in robots and bool(short)
    path = str(graph.flat.loaded.document.path)
    shown = path.removeprefix(folder)
    return {
        "name": graph.name,
        "robot": robot if belongs else "",
        "short": short if belongs else graph.name,
        "prim": graph.prim_path,
        "file": near(shown),
        "copy": os.path.abspath(shown) if shown == path else shown,
        "variables": list(run.variables),
    }


def describe(viewer: int, run: GraphRun, folder: str = "") -> GraphDetails:
    """Return drawing data and details of the graph that a viewer selected; the prefix `folder` is removed from file paths."""
    graph = run.executor.graph
    try:
        view = make_graph_view(graph, Findings())
    except UsageError as error:  # the graph is too large
        return GraphDetails(viewer, run.name, str(error), _nodes_of(run, folder))
    put_values(view, lambda instance, name: getattr(run.executor.nodes[instance.index], name))
    # Node classes are not sent: the page's process may not have the modules that define them.
    view.nodes = [replace(node, instance=None) for node in view.nodes]
    return GraphDetails(viewer, run.name, view, _nodes_of(run, folder))


def _nodes_of(run: GraphRun, folder: str) -> dict[str, dict[str, Any]]:
    graph = run.executor.graph
    wired = {(wire.target, wire.target_field) for wire in (*graph.data_wires, *graph.exec_wires)}
    return {
        instance.id: {
            "type": instance.cls.type_name,
            **place_of(instance.span, folder),
            "ports": [
                {
                    "name": port.name,
                    "side": port.side,
                    "unit": port.unit,
                    "doc": port.doc,
                    "type": str(port.type),
                    "wired": (instance.index, port.field) in wired,
                }
                for port in instance.cls.fields.values()
                if not port.is_exec and not (port.side == "state" and _is_internal(getattr(node, port.field, None)))
            ],
        }
        for instance, node in zip(graph.instances, run.executor.nodes, strict=True)
        if not instance.part_of
    }


def _is_internal(value: Any) -> bool:
    """Return whether a value is an object of the node type, such as a function, which tells users nothing."""
    return value is not None and not isinstance(
        value, bool | int | float | str | tuple | list | np.ndarray | np.generic
    )


def place_of(span: Span, folder: str = "") -> dict[str, str]:
    """Return a file position, short for display and as `path:line` for editors; the prefix `folder` is removed from paths."""
    path = span.source.path.removeprefix(folder)
    absolute = os.path.abspath(path) if path == span.source.path else path
    return {"place": near(str(span).removeprefix(folder)), "copy": f"{absolute}:{span.line}"}


def values_of(run: GraphRun) -> dict[str, Any]:
    """Return the values of all ports of a graph by `Node.side:port`, and of its variables by `variable:name`."""
    found = {f"variable:{name}": short_value(variable.value) for name, variable in run.variables.items()}
    for instance, node in zip(run.executor.graph.instances, run.executor.nodes, strict=True):
        if instance.part_of:
            continue
        for port in instance.cls.fields.values():
            if not port.is_exec:
                found[f"{instance.id}.{port.side}:{port.name}"] = short_value(getattr(node, port.field, None))
    return found


def rounded(value: float, digits: int) -> str:
    """Return a number with a number of significant digits; one that is only a rounding error is 0."""
    return f"{value if abs(value) >= NOISE else 0.0:.{digits}g}"


def short_value(value: Any) -> Any:
    """Return a finite number unchanged, any other value as short text: large arrays as shape and range, objects as class."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, int):
        return value
    if isinstance(value, str):
        return value[:LONGEST_TEXT]
    if isinstance(value, np.ndarray) and value.size > MOST_ELEMENTS and np.issubdtype(value.dtype, np.number):
        finite = value if np.issubdtype(value.dtype, np.integer) else value[np.isfinite(value)]
        return f"{value.shape} " + (f"{finite.min():.4g} to {finite.max():.4g}" if finite.size else "not finite")
    if isinstance(value, tuple | list | np.ndarray):
        parts = [short_value(part) for part in value[:MOST_ELEMENTS]]
        parts = [rounded(part, 4) if isinstance(part, float) else str(part) for part in parts]
        return "(" + ", ".join(parts) + (", …)" if len(value) > MOST_ELEMENTS else ")")
    return type(value).__name__
