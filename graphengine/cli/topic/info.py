"""`graphrun topic info`: print the type, publishers and subscribers of a topic."""

from __future__ import annotations

import argparse

from graphengine.cli.live import Live, absolute, add_live_arguments, show
from graphengine.cli.topic.qos_options import shouted
from graphengine.ros.network_graph import Endpoint


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic info` to its parser."""
    parser.add_argument("topic", metavar="TOPIC", help="topic, such as /chatter")
    what = "also print node, type, type hash, GID and quality of service of each publisher and subscriber"
    parser.add_argument("-v", "--verbose", action="store_true", help=what)
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the type, publishers and subscribers of the topic; return 0.

    Raises:
        TransportError: the topic has no publisher or subscriber.
    """
    topic = absolute(arguments.topic)
    with Live(arguments) as live:
        graph = live.graph(names=arguments.verbose)
        types = graph.types().get(topic)
        if types is None:
            raise live.unknown("topic", topic, graph.types())
        show(f"Type: {types[0] if len(types) == 1 else types}")
        for what, ends in (("Publisher", graph.publishers(topic)), ("Subscription", graph.subscribers(topic))):
            gap = "\n" if arguments.verbose else ""
            show(f"{gap}{what} count: {len(ends)}")
            for end in ends if arguments.verbose else ():
                show(f"\n{describe(end)}")
        if arguments.verbose:
            show("")
    return 0


def describe(end: Endpoint) -> str:
    """Return all details of a publisher or subscriber as text; details that its peer does not announce are UNKNOWN."""
    qos = end.qos
    history = f"KEEP_LAST ({qos.depth})" if qos.history == "keepLast" else shouted(qos.history)
    lines = [
        f"Node name: {end.node or '_NODE_NAME_UNKNOWN_'}",
        f"Node namespace: {end.namespace or '_NODE_NAMESPACE_UNKNOWN_'}",
        f"Topic type: {end.message_type}",
        f"Topic type hash: {end.type_hash or 'INVALID'}",
        f"Endpoint type: {'PUBLISHER' if end.direction == 'publish' else 'SUBSCRIPTION'}",
        f"GID: {end.gid.hex('.')}",
        "QoS profile:",
        f"  Reliability: {shouted(qos.reliability)}",
        f"  History (Depth): {history}",
        f"  Durability: {shouted(qos.durability)}",
        f"  Lifespan: {_time(qos.lifespan)}",
        f"  Deadline: {_time(qos.deadline)}",
        f"  Liveliness: {shouted(qos.liveliness)}",
        f"  Liveliness lease duration: {_time(qos.lease_duration)}",
    ]
    return "\n".join(lines)


def _time(seconds: float) -> str:
    return f"{round(seconds * 1e9)} nanoseconds" if seconds else "Infinite"
