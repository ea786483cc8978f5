"""Divides a graph into regions and orders their nodes; a region ends at the ports of pushers (loops and sequences).

Within a region, nodes are ordered topologically over execution and data wires; a pusher and all nodes below its ports are one
unit. If the wires do not determine the order of two nodes, the node whose first incoming execution wire is earlier in the file
runs first; without a difference, the node that is earlier in the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from graphengine.compiler.digraph import Digraph, reached
from graphengine.compiler.every_gates import EveryGate
from graphengine.compiler.graph import Graph, Wire
from graphengine.compiler.planning.dependencies import DependencyGraph
from graphengine.format.diagnostics import Findings
from graphengine.node.node_class import ENDINGS, Ending
from graphengine.node.port import Port

MAX_PUSHERS = 500
"""Maximum nesting of loops and sequences: their generated functions call each other, and Python limits nested calls to 1000."""


@dataclass(frozen=True, slots=True)
class DataRead:
    """The dependency of a node's inputs on the node `source`, which is no data node, directly or through data nodes."""

    source: int
    wire: Wire
    """Wire by which the value enters the node."""
    shown: bool
    """True if the value comes from an output of the source, false if only from a resource that the source writes."""


class RegionGraph(DependencyGraph):
    """A graph divided into regions; region 0 starts from the events of a pass.

    Attributes:
        members: nodes of each region, in the order in which they run.
        entries: wires that start each region; if several ports start the same region, the wires of the first port.
        titles: title of each region, as `graphrun show` prints it.
        endings: method that the events run, for each region that starts when play stops or the graph closes.
        pin_region: region that a port of a pusher starts, by node index and field of the port; -1 if the port fires no nodes.
        covers: for each pusher, all nodes that execution reaches from its ports.
        port_covers: for each pusher, the nodes that execution reaches from each of its ports, in the order of the ports.
    """

    def __init__(self, graph: Graph, findings: Findings) -> None:
        super().__init__(graph, findings)
        self.members: list[list[int]] = []
        self.entries: list[list[Wire]] = []
        self.titles: list[str] = []
        self.endings: dict[int, Ending] = {}
        self.pin_region: dict[tuple[int, str], int] = {}
        self.covers = {i: self.execution.descendants(i) for i, kind in enumerate(self.kinds) if kind == "pusher"}
        self.port_covers = {pusher: self._cover_ports(pusher) for pusher in self.covers}
        self.acyclic = self.acyclic and self._check_depth()
        if self.acyclic:
            self._open_regions()
            self._order_regions()
            self._find_gates()

    def _check_depth(self) -> bool:
        """Return whether loops and sequences are nested at most MAX_PUSHERS deep; if not, add a finding."""
        depth = dict[int, int]()
        for index in self.execution.sort():
            depth[index] = depth.get(index, 0) + (self.kinds[index] == "pusher")
            for target in self.execution.successors[index]:
                depth[target] = max(depth.get(target, 0), depth[index])
            if depth[index] > MAX_PUSHERS:
                node = self.node(index)
                what = f"{node.id} lies below more than {MAX_PUSHERS} nested loops and sequences"
                remedy = "wire loops and sequences one after the other instead of nesting them"
                self.findings.add("G105", what, node.span, remedy, related=node.entry.via)
                return False
        return True

    def _open_regions(self) -> None:
        starts = [
            i for i, kind in enumerate(self.kinds) if kind in ("event", "pusher") and not self.exec_ports(i, "inputs")
        ]
        self.events = set(starts)
        reached, count = set(starts), -1
        while count != len(reached):  # a latent node fires its outputs in a later pass
            count = len(reached)
            starts += [w.target for i in sorted(reached) if self.kinds[i] == "latent" for w in self.exec_out.get(i, [])]
            reached = set(starts).union(*(self.execution.descendants(start) for start in set(starts)))
        self.latents = {i for i in reached if self.kinds[i] == "latent"}
        self._open_region("pass", [], starts)
        for ending in ENDINGS:
            ended = [i for i in starts if self.kinds[i] == "event" and hasattr(self.node(i).cls, ending)]
            if ended:
                self.endings[self._open_region(ending, [], ended)] = ending
        known: dict[tuple[tuple[int, str], ...], int] = {}
        opened = 0
        while opened < len(self.members):  # regions open further regions
            for index in [i for i in self.members[opened] if self.kinds[i] == "pusher"]:
                for port in self.exec_ports(index, "outputs"):
                    if (index, port.field) not in self.pin_region:
                        self.pin_region[index, port.field] = self._region_below(index, port, known)
            opened += 1

    def _open_region(self, title: str, entries: list[Wire], starts: Iterable[int]) -> int:
        """Add a region with all nodes that execution reaches from `starts` without crossing a pusher's port; return its index."""
        self.titles.append(title)
        self.entries.append(entries)
        self.members.append(list(reached(starts, lambda index: [wire.target for wire in self._followed(index)])))
        return len(self.members) - 1

    def _region_below(self, pusher: int, port: Port, known: dict[tuple[tuple[int, str], ...], int]) -> int:
        """Return the index of the region that a port of a pusher starts, and add the region if it is new.

        The index is -1 if the port fires no nodes. Ports that fire the same pins share a region; `known` has the regions by pins.
        """
        wires = [w for w in self.exec_out.get(pusher, []) if w.source_field == port.field and self.forward(w)]
        title = f"{self.node(pusher).id}.{port.name}"
        pins = tuple(sorted((wire.target, wire.target_field) for wire in wires))
        if not pins:
            return -1
        if pins in known:
            self.titles[known[pins]] += f" or {title}"
        else:
            known[pins] = self._open_region(title, wires, [wire.target for wire in wires])
        return known[pins]

    def _followed(self, index: int) -> list[Wire]:
        """Return the execution wires from a node whose targets are in the same region; none for pushers and latent nodes."""
        wires = self.exec_out.get(index, []) if self.kinds[index] not in ("pusher", "latent") else []
        return [wire for wire in wires if self.forward(wire)]

    def readings(self, reader: int) -> Iterator[DataRead]:
        """Yield the data dependencies of the node `reader` on nodes that are not data nodes."""
        for wire in self.data_in.get(reader, []):
            if self.reads_input(wire):
                continue
            if self.kinds[wire.source] != "data":
                yield DataRead(wire.source, wire, shown=True)
                continue
            for source in sorted(self.depends[wire.source]):
                yield DataRead(source, wire, shown=source in self.shows[wire.source])

    def _order_regions(self) -> None:
        first_wire = {i: min((w.order for w in wires), default=-1) for i, wires in self.exec_in.items()}
        for region, members in enumerate(self.members):
            inside = set(members)
            owners: dict[int, list[int]] = {}
            for unit in members:
                for covered in {unit} | self.covers.get(unit, set()):
                    owners.setdefault(covered, []).append(unit)
            order = Digraph(members)
            for wire in (wire for unit in members for wire in self._followed(unit)):
                if wire.target in inside:
                    order.add_edge(wire.source, wire.target)
            self._add_data_edges(order, owners)

            def key(index: int) -> tuple[int, int, int]:
                return (0 if index in self.events else 1, first_wire.get(index, -1), index)

            self.members[region] = order.sort(key)
        for pusher in self.covers:
            self._lint_later_ports(pusher)

    def _cover_ports(self, pusher: int) -> list[set[int]]:
        wires = [w for w in self.exec_out.get(pusher, []) if self.forward(w)]
        below = {w.target: {w.target} | self.execution.descendants(w.target) for w in wires}
        outputs = [port.field for port in self.exec_ports(pusher, "outputs")]
        return [set[int]().union(*(below[w.target] for w in wires if w.source_field == field)) for field in outputs]

    def _lint_later_ports(self, pusher: int) -> None:
        """Add a warning for each node below a port of a pusher that reads a value computed only below a later port."""
        reached = self.port_covers[pusher]
        before: set[int] = set()
        for position, nodes in enumerate(reached):
            later = set().union(*reached[position + 1 :]) - nodes - before
            for reader in sorted(nodes):
                for reading in self.readings(reader):
                    if reading.source in later and not self._runs_before(reading.source, pusher):
                        self._report_previous(reading)
            before |= nodes

    def _runs_before(self, index: int, pusher: int) -> bool:
        """Return whether a node runs before a pusher in every region that contains the pusher."""
        earlier = [members[: members.index(pusher)] for members in self.members if pusher in members]
        return all(any(index == unit or index in self.covers.get(unit, ()) for unit in units) for units in earlier)

    def _add_data_edges(self, order: Digraph, owners: dict[int, list[int]]) -> None:
        """Add edges to `order` so that nodes run after the nodes whose values they read.

        An edge that would close a cycle is left out: its wire carries the value of the previous pass, and causes a warning.

        Args:
            order: graph of the nodes of a region.
            owners: for each node in or below the region, the nodes of the region that run it.
        """
        edges: list[tuple[int, int, DataRead]] = []
        for reader, units in owners.items():
            for reading in self.readings(reader):
                if self.kinds[reading.source] != "latent":
                    befores = owners.get(reading.source, [])
                    edges += [(before, unit, reading) for unit in units for before in befores if before != unit]
        edges.sort(key=lambda edge: (edge[2].wire.order, edge[0], edge[1]))
        refused = order.add_where_acyclic([(before, unit) for before, unit, _ in edges])
        for before, unit, reading in edges:
            if (before, unit) in refused and unit not in owners[reading.source]:  # else `unit` runs the source
                self._report_previous(reading)

    def _report_previous(self, reading: DataRead) -> None:
        if not reading.shown:
            return  # a read of a variable before its write needs no warning
        why = f"execution orders {self.node(reading.wire.target).id} before {self.node(reading.source).id}"
        self.report_previous(reading.wire, reading.source, why, "change the order of execution")

    def _find_gates(self) -> None:
        """Set `gates`: find the nodes of the pass's region that run in every pass, or for which only `every` gates decide."""
        for index in self.members[0]:
            wires = [wire for wire in self.exec_in.get(index, []) if self.forward(wire)]
            if index in self.events or any(self._fired_behind(wire) == () for wire in wires):
                self.gates[index] = ()
            elif len(wires) == 1 and (behind := self._fired_behind(wires[0])) is not None:
                self.gates[index] = behind

    def _fired_behind(self, wire: Wire) -> tuple[int, ...] | None:
        """Return the `every` gates that alone decide whether a wire fires in a pass; None if other nodes decide too."""
        behind = self.gates.get(wire.source)
        if behind is not None and issubclass(self.node(wire.source).cls, EveryGate):
            return None if self.fired_often(wire.source) else (*behind, wire.source)
        plain = self.kinds[wire.source] in ("event", "action") and not self.node(wire.source).cls.gated
        return behind if plain else None
