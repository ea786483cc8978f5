"""One graph in a session: its executor, the values of its variables, and the contexts of its nodes."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graphengine.compiler.every_gates import rate
from graphengine.compiler.graph import Graph, visible
from graphengine.devices.backend import World
from graphengine.devices.stage import Prim
from graphengine.format.errors import BadValueError, ContextError
from graphengine.format.prim_paths import at_or_below
from graphengine.node.clock import Clock
from graphengine.node.context.context import Context
from graphengine.node.context.session_services import Services
from graphengine.node.variable import Variable
from graphengine.runtime.executor import Executor
from graphengine.runtime.node_faults import FaultHandler, NodeFaults


class GraphContexts:
    """Creates and keeps the contexts of a graph's nodes; a new context closes the handles of the node's previous context."""

    def __init__(self, graph: Graph, services: Services, clock: Clock, variables: dict[str, Variable]) -> None:
        self.graph = graph
        self._services = services
        self._clock = clock
        self._variables = variables
        self._contexts: dict[int, Context] = {}
        self._wired: defaultdict[int, Counter[str]] = defaultdict(Counter)
        for wire in graph.data_wires:
            self._wired[wire.source][wire.source_field] += 1
        for wire in graph.exec_wires:
            self._wired[wire.target][wire.target_field] += 1
            self._wired[wire.source][wire.source_field] += 1

    def __call__(self, index: int) -> Context:
        """Return a new context for the node with an index; close the handles of the node's previous context."""
        if index in self._contexts:
            self._contexts[index].close()
        graph, clock = self.graph, self._clock
        instance = graph.instances[index]
        path, folder = f"{graph.prim_path}/{instance.id}", instance.entry.document.path.parent
        often, variables = rate(graph, index, 1.0 / clock.delta), visible(instance.id, self._variables)
        wired, base = self._wired[index], graph.prim_path
        context = Context(self._services, clock, graph.name, path, often, variables, graph.runs, wired, base, folder)
        self._contexts[index] = context
        return context

    def __iter__(self) -> Iterator[tuple[int, Context]]:
        return iter(self._contexts.items())

    def of(self, index: int) -> Context | None:
        """Return the context of the node with an index; None if the node was not set up."""
        return self._contexts.get(index)

    def bound(self, below: str) -> str | None:
        """Return the prim path of a node that uses the prim at `below` or a descendant; None if no node uses any of them."""
        for context in self._contexts.values():
            if any(at_or_below(prim.path, below) for prim in context.asked.values()):
                return context.prim_path
        return None

    def asked(self) -> Iterator[tuple[int, str, Prim]]:
        """Yield the node index, the requested path and the prim for each prim that a node has requested."""
        for index, context in self._contexts.items():
            yield from ((index, path, prim) for path, prim in context.asked.items())

    def reads_the_same(self) -> bool:
        """Return whether all files that nodes read in setup have the same content; False if a file can no longer be read."""
        try:
            return all(context.reads_the_same() for context in self._contexts.values())
        except ContextError:
            return False

    def close(self, heirs: Collection[str] = ()) -> None:
        """Close all handles of the nodes, and delete their random generators; safe to call twice.

        Args:
            heirs: prim paths of nodes whose random generators are kept for the nodes that replace these nodes.
        """
        for context in self._contexts.values():
            context.close()
            if context.prim_path not in heirs:
                self._services.generators.pop(context.prim_path, None)
        self._contexts.clear()


@dataclass(frozen=True, slots=True)
class SavedGraph:
    """The saved state of one graph.

    Attributes:
        executor: state of the nodes.
        variables: values of the variables, by name.
        mailboxes: state of the mailboxes of each node, by index.
        contexts: context of each node; if a node has another context at a restore, it was set up again in the meantime.
    """

    executor: Any
    variables: Mapping[str, Any]
    mailboxes: Mapping[int, Sequence[Any]]
    contexts: dict[int, Context]


@dataclass(slots=True, eq=False)
class GraphRun:
    """A graph that a session executes: its executor, variables and node contexts."""

    executor: Executor
    variables: dict[str, Variable]
    contexts: GraphContexts

    @property
    def name(self) -> str:
        """Full name of the graph: `robot/graph`, or `graph` if it belongs to no robot."""
        return self.executor.graph.name

    @property
    def paths(self) -> Sequence[str]:
        """Prim paths of the graph's nodes."""
        graph = self.executor.graph
        return [f"{graph.prim_path}/{instance.id}" for instance in graph.instances]

    @property
    def on_physics_step(self) -> bool:
        """Whether the graph runs after each physics step instead of once per tick."""
        return self.executor.graph.runs == "physics_step"

    def describe_as(self, graph: Graph) -> None:
        """Replace the resolved graph with an equal graph from the changed file, whose positions messages then show."""
        self.executor.graph = self.executor.faults.graph = self.contexts.graph = graph

    def save(self) -> SavedGraph:
        """Return a copy of the state of nodes, variables and mailboxes."""
        mailboxes = {index: [box.save() for box in context.mailboxes] for index, context in self.contexts}
        variables = {name: variable.save() for name, variable in self.variables.items()}
        return SavedGraph(self.executor.save(), variables, mailboxes, dict(self.contexts))

    def restore(self, saved: SavedGraph) -> None:
        """Restore the state that `save` returned.

        Raises:
            GraphError: a node that was set up after `save` cannot be set up again with its saved inputs.
        """
        changed = {index for index, context in self.contexts if saved.contexts.get(index) is not context}
        self.executor.restore(saved.executor, changed)
        saved.contexts.update(self.contexts)
        for name, state in saved.variables.items():
            self.variables[name].restore(state)
        for index, context in self.contexts:
            for box, state in zip(context.mailboxes, saved.mailboxes.get(index, ()), strict=False):
                box.restore(state)


def make_clock(world: World, *, on_step: bool = False) -> Clock:
    """Return a clock with the tick period of a world; with `on_step`, with the duration of a physics step."""
    numerator, denominator = world.tick_period
    return Clock((numerator, denominator * (world.substeps if on_step else 1)))


def make_graph_run(graph: Graph, services: Services, clock: Clock, fault: FaultHandler | None = None) -> GraphRun:
    """Return a run of a graph that is not set up yet.

    Args:
        graph: graph with a plan.
        services: services of the session for the contexts of nodes.
        clock: clock of the graph, which counts ticks or physics steps.
        fault: receives each exception of a node, after which the run continues; None: an exception ends the run.
    """
    dropped = services.dropped

    def drop(index: int, error: BadValueError, wired: bool) -> bool:
        if dropped is None or not (wired or dropped.drops_set_values):
            return False
        graph = faults.graph
        instance = graph.instances[index]
        node = f"{graph.prim_path}/{instance.id}"
        if dropped.add(node, clock.frame):
            what, *more = str(error).split("\n")
            what = f"{what}; dropped at tick {clock.frame}{dropped.earlier(node)}"
            where = f"{instance.span}: {instance.cls.type_name} in graph {graph.name}"
            services.warn(node, "\n  ".join([what, where, *more]))
        return True

    variables = {name: Variable(default) for name, default in graph.variables.items()}
    contexts = GraphContexts(graph, services, clock, variables)
    dropping = drop if dropped is not None else None
    nodes = [instance.make_node() for instance in graph.instances]
    faults = NodeFaults(graph, nodes, lambda: (clock.frame, clock.time), fault, dropping, services.started)
    return GraphRun(Executor(graph, nodes, contexts, faults), variables, contexts)
