"""The rules of a pass read off one by one and interpreted: no plan, no generated text, nothing remembered for speed.

It runs real nodes of a resolved graph; only what decides which of them computes, when and how often is written here again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from graphengine.compiler.graph import Graph, Wire
from graphengine.format.errors import BadValueError
from graphengine.node import Context, types
from graphengine.node.node_class import Ending, Kind
from graphengine.node.port import Port


class Reference:
    """One graph, pass by pass."""

    def __init__(self, graph: Graph, context_of: Callable[[int], Context]) -> None:
        self.graph = graph
        self.nodes: list[Any] = [instance.make_node() for instance in graph.instances]
        self.kinds: list[Kind] = [type(node).kind() for node in self.nodes]
        self.wire_into = {(w.target, w.target_field): w for w in graph.data_wires}
        self.version: Counter[int] = Counter()
        self.seen: dict[int, object] = {}
        self.waiting: Counter[tuple[int, str]] = Counter()
        self.fired_by_latent: dict[int, int] = {}
        self.active: dict[int, None] = {}
        self.passes = 0
        self.dropped: dict[int, set[int]] = {}
        """Ticks in which each node dropped a value."""
        self.tick = 0
        self.event_method = "compute"
        self.events = [i for i, kind in enumerate(self.kinds) if kind in ("event", "pusher") and not self.pins(i)]
        self.backward = self.find_backward()
        self.reachable = self.find_reachable()
        self.push_all = graph.flat.spec.evaluator == "push"
        for index, node in enumerate(self.nodes):
            if self.kinds[index] == "data" or index in self.reachable or self.push_all:
                node.setup(context_of(index))

    # What the file says

    def pins(self, index: int, side: str = "inputs") -> list[Port]:
        return [p for p in type(self.nodes[index]).fields.values() if p.is_exec and p.side == side]

    def port(self, index: int, field: str) -> Port:
        return self.graph.instances[index].cls.fields[field]

    def wires_out(self, index: int, port: str | None = None) -> list[Wire]:
        return [w for w in self.graph.exec_wires if w.source == index and port in (None, w.source_field)]

    def wires_in(self, index: int) -> list[Wire]:
        return [w for w in self.graph.exec_wires if w.target == index]

    def is_control(self, wire: Wire) -> bool:
        return self.port(wire.target, wire.target_field).control

    def find_backward(self) -> set[int]:
        """R6: control wires that close a cycle, looked at in the order of the file."""
        ahead = {i: {w.target for w in self.wires_out(i) if not self.is_control(w)} for i in range(len(self.nodes))}
        for index, kind in enumerate(self.kinds):
            if kind == "latent":
                ahead[index] = set()
        backward = set()
        for wire in self.graph.exec_wires:
            if self.is_control(wire) and self.kinds[wire.source] != "latent":
                if wire.source in reach([wire.target], lambda i: ahead[i]):
                    backward.add(wire.order)
                else:
                    ahead[wire.source].add(wire.target)
        return backward

    def forward(self, index: int, port: str | None = None) -> list[Wire]:
        """Wires that start something in the same pass."""
        if self.kinds[index] == "latent":
            return []
        return [w for w in self.wires_out(index, port) if w.order not in self.backward]

    def find_reachable(self) -> set[int]:
        return reach(self.events, lambda i: {w.target for w in self.wires_out(i) if w.order not in self.backward})

    # R3, R4, R5: regions and their order

    def region(self, starts: Iterable[int]) -> set[int]:
        def beyond(index: int) -> set[int]:
            return set() if self.kinds[index] == "pusher" else {w.target for w in self.forward(index)}

        return reach(starts, beyond)

    def below(self, index: int) -> set[int]:
        """The node, and for a pusher everything in the regions below it: what is one unit."""
        starts_more = self.kinds[index] == "pusher"
        return reach([index], lambda i: {w.target for w in self.forward(i)}) if starts_more else {index}

    def origin(self, wire: Wire) -> Wire:
        """Where the value of a wire comes from when it begins at an input."""
        passed = {wire.order}
        while self.port(wire.source, wire.source_field).side == "inputs":
            above = self.wire_into.get((wire.source, wire.source_field))
            if above is None or above.order in passed:
                break
            passed.add(above.order)
            wire = above
        return wire

    def is_constant(self, wire: Wire) -> bool:
        return self.port(self.origin(wire).source, self.origin(wire).source_field).side == "inputs"

    def data_wires_into(self, index: int) -> list[Wire]:
        return [w for w in self.graph.data_wires if w.target == index]

    def data_above(self, index: int) -> set[int]:
        """A data node and those that it reads, directly or not."""

        def beyond(data: int) -> set[int]:
            sources = {self.origin(w).source for w in self.data_wires_into(data) if not self.is_constant(w)}
            return {source for source in sources if self.kinds[source] == "data"}

        return reach([index], beyond)

    def shows(self, index: int) -> set[int]:
        """Executed nodes whose outputs a data node shows."""
        wires = [w for data in self.data_above(index) for w in self.data_wires_into(data) if not self.is_constant(w)]
        return {self.origin(w).source for w in wires if self.kinds[self.origin(w).source] != "data"}

    def depends_on(self, index: int) -> set[int]:
        """The same, and those that write what it reads beside its inputs."""
        volatile = [data for data in self.data_above(index) if type(self.nodes[data]).volatile]
        keys = {key for data in volatile for key in self.graph.instances[data].reads}
        return self.shows(index) | {i.index for i in self.graph.instances if keys & set(i.writes)}

    def is_volatile(self, index: int) -> bool:
        return any(type(self.nodes[data]).volatile for data in self.data_above(index))

    def is_fixed(self, index: int) -> bool:
        return self.kinds[index] == "data" and not self.is_volatile(index) and not self.depends_on(index)

    def order(self, members: set[int]) -> list[int]:
        units = {unit: self.below(unit) for unit in members}
        after: dict[int, set[int]] = {unit: set() for unit in members}
        for unit in members:
            if self.kinds[unit] not in ("pusher", "latent"):
                after[unit] |= {w.target for w in self.forward(unit)}
        wanted: list[tuple[int, int, int]] = []
        for wire in self.graph.data_wires:
            source = self.origin(wire).source
            if self.is_constant(wire) or self.kinds[wire.target] == "data":
                continue
            for read in self.depends_on(source) if self.kinds[source] == "data" else {source}:
                if self.kinds[read] != "latent":
                    befores = [unit for unit in members if read in units[unit]]
                    afters = [unit for unit in members if wire.target in units[unit]]
                    wanted += [(wire.order, b, a) for b in befores for a in afters if a != b]
        for _, before, unit in sorted(wanted):
            if before not in reach([unit], lambda i: after[i]):
                after[before].add(unit)
        ordered: list[int] = []
        while len(ordered) < len(members):
            blocked = {a for unit in members - set(ordered) for a in after[unit]}
            ordered.append(min(members - set(ordered) - blocked, key=self.rank))
        return ordered

    def rank(self, index: int) -> tuple[bool, int, int]:
        return index not in self.events, min((w.order for w in self.wires_in(index)), default=-1), index

    # R8, R9: data

    def read_inputs(self, index: int) -> None:
        """Bring up to date what a node reads, and hand it over."""
        for wire in self.data_wires_into(index):
            source = self.origin(wire)
            if self.kinds[source.source] == "data" and not self.is_constant(wire):
                self.refresh(source.source)
        for wire in self.data_wires_into(index):
            self.hand_over(wire)

    def hand_over(self, wire: Wire) -> None:
        source = self.origin(wire)
        value = getattr(self.nodes[source.source], source.source_field)
        for step in (source, wire) if source is not wire else (wire,):
            value = types.CONVERTERS[step.converter](value) if step.converter else value
        setattr(self.nodes[wire.target], wire.target_field, value)

    def refresh(self, index: int) -> None:
        now = [self.version[i] for i in sorted(self.depends_on(index))], self.passes if self.is_volatile(index) else 0
        if self.seen.get(index) != now:
            self.read_inputs(index)
            self.attempt(index, self.nodes[index].compute)
            self.seen[index] = now

    # R14

    def attempt(self, index: int, function: Callable[[], Any]) -> tuple[Any, bool]:
        """What a node returns, and whether it could use its values; else its branch ends."""
        try:
            return function(), True
        except BadValueError:
            self.dropped.setdefault(index, set()).add(self.tick)
            return None, False

    # The pass

    def run_pass(self) -> None:
        self.passes += 1
        if self.push_all:
            self.run_all()
            return
        fired: list[Wire] = []
        for index, ports in self.fired_by_latent.items():
            fired += [w for w in self.wires_out(index) if ports & self.port(index, w.source_field).mask]
        self.fired_by_latent = {}
        latent = [i for i in self.reachable if self.kinds[i] == "latent"]
        self.run_region([*self.events, *(w.target for i in latent for w in self.wires_out(i))], fired)

    def run_ending(self, ending: Ending) -> None:
        """A pass in which nothing starts but events that have a method for it; what latent nodes fired goes on waiting."""
        self.passes += 1
        if not self.push_all:
            ended = [i for i in self.events if self.kinds[i] == "event" and hasattr(self.nodes[i], ending)]
            self.event_method = ending
            self.run_region(ended, [])
            self.event_method = "compute"

    def run_all(self) -> None:
        """The pass of a push graph: whatever could run does, what it fires leads to nothing."""
        for index in self.order_of_all():
            for wire in self.data_wires_into(index):
                self.hand_over(wire)
            for pin in self.pins(index):
                setattr(self.nodes[index], pin.field, 0 if pin.control else 1)
            result, usable = self.attempt(index, self.nodes[index].compute)
            while usable and self.kinds[index] == "pusher":
                usable = self.attempt(index, partial(next, result, None))[0] is not None
            if self.kinds[index] == "latent" and self.nodes[index].active:
                self.active.setdefault(index)

    def order_of_all(self) -> list[int]:
        everything = set(range(len(self.nodes)))
        after = {i: {w.target for w in self.forward(i)} for i in everything}
        wires = [w for w in self.graph.data_wires if not self.is_constant(w)]
        wires.sort(key=lambda w: (not self.between_data(w), w.order))
        for wire in wires:
            source = self.origin(wire).source
            if source not in reach([wire.target], lambda i: after[i]):
                after[source].add(wire.target)
        ordered: list[int] = []
        while len(ordered) < len(everything):
            blocked = {a for unit in everything - set(ordered) for a in after[unit]}
            ordered.append(min(everything - set(ordered) - blocked))
        return ordered

    def between_data(self, wire: Wire) -> bool:
        return self.kinds[self.origin(wire).source] == self.kinds[wire.target] == "data"

    def run_region(self, starts: Iterable[int], entering: Iterable[Wire]) -> None:
        fired = Counter(wire.order for wire in entering)
        members = self.region(starts)
        for index in self.order(members):
            wires = [w for w in self.wires_in(index) if fired[w.order]]
            if wires or (index in self.events and index in members):
                self.activate(index, wires, fired)

    def activate(self, index: int, wires: list[Wire], fired: Counter[int]) -> None:
        """R7: once, or once for each time that a wire fired; control pins come first."""
        if not type(self.nodes[index]).counts:
            told: Counter[str] = Counter()
            for wire in wires:
                told[wire.target_field] += fired[wire.order]
            self.compute(index, told, fired)
            return
        for wire in sorted(wires, key=lambda w: (not self.is_control(w), w.order)):
            for _ in range(fired[wire.order]):
                self.compute(index, Counter({wire.target_field: 1}), fired)

    def compute(self, index: int, told: Counter[str], fired: Counter[int]) -> None:
        node = self.nodes[index]
        self.read_inputs(index)
        for pin in self.pins(index):
            setattr(node, pin.field, told[pin.field] + self.waiting.pop((index, pin.field), 0))
        method = getattr(node, self.event_method if index in self.events else "compute")
        result, usable = self.attempt(index, method)
        if self.kinds[index] == "pusher":
            while (ports := self.attempt(index, partial(next, result, None))[0]) is not None:
                self.version[index] += 1
                for port in self.pins(index, "outputs"):
                    if ports & port.mask:
                        self.push(index, port)
                if node.rereads:
                    self.read_inputs(index)
            for pin in self.pins(index):
                self.waiting.pop((index, pin.field), None)
        elif self.kinds[index] == "latent":
            if node.active:
                self.active.setdefault(index)
        elif usable:
            for port in self.pins(index, "outputs"):
                if not node.gated or (result or 0) & port.mask:
                    fired.update(w.order for w in self.forward(index, port.field))
                    self.let_wait(index, port)
        self.version[index] += 1

    def push(self, index: int, port: Port) -> None:
        self.let_wait(index, port)
        wires = self.forward(index, port.field)
        self.run_region([w.target for w in wires], wires)

    def let_wait(self, index: int, port: Port) -> None:
        """R6: control wires that close a cycle; a pusher that is running sees them at once."""
        for wire in self.wires_out(index, port.field):
            if wire.order in self.backward:
                node = self.nodes[wire.target]
                self.waiting[wire.target, wire.target_field] += 1
                if self.kinds[wire.target] == "pusher":
                    setattr(node, wire.target_field, getattr(node, wire.target_field) + 1)

    def run_latent(self) -> None:
        for index in list(self.active):
            node = self.nodes[index]
            if node.active:
                fired, _ = self.attempt(index, node.update)
                self.version[index] += 1
                if fired:
                    self.fired_by_latent[index] = self.fired_by_latent.get(index, 0) | fired
            if not node.active:
                del self.active[index]


def reach(starts: Iterable[int], beyond: Callable[[int], set[int]]) -> set[int]:
    """Everything that one comes to, the starts included."""
    found: set[int] = set()
    pending = list(starts)
    while pending:
        index = pending.pop()
        if index not in found:
            found.add(index)
            pending += beyond(index)
    return found
