"""`graphrun topic list`: list topics."""

from __future__ import annotations

import argparse
from typing import Literal

from graphengine.cli.live import Live, add_live_arguments, is_hidden
from graphengine.ros.network_graph import NetworkGraph


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic list` to its parser."""
    parser.add_argument("-t", "--show-types", action="store_true", help="also print the type of each topic")
    parser.add_argument("-c", "--count-topics", action="store_true", help="print only the number of topics")
    parser.add_argument(
        "--include-hidden-topics", action="store_true", help="include topics with a name part that begins with _"
    )
    parser.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="also print the types and the numbers of publishers and subscribers",
    )
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the topics; return 0, also if there are none."""
    with Live(arguments) as live:
        graph = live.graph()
        topics = [t for t in graph.types() if arguments.include_hidden_topics or not is_hidden(t)]
        types = {topic: f" [{', '.join(names)}]" for topic, names in graph.types().items()}
        lines = [topic + (types[topic] if arguments.show_types else "") for topic in topics]
        if arguments.verbose:
            lines = [_counts(graph, topics, "publish"), _counts(graph, topics, "subscribe")]
        live.show_found("topics", len(topics), lines, counted=arguments.count_topics)
    return 0


def _counts(graph: NetworkGraph, topics: list[str], direction: Literal["publish", "subscribe"]) -> str:
    """Return lines with the type of each topic and its number of publishers, or subscribers; topics with 0 are left out."""
    lines = ["Published topics:" if direction == "publish" else "Subscribed topics:"]
    who = "publisher" if direction == "publish" else "subscriber"
    for topic in topics:
        ends = graph.publishers(topic) if direction == "publish" else graph.subscribers(topic)
        if ends:
            types = ", ".join(graph.types()[topic])
            lines.append(f" * {topic} [{types}] {len(ends)} {who}{'s' if len(ends) > 1 else ''}")
    return "\n".join([*lines, ""])
