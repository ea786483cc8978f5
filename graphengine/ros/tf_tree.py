"""The tree of TF frames: broadcasters and rate of each transform, and faults of the tree."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.wording import printable
from graphengine.ros.rates import SECOND

MAX_EDGES = 5000
"""Maximum number of transforms in a tree; drawing a chain of this length takes 100 MB."""
TOLERANCE = 0.01
"""Maximum difference between a quaternion's squared norm and 1, as in tf2's buffer_core.cpp."""


@dataclass(slots=True)
class Edge:
    """The transform of a child frame in its parent frame, with statistics of the received messages.

    Args:
        parent: parent frame.
        child: child frame.
        static: whether the transform was received on tf_static.
        sources: GIDs of the transform's broadcasters.
        number: number of received messages with the transform.
        oldest: oldest stamp, ns.
        newest: newest stamp, ns.
    """

    parent: str
    child: str
    static: bool
    sources: set[bytes] = field(default_factory=set)
    number: int = 0
    oldest: int = 0
    newest: int = 0

    @property
    def rate(self) -> float | None:
        """Average rate, computed from the stamps, Hz; None if all stamps are equal."""
        span = self.newest - self.oldest
        return (self.number - 1) * SECOND / span if span else None

    def add(self, stamp: int, source: bytes) -> None:
        """Count a received transform; `stamp` is in ns, and `source` is the GID of the broadcaster."""
        self.oldest = min(self.oldest, stamp) if self.number else stamp
        self.newest = max(self.newest, stamp) if self.number else stamp
        self.number += 1
        self.sources.add(source)


@dataclass(frozen=True, slots=True)
class Row:
    """A line in the drawing of the tree.

    Args:
        frame: name of the frame.
        edge: transform to the parent; None for a root.
        last: for each frame on the path from the root (excluded) to this frame (included), whether the frame on the path is
            the last child of its parent.
        again: whether the row omits the frame's children, because an earlier row of the same frame shows them.
    """

    frame: str
    edge: Edge | None = None
    last: tuple[bool, ...] = ()
    again: bool = False

    def __str__(self) -> str:
        above = "".join("   " if last else "│  " for last in self.last[:-1])
        branch = ("└─ " if self.last[-1] else "├─ ") if self.last else ""
        return f"{above}{branch}{self.frame}{' (above)' if self.again else ''}"


class FrameTree:
    """TF frames with their parents. Each frame should have one parent, and there should be one root."""

    def __init__(self) -> None:
        self._edges: dict[tuple[str, str], Edge] = {}
        self._refused: dict[tuple[str, str, str], set[bytes]] = {}
        """GIDs of the writers of each transform that tf2 ignores; the key has child frame, parent frame and reason."""
        self._full = False

    def add(self, message: Any, static: bool, source: bytes) -> None:
        """Add the transforms of a TFMessage, up to `MAX_EDGES` in all; `source` is the GID of the message's writer."""
        for transform in message.transforms:
            # For tf2, a name with a slash in front and the name without it mean the same frame.
            frames = transform.header.frame_id, transform.child_frame_id
            parent, child = (printable(frame.removeprefix("/")) for frame in frames)
            edge = self._edges.get((child, parent))
            if len(self._edges) + len(self._refused) >= MAX_EDGES and edge is None:
                self._full = True
                continue
            if why := _refusal(parent, child, transform.transform):
                self._refused.setdefault((child, parent, why), set()).add(source)
                continue
            if edge is None:
                edge = self._edges[child, parent] = Edge(parent, child, static)
            stamp = transform.header.stamp
            edge.add(stamp.sec * SECOND + stamp.nanosec, source)

    @property
    def edges(self) -> list[Edge]:
        """All transforms, sorted by the name of the child, then of the parent."""
        return [self._edges[key] for key in sorted(self._edges)]

    def roots(self) -> list[str]:
        """Return the roots of the drawing: all frames without a parent, and one frame of each loop without a root above."""
        return [row.frame for row in self.rows() if row.edge is None]

    def rows(self) -> list[Row]:
        """Return the rows of the drawing from top to bottom; each frame is below its parent."""
        children: dict[str, list[Edge]] = {}
        for edge in self.edges:
            children.setdefault(edge.parent, []).append(edge)
        below = {edge.child for edge in self._edges.values()}
        shown: set[str] = set()
        rows: list[Row] = []
        for root in (*sorted(children.keys() - below), *sorted(below)):
            if root not in shown:
                rows += _descend(root, children, shown)
        return rows

    def faults(self, names: Mapping[bytes, str]) -> list[str]:
        """Return one sentence for each fault: several roots, parents or broadcasters, a loop, an ignored transform.

        Args:
            names: name of the node of each writer, by GID.
        """
        full = [f"there are more than {MAX_EDGES} transforms; further transforms are ignored"] if self._full else []
        wrong = (self._islands(), self._parents(names), self._loops(), self._rivals(names), self._refusals(names))
        return [*full, *itertools.chain(*wrong)]

    def _islands(self) -> Iterator[str]:
        robots: dict[str, list[str]] = {}  # robots that share the topics have their namespaces as prefixes
        for root in self.roots():
            robots.setdefault(root.rpartition("/")[0], []).append(root)
        for prefix, roots in robots.items():
            if len(roots) > 1:
                of = f" of {prefix}" if prefix else ""
                yield f"the tree{of} is in {len(roots)} pieces, with the roots {', '.join(roots)}"

    def _parents(self, names: Mapping[bytes, str]) -> Iterator[str]:
        for child, group in itertools.groupby(self.edges, lambda edge: edge.child):
            if len(edges := [*group]) > 1:
                told = (f"{edge.parent} (by {broadcasters(edge.sources, names)})" for edge in edges)
                yield f"{child} has {len(edges)} parents: {', '.join(told)}"

    def _loops(self) -> Iterator[str]:
        parents = {edge.child: edge.parent for edge in self.edges}
        seen: set[str] = set()
        for frame in parents:
            path: list[str] = []
            while frame in parents and frame not in seen:
                seen.add(frame)
                path.append(frame)
                frame = parents[frame]
            if frame in path:
                yield f"frames form a loop: {' in '.join([*path[path.index(frame) :], frame])}"

    def _rivals(self, names: Mapping[bytes, str]) -> Iterator[str]:
        for edge in self.edges:
            if len(edge.sources) > 1:
                several = broadcasters(edge.sources, names)
                yield f"{edge.child} in {edge.parent} has several broadcasters: {several}"

    def _refusals(self, names: Mapping[bytes, str]) -> Iterator[str]:
        for (child, parent, why), sources in sorted(self._refused.items()):
            yield f"tf2 ignores {child!r} in {parent!r} because {why}; sent by {broadcasters(sources, names)}"


