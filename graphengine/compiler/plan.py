"""The plan of a graph as plain data: regions, calls in order, guards, copies, refreshes of data nodes.

A **pusher** is a node such as a loop or a sequence: it runs all nodes below an output port each time it fires the port. A
**region** is the set of nodes that execution reaches without crossing a pusher's port. It starts from the events of a pass,
from the events at the end of a play or of the graph, or from one port of a pusher. `planning` makes a plan of a resolved graph,
`graphrun show` prints it, `codegen` turns it into source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.node.node_class import Ending


@dataclass(frozen=True, slots=True)
class Copy:
    """A copy of a value from a field of one node to a field of another."""

    source: int
    source_field: str
    target: int
    target_field: str
    converter: str = ""
    setup: bool = False
    """Whether the target is read in `setup`, so that the node is set up again when the value changes."""


@dataclass(frozen=True, slots=True)
class Refresh:
    """The computation of a data node before a node that reads it: always, or only if one of its dependencies changed."""

    node: int
    copies: tuple[Copy, ...]
    if_stale: bool = False
    flagged: bool = False
    repeated: bool = False
    """Whether it depends on outputs of its consumer, so that it is repeated before each activation of the consumer."""


@dataclass(frozen=True, slots=True)
class FireEffect:
    """The effect of one execution wire that fires: it sets a flag, a counter, or a pending pin of the target node."""

    target: int
    guard: str = ""
    counter: str = ""
    pending_pin: str = ""


@dataclass(frozen=True, slots=True)
class ExecBranch:
    """One execution output: its bit in the value that `compute` returns, and the effects of firing it."""

    mask: int
    fires: tuple[FireEffect, ...] = ()
    region: int = -1
    """For a pusher: the region that runs at each yield of the port; -1: none."""


@dataclass(frozen=True, slots=True)
class Pin:
    """An execution input whose firing is reported to the node."""

    field: str
    counter: str = ""
    """Local counter of the pin's firings in this run of the region; empty if no node in the region fires the pin."""
    pending: bool = False
    """Whether the pin is a control pin that may have been fired in an earlier activation."""


@dataclass(frozen=True, slots=True)
class Call:
    """The call of one node within a region."""

    node: int
    kind: str
    guard: str
    """Local flag that must be set for the node to run; empty if the node always runs."""
    refreshes: tuple[Refresh, ...]
    copies: tuple[Copy, ...]
    gated: bool
    branches: tuple[ExecBranch, ...]
    marks: tuple[int, ...]
    """Data nodes that become stale when this node was computed."""
    pins: tuple[Pin, ...]
    """Execution inputs with their counters; empty for a node with one incoming wire."""
    activations: tuple[Pin, ...] = ()
    """For a node that counts: one pin for each wire that fires it, in the order of the computes."""
    rereads: tuple[Refresh, ...] | None = None
    """For a pusher whose inputs are updated after each yield: the data nodes to refresh."""


@dataclass(frozen=True, slots=True)
class Region:
    """The calls of a region, in order; `flags` are local integers that start at 0."""

    index: int
    title: str
    flags: tuple[str, ...]
    entries: tuple[FireEffect, ...]
    """Effects of the wires that start the region."""
    calls: tuple[Call, ...]
    stale: tuple[int, ...] = ()
    """For a root region: data nodes that each pass makes stale."""
    pending: tuple[tuple[int, tuple[ExecBranch, ...]], ...] = ()
    """For a root region: latent nodes that may have fired since the last pass."""
    ending: Ending | None = None
    """For a region that starts between ticks: the method of its events."""


@dataclass(frozen=True, eq=False)
class Plan:
    """The steps of the generated functions; graphs of one file that differ only in literals share a plan.

    A node of the plan has the index of its instance in each of these graphs.
    """

    path: Path
    """The graph file."""
    ids: tuple[str, ...]
    """Names of the nodes in the file."""
    regions: tuple[Region, ...]
    gates: Mapping[int, tuple[int, ...]]
    """For each node that runs in every pass, or that only `every:` gates keep from doing so: these gates."""
    flagged: tuple[int, ...] = ()
    """Data nodes with a run-time flag that says whether they are stale."""
    latent_marks: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    """For each latent node: data nodes that become stale when it was updated."""
    constants: tuple[Refresh, ...] = ()
    """Data nodes that cannot change while the graph runs, computed once."""
    constant_copies: tuple[Copy, ...] = ()
    order: tuple[int, ...] = ()
    """All nodes that can run, in schedule order, each data node before its first consumer; the order of setup."""
    early: frozenset[int] = frozenset()
    """Data nodes that are not constant but must be computed before setup, for inputs that are read in `setup`."""

    @property
    def root(self) -> Region:
        """The region that starts from the events of a pass."""
        return self.regions[0]
