"""Executes one graph: sets up its nodes, runs its passes and latent nodes, and resets it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, Protocol

from graphengine.compiler import codegen
from graphengine.compiler.graph import Graph
from graphengine.compiler.plan import Copy, by_target
from graphengine.format.errors import BadValueError, ContextError, GraphError, NodeError
from graphengine.node import types
from graphengine.node.context.context import Context
from graphengine.node.node_class import Ending, Node
from graphengine.node.port import Port
from graphengine.runtime.node_faults import NodeFaults

ContextFactory = Callable[[int], Context]
"""A function that returns a new context for the node with an index, and closes the handles of the node's previous context."""

Observed = Callable[[bool], None]
"""A function that switches the observation of passes on (True) or off (False)."""


class Predecessors(Protocol):
    """Gives the nodes of a changed graph the state of the nodes that they replace."""

    def before_setup(self, index: int) -> bool:
        """Restore the state of the node with this index before the node's setup; return False to skip the setup."""

    def after_setup(self, index: int) -> None:
        """Restore the state of the node with this index again, because the node's setup may have changed the state."""


class Executor:
    """Runs the plan of a graph.

    After an exception that `faults` handles, the pass continues without the nodes that the failed node would have fired.

    Args:
        graph: graph with a plan.
        nodes: the nodes of the graph, by index.
        context_of: function that returns a new context for a node.
        faults: handles the exceptions of the nodes.
    """

    def __init__(self, graph: Graph, nodes: list[Node], context_of: ContextFactory, faults: NodeFaults) -> None:
        self.graph = graph
        self.plan = graph.plan
        self.nodes = nodes
        self.faults = faults
        self._context_of = context_of
        self._failed: set[int] = set()
        self._active: dict[int, None] = {}
        """Indices of the active latent nodes, in order of execution; a restarted node keeps its position."""
        self._outputs_of_setup: dict[int, dict[str, Any]] = {}
        self._functions = codegen.bind(
            self.plan, nodes, self._setup_again, self._active.setdefault, faults.end_branch, faults.caught, self._failed
        )
        self._flags = [f"s{data}" for data in self.plan.flagged]
        self._flags += [f"l{index}" for index, _ in self.plan.root.pending]
        self._pass: Callable[[], None] = self._functions["pass_"]
        self._set_pins()

    def node(self, node_id: str) -> Node:
        """Return the node with an id: the node's name in the file, or `Instance/Node` for a node in a subgraph."""
        return self.nodes[self.graph.by_id(node_id).index]

    def save(self) -> Any:
        """Return a copy of the state of all nodes, with the sets of nodes that are active, stale, or failed in setup."""
        flags = {name: self._functions[name] for name in self._flags}
        outputs = {index: dict(values) for index, values in self._outputs_of_setup.items()}
        nodes = [self._call(index, node.save) for index, node in enumerate(self.nodes)]
        return nodes, flags, list(self._active), set(self._failed), outputs, set(self.faults.set_later)

    def restore(self, saved: Any, again: Collection[int] = ()) -> None:
        """Restore the state that `save` returned.

        Args:
            saved: state of a graph with the same plan.
            again: indices of the nodes that were set up after `save`, and are now set up again with the saved inputs.

        Raises:
            GraphError: a node can no longer be set up.
        """
        nodes, flags, active, failed, outputs, set_later = saved
        for index in [index for index in self.plan.order if index in again and index not in failed]:
            self.nodes[index].restore(nodes[index])
            self._call(index, self._setup_node, index)
        for node, state in zip(self.nodes, nodes, strict=True):
            node.restore(state)
        self._functions.update(flags)
        self._outputs_of_setup = {index: dict(values) for index, values in outputs.items()}
        # The generated functions hold these two.
        self._active.clear()
        self._active.update(dict.fromkeys(active))
        self._failed.clear()
        self._failed.update(failed)
        self.faults.set_later = set(set_later)

    def _set_pins(self) -> None:
        """Set each wired execution input, a number of firings: to 0 if the generated code writes the input, else to 1.

        In a push graph, control inputs are 0 and all other execution inputs are 1.
        """
        if self.graph.flat.spec.evaluator == "push":
            for node in self.nodes:
                for port in type(node).fields.values():
                    if port.is_exec and port.side == "inputs":
                        setattr(node, port.field, 0 if port.control else 1)
            return
        told = {call.node for call in self.plan.calls if call.pins}
        for wire in self.graph.exec_wires:
            setattr(self.nodes[wire.target], wire.target_field, 0 if wire.target in told else 1)

    def setup(
        self, failed: Callable[[int, GraphError], None] | None = None, predecessors: Predecessors | None = None
    ) -> None:
        """Set up all nodes in the plan's order.

        Also compute constant data nodes, and data nodes whose outputs other nodes read in `setup`.

        Args:
            failed: called with the index of each node that cannot be set up, and the error; setup then continues.
                None: the first error is raised.
            predecessors: state from the replaced graph; None: all nodes start with new state.

        Raises:
            GraphError: a node requested something that does not exist or is not allowed.
            NodeError: the setup of a node raised another exception.
        """
        constant = self.plan.constant_nodes
        incoming = by_target(self.plan.copies)
        for index in self.plan.order:
            self._apply(incoming[index])
            try:
                if predecessors is None or predecessors.before_setup(index):
                    self._call(index, self._setup_node, index)
                    if predecessors is not None:
                        predecessors.after_setup(index)
                if index in constant:
                    self._call(index, self.nodes[index].compute)
                elif index in self.plan.early:
                    with contextlib.suppress(Exception):  # its inputs may be unknown before the first pass
                        self.nodes[index].compute()
            except GraphError as error:
                if failed is None:
                    raise
                failed(index, error)

    def succeed(self, other: Executor, nodes: Mapping[int, int]) -> None:
        """Take over the execution of another executor: active latent nodes, outputs that they have fired, and failed nodes.

        Args:
            other: executor of the replaced graph.
            nodes: a dict from the index of each replaced node in `other` to the index of its successor in this executor.
        """
        for index in other._active:
            if index in nodes:
                self._active[nodes[index]] = None
        for before, index in nodes.items():
            if f"l{index}" in self._flags:
                self._functions[f"l{index}"] = other._functions.get(f"l{before}", 0)
        self._failed.update(nodes[index] for index in other._failed if index in nodes)

    def has_failed(self, index: int) -> bool:
        """Return whether the last setup of a node failed."""
        return index in self._failed

    def _apply(self, copies: Iterable[Copy]) -> None:
        for copy in copies:
            value = getattr(self.nodes[copy.source], copy.source_field)
            value = types.CONVERTERS[copy.converter](value) if copy.converter else value
            setattr(self.nodes[copy.target], copy.target_field, value)

    def _setup_node(self, index: int) -> None:
        """Set up a node, for the first time or again; `stop` later restores the outputs that the setup has written."""
        node = self.nodes[index]
        fields = [p.field for p in type(node).fields.values() if p.side == "outputs" and not p.is_exec]
        before = {field: getattr(node, field) for field in fields}
        node.setup(self._context_of(index))
        self._failed.discard(index)
        changed = [field for field in fields if getattr(node, field) is not before[field]]
        self._outputs_of_setup.setdefault(index, {}).update((field, getattr(node, field)) for field in changed)

    def _setup_again(self, index: int) -> None:
        """Set up a node again after a wire changed an input that the node reads in `setup`.

        The node is not computed until a setup succeeds.

        Raises:
            BadValueError: an input has an illegal value, or names something that does not exist.
        """
        self._failed.add(index)
        node = self.nodes[index]
        ports = [port for port in type(node).fields.values() if port.setup and (index, port.field) in self.faults.wired]
        values = {port.name: getattr(node, port.field) for port in ports}
        _check_setup_inputs(node, ports)
        try:
            self._setup_node(index)
        except BadValueError:
            raise
        except ContextError as error:
            named = [name for name, value in values.items() if types.equal(value, error.value)] or list(values)
            raise BadValueError(named[0], values[named[0]]) from error

    def set_input(self, index: int, field: str, value: Any) -> None:
        """Set an unwired input between two passes, and set up the nodes again that read the input's value in `setup`.

        Raises:
            GraphError: a node cannot be set up or computed with the value. The input keeps its old value.
        """
        before = getattr(self.nodes[index], field)
        try:
            self._put(index, field, value)
        except BaseException:
            self._put(index, field, before)
            raise
        self.faults.set_later.add(index)

    def _put(self, index: int, field: str, value: Any) -> None:
        """Set an input; then, in the plan's order, compute constant nodes and set up nodes whose setup inputs have changed."""
        setattr(self.nodes[index], field, value)
        constant = self.plan.constant_nodes
        incoming = by_target(self.plan.fixed_copies)
        for target in self.plan.order:
            node = self.nodes[target]
            ports = [port for port in type(node).fields.values() if port.setup]
            before = [getattr(node, port.field) for port in ports]
            self._apply(incoming[target])
            changed = [
                port
                for old, port in zip(before, ports, strict=True)
                if (target == index and port.field == field) or not types.equal(old, getattr(node, port.field))
            ]
            if changed:
                self._call(target, _check_setup_inputs, node, changed)
                self._call(target, self._setup_node, target)
            if target in constant:
                self._call(target, node.compute)
        self.mark_stale()

    def _call(self, index: int, function: Callable[..., Any], *arguments: object) -> Any:
        try:
            return function(*arguments)
        except Exception as error:
            if isinstance(error, GraphError) and not isinstance(error, BadValueError):
                raise
            raise self.faults.explain(index, error) from error

    def observe(self, wrap: Callable[[int, Callable[[], Any]], Callable[[], Any]]) -> Observed:
        """Compile a second version of the pass, in which a wrapper replaces `compute` of each node.

        Args:
            wrap: function that takes the index and `compute` of a node, and returns the wrapper.

        Returns:
            A function that selects a version: the second for True, the original for False.
        """
        plain, functions = self._pass, self._functions
        computes = {index: wrap(index, functions[f"c{index}"]) for index in self.plan.order}
        observed = codegen.bind_observed(self.plan, functions, computes)

        def switch(on: bool) -> None:
            self._pass = observed if on else plain

        return switch

    def run_pass(self) -> None:
        """Run one pass: the event nodes, then the nodes that execution reaches from them.

        Raises:
            NodeError: a node raised an exception, which is the `__cause__` of the NodeError.
        """
        self._run(self._pass)

    def run_ending(self, ending: Ending) -> None:
        """Run the event nodes for the end of play (`at_stop`) or of the graph (`at_close`), then the nodes that they reach.

        Raises:
            NodeError: a node raised an exception, which is the `__cause__` of the NodeError.
        """
        if (function := self._functions.get(ending)) is not None:
            self._run(function)

    def announce_time(self, *, restored: bool) -> None:
        """Call `announce_time` of all nodes with this method, after a jump of the simulation time between two ticks.

        Args:
            restored: whether a checkpoint has restored the inputs of these nodes. If not, the data nodes that feed the inputs
                are computed first.

        Raises:
            NodeError: a node raised an exception, which is the `__cause__` of the NodeError.
        """
        for index, call in {call.node: call for call in self.plan.calls}.items():
            announce = getattr(self.nodes[index], "announce_time", None)
            if announce is None or index in self._failed:
                continue
            if not restored:
                for refresh in self.plan.upstream(copy.source for copy in call.copies):
                    self._apply(refresh.copies)
                    self._call(refresh.node, self.nodes[refresh.node].compute)
                self._apply(call.copies)
            self._call(index, announce)

    def _run(self, function: Callable[[], None]) -> None:
        """Call a generated function; convert a node's exception to a `NodeError` that names the node."""
        try:
            function()
        except NodeError:
            raise
        except Exception as error:
            raise self.faults.explain(codegen.source_of(self.plan).node_of(error), error) from error

    def run_latent(self) -> None:
        """Call `update` of all active latent nodes; outputs that the nodes fire take effect in the next pass."""
        for index in list(self._active):
            node: Any = self.nodes[index]
            if not node.active:
                del self._active[index]
                continue
            for data in self.plan.latent_marks.get(index, ()):
                self._functions[f"s{data}"] = 1
            try:
                fired = node.update()
            except Exception as error:
                if not self.faults.drop(index, error):
                    del self._active[index]
                    node.active = False
                    self.faults.report(index, error)
                continue
            if fired:
                self._functions[f"l{index}"] = self._functions.get(f"l{index}", 0) | fired
            if not node.active:
                del self._active[index]

    def mark_stale(self) -> None:
        """Mark all data nodes as stale: the next pass computes them. Called after a value has changed between two passes."""
        for data in self.plan.flagged:
            self._functions[f"s{data}"] = 1

    def stop(self) -> None:
        """Reset outputs, state and execution inputs to the values before the first pass, and deactivate all latent nodes."""
        self._active.clear()
        for index in self.plan.order:
            node = self.nodes[index]
            self._call(index, node.reset)
            node.clear()
            for field, value in self._outputs_of_setup.get(index, {}).items():
                setattr(node, field, value)
        for index, _ in self.plan.root.pending:
            self._functions[f"l{index}"] = 0
        self._set_pins()
        self.mark_stale()
        self._run(self._functions["constants"])


def _check_setup_inputs(node: Node, ports: Iterable[Port]) -> None:
    """Raise BadValueError if one of the inputs is required and empty, or has a value that is not among its legal values."""
    for port in ports:
        value = getattr(node, port.field)
        if port.is_missing(value) or (port.tokens and value not in port.tokens):
            raise BadValueError(port.name, value, port.constraint)
