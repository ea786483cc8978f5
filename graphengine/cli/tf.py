"""`graphrun tf tree`: print the tf frame tree of a live network."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from graphengine.cli.common import clean, table
from graphengine.cli.live import Live, absolute_namespace, add_live_arguments, show
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.parser import add_verb
from graphengine.cli.quantities import positive
from graphengine.format.atomic_write import write_together
from graphengine.format.errors import TransportError, UsageError
from graphengine.format.wording import listing
from graphengine.messages.endpoints import QoS
from graphengine.ros.network_graph import NetworkGraph
from graphengine.ros.tf_tree import FrameTree, Row, broadcasters, frequency, seconds, to_dot

LISTENING = 5.0
"""Default time to listen to transforms, s; equal to that of `view_frames` in tf2_tools."""
DOT, PICTURES, TEXT = (".dot", ".gv"), (".png", ".svg", ".pdf"), (".txt",)
DRAWING = 60.0
"""Maximum time for Graphviz to draw the tree, s."""
TYPE = "tf2_msgs/msg/TFMessage"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun tf tree` to its parser."""
    verbs = parser.add_subparsers(dest="tf_verb", metavar="VERB", required=True)
    tree = add_verb(verbs, "tree", "print the frame tree with the broadcaster, rate and newest transform of each frame")
    namespace = "namespace of tf and tf_static, such as dd100_0000 (default: the root, else the only one in use)"
    add_value(tree, "--namespace", "NAME", namespace)
    wait = f"time to listen to transforms (default {LISTENING:g})"
    add_value(tree, "--wait-time", "SECONDS", wait, short="-t", type=positive, default=LISTENING)
    output = "file to write: text (.txt), Graphviz source (.dot, .gv), or an image drawn by Graphviz (.png, .svg, "
    output += ".pdf); default: print text"
    add_value(tree, "--output", "FILE", output, short="-o", type=Path)
    add_flag(tree, "--strict", "exit with code 1 if there are warnings")
    add_live_arguments(tree)


def execute(arguments: argparse.Namespace) -> int:
    """Print or write the tree; return 0, or with `--strict` 1 if there are warnings.

    Raises:
        TransportError: there are no transforms, or several namespaces have transforms and none is given.
        UsageError: the file to write has an unknown suffix, or it needs Graphviz, which is not installed.
    """
    _check_output(arguments.output)
    tree = FrameTree()
    with Live(arguments) as live:
        given = arguments.namespace
        namespace = _only_namespace(live.graph()) if given is None else absolute_namespace(given)
        topics = [f"{namespace}/tf", f"{namespace}/tf_static"]
        print(f"listening to {' and '.join(topics)} for {arguments.wait_time:g} s", file=sys.stderr)
        _listen(live, topics, tree)
        with contextlib.suppress(KeyboardInterrupt):  # which ends the listening, and what was heard counts
            time.sleep(arguments.wait_time)
        graph = live.graph(lambda graph: graph.named)
        live.transport.close()  # so that the tree grows no more
        if not tree.edges:
            silence = f"no transforms on {' and '.join(topics)} within {arguments.wait_time:g} s"
            there = [namespace or "/" for namespace in _namespaces(graph)]
            raise TransportError(f"{silence}\n{listing(there, 'namespaces in which there are publishers')}")
        names = _names(graph, topics)
        _write(tree, names, arguments.output)
        faults = [*tree.faults(names), *_volatile(graph, topics[1])]
        for fault in faults:
            print(clean(f"warning: {fault}"), file=sys.stderr)
        return 1 if faults and arguments.strict else 0
    return 0


def _check_output(path: Path | None) -> None:
    if path is None:
        return
    if path.suffix not in (*DOT, *PICTURES, *TEXT):
        raise UsageError(f"-o {path}: the name of the file must end in one of {', '.join((*TEXT, *DOT, *PICTURES))}")
    if path.suffix in PICTURES and shutil.which("dot") is None:
        remedy = f"write {path.with_suffix('.dot')}, or install graphviz"
        raise UsageError(f"-o {path}: an image needs Graphviz, but its program dot is not installed\n  {remedy}")


