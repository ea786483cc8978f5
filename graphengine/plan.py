"""From wires to a Plan: regions, their order, what guards a node, and when a data node is computed again.

A **region** is what is reached from the events of a pass, or from one port of a pusher, without crossing another pusher's
port. Within a region nodes are ordered topologically over execution and data wires; a pusher with everything below it is one
unit. The plan is plain data: `graphrun show --plan` prints it, `codegen` turns it into source.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import networkx as nx

from graphengine.diagnostics import Findings
from graphengine.resolve import Graph, Instance, Wire


@dataclass(frozen=True, slots=True)
class Copy:
    """A value goes from one node's field to another's."""

    source: int
    source_field: str
    target: int
    target_field: str
    converter: str = ""
    setup: bool = False
    """The target is read in `setup`: when the value changes, the node is set up again."""


@dataclass(frozen=True, slots=True)
class Refresh:
    """A data node is computed before its consumer: always, or when something it depends on changed."""

    node: int
    copies: tuple[Copy, ...]
    if_stale: bool = False
    flagged: bool = False
    repeated: bool = False
    """It shows what its consumer puts out, and so belongs to each activation of a consumer that counts them."""


@dataclass(frozen=True, slots=True)
class Fire:
    """What follows when a port fires: local flags and counters of the region, or a pin that waits on the node itself."""

    target: int
    guard: str = ""
    counter: str = ""
    pending_pin: str = ""


@dataclass(frozen=True, slots=True)
class Branch:
    """One execution output: its bit in what `compute` returns, and what it leads to."""

    mask: int
    fires: tuple[Fire, ...] = ()
    region: int = -1
    """Of a pusher: the region that runs for each yield of the port."""


@dataclass(frozen=True, slots=True)
class Pin:
    """An execution input that a node is told about."""

    field: str
    counter: str = ""
    """Local counter of how often it fired in this run of the region; empty when nothing in the region fires it."""
    pending: bool = False
    """A control pin that may have fired for this activation in an earlier one."""


@dataclass(frozen=True, slots=True)
class Activation:
    """Of a node that counts: how often one of its wires fired, and the pin it leads to."""

    counter: str
    pin: str


@dataclass(frozen=True, slots=True)
class Call:
    """One node in its place in a region."""

    node: int
    kind: str
    guard: str
    """Local flag that must be set; empty when the node always runs."""
    refreshes: tuple[Refresh, ...]
    copies: tuple[Copy, ...]
    gated: bool
    branches: tuple[Branch, ...]
    marks: tuple[int, ...]
    """Data nodes that become stale when this node has computed."""
    pins: tuple[Pin, ...]
    """Empty for a node with one incoming wire: there is nothing to tell."""
    activations: tuple[Activation, ...] = ()


@dataclass(frozen=True, slots=True)
class Region:
    """Calls in order; `flags` are the local integers that start at 0."""

    index: int
    title: str
    flags: tuple[str, ...]
    entries: tuple[Fire, ...]
    """What the wires set that start the region."""
    calls: tuple[Call, ...]
    stale: tuple[int, ...] = ()
    """Of a root region: data nodes that each pass makes stale."""
    pending: tuple[tuple[int, tuple[Branch, ...]], ...] = ()
    """Of a root region: latent nodes that may have fired since the last pass."""


@dataclass(slots=True)
class Plan:
    """Everything that the generated functions do."""

    graph: Graph
    regions: list[Region] = field(default_factory=list)
    constants: list[Refresh] = field(default_factory=list)
    """Data nodes that cannot change while the graph runs, computed once."""
    constant_copies: list[Copy] = field(default_factory=list)
    flagged: tuple[int, ...] = ()
    """Data nodes with a run-time flag that says whether they are stale."""
    latent_marks: dict[int, tuple[int, ...]] = field(default_factory=dict)
    """Data nodes that become stale when a latent node was updated."""
    order: list[int] = field(default_factory=list)
    """Every node that can run, in schedule order, each data node before its first consumer; setup follows it."""
    early: set[int] = field(default_factory=set)
    """Data nodes that change while the graph runs, but whose values inputs that are read in `setup` need before."""
    certain: set[int] = field(default_factory=set)
    """Nodes that run in every pass."""
    keep_going: bool = False
    """A node that raises ends its branch only, so what follows it is never certain to run."""

    @property
    def root(self) -> Region:
        """The region that starts from the events of a pass."""
        return self.regions[0]


def make_plan(graph: Graph, findings: Findings, *, keep_going: bool = False) -> Plan | None:
    """The plan of a resolved graph; None when a cycle keeps it from running.

    Args:
        graph: instances and wires.
        findings: where mistakes go.
        keep_going: a node that raises is to end its branch only.
    """
    return _Planner(graph, findings, keep_going).make()


@dataclass(frozen=True, slots=True)
class _Reading:
    """A node reads from one that is executed: through a wire, and perhaps data nodes."""

    reader: int
    source: int
    wire: Wire
    shown: bool
    """Whether an output of the source is read, and not only what it writes elsewhere."""


class _Planner:
    def __init__(self, graph: Graph, findings: Findings, keep_going: bool) -> None:
        self.graph = graph
        self.findings = findings
        self.kinds = [instance.cls.kind() for instance in graph.instances]
        self.data_in: dict[int, list[Wire]] = {}
        """Wires into each node; one that began at a wired input begins where that input's value comes from."""
        self.exec_out: dict[int, list[Wire]] = {}
        self.exec_in: dict[int, list[Wire]] = {}
        self.execution: nx.DiGraph[int] = nx.DiGraph()
        """What starts what in the same pass."""
        self.pending_control: set[int] = set()
        """Orders of control wires that close a cycle."""
        self.plan = Plan(graph, keep_going=keep_going)
        self.members: list[list[int]] = []
        """Nodes of each region in order."""
        self.entries: list[list[Wire]] = []
        """Wires that start each region; of several ports that open one region alike, those of the first."""
        self.titles: list[str] = []
        self.pin_region: dict[tuple[int, str], int] = {}
        self.flagged: set[int] = set()

    def node(self, index: int) -> Instance:
        return self.graph.instances[index]

    def make(self) -> Plan | None:
        self._index_wires()
        if not all([self._check_data_cycles(), self._check_exec_cycles()]):  # both tell what they find
            return None
        self._find_counting()
        self._find_dependencies()
        self._open_regions()
        self._order_regions()
        self._lint_reads_and_writes()
        self._find_certain()
        count = -1
        while count != len(self.flagged):  # a data node that needs a flag changes what other steps must do
            count = len(self.flagged)
            self.plan.regions = [_Emitter(self, i).emit() for i in range(len(self.members))]
        self.plan.flagged = tuple(sorted(self.flagged))
        for index, kind in enumerate(self.kinds):
            if kind == "latent":
                self.plan.latent_marks[index] = self.marks(index)
        self._order_setup()
        return self.plan

    # Wires

    def _index_wires(self) -> None:
        wire_into = {(wire.target, wire.target_field): wire for wire in self.graph.data_wires}
        for wire in self.graph.data_wires:
            origin, converter, seen = wire, wire.converter, {wire.order}
            while self._reads_input(origin):
                upstream = wire_into.get((origin.source, origin.source_field))
                if upstream is None or upstream.order in seen:
                    break
                seen.add(upstream.order)
                origin, converter = upstream, converter or upstream.converter
            effective = replace(wire, source=origin.source, source_field=origin.source_field, converter=converter)
            self.data_in.setdefault(wire.target, []).append(effective)
        for wire in self.graph.exec_wires:
            self.exec_out.setdefault(wire.source, []).append(wire)
            self.exec_in.setdefault(wire.target, []).append(wire)

    def _reads_input(self, wire: Wire) -> bool:
        """Whether a wire starts at an input; of those in `data_in`, at one that nothing is wired to: a constant."""
        return self.node(wire.source).cls.fields[wire.source_field].side == "inputs"

    def _check_data_cycles(self) -> bool:
        graph: nx.DiGraph[int] = nx.DiGraph()
        graph.add_nodes_from(i for i, kind in enumerate(self.kinds) if kind == "data")
        wires = [w for i in graph for w in self.data_in.get(i, []) if w.source in graph and not self._reads_input(w)]
        graph.add_edges_from((wire.source, wire.target) for wire in wires)
        if self._report_cycles("G209", "data nodes wait for each other", graph, wires):
            return False
        self.data_rank = {index: rank for rank, index in enumerate(nx.topological_sort(graph))}
        return True

    def _check_exec_cycles(self) -> bool:
        """Control wires that close a cycle act for the next activation; any other cycle is an error."""
        graph = self.execution
        wires: list[Wire] = []
        control: list[Wire] = []
        graph.add_nodes_from(range(len(self.kinds)))
        for wire in self.graph.exec_wires:
            if self.kinds[wire.source] == "latent":
                continue
            is_control = self.node(wire.target).cls.fields[wire.target_field].control
            (control if is_control else wires).append(wire)
        graph.add_edges_from((wire.source, wire.target) for wire in wires)
        if self._report_cycles("G210", "execution runs in a circle", graph, wires):
            return False
        for wire in control:
            if nx.has_path(graph, wire.target, wire.source):
                self.pending_control.add(wire.order)
            else:
                graph.add_edge(wire.source, wire.target)
        return True

    def _report_cycles(self, code: str, what: str, graph: nx.DiGraph[int], wires: list[Wire]) -> bool:
        """Tell of one cycle in each knot of nodes that wait for each other; whether there is any."""
        between = {(wire.source, wire.target): wire for wire in reversed(wires)}
        found = False
        for component in sorted(nx.strongly_connected_components(graph), key=min):
            first = min(component)
            if len(component) > 1 or graph.has_edge(first, first):
                loop = nx.find_cycle(graph.subgraph(component), first)
                self._report_cycle(code, what, [between[edge[0], edge[1]] for edge in loop])
                found = True
        return found

    def _report_cycle(self, code: str, what: str, loop: list[Wire]) -> None:
        path = " -> ".join([self.node(wire.source).id for wire in loop] + [self.node(loop[0].source).id])
        remedy = (
            "break it with a node that has an execution input"
            if code == "G209"
            else "break it with a Delay, or a control pin"
        )
        related = [(wire.span, str(wire)) for wire in loop]
        self.findings.add(code, f"{what}: {path}", loop[0].span, remedy, related=[*related, *loop[0].entry.via])

    def forward(self, wire: Wire) -> bool:
        """Whether a wire starts something in the same pass."""
        return wire.order not in self.pending_control and self.kinds[wire.source] != "latent"

    def fires_surely(self, index: int) -> bool:
        """Whether a node's output fires whenever the node is computed."""
        plain = self.kinds[index] in ("event", "action") and not self.node(index).cls.gated
        return plain and not self.plan.keep_going

    def _find_counting(self) -> None:
        self.counting: set[int] = set()
        """Nodes that count activations, and may see several in one run of a region."""
        for index in nx.topological_sort(self.execution):
            if self.node(index).cls.counts and self.fired_often(index):
                self.counting.add(index)

    def fired_often(self, index: int) -> bool:
        """Whether a node may be fired more than once in one run of a region."""
        wires = self.exec_in.get(index, [])
        return len(wires) > 1 or any(wire.source in self.counting for wire in wires)

    # What a data node depends on

    def _find_dependencies(self) -> None:
        self.shows: dict[int, set[int]] = {}
        """For each data node: the executed nodes whose outputs it shows."""
        self.depends: dict[int, set[int]] = {}
        """The same, and the executed nodes that write what it reads."""
        self.dependents: dict[int, list[int]] = {}
        """For each executed node: the data nodes that depend on it."""
        self.volatile: set[int] = set()
        writers: dict[str, set[int]] = {}
        for instance in self.graph.instances:
            for key in instance.node.writes():
                writers.setdefault(key, set()).add(instance.index)
        for index in self.data_rank:
            instance = self.node(index)
            shows: set[int] = set()
            written: set[int] = set()
            if instance.cls.volatile:
                self.volatile.add(index)
                written.update(*(writers.get(key, ()) for key in instance.node.reads()))
            for source in self._sources_of_value(index):
                if self.kinds[source] != "data":
                    shows.add(source)
                    continue
                shows |= self.shows[source]
                written |= self.depends[source]
                if source in self.volatile:
                    self.volatile.add(index)
            self.shows[index], self.depends[index] = shows, shows | written
            for source in sorted(self.depends[index]):
                self.dependents.setdefault(source, []).append(index)
        self.constant = {d for d in self.data_rank if not self.depends[d] and d not in self.volatile}

    def _sources_of_value(self, index: int) -> Iterator[int]:
        """Nodes whose outputs a node reads."""
        return (wire.source for wire in self.data_in.get(index, []) if not self._reads_input(wire))

    def _upstream(self, index: int) -> list[int]:
        """Data nodes that a node reads, directly or through others, in the order to compute them."""
        found: set[int] = set()
        pending = list(self._sources_of_value(index))
        while pending:
            source = pending.pop()
            if source in self.data_rank and source not in found:
                found.add(source)
                pending += self._sources_of_value(source)
        return sorted(found, key=lambda data: self.data_rank[data])

    def data_needs(self, index: int) -> list[int]:
        """The same without constants."""
        return [data for data in self._upstream(index) if data not in self.constant]

    def marks(self, index: int) -> tuple[int, ...]:
        """Data nodes with a run-time flag that become stale when a node has computed."""
        return tuple(data for data in self.dependents.get(index, ()) if data in self.flagged)

    def _copies(self, index: int, *, constant: bool | None) -> tuple[Copy, ...]:
        """Copies into a node: from constants only, from what changes only, or all."""
        copies = []
        for wire in self.data_in.get(index, []):
            fixed = self._reads_input(wire) or wire.source in self.constant
            if constant is None or fixed == constant:
                setup = self.node(index).cls.fields[wire.target_field].setup
                copies.append(
                    Copy(wire.source, wire.source_field, index, wire.target_field, wire.converter, setup and not fixed)
                )
        return tuple(copies)

    def changing_copies(self, index: int) -> tuple[Copy, ...]:
        """Copies that are made whenever the node runs."""
        return self._copies(index, constant=False)

    # Regions

    def _open_regions(self) -> None:
        starts = [i for i, kind in enumerate(self.kinds) if kind in ("event", "pusher") and not self.exec_in_ports(i)]
        self.events = set(starts)
        reached, count = set(starts), -1
        while count != len(reached):  # what starts a latent node starts, in a later pass, what follows it
            count = len(reached)
            starts += [w.target for i in sorted(reached) if self.kinds[i] == "latent" for w in self.exec_out.get(i, [])]
            reached = set(starts).union(*(nx.descendants(self.execution, start) for start in set(starts)))
        self.latents = {i for i in reached if self.kinds[i] == "latent"}
        self._open_region("pass", [], starts)
        known: dict[tuple[tuple[int, str], ...], int] = {}
        opened = 0
        while opened < len(self.members):  # regions open further regions
            for index in [i for i in self.members[opened] if self.kinds[i] == "pusher"]:
                for port in self._exec_outputs(index):
                    if (index, port) not in self.pin_region:
                        self.pin_region[index, port] = self._region_below(index, port, known)
            opened += 1

    def _open_region(self, title: str, entries: list[Wire], starts: Iterable[int]) -> int:
        self.titles.append(title)
        self.entries.append(entries)
        self.members.append(self._reach(starts))
        return len(self.members) - 1

    def _region_below(self, pusher: int, port: str, known: dict[tuple[tuple[int, str], ...], int]) -> int:
        """The region that a port opens; ports that start the same pins share one, -1 is one without nodes."""
        wires = [w for w in self.exec_out.get(pusher, []) if w.source_field == port and self.forward(w)]
        title = f"{self.node(pusher).id}.{self.node(pusher).cls.fields[port].name}"
        pins = tuple(sorted((wire.target, wire.target_field) for wire in wires))
        if not pins:
            return -1
        if pins in known:
            self.titles[known[pins]] += f" or {title}"
        else:
            known[pins] = self._open_region(title, wires, [wire.target for wire in wires])
        return known[pins]

    def exec_in_ports(self, index: int) -> list[str]:
        """Fields of a node's execution inputs."""
        return [p.field for p in self.node(index).cls.fields.values() if p.is_exec and p.side == "inputs"]

    def _exec_outputs(self, index: int) -> list[str]:
        return [p.field for p in self.node(index).cls.fields.values() if p.is_exec and p.side == "outputs"]

    def _reach(self, starts: Iterable[int]) -> list[int]:
        """Nodes reached by execution without crossing a pusher's port."""
        found: dict[int, None] = {}
        pending = list(dict.fromkeys(starts))[::-1]
        while pending:
            index = pending.pop()
            if index in found:
                continue
            found[index] = None
            if self.kinds[index] not in ("pusher", "latent"):
                pending += [w.target for w in reversed(self.exec_out.get(index, [])) if self.forward(w)]
        return list(found)

    # Order

    def _readings(self, reader: int) -> Iterator[_Reading]:
        """What a node reads from executed nodes."""
        for wire in self.data_in.get(reader, []):
            if self._reads_input(wire):
                continue
            if self.kinds[wire.source] != "data":
                yield _Reading(reader, wire.source, wire, shown=True)
                continue
            for source in sorted(self.depends[wire.source]):
                yield _Reading(reader, source, wire, shown=source in self.shows[wire.source])

    def _order_regions(self) -> None:
        self.covers = {i: nx.descendants(self.execution, i) for i, kind in enumerate(self.kinds) if kind == "pusher"}
        """For each pusher: every node in the regions below it."""
        first_wire = {i: min((w.order for w in wires), default=-1) for i, wires in self.exec_in.items()}
        for region, members in enumerate(self.members):
            inside = set(members)
            owners: dict[int, list[int]] = {}
            for unit in members:
                for covered in {unit} | self.covers.get(unit, set()):
                    owners.setdefault(covered, []).append(unit)
            order: nx.DiGraph[int] = nx.DiGraph()
            order.add_nodes_from(members)
            for unit in members:
                if self.kinds[unit] not in ("pusher", "latent"):
                    targets = [w.target for w in self.exec_out.get(unit, []) if self.forward(w) and w.target in inside]
                    order.add_edges_from((unit, target) for target in targets)
            self._add_data_edges(order, owners)

            def key(index: int) -> tuple[int, int, int]:
                return (0 if index in self.events else 1, first_wire.get(index, -1), index)

            self.members[region] = list(nx.lexicographical_topological_sort(order, key=key))
        for pusher in self.covers:
            self._lint_later_ports(pusher)

    def _lint_later_ports(self, pusher: int) -> None:
        """Tell of a node below one port that reads what only a later port's nodes compute."""
        regions = [self.pin_region.get((pusher, port), -1) for port in self._exec_outputs(pusher)]
        reached = [
            {n for m in self.members[r] for n in {m} | self.covers.get(m, set())} if r >= 0 else set() for r in regions
        ]
        before: set[int] = set()
        for position, nodes in enumerate(reached):
            later = set().union(*reached[position + 1 :]) - nodes - before
            for reader in sorted(nodes):
                for reading in self._readings(reader):
                    if reading.source in later:
                        self._report_previous(reading)
            before |= nodes

    def _add_data_edges(self, order: nx.DiGraph[int], owners: dict[int, list[int]]) -> None:
        """Order readers after what they read; a wire that would close a cycle reads the previous value."""
        edges: list[tuple[int, int, _Reading]] = []
        for reader, units in owners.items():
            for reading in self._readings(reader):
                if self.kinds[reading.source] != "latent":
                    befores = owners.get(reading.source, [])
                    edges += [(before, unit, reading) for unit in units for before in befores if before != unit]
        edges.sort(key=lambda edge: (edge[2].wire.order, edge[0], edge[1]))
        tentative = order.copy()
        tentative.add_edges_from((before, unit) for before, unit, _ in edges)
        component = {n: i for i, part in enumerate(nx.strongly_connected_components(tentative)) for n in part}
        for before, unit, reading in edges:
            if order.has_edge(before, unit):
                continue
            if component[before] == component[unit] and nx.has_path(order, unit, before):
                self._report_previous(reading)
            else:
                order.add_edge(before, unit)

    def _report_previous(self, reading: _Reading) -> None:
        wire, reader = reading.wire, self.node(reading.reader).id
        if reading.shown:  # that a variable is read before it is written needs no remark
            self.findings.add(
                "W104",
                f"{wire.entry.target} reads the value that {self.node(reading.source).id} had before this pass: "
                f"execution orders {reader} before it",
                wire.span,
                "if that is meant, leave it; else change the order of execution",
                related=wire.entry.via,
            )

    def _lint_reads_and_writes(self) -> None:
        """Tell where only the tie rule decides whether a reader sees a write of the same pass."""
        writers: dict[str, list[int]] = {}
        for instance in self.graph.instances:
            for name in instance.node.writes():
                writers.setdefault(name, []).append(instance.index)
        if not writers:
            return
        for instance in self.graph.instances:
            for name in instance.node.reads():
                readers = [instance.index] if self.kinds[instance.index] != "data" else self._consumers(instance.index)
                for reader in readers:
                    for writer in writers.get(name, []):
                        if self._in_stated_order(reader, writer):
                            continue
                        self.findings.add(
                            "W105",
                            f"{self.node(reader).id} reads and {self.node(writer).id} writes {name.replace(':', ' ')}, "
                            "in no stated order",
                            self.node(reader).span,
                            "order them with a Multisequence",
                            related=[(self.node(writer).span, "written here"), *self.node(reader).entry.via],
                        )

    def _in_stated_order(self, one: int, other: int) -> bool:
        """Whether execution or a pusher says which of two nodes comes first."""
        ordered = nx.has_path(self.execution, one, other) or nx.has_path(self.execution, other, one)
        return ordered or any({one, other} <= covered for covered in self.covers.values())

    def _consumers(self, data: int) -> list[int]:
        """Executed nodes that read a data node, through others too."""
        return [i for i, kind in enumerate(self.kinds) if kind != "data" and data in self.data_needs(i)]

    # What runs in every pass

    def _find_certain(self) -> None:
        """Nodes of the root region that run in every pass, whatever fires."""
        for index in self.members[0]:
            wires = [wire for wire in self.exec_in.get(index, []) if self.forward(wire)]
            fired = any(wire.source in self.plan.certain and self.fires_surely(wire.source) for wire in wires)
            if index in self.events or fired:
                self.plan.certain.add(index)

    def _order_setup(self) -> None:
        executed: dict[int, None] = {}
        pending = self.members[0][::-1]
        while pending:
            index = pending.pop()
            if index not in executed:
                executed[index] = None
                below = [self.pin_region.get((index, port), -1) for port in self._exec_outputs(index)]
                pending += [n for region in reversed(below) if region >= 0 for n in reversed(self.members[region])]
        order: dict[int, None] = {}
        for index in executed:
            needs = self._upstream(index)
            order |= dict.fromkeys([*needs, *self._read_off([*needs, index]), index])
        constants = sorted(self.constant & order.keys(), key=lambda data: self.data_rank[data])
        self.plan.constants = [Refresh(data, self._copies(data, constant=None)) for data in constants]
        self.plan.order = list(dict.fromkeys([*constants, *order]))
        self.plan.constant_copies = [copy for i in self.plan.order for copy in self._copies(i, constant=True)]
        for wire in (wire for index in order for wire in self.data_in.get(index, [])):
            if self.node(wire.target).cls.fields[wire.target_field].setup and wire.source in self.data_rank:
                self.plan.early |= {*self.data_needs(wire.source), wire.source} - self.constant

    def _read_off(self, readers: Iterable[int]) -> list[int]:
        """Data nodes whose unwired inputs a wire begins at; they need not be computed for it."""
        wires = [wire for reader in readers for wire in self.data_in.get(reader, [])]
        return [wire.source for wire in wires if self._reads_input(wire) and wire.source in self.data_rank]


