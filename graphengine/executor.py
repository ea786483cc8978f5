"""One graph at run time: its nodes' life from setup to stop, its pass, and its latent nodes."""

from __future__ import annotations

import linecache
from collections.abc import Callable, Iterable
from typing import Any

from graphengine import codegen, types
from graphengine.context import Context
from graphengine.diagnostics import GraphError, NodeError
from graphengine.plan import Copy, Plan

ContextFactory = Callable[[int], Context]
"""The context of a node, by its index in the graph; each call gives a new one and closes the old one's handles."""


class Executor:
    """Runs a plan.

    Args:
        plan: what to do.
        context_of: where nodes get their contexts.
        now: simulation tick and time, for messages.
        fault: who hears of a node that raised; None stops the run at the first.
    """

    def __init__(
        self,
        plan: Plan,
        context_of: ContextFactory,
        now: Callable[[], tuple[int, float]],
        fault: Callable[[NodeError], None] | None = None,
    ) -> None:
        self.plan = plan
        self.nodes = [instance.node for instance in plan.graph.instances]
        self.source = codegen.write_source(plan, keep_going=fault is not None)
        self._context_of = context_of
        self._now = now
        self._fault = fault
        self._active: dict[int, None] = {}
        self._functions = codegen.compile_source(self.source, self.nodes, self.setup_node, self._activate, self._report)
        self._pass: Callable[[], None] = self._functions["pass_"]
        self._set_constant_pins()

    def _set_constant_pins(self) -> None:
        """An input with a single wire always fires once; it is told once."""
        wired: dict[int, list[str]] = {}
        for wire in self.plan.graph.exec_wires:
            wired.setdefault(wire.target, []).append(wire.target_field)
        told = {call.node for region in self.plan.regions for call in region.calls if call.pins or call.activations}
        for index, pins in wired.items():
            for pin in pins:
                setattr(self.nodes[index], pin, 0 if index in told else 1)

    def setup(self, failed: Callable[[int, GraphError], None] | None = None) -> None:
        """Set up every node that can run, in schedule order; constants first, outputs handed on as they become known.

        Args:
            failed: who hears of a node that could not be set up, so that the others still are; None raises at the first.

        Raises:
            GraphError: a node asked for something that is not there.
            NodeError: a node's setup raised anything else.
        """
        constant = {refresh.node: refresh for refresh in self.plan.constants}
        incoming: dict[int, list[Copy]] = {}
        for copy in self._all_copies():
            incoming.setdefault(copy.target, []).append(copy)
        for index in self.plan.order:
            self._apply(incoming.get(index, ()))
            try:
                self.setup_node(index)
                if index in constant:
                    self._call(index, self.nodes[index].compute)
            except GraphError as error:
                if failed is None:
                    raise
                failed(index, error)

    def _all_copies(self) -> Iterable[Copy]:
        """Every copy of the plan, once."""
        copies = dict.fromkeys(self.plan.constant_copies)
        for refresh in self.plan.constants:
            copies |= dict.fromkeys(refresh.copies)
        for region in self.plan.regions:
            for call in region.calls:
                copies |= dict.fromkeys(call.copies)
                copies |= {copy: None for refresh in call.refreshes for copy in refresh.copies}
        return copies

    def _apply(self, copies: Iterable[Copy]) -> None:
        for copy in copies:
            value = getattr(self.nodes[copy.source], copy.source_field)
            value = types.CONVERTERS[copy.converter](value) if copy.converter else value
            setattr(self.nodes[copy.target], copy.target_field, value)

    def setup_node(self, index: int) -> None:
        """Set up one node, anew if it was before."""
        node = self.nodes[index]
        self._call(index, lambda: node.setup(self._context_of(index)))

    def _call(self, index: int, function: Callable[[], Any]) -> Any:
        try:
            return function()
        except GraphError:
            raise
        except Exception as error:
            raise self.explain(index, error) from error

    def run_pass(self) -> None:
        """One pass: events fire, and what they reach is computed.

        Raises:
            NodeError: a node raised; its cause is chained.
        """
        try:
            self._pass()
        except GraphError:
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
            try:
                fired = node.update()
            except GraphError:
                raise
            except Exception as error:
                del self._active[index]
                node.active = False
                self._report(index, error)
                continue
            if fired:
                self._functions[f"l{index}"] = self._functions.get(f"l{index}", 0) | fired
            for data in self.plan.latent_marks.get(index, ()):
                self._functions[f"s{data}"] = 1
            if not node.active:
                del self._active[index]

    def set_constant(self, index: int, field: str, value: Any) -> None:
        """Change a literal while the graph runs; constants that follow from it are computed again.

        Raises:
            TypeError: the value is of the wrong type.
            ValueError: it is out of range.
        """
        node = self.nodes[index]
        port = type(node).fields[field]
        setattr(node, field, port.check(value))
        before = {copy: getattr(self.nodes[copy.target], copy.target_field) for copy in self.plan.constant_copies}
        self._functions["constants"]()
        changed = {index} if port.setup else set()
        for copy, old in before.items():
            target = type(self.nodes[copy.target]).fields[copy.target_field]
            if target.setup and not types.equal(old, getattr(self.nodes[copy.target], copy.target_field)):
                changed.add(copy.target)
        for data in self.plan.flagged:
            self._functions[f"s{data}"] = 1
        for changed_node in sorted(changed):
            self.setup_node(changed_node)

    def stop(self) -> None:
        """Outputs and state back to their defaults; latent nodes end."""
        self._active.clear()
        for index in self.plan.order:
            node = self.nodes[index]
            node.reset()
            node.clear()
        for data in self.plan.flagged:
            self._functions[f"s{data}"] = 1
        for index, _ in self.plan.root.pending:
            self._functions[f"l{index}"] = 0
        self._functions["constants"]()

    def _activate(self, index: int) -> None:
        """Register a latent node; one that starts again keeps its place."""
        self._active.setdefault(index)

    def _culprit(self, error: Exception) -> int | None:
        """The node whose line of the generated text an exception came through last."""
        found, traceback = None, error.__traceback__
        while traceback is not None:
            if traceback.tb_frame.f_code.co_filename == self.source.name:
                found = self.source.node_at(traceback.tb_lineno)
            traceback = traceback.tb_next
        return found

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
            return NodeError(f"graph {self.plan.graph.name}, {when}: {type(error).__name__}: {error}")
        instance = self.plan.graph.instances[index]
        node = self.nodes[index]
        inputs = [p for p in type(node).fields.values() if p.side == "inputs" and not p.is_exec]
        shown = ", ".join(f"{p.name}={_short(getattr(node, p.field, None))}" for p in inputs)
        return NodeError(
            f"{instance.span}: node {instance.id} ({type(node).type_name}) raised {type(error).__name__}: {error}\n"
            f"  {when}, in graph {self.plan.graph.name}\n"
            f"  inputs: {shown or 'none'}"
        )

    def close(self) -> None:
        """Forget the generated text."""
        linecache.cache.pop(self.source.name, None)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
