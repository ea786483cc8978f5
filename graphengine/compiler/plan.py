"""The plan of a graph as plain data: regions, calls in order, guards, copies, refreshes of data nodes.

A **region** is what is reached from the events of a pass, or from one port of a pusher, without crossing another pusher's
port; or from the events that a play, or the graph, ends with. `planning` makes a plan of a resolved graph, `graphrun show`
prints it, `codegen` turns it into source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.node.node_class import Ending


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
class FireEffect:
    """The effect of a firing port: flags and counters of the region, or a pending pin of the target node."""

    target: int
    guard: str = ""
    counter: str = ""
    pending_pin: str = ""


@dataclass(frozen=True, slots=True)
class ExecBranch:
    """One execution output: its bit in what `compute` returns, and what it leads to."""

    mask: int
    fires: tuple[FireEffect, ...] = ()
    region: int = -1
    """Of a pusher: the region that runs for each yield of the port."""


@dataclass(frozen=True, slots=True)
class Pin:
    """An execution input whose firing is reported to the node."""

    field: str
    counter: str = ""
    """Local counter of how often it fired in this run of the region; empty when nothing in the region fires it."""
    pending: bool = False
    """A control pin that may have fired for this activation in an earlier one."""


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
    branches: tuple[ExecBranch, ...]
    marks: tuple[int, ...]
    """Data nodes that become stale when this node has computed."""
    pins: tuple[Pin, ...]
    """Empty for a node with one incoming wire: there is nothing to tell."""
    activations: tuple[Pin, ...] = ()
    """Of a node that counts: one for each wire that starts it, in the order of the computes."""
    rereads: tuple[Refresh, ...] | None = None
    """Of a pusher that reads its inputs again after each yield: the data nodes among what it reads."""


@dataclass(frozen=True, slots=True)
class Region:
    """Calls in order; `flags` are the local integers that start at 0."""

    index: int
    title: str
    flags: tuple[str, ...]
    entries: tuple[FireEffect, ...]
    """What the wires set that start the region."""
    calls: tuple[Call, ...]
    stale: tuple[int, ...] = ()
    """Of a root region: data nodes that each pass makes stale."""
    pending: tuple[tuple[int, tuple[ExecBranch, ...]], ...] = ()
    """Of a root region: latent nodes that may have fired since the last pass."""
    ending: Ending | None = None
    """Of a region that starts outside of ticks: the method of its events."""


@dataclass(frozen=True, eq=False)
class Plan:
    """All that the generated functions do; graphs of one file that differ only in literals share a plan.

    Its nodes are numbered as the instances of each of these graphs are, whose literals are a row each.
    """

    path: Path
    """The graph file."""
    ids: tuple[str, ...]
    """Names of the nodes in the file."""
    regions: tuple[Region, ...]
    gates: Mapping[int, tuple[int, ...]]
    """Of nodes that run in every pass while no node raises, except for gates above them: these gates."""
    flagged: tuple[int, ...] = ()
    """Data nodes with a run-time flag that says whether they are stale."""
    latent_marks: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    """Data nodes that become stale when a latent node was updated."""
    constants: tuple[Refresh, ...] = ()
    """Data nodes that cannot change while the graph runs, computed once."""
    constant_copies: tuple[Copy, ...] = ()
    order: tuple[int, ...] = ()
    """Every node that can run, in schedule order, each data node before its first consumer; setup follows it."""
    early: frozenset[int] = frozenset()
    """Data nodes that change while the graph runs, but whose values inputs that are read in `setup` need before."""

    @property
    def root(self) -> Region:
        """The region that starts from the events of a pass."""
        return self.regions[0]