class _Emitter:
    """Writes one region's calls, keeping book of which data nodes are up to date where."""

    def __init__(self, planner: _Planner, region: int) -> None:
        self.planner = planner
        self.region = region
        self.inside = set(planner.members[region])
        self.entered = {wire.order for wire in planner.entries[region]}
        """Orders of the wires that start the region for certain."""
        self.flags: dict[str, None] = {}
        self.guards: dict[int, str] = {}
        self.state: dict[int, str] = {}
        """Of each data node: `stale`, `clean`, `maybe`, or `clean under <guard>`."""

    def emit(self) -> Region:
        planner, root = self.planner, self.region == 0
        for data in planner.data_rank:
            if data in planner.constant:
                self.state[data] = "clean"
            else:
                self.state[data] = "stale" if root and data in planner.volatile else "maybe"
        for index in planner.members[self.region]:
            self.guards[index] = self._guard(index)
        calls = tuple(self._call(index) for index in planner.members[self.region])
        stale = tuple(d for d in sorted(planner.flagged) if d in planner.volatile) if root else ()
        entries = tuple(self._fires(planner.entries[self.region]))
        pending = self._pending() if root else ()
        return Region(self.region, planner.titles[self.region], tuple(self.flags), entries, calls, stale, pending)

    def _in_wires(self, index: int) -> list[Wire]:
        """Wires that can start a node in this region."""
        planner, root = self.planner, self.region == 0
        return [
            w
            for w in planner.exec_in.get(index, [])
            if w.order in self.entered
            or (root and w.source in planner.latents)
            or (w.source in self.inside and planner.kinds[w.source] in ("event", "action") and planner.forward(w))
        ]

    def _guard(self, index: int) -> str:
        planner, wires = self.planner, self._in_wires(index)
        sure = [w for w in wires if w.order in self.entered or planner.fires_surely(w.source)]
        if index in planner.events or any(w.order in self.entered or self.guards[w.source] == "" for w in sure):
            return ""
        if len(wires) == len(sure) == 1:
            return self.guards[sure[0].source]
        return self._flag(f"f{index}")

    def _flag(self, name: str) -> str:
        """A local integer that starts at 0."""
        self.flags[name] = None
        return name

    def _tells_pins(self, index: int) -> bool:
        """Whether a node's execution inputs say different things from one run to the next."""
        wires = self.planner.exec_in.get(index, [])
        return self.planner.fired_often(index) or any(wire.order in self.planner.pending_control for wire in wires)

    def _pins(self, index: int) -> tuple[Pin, ...]:
        if not self._tells_pins(index):
            return ()
        waiting = {w.target_field for w in self.planner.exec_in[index] if w.order in self.planner.pending_control}
        fired = set() if index in self.planner.counting else {wire.target_field for wire in self._in_wires(index)}
        pins = self.planner.exec_in_ports(index)
        return tuple(Pin(p, self._flag(f"x{index}_{p}") if p in fired else "", p in waiting) for p in pins)

    def _fires(self, wires: Iterable[Wire]) -> Iterator[Fire]:
        """What wires set when they fire; nothing where a node runs anyway and need not be told."""
        for wire in sorted(wires, key=lambda w: w.order):
            target = wire.target
            if wire.order in self.planner.pending_control:
                yield Fire(target, pending_pin=wire.target_field)
                continue
            guard = f"f{target}" if self.guards[target] == f"f{target}" else ""
            counter = ""
            if target in self.planner.counting:
                counter = self._flag(f"w{wire.order}")
            elif self._tells_pins(target):
                counter = self._flag(f"x{target}_{wire.target_field}")
            if guard or counter:
                yield Fire(target, guard, counter)

    def _branches(self, index: int) -> tuple[Branch, ...]:
        """One for each execution output; a pusher's ports fire by themselves only pins that wait."""
        planner = self.planner
        branches = []
        for port in planner.node(index).cls.fields.values():
            if not port.is_exec or port.side != "outputs":
                continue
            wires = [w for w in planner.exec_out.get(index, []) if w.source_field == port.field]
            region = planner.pin_region.get((index, port.field), -1)
            if planner.kinds[index] == "pusher":
                wires = [w for w in wires if w.order in planner.pending_control]
            branches.append(Branch(port.mask, tuple(self._fires(wires)), region))
        return tuple(branches)

    def _pending(self) -> tuple[tuple[int, tuple[Branch, ...]], ...]:
        latent = [index for index in sorted(self.planner.latents) if self.planner.exec_out.get(index)]
        return tuple((index, self._branches(index)) for index in latent)

    def _call(self, index: int) -> Call:
        planner = self.planner
        kind, guard = planner.kinds[index], self.guards[index]
        refreshes = tuple(r for data in planner.data_needs(index) for r in self._refresh(data, index))
        branches = () if kind == "latent" else self._branches(index)
        self._invalidate(index, guard)
        activations: tuple[Activation, ...] = ()
        if index in planner.counting:
            wires = sorted(self._in_wires(index), key=lambda w: (not self._is_control(w), w.order))
            activations = tuple(Activation(self._flag(f"w{w.order}"), w.target_field) for w in wires)
        gated = planner.node(index).cls.gated
        copies, marks = planner.changing_copies(index), planner.marks(index)
        return Call(index, kind, guard, refreshes, copies, gated, branches, marks, self._pins(index), activations)

    def _is_control(self, wire: Wire) -> bool:
        return self.planner.node(wire.target).cls.fields[wire.target_field].control

    def _refresh(self, data: int, consumer: int) -> list[Refresh]:
        """How a data node is brought up to date before a consumer."""
        planner, state, guard = self.planner, self.state[data], self.guards[consumer]
        repeated = consumer in planner.counting and consumer in planner.depends[data]
        if not repeated and (state == "clean" or (guard and state == f"clean under {guard}")):
            return []
        sure = state == "stale" and not repeated
        if not sure:
            planner.flagged.add(data)
        self.state[data] = f"clean under {guard}" if guard else "clean"
        return [Refresh(data, planner.changing_copies(data), not sure, data in planner.flagged, repeated)]

    def _invalidate(self, index: int, guard: str) -> None:
        """Note which data nodes are stale, or may be, after a node has run."""
        planner = self.planner
        pusher = planner.kinds[index] == "pusher"
        for data in planner.dependents.get(index, ()):
            if not guard and not pusher:
                self.state[data] = "stale"
            elif self.state[data] != "stale":
                self.state[data] = "maybe"
        for data in {d for covered in planner.covers.get(index, ()) for d in planner.dependents.get(covered, ())}:
            self.state[data] = "maybe"
        if pusher:  # a region below may have brought up to date what was stale before
            self.state |= dict.fromkeys((data for data, state in self.state.items() if state == "stale"), "maybe")
