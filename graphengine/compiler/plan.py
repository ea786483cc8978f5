"""The plan of a graph as plain data: the order and conditions in which nodes run, and the copies of values.

A **pusher** is a node such as a loop or a sequence: each time it fires an output port, all nodes below this port run before it
continues. A **region** is a set of nodes that execution reaches from a common start without crossing a port of a pusher. The
start is the events of a pass, the events when play stops or the graph closes, or one port of a pusher. A **data node** has no
execution ports; it is **stale** if its inputs may have changed since it was computed.

`planning` makes a plan from a resolved graph, `graphrun show` prints it, and `codegen` generates source from it. Nodes are given
by index, ports by field.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from graphengine.compiler.digraph import reached
from graphengine.node.node_class import Ending


@dataclass(frozen=True, slots=True)
class Copy:
    """A copy of a value from a port of one node to a port of another, through a converter if `converter` is not empty."""

    source: int
    source_field: str
    target: int
    target_field: str
    converter: str = ""
    setup: bool = False
    """Whether the target node reads the port in `setup`; if so, a change of the value sets the node up again."""


@dataclass(frozen=True, slots=True)
class Refresh:
    """The computation of a data node before a node that reads it: always, or with `if_stale` only if the data node is stale."""

    node: int
    copies: tuple[Copy, ...]
    if_stale: bool = False
    flagged: bool = False
    repeated: bool = False
    """Whether the data node depends on outputs of its reader; if so, it is computed before each activation of the reader."""
    shared: bool = False
    """Whether several nodes need the data node. A generated function then computes it, after the stale data nodes upstream."""


@dataclass(frozen=True, slots=True)
class FireEffect:
    """The effect of firing one execution wire: it sets the flag `guard`, or increments `counter` or a pin of the target.

    A name is empty if the wire does not have this effect.
    """

    target: int
    guard: str = ""
    counter: str = ""
    pending_pin: str = ""


@dataclass(frozen=True, slots=True)
class ExecBranch:
    """One execution output of a node: its bit in the value that `compute` returns, and the effects of firing it."""

    mask: int
    fires: tuple[FireEffect, ...] = ()
    region: int = -1
    """For a pusher: index of the region that runs each time the pusher fires this port; -1: the port starts no region."""


@dataclass(frozen=True, slots=True)
class Pin:
    """An execution input whose number of firings is written to the node before `compute`."""

    field: str
    counter: str = ""
    """Name of the local variable that counts the firings in this run of the region; empty if no node in the region fires it."""
    pending: bool = False
    """Whether a firing from an earlier activation can be waiting, because a wire to this control input closes a cycle."""


@dataclass(frozen=True, slots=True)
class Call:
    """The call of one node in a region, with all that happens before and after `compute`."""

    node: int
    kind: str
    guard: str
    """Name of the local flag that must be set for the node to run; empty if the node always runs."""
    refreshes: tuple[Refresh, ...]
    copies: tuple[Copy, ...]
    gated: bool
    branches: tuple[ExecBranch, ...]
    marks: tuple[int, ...]
    """Data nodes that become stale when this node is computed."""
    pins: tuple[Pin, ...]
    """Execution inputs whose number of firings is written to the node; empty if the number is always the same."""
    activations: tuple[Pin, ...] = ()
    """For a node that runs once for each firing: one pin for each incoming wire, in the order of serving."""
    rereads: tuple[Refresh, ...] | None = None
    """For a pusher whose inputs are updated after each yield: the data nodes to compute then; None for other nodes."""


@dataclass(frozen=True, slots=True)
class Region:
    """The calls of a region, in the order of execution; `flags` are names of local integers that start at 0."""

    index: int
    title: str
    flags: tuple[str, ...]
    entries: tuple[FireEffect, ...]
    """Effects of the wires that start the region; these wires have fired whenever the region runs."""
    calls: tuple[Call, ...]
    stale: tuple[int, ...] = ()
    """Data nodes that become stale when the region starts; only for the regions of a pass, of a stop and of a close."""
    pending: tuple[tuple[int, tuple[ExecBranch, ...]], ...] = ()
    """For the region of a pass: latent nodes whose outputs may have fired since the last pass, with their outputs."""
    ending: Ending | None = None
    """For a region that runs when play stops or the graph closes: name of the method that its events run; otherwise None."""


@dataclass(frozen=True, eq=False)
class Plan:
    """The plan of a graph. Graphs of one file that differ only in literals share a plan.

    The index of a node in the plan is the index of its instance in each of these graphs.
    """

    path: Path
    """Path of the graph file."""
    ids: tuple[str, ...]
    """Ids of the nodes in the flat graph, by index."""
    regions: tuple[Region, ...]
    gates: Mapping[int, tuple[int, ...]]
    """For each node whose execution depends only on `every` gates: these gates; empty for a node that runs in every pass."""
    data: Mapping[int, Refresh] = field(default_factory=dict)
    """The data nodes that are computed in passes, by index; each node follows the data nodes that it reads."""
    flagged: tuple[int, ...] = ()
    """Data nodes for which a flag at run time says whether they are stale."""
    latent_marks: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    """For each latent node: the data nodes that become stale when the node is updated."""
    constants: tuple[Refresh, ...] = ()
    """Data nodes whose outputs cannot change while the graph runs; they are computed in setup, not in passes."""
    constant_copies: tuple[Copy, ...] = ()
    order: tuple[int, ...] = ()
    """All nodes that can run, in the order of setup: the order of execution, with each data node before its first reader."""
    early: frozenset[int] = frozenset()
    """Data nodes that are not constant but are computed during setup, because other nodes read their outputs in `setup`."""

    @property
    def root(self) -> Region:
        """The region that starts from the events of a pass."""
        return self.regions[0]

    @property
    def calls(self) -> list[Call]:
        """The calls of all regions."""
        return [call for region in self.regions for call in region.calls]

    @property
    def constant_nodes(self) -> set[int]:
        """The data nodes in `constants`."""
        return {refresh.node for refresh in self.constants}

    @property
    def fixed_copies(self) -> list[Copy]:
        """The copies along wires whose values are constant while the graph runs."""
        return [*self.constant_copies, *(copy for refresh in self.constants for copy in refresh.copies)]

    @property
    def copies(self) -> Iterable[Copy]:
        """All copies along wires, each only once."""
        copies = [copy for call in self.calls for copy in call.copies]
        copies += [copy for refresh in self.data.values() for copy in refresh.copies]
        return dict.fromkeys([*self.fixed_copies, *copies])

    @cached_property
    def ranks(self) -> Mapping[int, int]:
        """Position of each data node in `data`, by index."""
        return {index: rank for rank, index in enumerate(self.data)}

    def upstream(self, nodes: Iterable[int]) -> list[Refresh]:
        """Return the computations of the data nodes among `nodes`, and of all data nodes on which they depend, in order."""
        found = reached(filter(self.data.__contains__, nodes), self._data_sources)
        return [self.data[index] for index in sorted(found, key=self.ranks.__getitem__)]

    def _data_sources(self, index: int) -> list[int]:
        return [copy.source for copy in self.data[index].copies if copy.source in self.data]

    @cached_property
    def flagged_readers(self) -> Mapping[int, set[int]]:
        """For each flagged data node: the flagged data nodes that read it, directly or through data nodes without a flag."""
        readers: dict[int, set[int]] = {index: set() for index in self.flagged}
        plain = {index: self._data_sources(index) for index in self.data.keys() - readers.keys()}
        for index in self.flagged:
            for source in reached(self._data_sources(index), lambda data: plain.get(data, ())):
                if source in readers:
                    readers[source].add(index)
        return readers


def by_target(copies: Iterable[Copy]) -> defaultdict[int, list[Copy]]:
    """Return copies grouped by the index of the target node."""
    incoming: defaultdict[int, list[Copy]] = defaultdict(list)
    for copy in copies:
        incoming[copy.target].append(copy)
    return incoming