def _refusal(parent: str, child: str, transform: Any) -> str:
    """Return the reason why tf2 ignores a transform; empty if tf2 accepts it."""
    place, turn = transform.translation, transform.rotation
    quaternion = turn.x, turn.y, turn.z, turn.w
    if not parent or not child:
        return "a frame has no name"
    if parent == child:
        return "parent and child are the same frame"
    if any(map(math.isnan, (place.x, place.y, place.z, *quaternion))):
        return "it contains NaN"
    off = abs(sum(value * value for value in quaternion) - 1.0)
    return "" if off < TOLERANCE else "the length of its quaternion is not 1"


def _descend(root: str, children: Mapping[str, Iterable[Edge]], shown: set[str]) -> Iterator[Row]:
    """Yield the rows of a root and of all frames below; there is no recursion, because a chain of frames may be long."""
    waiting = [Row(root)]
    while waiting:
        row = waiting.pop()
        edges = list(children.get(row.frame, ()))
        if row.frame in shown and edges:
            yield Row(row.frame, row.edge, row.last, again=True)
            continue
        yield row
        shown.add(row.frame)
        below = [Row(edge.child, edge, (*row.last, edge is edges[-1])) for edge in edges]
        waiting += reversed(below)


def broadcasters(sources: Iterable[bytes], names: Mapping[bytes, str]) -> str:
    """Return the sorted node names of the broadcasters with the given GIDs, separated by commas."""
    return ", ".join(sorted({names.get(source, "unknown") for source in sources}))


def frequency(edge: Edge) -> str:
    """Return the rate of a transform as text: `static`, a rate in Hz, or the number of messages if the rate is unknown."""
    if edge.static:
        return "static"
    return f"{edge.number} in all" if edge.rate is None else f"{edge.rate:.1f} Hz"


def seconds(nanoseconds: int) -> str:
    """Return a stamp in seconds as text with three decimals."""
    return f"{nanoseconds // SECOND}.{nanoseconds % SECOND // 1_000_000:03d}"


def to_dot(tree: FrameTree, names: Mapping[bytes, str]) -> str:
    """Return the tree in Graphviz's DOT language."""
    lines = ["digraph frames {", "  node [shape=box];"]
    for edge in tree.edges:
        facts = [
            f"Broadcaster: {broadcasters(edge.sources, names)}",
            f"Average rate: {frequency(edge)}",
            f"Most recent transform: {seconds(edge.newest)}",
            f"Oldest transform: {seconds(edge.oldest)}",
        ]
        label = _quoted("\n".join(facts))
        lines.append(f"  {_quoted(edge.parent)} -> {_quoted(edge.child)} [label={label}];")
    return "\n".join([*lines, "}", ""])


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