def _listen(live: Live, topics: list[str], tree: FrameTree) -> None:
    from graphengine.messages import messages

    def take(topic: str, static: bool, data: bytes) -> None:
        # A transport that cannot tell who sent a message leaves all that write the topic.
        source = live.transport.source or topic.encode()
        with contextlib.suppress(messages.MessageError):
            tree.add(messages.decode(data, TYPE), static, source)

    moving, static = topics
    live.transport.reader(moving, TYPE, QoS(depth=100, reliability="bestEffort"), partial(take, moving, False))
    live.transport.reader(static, TYPE, QoS(depth=100, durability="transientLocal"), partial(take, static, True))


def _namespaces(graph: NetworkGraph) -> list[str]:
    """Return all namespaces in which tf or tf_static is published, sorted; the root namespace is an empty text."""
    topics = {end.topic for end in graph.endpoints if (end.direction, end.message_type) == ("publish", TYPE)}
    return sorted({topic.rpartition("/")[0] for topic in topics if topic.endswith(("/tf", "/tf_static"))})


def _only_namespace(graph: NetworkGraph) -> str:
    """Return the root namespace (an empty text) if it has transforms, else the only namespace with transforms.

    Raises:
        TransportError: the root namespace has no transforms, but several other namespaces have.
    """
    there = _namespaces(graph)
    if len(there) < 2 or "" in there:
        return "" if "" in there else "".join(there)
    advice = listing(there, "choose one with --namespace")
    raise TransportError(f"transforms are published in several namespaces\n{advice}")


def _names(graph: NetworkGraph, topics: list[str]) -> dict[bytes, str]:
    """Return a dict from sources of transforms to node names; a source is the GID of a publisher, or a topic.

    A topic is the source on transports that do not report the publisher of a message; its name lists all publishers.
    """
    names = {end.gid: end.full_node or "unknown" for end in graph.endpoints}
    writers = {topic: sorted({names[end.gid] for end in graph.publishers(topic)}) for topic in topics}
    return names | {topic.encode(): " or ".join(nodes) or "unknown" for topic, nodes in writers.items()}


def _volatile(graph: NetworkGraph, topic: str) -> list[str]:
    """Return a warning for each node that publishes `topic` with volatile durability, because tf2 misses its messages."""
    late = [end.full_node for end in graph.publishers(topic) if end.qos.durability == "volatile"]
    return [f"{node} publishes {topic} with durability volatile, so tf2 does not receive it" for node in late]


def _write(tree: FrameTree, names: Mapping[bytes, str], path: Path | None) -> None:
    """Print the tree, or write it to a file.

    Raises:
        TransportError: Graphviz cannot draw the tree.
    """
    if path is None:
        show(_table(tree, names))
        return
    content = (f"{_table(tree, names)}\n" if path.suffix in TEXT else to_dot(tree, names)).encode()
    if path.suffix in PICTURES:
        command = ["dot", f"-T{path.suffix[1:]}"]
        try:
            content = subprocess.run(command, input=content, capture_output=True, check=True, timeout=DRAWING).stdout
        except (subprocess.SubprocessError, OSError) as error:
            raise TransportError(f"Graphviz cannot draw {path}: {error}") from error
    write_together({path: content})


def _table(tree: FrameTree, names: Mapping[bytes, str]) -> str:
    rows: list[tuple[str, ...]] = [("FRAME", "BROADCASTER", "RATE", "NEWEST")]
    rows += [_cells(row, names) for row in tree.rows()]
    return table([tuple(cell.replace("\n", " ") for cell in row) for row in rows])


def _cells(row: Row, names: Mapping[bytes, str]) -> tuple[str, str, str, str]:
    edge = row.edge
    if edge is None:
        return str(row), "", "", ""
    return str(row), broadcasters(edge.sources, names), frequency(edge), f"{seconds(edge.newest)} s"
