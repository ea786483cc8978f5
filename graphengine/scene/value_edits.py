"""Writes values of inputs, and positions of nodes, into the YAML files of a running scene, one change at a time, with undo."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphengine.compiler.graph import Graph, Instance
from graphengine.compiler.literals import Override, ends_with
from graphengine.format import document
from graphengine.format.atomic_write import write_together
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import Location
from graphengine.format.errors import GraphError, RecordingError, StateError, TransportError, UsageError
from graphengine.format.files import Files, near
from graphengine.format.yaml_patch import PatchError, location_at, set_value
from graphengine.format.yaml_text import flow
from graphengine.runtime.addresses import NodePort
from graphengine.scene.loaded_scene import LoadedScene

MOST_CHANGES = 1000
"""Maximum number of changes that can be undone."""
_BOM = "\ufeff"


@dataclass(frozen=True, slots=True)
class Target:
    """The place in a file to which a change is written.

    Attributes:
        path: file.
        location: keys and indices in the file.
        line: line of the value, or of the node that gets a new key.
        origin: description of the place, such as `graphs/cmd_vel.yaml:17, through $(speed)`.
    """

    path: Path
    location: Location
    line: int
    origin: str


@dataclass(frozen=True, slots=True)
class Change:
    """A change of one file: its bytes before and after, and a description in one line."""

    path: Path
    before: bytes
    after: bytes
    text: str


class ValueEdits:
    """The changes of a session's files. They take effect by a reload; a change that the reload refuses is taken back.

    Args:
        reload: reloads the files of the session.
    """

    def __init__(self, reload: Callable[[], object]) -> None:
        self._reload = reload
        self._done: list[Change] = []
        self._undone: list[Change] = []

    def propose_value(self, scene: LoadedScene, files: Files, port: NodePort, value: Any) -> Change:
        """Return the change that writes a value of an input; nothing is written.

        Args:
            scene: scene that the session runs.
            files: record of the files that the session has read.
            port: unwired input.
            value: value to write, as in a graph file.

        Raises:
            UsageError: no file can be changed so that the input gets this value, with the reason and a remedy.
        """
        graph, instance = port.executor.graph, port.executor.graph.instances[port.index]
        target = _input_target(scene, graph, instance, port)
        port.convert(value)
        shared = _users(scene, instance, target)
        return self._propose(scene, files, target, value, port.port.name, shared)

    def propose_position(
        self, scene: LoadedScene, files: Files, graph: Graph, node: str, at: Sequence[float]
    ) -> Change:
        """Return the change that writes the position of a node in drawings, in the key `layout` of its graph file.

        Raises:
            UsageError: the graph has no such node, the node is in a subgraph, or the file cannot be changed.
        """
        instance = next((one for one in graph.instances if one.id == node and not one.entry.via), None)
        if instance is None:
            raise UsageError(f"{graph.name} has no node {node!r} outside of its subgraphs")
        file = instance.entry.document
        target = Target(_absolute(file.source.path), ("layout", node), file.key_span("layout", node).line, "")
        return self._propose(
            scene, files, target, [round(float(number), 1) for number in at], f"position of {node}", ""
        )

    def _propose(self, scene: LoadedScene, files: Files, target: Target, value: Any, name: str, shared: str) -> Change:
        path = target.path
        _require_editable(scene, files, path)
        before = path.read_bytes()
        text = before.decode("utf-8")
        mark = _BOM if text.startswith(_BOM) else ""
        old = _old(text.removeprefix(mark), target.location)
        try:
            after = _patched(text.removeprefix(mark), target.location, value)
        except PatchError as error:
            raise UsageError(f"{near(str(path))}:{target.line}: {error}; edit the file in an editor") from None
        where = target.origin or f"{near(str(path))}:{target.line}"
        return Change(path, before, (mark + after).encode(), f"{name}: {old} -> {flow(value)} in {where}{shared}")

    def write(self, change: Change) -> None:
        """Write a proposed change and reload; the list of undone changes is discarded.

        Raises:
            CheckError: the changed scene has errors; the file has its old text again.
            StateError: the file has changed since the change was proposed.
            UsageError: the file cannot be written.
            RecordingError: the change took effect, but the recording ended.
            TransportError: the change took effect, but not on the network.
        """
        self._exchange(change.path, change.before, change.after)
        self._done = [*self._done, change][-MOST_CHANGES:]
        self._undone.clear()

    def undo(self) -> Change:
        """Take back the newest change that is not undone, and reload. Return this change.

        Raises:
            StateError: there is no such change, or the file has changed since.
        """
        if not self._done:
            raise StateError("there is no change to undo")
        change = self._done[-1]
        self._exchange(change.path, change.after, change.before)
        self._undone.append(self._done.pop())
        return change

    def redo(self) -> Change:
        """Write the change that was undone last, and reload. Return this change.

        Raises:
            StateError: there is no such change, or the file has changed since.
        """
        if not self._undone:
            raise StateError("there is no undone change")
        change = self._undone[-1]
        self._exchange(change.path, change.before, change.after)
        self._done.append(self._undone.pop())
        return change

    def _exchange(self, path: Path, expected: bytes, content: bytes) -> None:
        """Replace the content of a file if it is as expected, and reload; after an error of the reload, the file is restored."""
        try:
            if Path(os.path.realpath(path)) != path or path.read_bytes() != expected:
                raise StateError(f"{near(str(path))} has changed meanwhile: reload it and try again")
            write_together({path: content})
        except OSError as error:
            raise UsageError(f"{near(str(path))} cannot be written: {error.strerror}") from None
        try:
            self._reload()
        except (RecordingError, TransportError):
            raise  # The session runs with the changed file.
        except BaseException:
            self._restore(path, content, expected)
            raise

    def _restore(self, path: Path, content: bytes, expected: bytes) -> None:
        """Give a file its text from before a refused reload, unless another program has written it since, and reload.

        Raises:
            UsageError: the file cannot be written.
        """
        try:
            if Path(os.path.realpath(path)) != path or path.read_bytes() != content:
                return
            write_together({path: expected})
        except OSError as error:
            text = f"{near(str(path))} has the refused change and cannot be restored: {error.strerror}"
            raise UsageError(f"{text}; take the change back in an editor") from None
        with contextlib.suppress(GraphError):
            self._reload()  # The session's record has the refused file.


def _old(text: str, location: Location) -> str:
    """Return the present value at a location of a YAML text as flow-style YAML, or `not set`."""
    found = document.parse(text, "", Findings())
    value = found.find(*location) if found is not None else None
    return flow(value.to_data()) if value is not None else "not set"


def _patched(text: str, location: Location, value: Any) -> str:
    """Return a text with a value set; a node in its short form, such as `Drive: TYPE`, becomes a mapping.

    Raises:
        PatchError: the value cannot be set.
    """
    found = document.parse(text, "", Findings())
    node = found.find(*location[:2]) if found is not None else None
    if len(location) == 4 and location[2] == "inputs" and node is not None and isinstance(node.data, str):
        return set_value(text, location[:2], {"type": node.data, "inputs": {str(location[3]): value}})
    return set_value(text, location, value)


def _input_target(scene: LoadedScene, graph: Graph, instance: Instance, port: NodePort) -> Target:
    """Return the place of the value of an input: where a file sets it, or else the place for a new key in the graph file.

    Raises:
        UsageError: `--set` or the engine gives the value.
    """
    address = f"{graph.name}/{instance.id}.{port.port.name}"
    for override in Override.parse_all(scene.options.overrides):
        if override.port == port.port.name and ends_with(f"{graph.name}/{instance.id}", override.target):
            raise UsageError(f"{address} has its value from --set {override.text}: run without it, then save the value")
    entry, key = instance.entry, instance.literal_key(port.port)
    if key not in entry.spec.inputs and port.port.name not in entry.given:
        path = _absolute(entry.document.source.path)
        location: Location = (*entry.location, "inputs", port.port.name)
        return Target(path, location, instance.span.line, f"{near(str(path))}:{instance.span.line}, a new key")
    if not entry.is_written("inputs", key):
        raise UsageError(
            f"{address} has its value from the scene, which sets it for each robot; no file can be changed"
        )
    span = entry.span("inputs", key)
    return Target(_absolute(span.source.path), _location(span), span.line, _origin(span))


def _location(span: Span) -> Location:
    """Return the keys and indices of the value at a position, in the text that was read.

    Raises:
        UsageError: no value begins at the position.
    """
    try:
        found = location_at("\n".join(span.source.lines), span.line, span.column)
    except PatchError:
        found = None
    if found is None:
        raise UsageError(f"{span}: the value is part of a text; edit the file in an editor")
    return found


def _origin(span: Span) -> str:
    """Return the position of a value, and the parameters that pass it on."""
    names = dict.fromkeys(label.partition("$(")[2].partition(")")[0] for _, label in span.through if "$(" in label)
    through = f", through {' and '.join(f'$({name})' for name in names)}" if names else ""
    return f"{near(str(span.source.path))}:{span.line}{through}"


def _users(scene: LoadedScene, instance: Instance, target: Target) -> str:
    """Return how many other nodes get their value from the same place, as the end of a description; empty for none."""
    entry, count = instance.entry, 0
    for graph in scene.planned:
        for other in graph.instances:
            same = other.entry.location == entry.location
            count += same and _absolute(other.entry.document.source.path) == _absolute(entry.document.source.path)
    own_file = target.path == _absolute(entry.document.source.path)
    return f", for {count} nodes" if own_file and count > 1 else ""


def _require_editable(scene: LoadedScene, files: Files, path: Path) -> None:
    """Check that a file may be changed: it is a file of the scene's folder, no link, and as the session has read it.

    Raises:
        UsageError: the file may not be changed; the message has a remedy.
    """
    shown, folder = near(str(path)), scene.path.resolve().parent
    if files.text(path) is not None:
        raise UsageError(f"{shown} is a text that a program gave, not a file")
    if any(path.resolve().is_relative_to((files.base / name).resolve()) for name in ("graphs", "scenes")):
        advice = f"copy it into {near(str(folder))} and use the copy in your scene"
        raise UsageError(f"{shown} ships with graphengine and is not changed\n  {advice}")
    if Path(os.path.realpath(path)) != path or not path.is_relative_to(folder):
        where = f"outside of the scene's folder {near(str(folder))}, or a link"
        raise UsageError(f"{shown} is {where}; edit it in an editor")
    if path not in files.used or path in files.changed():
        raise UsageError(f"{shown} has changed since the session read it: reload it first")


def _absolute(path: str) -> Path:
    return Path(os.path.abspath(path))
