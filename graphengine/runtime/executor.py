"""One graph at run time: its nodes' life from setup to stop, its pass, and its latent nodes."""

from __future__ import annotations

import contextlib
import traceback
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, Protocol

from graphengine.compiler import codegen
from graphengine.compiler.graph import Graph
from graphengine.compiler.plan import Copy
from graphengine.format.errors import BadValueError, ContextError, GraphError, NodeError
from graphengine.node import types
from graphengine.node.context.context import Context
from graphengine.node.node_class import Ending, Node

ContextFactory = Callable[[int], Context]
"""The context of a node, by its index in the graph; each call gives a new one and closes the old one's handles."""

Observed = Callable[[bool], None]
"""Lets passes be observed from here on, or no longer."""


class Predecessors(Protocol):
    """The replaced nodes of an executor's graph, whose state the new nodes take over."""

    def before_setup(self, index: int) -> bool:
        """Restore the state that a node needs for its setup; return False if the node cannot be set up yet."""

    def after_setup(self, index: int) -> None:
        """Restore the rest of the state."""


class Executor:
    """Runs the plan of a graph.

    Args:
        graph: with its plan.
        context_of: where nodes get their contexts.
        now: simulation tick and time, for messages.
        fault: receives each fault of a node, which then ends the node's branch only; None ends the run at the first.
        dropped: receives each value from a wire that a node could not use, with the node's index; None makes it a fault.
    """

    def __init__(
        self,
        graph: Graph,
        context_of: ContextFactory,
        now: Callable[[], tuple[int, float]],
        fault: Callable[[NodeError], None] | None = None,
        dropped: Callable[[int, BadValueError], None] | None = None,
    ) -> None:
        self.graph = graph
        self.plan = graph.plan
        self.nodes = [instance.make_node() for instance in graph.instances]
        self._context_of = context_of
        self._now = now
        self._fault = fault
        self._dropped = dropped
        self._wired = {(wire.target, wire.target_field) for wire in graph.data_wires}
        self._failed: set[int] = set()
        self._active: dict[int, None] = {}
        """Latent nodes; one that starts again keeps its place."""
        self._outputs_of_setup: dict[int, dict[str, Any]] = {}
        caught = (Exception,) if fault else (BadValueError,) if dropped else ()
        self._functions = codegen.bind(
            self.plan, self.nodes, self._setup_again, self._active.setdefault, self._end_branch, caught, self._failed
        )
        self._flags = [f"s{data}" for data in self.plan.flagged]
        self._flags += [f"l{index}" for index, _ in self.plan.root.pending]
        self._pass: Callable[[], None] = self._functions["pass_"]
        self._set_pins()

    def node(self, node_id: str) -> Node:
        """The node of a name in the file, `Instance/Node` within a subgraph."""
        return self.nodes[self.graph.by_id(node_id).index]

    def save(self) -> Any:
        """A copy of the state of all nodes, and of which are active, stale, or could not be set up."""
        flags = {name: self._functions[name] for name in self._flags}
        outputs = {index: dict(values) for index, values in self._outputs_of_setup.items()}
        nodes = [self._call(index, node.save) for index, node in enumerate(self.nodes)]
        return nodes, flags, list(self._active), set(self._failed), outputs

    def restore(self, saved: Any, again: Collection[int] = ()) -> None:
        """Go back to what `save` returned.

        Args:
            saved: of a graph with the same plan.
            again: nodes that were set up otherwise since then, and are set up with the inputs of that time.

        Raises:
            GraphError: a node cannot be set up any more.
        """
        nodes, flags, active, failed, outputs = saved
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

    def _set_pins(self) -> None:
        """The input of a node with a single wire always fires once and is told so now; no other has fired.

        In a push graph all have fired but control pins.
        """
        if self.graph.flat.spec.evaluator == "push":
            for node in self.nodes:
                for port in type(node).fields.values():
                    if port.is_exec and port.side == "inputs":
                        setattr(node, port.field, 0 if port.control else 1)
            return
        told = {call.node for region in self.plan.regions for call in region.calls if call.pins}
        for wire in self.graph.exec_wires:
            setattr(self.nodes[wire.target], wire.target_field, 0 if wire.target in told else 1)

    def setup(
        self, failed: Callable[[int, GraphError], None] | None = None, predecessors: Predecessors | None = None
    ) -> None:
        """Set up every node that can run, in schedule order: constants first, outputs propagated as soon as they are known.

        Args:
            failed: called for each node that cannot be set up, and setup continues; None: raise at the first.
            predecessors: the nodes that this executor's nodes replace.

        Raises:
            GraphError: a node requested something that does not exist.
            NodeError: a node's setup raised another exception.
        """
        constant = {refresh.node for refresh in self.plan.constants}
        incoming = _by_target(self._all_copies())
        for index in self.plan.order:
            self._apply(incoming[index])
            try:
                if predecessors is None:
                    self._call(index, self._setup_node, index)
                elif predecessors.before_setup(index):
                    self._call(index, self._setup_node, index)
                    predecessors.after_setup(index)
                if index in constant:
                    self._call(index, self.nodes[index].compute)
                elif index in self.plan.early:
                    with contextlib.suppress(Exception):  # what it reads may not be known before the first pass
                        self.nodes[index].compute()
            except GraphError as error:
                if failed is None:
                    raise
                failed(index, error)

    def succeed(self, other: Executor, nodes: Mapping[int, int]) -> None:
        """Continue where another executor stops: its latent nodes stay active, and their pending firings are kept.

        Args:
            other: executor of the replaced graph.
            nodes: index of each new node in this executor, by the index of the replaced node in the other one.
        """
        for index in other._active:
            if index in nodes:
                self._active[nodes[index]] = None
        for before, index in nodes.items():
            if f"l{index}" in self._flags:
                self._functions[f"l{index}"] = other._functions.get(f"l{before}", 0)
        self._failed.update(nodes[index] for index in other._failed if index in nodes)

    @property
    def fixed_inputs(self) -> set[tuple[int, str]]:
        """Node and field of the inputs whose wire carries a constant value."""
        return {(copy.target, copy.target_field) for copy in self._constant_copies()}

    def has_failed(self, index: int) -> bool:
        """Return whether the last setup of a node failed."""
        return index in self._failed

    def _all_copies(self) -> Iterable[Copy]:
        """Every copy of the plan, once."""
        calls = [call for region in self.plan.regions for call in region.calls]
        copies = [copy for call in calls for copy in call.copies]
        copies += [copy for call in calls for refresh in call.refreshes for copy in refresh.copies]
        return dict.fromkeys([*self._constant_copies(), *copies])

    def _constant_copies(self) -> Iterable[Copy]:
        """Every copy of a value that cannot change while the graph runs."""
        yield from self.plan.constant_copies
        for refresh in self.plan.constants:
            yield from refresh.copies

    def _apply(self, copies: Iterable[Copy]) -> None:
        for copy in copies:
            value = getattr(self.nodes[copy.source], copy.source_field)
            value = types.CONVERTERS[copy.converter](value) if copy.converter else value
            setattr(self.nodes[copy.target], copy.target_field, value)

    def _setup_node(self, index: int) -> None:
        """Set up one node, anew if it was before; what it puts out then, it puts out from the start of each play."""
        node = self.nodes[index]
        fields = [p.field for p in type(node).fields.values() if p.side == "outputs" and not p.is_exec]
        before = {field: getattr(node, field) for field in fields}
        node.setup(self._context_of(index))
        self._failed.discard(index)
        changed = [field for field in fields if getattr(node, field) is not before[field]]
        self._outputs_of_setup.setdefault(index, {}).update((field, getattr(node, field)) for field in changed)

    def _setup_again(self, index: int) -> None:
        """Set up a node after an input that it reads in setup changed over a wire; until that succeeds it does not compute.

        Raises:
            BadValueError: the session does not have what the input names.
        """
        self._failed.add(index)
        node = self.nodes[index]
        ports = [port for port in type(node).fields.values() if port.setup and (index, port.field) in self._wired]
        values = {port.name: getattr(node, port.field) for port in ports}
        for port, value in zip(ports, values.values(), strict=True):
            empty = port.required is True and isinstance(value, tuple | str) and not value
            if empty or (port.tokens and value not in port.tokens):
                raise BadValueError(port.name, value, port.constraint)
        try:
            self._setup_node(index)
        except BadValueError:
            raise
        except ContextError as error:
            named = [name for name, value in values.items() if types.equal(value, error.value)] or list(values)
            raise BadValueError(named[0], values[named[0]]) from error

    def set_input(self, index: int, field: str, value: Any) -> None:
        """Change an input that no wire feeds, between two passes; nodes that read it in `setup` are set up again.

        Raises:
            GraphError: a node cannot be set up, or computed, with the value. The input has its old value then.
        """
        before = getattr(self.nodes[index], field)
        try:
            self._put(index, field, value)
        except BaseException:
            self._put(index, field, before)
            raise

    def _put(self, index: int, field: str, value: Any) -> None:
        """Set an input, then compute constants anew and set up nodes again, in schedule order, where that changes anything."""
        setattr(self.nodes[index], field, value)
        constant = {refresh.node for refresh in self.plan.constants}
        incoming = _by_target(self._constant_copies())
        for target in self.plan.order:
            node = self.nodes[target]
            read = [port.field for port in type(node).fields.values() if port.setup]
            before = {name: getattr(node, name) for name in read}
            self._apply(incoming[target])
            changed = any(not types.equal(before[name], getattr(node, name)) for name in read)
            if changed or (target == index and field in read):
                self._call(target, self._setup_node, target)
            if target in constant:
                self._call(target, node.compute)
        self._make_stale()

    def _call(self, index: int, function: Callable[..., Any], *arguments: object) -> Any:
        try:
            return function(*arguments)
        except Exception as error:
            if isinstance(error, GraphError) and not isinstance(error, BadValueError):
                raise
            raise self.explain(index, error) from error

    def observe(self, wrap: Callable[[int, Callable[[], Any]], Callable[[], Any]]) -> Observed:
        """A second pass whose nodes compute through functions that see each compute.

        Args:
            wrap: makes such a function of a node's index and its compute.
        """
        plain, functions = self._pass, self._functions
        computes = {index: wrap(index, functions[f"c{index}"]) for index in self.plan.order}
        observed = codegen.bind_observed(self.plan, functions, computes)

        def switch(on: bool) -> None:
            self._pass = observed if on else plain

        return switch

    def run_pass(self) -> None:
        """One pass: events fire, and what they reach is computed.

        Raises:
            NodeError: a node raised; its cause is chained.
        """
        self._run(self._pass)

    def run_ending(self, ending: Ending) -> None:
        """What starts where a play, or the graph, ends; nothing in most graphs.

        Raises:
            NodeError: a node raised; its cause is chained.
        """
        if (function := self._functions.get(ending)) is not None:
            self._run(function)

    def _run(self, function: Callable[[], None]) -> None:
        """Run generated text; an exception in it names its node."""
        try:
            function()
        except NodeError:
            raise
        except Exception as error:
            raise self.explain(self._culprit(error), error) from error

    def run_latent(self) -> None:
        """Update every active latent node; what it fires is an event of the next pass."""
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
                if not self._drop(index, error):
                    del self._active[index]
                    node.active = False
                    self._report(index, error)
                continue
            if fired:
                self._functions[f"l{index}"] = self._functions.get(f"l{index}", 0) | fired
            if not node.active:
                del self._active[index]

    def _make_stale(self) -> None:
        for data in self.plan.flagged:
            self._functions[f"s{data}"] = 1

    def stop(self) -> None:
        """Outputs and state back to what they were before the first pass; latent nodes end, pins are forgotten."""
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
        self._make_stale()
        self._run(self._functions["constants"])

    def _culprit(self, error: Exception) -> int | None:
        """The node whose line of the generated text an exception came through last."""
        source = codegen.source_of(self.plan)
        frames = traceback.walk_tb(error.__traceback__)
        lines = [line for frame, line in frames if frame.f_code.co_filename == source.name]
        return source.node_at(lines[-1]) if lines else None

    def _end_branch(self, index: int, error: Exception) -> None:
        """A node raised something that may end its branch only."""
        if not self._drop(index, error):
            self._report(index, error)

    def _drop(self, index: int, error: Exception) -> bool:
        """Whether an exception says that a value is bad that came over a wire, or from outside of the node's inputs."""
        if self._dropped is None or not isinstance(error, BadValueError):
            return False
        ports = [type(self.nodes[index]).ports.get(f"inputs:{name}") for name in error.port.split(", ")]
        if all(port is not None and (index, port.field) not in self._wired for port in ports):
            return False
        self._dropped(index, error)
        return True

    def _report(self, index: int, error: Exception) -> None:
        explained = self.explain(index, error)
        explained.__cause__ = error
        if self._fault is None:
            raise explained
        self._fault(explained)

    def explain(self, index: int | None, error: Exception) -> NodeError:
        """Which node raised, where it stands in its file, with which inputs, when."""
        tick, time = self._now()
        when = f"at tick {tick}, {time:.6g} s"
        if index is None:
            return NodeError(f"graph {self.graph.name}, {when}: {type(error).__name__}: {error}")
        instance = self.graph.instances[index]
        node = self.nodes[index]
        inputs = [p for p in type(node).fields.values() if p.side == "inputs" and not p.is_exec]
        shown = ", ".join(f"{p.name}={_short(getattr(node, p.field, None))}" for p in inputs)
        return NodeError(
            f"{instance.span}: node {instance.id} ({type(node).type_name}) raised {type(error).__name__}: {error}\n"
            f"  {when}, in graph {self.graph.name}\n"
            f"  inputs: {shown or 'none'}",
            f"{self.graph.prim_path}/{instance.id}",
        )


def _by_target(copies: Iterable[Copy]) -> defaultdict[int, list[Copy]]:
    """Copies into each node."""
    incoming: defaultdict[int, list[Copy]] = defaultdict(list)
    for copy in copies:
        incoming[copy.target].append(copy)
    return incoming


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
