"""Writes the calls of a region: conditions and effects of each node, and the data nodes that are computed before."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from graphengine.compiler.graph import Wire
from graphengine.compiler.plan import Call, ExecBranch, FireEffect, Pin, Refresh, Region
from graphengine.compiler.planning.guards import GuardTree
from graphengine.compiler.planning.regions import RegionGraph


class RegionWriter:
    """Writes the calls of a region, and tracks at each call which data nodes are up to date."""

    def __init__(self, graph: RegionGraph, region: int) -> None:
        self.graph = graph
        self.region = region
        self.inside = set(graph.members[region])
        self.entered = {wire.order for wire in graph.entries[region]}
        """`order` of each wire that starts the region."""
        self.flags: dict[str, None] = {}
        self.guards: dict[int, str] = {}
        self.tree = GuardTree()
        self.clean: dict[int, list[int]] = {}
        """For each data node: flags of which one is set only if the data node was computed after its last change."""
        self.stale: set[int] = set()
        """Data nodes that are certainly stale. For a data node neither here nor in `clean`, only a flag at run time tells."""

    def write(self) -> Region:
        """Return the region with all its calls."""
        graph, root = self.graph, self.region == 0
        pass_ = root or self.region in graph.endings
        self.stale = set(graph.volatile) if pass_ else set()
        for index in graph.members[self.region]:
            self.guards[index] = self._guard(index)
        self.tree.number()
        calls = tuple(self._call(index) for index in graph.members[self.region])
        stale = tuple(d for d in sorted(graph.flagged) if d in graph.volatile) if pass_ else ()
        entries = tuple(self._fires(graph.entries[self.region]))
        pending = self._pending() if root else ()
        title, ending = graph.titles[self.region], graph.endings.get(self.region)
        return Region(self.region, title, tuple(self.flags), entries, calls, stale, pending, ending)

    def _in_wires(self, index: int) -> list[Wire]:
        """Return the execution wires that can fire a node in this region."""
        graph, root = self.graph, self.region == 0
        return [
            w
            for w in graph.exec_in.get(index, [])
            if w.order in self.entered
            or (root and w.source in graph.latents)
            or (w.source in self.inside and graph.kinds[w.source] in ("event", "action") and graph.forward(w))
        ]

    def _guard(self, index: int) -> str:
        graph, wires = self.graph, self._in_wires(index)
        if index in graph.events or any(wire.order in self.entered for wire in wires):
            return ""
        # Latent nodes are in no branch.
        ports = {f"f{w.source}_{w.source_field}": self.guards.get(w.source, "") for w in wires}
        causes = [self.tree.add(port, [guard]) for port, guard in ports.items()]
        if len(wires) == 1:  # all nodes that only this port fires share its flag
            return self._flag(causes[0])
        return self._flag(self.tree.add(f"f{index}", causes))

    def _flag(self, name: str) -> str:
        """Add the name of a local variable that starts at 0 to the generated function; return the name."""
        self.flags[name] = None
        return name

    def _tells_pins(self, index: int) -> bool:
        """Return whether the execution inputs of a node can fire a different number of times in each run of the region."""
        wires = self.graph.exec_in.get(index, [])
        return self.graph.fired_often(index) or any(wire.order in self.graph.pending_control for wire in wires)

    def _pins(self, index: int) -> tuple[Pin, ...]:
        if not self._tells_pins(index):
            return ()
        waiting = {w.target_field for w in self.graph.exec_in[index] if w.order in self.graph.pending_control}
        fired = set() if index in self.graph.counting else {wire.target_field for wire in self._in_wires(index)}
        pins = [port.field for port in self.graph.exec_ports(index, "inputs")]
        return tuple(Pin(p, self._flag(f"x{index}_{p}") if p in fired else "", p in waiting) for p in pins)

    def _fires(self, wires: Iterable[Wire]) -> Iterator[FireEffect]:
        """Yield the effect of firing each wire; wires to nodes that run anyway have no effect and are skipped."""
        set_already = {""}
        for wire in sorted(wires, key=lambda w: w.order):
            target = wire.target
            if wire.order in self.graph.pending_control:
                yield FireEffect(target, pending_pin=wire.target_field)
                continue
            guard = "" if self.guards[target] in set_already else self.guards[target]
            set_already.add(guard)
            counter = ""
            if target in self.graph.counting:
                counter = self._flag(f"w{wire.order}")
            elif self._tells_pins(target):
                counter = self._flag(f"x{target}_{wire.target_field}")
            if guard or counter:
                yield FireEffect(target, guard, counter)

    def _branches(self, index: int) -> tuple[ExecBranch, ...]:
        """Return one branch per execution output of a node.

        A port of a pusher starts a region, whose entries have the effects of its wires; only its wires to pending pins are
        in the branch.
        """
        graph = self.graph
        branches = []
        for port in graph.exec_ports(index, "outputs"):
            wires = [w for w in graph.exec_out.get(index, []) if w.source_field == port.field]
            region = graph.pin_region.get((index, port.field), -1)
            if graph.kinds[index] == "pusher":
                wires = [w for w in wires if w.order in graph.pending_control]
            branches.append(ExecBranch(port.mask, tuple(self._fires(wires)), region))
        return tuple(branches)

    def _pending(self) -> tuple[tuple[int, tuple[ExecBranch, ...]], ...]:
        latent = [index for index in sorted(self.graph.latents) if self.graph.exec_out.get(index)]
        return tuple((index, self._branches(index)) for index in latent)

    def _call(self, index: int) -> Call:
        graph = self.graph
        kind, guard = graph.kinds[index], self.guards[index]
        refreshes = self._refreshes(index)
        branches = () if kind == "latent" else self._branches(index)
        self._invalidate(index, guard)
        activations: tuple[Pin, ...] = ()
        if index in graph.counting:
            wires = sorted(self._in_wires(index), key=lambda w: (not graph.graph.target(w)[1].control, w.order))
            activations = tuple(Pin(w.target_field, self._flag(f"w{w.order}")) for w in wires)
        gated = graph.node(index).cls.gated
        copies, marks, rereads = graph.copies(index), graph.marks(index), None
        if kind == "pusher" and graph.node(index).cls.rereads:
            rereads = self._refreshes(index, again=True)
        pins = self._pins(index)
        return Call(index, kind, guard, refreshes, copies, gated, branches, marks, pins, activations, rereads)

    def _refreshes(self, consumer: int, *, again: bool = False) -> tuple[Refresh, ...]:
        """Return the computations of data nodes before `consumer` reads them, or with `again` after a yield of this pusher.

        Data nodes that are up to date are left out. The search ends at these and at shared data nodes, whose refreshes include
        the data nodes upstream.
        """
        graph, guard = self.graph, self.guards[consumer]
        found: dict[int, bool] = {}
        pending = graph.data_sources(consumer)
        while pending:
            data = pending.pop()
            repeated = consumer in graph.counting and consumer in graph.depends[data]
            clean = not (repeated or again) and self.tree.implies(guard, self.clean.get(data, []))
            if data in found or clean:
                continue
            found[data] = repeated
            if data in graph.placed:
                graph.shared.add(data)
            graph.placed.add(data)
            if data not in graph.shared:
                pending += graph.data_sources(data)
        ordered = sorted(found, key=lambda data: graph.data_rank[data])
        return tuple(self._refresh(data, guard, found[data], again) for data in ordered)

    def _refresh(self, data: int, guard: str, repeated: bool, again: bool) -> Refresh:
        graph = self.graph
        shared = data in graph.shared
        sure = data in self.stale and not (repeated or again or shared)
        if not sure:
            graph.flagged.add(data)
        if not again:
            self.stale.discard(data)
            flags = self.clean.setdefault(data, [])
            if not self.tree.implies(guard, flags):
                self.tree.include(guard, flags)
        return Refresh(data, graph.copies(data), not sure, data in graph.flagged, repeated, shared)

    def _invalidate(self, index: int, guard: str) -> None:
        """Record which data nodes are or may be stale after the call of a node on which they depend."""
        graph = self.graph
        pusher = graph.kinds[index] == "pusher"
        for data in graph.dependents.get(index, ()):
            self.clean.pop(data, None)
            if not guard and not pusher:
                self.stale.add(data)
        for covered in graph.covers.get(index, ()):
            for data in graph.dependents.get(covered, ()):
                self.clean.pop(data, None)
        if pusher:  # a region below may have brought up to date what was stale before
            self.stale.clear()
