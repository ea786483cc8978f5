"""`graphrun action list`: list actions."""

from __future__ import annotations

import argparse

from graphengine.cli.live import Live, add_live_arguments
from graphengine.ros.network_graph import NetworkGraph


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun action list` to its parser."""
    parser.add_argument("-t", "--show-types", action="store_true", help="also print the type of each action")
    parser.add_argument("-c", "--count-actions", action="store_true", help="print only the number of actions")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the actions; return 0, also if there are none."""
    with Live(arguments) as live:
        actions = action_types(live.graph())
        types = {action: f" [{', '.join(names)}]" for action, names in actions.items()}
        lines = [action + (types[action] if arguments.show_types else "") for action in actions]
        live.show_found("actions", len(actions), lines, counted=arguments.count_actions)
    return 0


def action_types(graph: NetworkGraph) -> dict[str, list[str]]:
    """Return the types of each action by its name; both come from the feedback topics on the network."""
    topics = {topic: types for topic, types in graph.types().items() if topic.endswith(FEEDBACK)}
    return {
        topic.removesuffix(FEEDBACK): [name.removesuffix("_FeedbackMessage") for name in types]
        for topic, types in topics.items()
    }


FEEDBACK = "/_action/feedback"
