"""Transfers the state of the nodes of a running graph to a changed version of the graph.

A node with the same name, class and port types keeps its state: outputs, State fields, activity, mailboxes and random numbers. An
input keeps its current value, even a value from the command `set`, unless the input's wires or value in the file have changed. If
an input that the node reads in `setup` has changed, the setup runs with the old state and may reset the state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.compiler.graph import Graph
from graphengine.compiler.planning import shape
from graphengine.node import types
from graphengine.runtime.graph_run import GraphRun


def unchanged(run: GraphRun, graph: Graph) -> bool:
    """Return whether a graph equals the running graph, and the files that the nodes read in setup have not changed.

    Comments, layout and positions in files are not compared.
    """
    before = run.executor.graph
    return (
        before.prim_path == graph.prim_path
        and before.runs == graph.runs
        and before.variable_types == graph.variable_types
        and _equal(before.variables, graph.variables)
        and shape(before) == shape(graph)
        and all(
            one.reads == other.reads
            and one.writes == other.writes
            and one.settled == other.settled
            and one.entry.document.path == other.entry.document.path
            and _equal(one.literals, other.literals)
            for one, other in zip(before.instances, graph.instances, strict=True)
        )
        and run.contexts.reads_the_same()
    )


def _equal(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return one.keys() == other.keys() and all(types.equal(value, other[name]) for name, value in one.items())


class Succession:
    """Sets up the changed version of a running graph with the state of the running graph.

    The run of the old version does not change; so it can continue after an error.

    Args:
        old: run of the graph before the change.
        new: run of the changed graph, not set up yet.
    """

    def __init__(self, old: GraphRun, new: GraphRun) -> None:
        self._old, self._new = old, new
        before, after = old.executor.graph, new.executor.graph
        named = {instance.id: instance for instance in before.instances}
        constant = new.executor.plan.constant_nodes
        self._heirs: dict[int, int] = {}
        """For each node that keeps its state: a dict from the index in the new graph to the index in the old graph."""
        self._saved: dict[int, Any] = {}
        for instance in after.instances:
            other = named.get(instance.id)
            if other is None or other.cls is not instance.cls or other.settled != instance.settled:
                continue
            try:
                saved = old.executor.nodes[other.index].save()
            except Exception:  # the state cannot be copied, so the node starts with new state
                continue
            if instance.index not in constant:
                self._saved[instance.index] = saved
            self._heirs[instance.index] = other.index
        self._wires_before, self._wires = _wires(before), _wires(after)
        self._fixed = {(copy.target, copy.target_field) for copy in new.executor.plan.fixed_copies}
        """Node index and field of each wired input whose value cannot change while the new graph runs."""
        self._set_up_otherwise: set[int] = set()
        """Indices of the nodes that keep their state although an input that they read in setup has changed."""

    @property
    def kept(self) -> int:
        """Number of nodes of the changed graph that keep their state."""
        return sum(not self._new.executor.graph.instances[index].part_of for index in self._heirs)

    @property
    def nodes(self) -> int:
        """Number of nodes of the changed graph."""
        return sum(not instance.part_of for instance in self._new.executor.graph.instances)

    @property
    def new_paths(self) -> Sequence[str]:
        """Prim paths of the nodes of the changed graph that start with initial state."""
        before = self._old.paths
        heirs = {before[index] for index in self._heirs.values()}
        return [path for path in self._new.paths if path not in heirs]

    @property
    def name(self) -> str:
        """Full name of the changed graph: `robot/graph`, or `graph` if it belongs to no robot."""
        return self._new.name

    def set_up(self) -> None:
        """Set up the nodes of the new run, and copy the state of nodes, variables and mailboxes from the old run.

        Raises:
            GraphError: a node could not be set up.
        """
        executor, graph = self._new.executor, self._new.executor.graph
        executor.succeed(self._old.executor, {before: index for index, before in self._heirs.items()})
        for name, variable in self._new.variables.items():
            old, before = self._old.variables.get(name), self._old.executor.graph
            same = old is not None and before.variable_types.get(name) == graph.variable_types.get(name)
            if old is not None and same and types.equal(before.variables[name], graph.variables[name]):
                variable.restore(old.save())
        executor.faults.set_later -= {index for index in self._heirs if self._is_as_at_start(index)}
        executor.setup(predecessors=self)
        for index, old_index in self._heirs.items():
            context, other = self._new.contexts.of(index), self._old.contexts.of(old_index)
            if context is not None and other is not None:
                for box, old_box in zip(context.mailboxes, other.mailboxes, strict=False):
                    box.restore(old_box.save())

    def before_setup(self, index: int) -> bool:
        """Copy the state of the old node to the new node with this index, before its setup.

        Returns:
            False to skip the setup, because it failed in the old graph with the same inputs; otherwise True.
        """
        if index not in self._heirs:
            return True
        self._restore(index)
        return not self._new.executor.has_failed(index) or index in self._set_up_otherwise

    def after_setup(self, index: int) -> None:
        """Copy the state of the old node to the new node with this index again, because the setup may have changed the state.

        Nothing is copied if the setup has read changed inputs or files, or if the node replaces no old node.
        """
        if index not in self._heirs or index in self._set_up_otherwise:
            return
        context, other = self._new.contexts.of(index), self._old.contexts.of(self._heirs[index])
        if context is not None and other is not None and context.files_read == other.files_read:
            self._restore(index)

    def _restore(self, index: int) -> None:
        """Copy the state of the old node to the new node, without inputs whose wires or value in the file have changed.

        Only the inputs of a constant data node are copied.
        """
        before = self._heirs[index]
        node, other = self._new.executor.nodes[index], self._old.executor.nodes[before]
        inputs = [port for port in type(node).fields.values() if port.side == "inputs"]
        same = {port.field for port in inputs if self._is_fed_alike(index, before, port.field)}
        values = {port.field: getattr(node, port.field) for port in inputs if port.field not in same}
        if index in self._saved:
            node.restore(self._saved[index])
        else:
            values |= {field: getattr(other, field) for field in same}
        for field, value in values.items():
            setattr(node, field, value)
        read = [port.field for port in inputs if port.setup]
        if not all(types.equal(getattr(node, field), getattr(other, field)) for field in read):
            self._set_up_otherwise.add(index)

    def _is_as_at_start(self, index: int) -> bool:
        """Return whether no input of a node has changed since the session started; `index` is that in the new graph."""
        before, fields = self._heirs[index], self._new.executor.nodes[index].fields
        inputs = [port.field for port in fields.values() if port.side == "inputs"]
        changed = before in self._old.executor.faults.set_later
        return not changed and all(self._is_fed_alike(index, before, field) for field in inputs)

    def _is_fed_alike(self, index: int, before: int, field: str) -> bool:
        """Return whether an input has the same wires as in the old graph, or is unwired with the same value in the file.

        The result is False for an input that gets its value from constant nodes.

        Args:
            index: index of the node in the new graph.
            before: index of the node in the old graph.
            field: field of the input.
        """
        wires, old_wires = self._wires.get((index, field), []), self._wires_before.get((before, field), [])
        if wires != old_wires or (index, field) in self._fixed:
            return False
        one, other = self._old.executor.graph.instances[before], self._new.executor.graph.instances[index]
        return bool(wires) or other.cls.fields[field].is_exec or types.equal(one.value(field), other.value(field))


def _wires(graph: Graph) -> dict[tuple[int, str], list[object]]:
    """Return the sources (node id, field, converter) of the wires into each input; the key has node index and field."""
    found: dict[tuple[int, str], list[object]] = {}
    for wire in (*graph.data_wires, *graph.exec_wires):
        source = graph.instances[wire.source].id, wire.source_field, wire.converter
        found.setdefault((wire.target, wire.target_field), []).append(source)
    return found
