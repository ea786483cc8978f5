"""From wires to a Plan: regions, their order, what guards a node, and when a data node is computed again.

A **region** is what is reached from the events of a pass, or from one port of a pusher, without crossing another pusher's
port. Within a region nodes are ordered topologically over execution and data wires; a pusher with everything below it is one
unit. The plan is plain data: `graphrun show --plan` prints it, `codegen` turns it into source.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

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


@dataclass(frozen=True, slots=True)
class Fire:
    """What follows when a port fires: a node is to run, one of its pins is counted, an activation is queued."""

    target: int
    guard: str = ""
    pin: str = ""
    activation: str = ""


@dataclass(frozen=True, slots=True)
class Branch:
    """One execution output: its bit in what `compute` returns, and what it leads to."""

    mask: int
    fires: tuple[Fire, ...] = ()
    region: int = -1
    """Of a pusher: the region that runs for each yield of the port."""


@dataclass(frozen=True, slots=True)
class Activation:
    """Of a node that counts: one wire that may have fired, and the pin it leads to."""

    flag: str
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
    pins: tuple[str, ...]
    """Execution inputs to count and to clear; empty where there is nothing to tell."""
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
    certain: set[int] = field(default_factory=set)
    """Nodes that run in every pass."""

    @property
    def root(self) -> Region:
        """The region that starts from the events of a pass."""
        return self.regions[0]


def make_plan(graph: Graph, findings: Findings) -> Plan | None:
    """The plan of a resolved graph; None when a cycle keeps it from running."""
    return _Planner(graph, findings).make()


class _Planner:
    def __init__(self, graph: Graph, findings: Findings) -> None:
        self.graph = graph
        self.findings = findings
        self.kinds = [instance.cls.kind() for instance in graph.instances]
        self.data_in: dict[int, list[Wire]] = {}
        self.exec_out: dict[int, list[Wire]] = {}
        self.exec_in: dict[int, list[Wire]] = {}
        self.pending_control: set[Wire] = set()
        self.plan = Plan(graph)
        self.members: list[list[int]] = []
        """Nodes of each region in order."""
        self.pin_region: dict[tuple[int, str], int] = {}
        self.flagged: set[int] = set()

    def node(self, index: int) -> Instance:
        return self.graph.instances[index]

    def make(self) -> Plan | None:
        self._index_wires()
        if not (self._check_data_cycles() and self._check_exec_cycles()):
            return None
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
                self.plan.latent_marks[index] = tuple(d for d in self.plan.flagged if index in self.depends[d])
        self._order_setup()
        return self.plan

    # Wires

    def _index_wires(self) -> None:
        wire_into = {(wire.target, wire.target_field): wire for wire in self.graph.data_wires}
        for wire in self.graph.data_wires:
            origin, seen = wire, {wire}
            while self.node(origin.source).cls.fields[origin.source_field].side == "inputs":  # a wire from an input
                upstream = wire_into.get((origin.source, origin.source_field))
                if upstream is None or upstream in seen:
                    break
                seen.add(upstream)
                origin = upstream
            self.data_in.setdefault(wire.target, []).append(
                Wire(
                    origin.source,
                    origin.source_field,
                    wire.target,
                    wire.target_field,
                    wire.converter,
                    wire.entry,
                    wire.order,
                )
            )
        for wire in self.graph.exec_wires:
            self.exec_out.setdefault(wire.source, []).append(wire)
            self.exec_in.setdefault(wire.target, []).append(wire)

    def _reads_input(self, wire: Wire) -> bool:
        """Whether a wire starts at an input that nothing is wired to: a constant."""
        return self.node(wire.source).cls.fields[wire.source_field].side == "inputs"

    def _check_data_cycles(self) -> bool:
        graph: nx.DiGraph[int] = nx.DiGraph()
        wires: dict[tuple[int, int], Wire] = {}
        for wire in self.graph.data_wires:
            if self.kinds[wire.source] == self.kinds[wire.target] == "data":
                graph.add_edge(wire.source, wire.target)
                wires.setdefault((wire.source, wire.target), wire)
        found = False
        for component in nx.strongly_connected_components(graph):
            first = min(component)
            if len(component) > 1 or graph.has_edge(first, first):
                loop = nx.find_cycle(graph.subgraph(component), first)
                self._report_cycle("G209", "data nodes wait for each other", [wires[edge[0], edge[1]] for edge in loop])
                found = True
        if not found:
            self.data_order = list(nx.topological_sort(graph)) if graph else []
            rank = {n: i for i, n in enumerate(self.data_order)}
            self.data_rank = {i: rank.get(i, -1) for i, kind in enumerate(self.kinds) if kind == "data"}
        return not found

    def _check_exec_cycles(self) -> bool:
        """Control wires that close a cycle act for the next activation; any other cycle is an error."""
        graph: nx.DiGraph[int] = nx.DiGraph()
        graph.add_nodes_from(range(len(self.kinds)))
        wires: dict[tuple[int, int], Wire] = {}
        control: list[Wire] = []
        for wire in self.graph.exec_wires:
            if self.kinds[wire.source] == "latent":
                continue
            if self.node(wire.target).cls.fields[wire.target_field].control:
                control.append(wire)
            else:
                graph.add_edge(wire.source, wire.target)
                wires.setdefault((wire.source, wire.target), wire)
        found = False
        for component in nx.strongly_connected_components(graph):
            first = min(component)
            if len(component) > 1 or graph.has_edge(first, first):
                loop = nx.find_cycle(graph.subgraph(component), first)
                self._report_cycle("G210", "execution runs in a circle", [wires[edge[0], edge[1]] for edge in loop])
                found = True
        if found:
            return False
        for wire in control:
            if wire.source == wire.target or nx.has_path(graph, wire.target, wire.source):
                self.pending_control.add(wire)
            else:
                graph.add_edge(wire.source, wire.target)
        return True

    def _report_cycle(self, code: str, what: str, loop: list[Wire]) -> None:
        path = " -> ".join([self.node(wire.source).id for wire in loop] + [self.node(loop[0].source).id])
        remedy = (
            "break it with a node that has an execution input"
            if code == "G209"
            else "break it with a Delay, or a control pin"
        )
        related = [(wire.span, str(wire)) for wire in loop]
        self.findings.add(code, f"{what}: {path}", loop[0].span, remedy, related=related)

    def _forward(self, wire: Wire) -> bool:
        """Whether a wire starts something in the same pass."""
        return wire not in self.pending_control and self.kinds[wire.source] != "latent"

    # What a data node depends on

    def _find_dependencies(self) -> None:
        self.depends: dict[int, set[int]] = {}
        """For each data node: the executed nodes whose outputs or writes it shows."""
        self.volatile: set[int] = set()
        self.upstream: dict[int, list[int]] = {}
        """For each data node: the data nodes to compute before it, in order."""
        writers: dict[str, set[int]] = {}
        for instance in self.graph.instances:
            for key in instance.node.writes():
                writers.setdefault(key, set()).add(instance.index)
        for index in sorted(self.data_rank, key=lambda i: self.data_rank[i]):
            instance = self.node(index)
            depends: set[int] = set()
            before: list[int] = []
            if instance.cls.volatile:
                self.volatile.add(index)
                for key in instance.node.reads():
                    depends |= writers.get(key, set())
            for wire in self.data_in.get(index, []):
                if self._reads_input(wire):
                    continue
                if self.kinds[wire.source] == "data":
                    depends |= self.depends[wire.source]
                    if wire.source in self.volatile:
                        self.volatile.add(index)
                    before += [d for d in (*self.upstream[wire.source], wire.source) if d not in before]
                else:
                    depends.add(wire.source)
            self.depends[index] = depends
            self.upstream[index] = before
        self.constant = {d for d in self.data_rank if not self.depends[d] and d not in self.volatile}
        for index in sorted(self.constant, key=lambda i: self.data_rank[i]):
            self.plan.constants.append(Refresh(index, self._copies(index, constant=None)))

    def data_needs(self, index: int) -> list[int]:
        """Data nodes that a node reads, directly or through others, in the order to compute them; constants left out."""
        needs: list[int] = []
        for wire in self.data_in.get(index, []):
            if self.kinds[wire.source] == "data" and not self._reads_input(wire):
                needs += [d for d in (*self.upstream[wire.source], wire.source) if d not in needs]
        return [d for d in sorted(needs, key=lambda i: self.data_rank[i]) if d not in self.constant]

    def _copies(self, index: int, *, constant: bool | None) -> tuple[Copy, ...]:
        """Copies into a node: from constants only, from what changes only, or all."""
        copies = []
        for wire in self.data_in.get(index, []):
            fixed = self._reads_input(wire) or wire.source in getattr(self, "constant", ())
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
        events = [i for i, kind in enumerate(self.kinds) if not self.exec_in_ports(i) and kind in ("event", "pusher")]
        starts = [i for i in events if self.kinds[i] == "event"]
        pushers = [i for i in events if self.kinds[i] == "pusher"]
        latent = [
            wire.target for i, kind in enumerate(self.kinds) if kind == "latent" for wire in self.exec_out.get(i, [])
        ]
        self.events = set(events)
        self.members.append(self._reach([*starts, *pushers, *latent]))
        self.titles = ["pass"]
        opened = 0
        while opened < len(self.members):  # regions open further regions
            for index in self.members[opened]:
                if self.kinds[index] != "pusher":
                    continue
                for port in self._exec_outputs(index):
                    if (index, port) not in self.pin_region:
                        targets = [
                            w.target
                            for w in self.exec_out.get(index, [])
                            if w.source_field == port and self._forward(w)
                        ]
                        self.pin_region[index, port] = len(self.members) if targets else -1
                        if targets:
                            self.members.append(self._reach(targets))
                            name = self.node(index).cls.fields[port].name
                            self.titles.append(f"{self.node(index).id}.{name}")
            opened += 1

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
                pending += [w.target for w in reversed(self.exec_out.get(index, [])) if self._forward(w)]
        return list(found)

    def _covers(self) -> dict[int, set[int]]:
        """For each pusher: every node in the regions below it."""
        covers: dict[int, set[int]] = {}

        def cover(index: int) -> set[int]:
            if index not in covers:
                covers[index] = set()
                for (pusher, _), region in self.pin_region.items():
                    if pusher == index and region >= 0:
                        for member in self.members[region]:
                            covers[index] |= {member} | (cover(member) if self.kinds[member] == "pusher" else set())
            return covers[index]

        for index, kind in enumerate(self.kinds):
            if kind == "pusher":
                cover(index)
        return covers

    # Order

    def _sources(self, index: int) -> list[tuple[int, Wire]]:
        """Executed nodes that a node reads from, through data nodes too, each with the wire into the node."""
        found: list[tuple[int, Wire]] = []
        for wire in self.data_in.get(index, []):
            if self._reads_input(wire):
                continue
            if self.kinds[wire.source] == "data":
                found += [(source, wire) for source in sorted(self.depends[wire.source])]
            else:
                found.append((wire.source, wire))
        return found

    def _order_regions(self) -> None:
        self.covers = self._covers()
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
                    targets = [w.target for w in self.exec_out.get(unit, []) if self._forward(w) and w.target in inside]
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
                for source, wire in self._sources(reader):
                    if source in later:
                        self._report_previous(wire, source, reader)
            before |= nodes

    def _add_data_edges(self, order: nx.DiGraph[int], owners: dict[int, list[int]]) -> None:
        """Order readers after what they read; a wire that would close a cycle reads the previous value."""
        edges: list[tuple[int, int, Wire]] = []
        for reader, units in owners.items():
            for source, wire in self._sources(reader):
                if self.kinds[source] == "latent":
                    continue
                edges += [(s, u, wire) for u in units for s in owners.get(source, []) if s != u]
        edges.sort(key=lambda edge: edge[2].order)
        tentative = order.copy()
        tentative.add_edges_from((s, u) for s, u, _ in edges)
        component = {n: i for i, part in enumerate(nx.strongly_connected_components(tentative)) for n in part}
        for source, unit, wire in edges:
            if order.has_edge(source, unit):
                continue
            if component[source] == component[unit] and nx.has_path(order, unit, source):
                self._report_previous(wire, source, unit)
            else:
                order.add_edge(source, unit)

    def _report_previous(self, wire: Wire, source: int, reader: int) -> None:
        self.findings.add(
            "W104",
            f"{wire.entry.target} reads the value that {self.node(source).id} had before this pass: "
            f"execution orders {self.node(reader).id} before it",
            wire.span,
            "if that is meant, leave it; else change the order of execution",
        )

    def _lint_reads_and_writes(self) -> None:
        """Tell where only the tie rule decides whether a reader sees a write of the same pass."""
        order: nx.DiGraph[int] = nx.DiGraph()
        order.add_nodes_from(range(len(self.kinds)))
        order.add_edges_from((w.source, w.target) for w in self.graph.exec_wires if self._forward(w))
        writers: dict[str, list[int]] = {}
        for instance in self.graph.instances:
            for name in instance.node.writes():
                writers.setdefault(name, []).append(instance.index)
        if not writers:
            return
        sequenced = set(self.covers)
        for instance in self.graph.instances:
            for name in instance.node.reads():
                readers = [instance.index] if self.kinds[instance.index] != "data" else self._consumers(instance.index)
                for reader in readers:
                    for writer in writers.get(name, []):
                        if reader == writer or nx.has_path(order, writer, reader) or nx.has_path(order, reader, writer):
                            continue
                        if any({reader, writer} <= self.covers[p] for p in sequenced):
                            continue
                        self.findings.add(
                            "W105",
                            f"{self.node(reader).id} reads and {self.node(writer).id} writes {name.replace(':', ' ')}, "
                            "in no stated order",
                            self.node(reader).span,
                            "order them with a Multisequence",
                            related=[(self.node(writer).span, "written here")],
                        )

    def _consumers(self, data: int) -> list[int]:
        """Executed nodes that read a data node, through others too."""
        return [i for i, kind in enumerate(self.kinds) if kind != "data" and data in self.data_needs(i)]

    # What runs in every pass

    def _find_certain(self) -> None:
        """Nodes of the root region that run in every pass, whatever fires."""
        for index in self.members[0]:
            if index in self.events and self.kinds[index] in ("event", "pusher"):
                self.plan.certain.add(index)
            else:
                self.plan.certain |= {index} if any(map(self._fires_surely, self.exec_in.get(index, []))) else set()

    def _fires_surely(self, wire: Wire) -> bool:
        source = self.node(wire.source)
        plain = self.kinds[wire.source] in ("event", "action") and not source.cls.gated
        return self._forward(wire) and plain and wire.source in self.plan.certain

    def _order_setup(self) -> None:
        order: dict[int, None] = {refresh.node: None for refresh in self.plan.constants}

        def visit(region: int) -> None:
            for index in self.members[region]:
                if index in order:
                    continue
                for data in self.data_needs(index):
                    order.setdefault(data, None)
                order[index] = None
                for port in self._exec_outputs(index):
                    child = self.pin_region.get((index, port), -1)
                    if child >= 0:
                        visit(child)

        visit(0)
        used = {d for i in order for d in (self.data_needs(i) if self.kinds[i] != "data" else [])}
        readers = {w.source for i in order for w in self.data_in.get(i, [])}
        self.plan.order = [i for i in order if self.kinds[i] != "data" or i in used or i in readers]
        self.plan.constants = [r for r in self.plan.constants if r.node in readers]
        self.plan.constant_copies = [copy for i in self.plan.order for copy in self._copies(i, constant=True)]


class _Emitter:
    """Writes one region's calls, keeping book of which data nodes are up to date where."""

    def __init__(self, planner: _Planner, region: int) -> None:
        self.planner = planner
        self.region = region
        self.inside = set(planner.members[region])
        self.flags: dict[str, None] = {}
        self.guards: dict[int, str] = {}
        self.entered = self._entry_wires()
        self.state: dict[int, str] = {}
        """Of each data node: `stale`, `clean`, `maybe`, or `clean under <guard>`."""

    def _entry_wires(self) -> set[Wire]:
        """Wires that start the region for certain: those of the pusher's port it hangs on."""
        for (pusher, port), region in self.planner.pin_region.items():
            if region == self.region:
                return {w for w in self.planner.exec_out[pusher] if w.source_field == port and self.planner._forward(w)}
        return set()

    def emit(self) -> Region:
        planner = self.planner
        pusher = next((p for (p, _), region in planner.pin_region.items() if region == self.region), None)
        for data in planner.data_rank:
            if data in planner.constant:
                self.state[data] = "clean"
            elif pusher is None:
                self.state[data] = "stale" if data in planner.volatile else "maybe"
            else:
                self.state[data] = "stale" if pusher in planner.depends[data] else "maybe"
        for index in planner.members[self.region]:
            self.guards[index] = self._guard(index)
        calls = tuple(self._call(index) for index in planner.members[self.region])
        stale = tuple(d for d in sorted(planner.flagged) if d in planner.volatile) if pusher is None else ()
        entries = tuple(fire for wire in sorted(self.entered, key=lambda w: w.order) if (fire := self._fire(wire)))
        pending = self._pending()
        return Region(self.region, planner.titles[self.region], tuple(self.flags), entries, calls, stale, pending)

    def _in_wires(self, index: int) -> list[Wire]:
        """Wires that can start a node in this region."""
        planner = self.planner
        wires = [w for w in planner.exec_in.get(index, []) if w not in planner.pending_control]
        root = self.region == 0
        return [
            w
            for w in wires
            if w in self.entered
            or (root and planner.kinds[w.source] == "latent")
            or (w.source in self.inside and planner.kinds[w.source] in ("event", "action"))
        ]

    def _certain(self, wire: Wire) -> bool:
        planner = self.planner
        if wire in self.entered:
            return True
        gated = planner.node(wire.source).cls.gated or planner.kinds[wire.source] not in ("event", "action")
        return not gated and self.guards.get(wire.source, "?") == ""

    def _guard(self, index: int) -> str:
        planner = self.planner
        wires = self._in_wires(index)
        if index in planner.events or any(self._certain(w) for w in wires):
            return ""
        only = wires[0] if len(wires) == 1 else None
        if only and planner.kinds[only.source] in ("event", "action") and not planner.node(only.source).cls.gated:
            return self.guards[only.source]
        self.flags[f"f{index}"] = None
        return f"f{index}"

    def _counts(self, index: int) -> bool:
        return self.planner.node(index).cls.counts and len(self.planner.exec_in.get(index, [])) > 1

    def _pins(self, index: int) -> tuple[str, ...]:
        """Execution inputs whose numbers change from one run to the next."""
        wires = self.planner.exec_in.get(index, [])
        return (
            tuple(self.planner.exec_in_ports(index))
            if len(wires) > 1 or any(w in self.planner.pending_control for w in wires)
            else ()
        )

    def _fire(self, wire: Wire) -> Fire | None:
        """What a wire sets when its source fires; None when there is nothing to set."""
        planner, target = self.planner, wire.target
        pin = wire.target_field if self._pins(target) else ""
        if wire in planner.pending_control:
            return Fire(target, pin=wire.target_field)
        if self._counts(target):
            flag = f"w{wire.order}"
            self.flags[flag] = None
            return Fire(
                target, guard=self.guards[target] if self.guards[target] == f"f{target}" else "", activation=flag
            )
        guard = self.guards[target] if self.guards[target] == f"f{target}" else ""
        return Fire(target, guard, pin) if guard or pin else None

    def _branches(self, index: int, *, latent: bool = False) -> tuple[Branch, ...]:
        planner = self.planner
        branches = []
        for port in planner.node(index).cls.fields.values():
            if not port.is_exec or port.side != "outputs":
                continue
            if planner.kinds[index] == "pusher":
                branches.append(Branch(port.mask, region=planner.pin_region.get((index, port.field), -1)))
                continue
            wires = [w for w in planner.exec_out.get(index, []) if w.source_field == port.field]
            fires = [self._fire(w) for w in wires if latent or planner._forward(w) or w in planner.pending_control]
            branches.append(Branch(port.mask, tuple(f for f in fires if f is not None)))
        return tuple(branches) if planner.kinds[index] == "pusher" else tuple(b for b in branches if b.fires)

    def _pending(self) -> tuple[tuple[int, tuple[Branch, ...]], ...]:
        if self.region != 0:
            return ()
        latent = [i for i, kind in enumerate(self.planner.kinds) if kind == "latent" and self.planner.exec_out.get(i)]
        return tuple((i, self._branches(i, latent=True)) for i in latent)

    def _call(self, index: int) -> Call:
        planner = self.planner
        kind, guard = planner.kinds[index], self.guards[index]
        refreshes = tuple(r for data in planner.data_needs(index) for r in self._refresh(data, guard))
        branches = () if kind == "latent" else self._branches(index)
        marks = self._invalidate(index, guard)
        activations: tuple[Activation, ...] = ()
        if self._counts(index):
            wires = sorted(self._in_wires(index), key=lambda w: (not self._is_control(w), w.order))
            activations = tuple(Activation(f"w{w.order}", w.target_field) for w in wires)
        gated = planner.node(index).cls.gated
        copies, pins = planner.changing_copies(index), self._pins(index)
        return Call(index, kind, guard, refreshes, copies, gated, branches, marks, pins, activations)

    def _is_control(self, wire: Wire) -> bool:
        return self.planner.node(wire.target).cls.fields[wire.target_field].control

    def _refresh(self, data: int, guard: str) -> list[Refresh]:
        """How a data node is brought up to date before a consumer under a guard."""
        planner, state = self.planner, self.state[data]
        if state == "clean" or (guard and state == f"clean under {guard}"):
            return []
        flagged = data in planner.flagged
        if state != "stale":
            planner.flagged.add(data)
        self.state[data] = f"clean under {guard}" if guard else "clean"
        return [
            Refresh(data, planner.changing_copies(data), if_stale=state != "stale", flagged=flagged or state != "stale")
        ]

    def _invalidate(self, index: int, guard: str) -> tuple[int, ...]:
        """Note which data nodes are stale after a node has run; those with a flag are marked at run time."""
        planner = self.planner
        ran = {index} | planner.covers.get(index, set())
        for data, depends in planner.depends.items():
            if data in planner.constant:
                continue
            if index in depends and not guard and planner.kinds[index] != "pusher":
                self.state[data] = "stale"
            elif (depends & ran and self.state[data] != "stale") or (
                planner.kinds[index] == "pusher" and self.state[data] == "stale"
            ):
                self.state[data] = "maybe"
        return tuple(d for d in sorted(planner.flagged) if index in planner.depends[d])
