"""`graphrun action`: list actions and send goals on a live network, with or without ROS installed, like `ros2 action`."""

from __future__ import annotations

import argparse
import queue
import sys
from typing import TYPE_CHECKING, Any

from graphengine.cli.live import FEEDBACK, Live, absolute, actions_of, add_message_arguments, show, types_by_name
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.subverbs import add_live_subverbs, reach_of
from graphengine.ros.network_graph import NetworkGraph

if TYPE_CHECKING:
    from graphengine.ros.action_caller import ActionCaller, GoalCall

CANCEL_PATIENCE = 5.0
"""Maximum time to wait for the server's response to a cancel request, s."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subverbs with their arguments to the parser of the verb."""
    subverbs = {
        "list": ("list actions that have a server or client", _list_arguments, _list),
        "info": ("list the clients and servers of an action", _info_arguments, _info),
        "send_goal": ("send a goal and print its result", _send_goal_arguments, _send_goal),
    }
    add_live_subverbs(parser, subverbs, reach_of("servers"), ("send_goal",))


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_flag(parser, "--show-types", "also print the type of each action", short="-t")
    add_flag(parser, "--count-actions", "print only the number of actions", short="-c")


def _list(arguments: argparse.Namespace) -> int:
    """Print the actions; return 0, also if there are none."""
    with Live(arguments) as live:
        actions = action_types(live.graph())
        types = {action: f" [{', '.join(names)}]" for action, names in actions.items()}
        lines = [action + (types[action] if arguments.show_types else "") for action in actions]
        live.show_found("actions", len(actions), lines, counted=arguments.count_actions)
    return 0


def action_types(graph: NetworkGraph) -> dict[str, list[str]]:
    """Return a dict from each action on the network to its types, both sorted."""
    return types_by_name(sorted(actions_of((end.topic, end.message_type) for end in graph.endpoints)))


def _info_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "action", "ACTION", "action, such as /fibonacci")
    add_flag(parser, "--show-types", "also print the type of each client and server", short="-t")
    add_flag(parser, "--count", "print only the number of clients and servers", short="-c")


def _info(arguments: argparse.Namespace) -> int:
    """Print the clients and servers of the action; return 0.

    Raises:
        TransportError: the action has no client or server.
    """
    action = absolute(arguments.action)
    feedback = action + FEEDBACK
    with Live(arguments) as live:
        graph = live.graph(names=not arguments.count)
        known = action_types(graph)
        if action not in known:
            raise live.unknown("action", action, known)
        show(f"Action: {action}")
        for what, ends in (("clients", graph.subscribers(feedback)), ("servers", graph.publishers(feedback))):
            show(f"Action {what}: {len(ends)}")
            for end in () if arguments.count else ends:
                kind = f" [{end.message_type.removesuffix('_FeedbackMessage')}]" if arguments.show_types else ""
                show(f"    {end.full_node or '_NODE_NAME_UNKNOWN_'}{kind}")
    return 0


def _send_goal_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "action", "ACTION", "action, such as /fibonacci")
    add_value(parser, "type", "TYPE", "action type, such as example_interfaces/action/Fibonacci")
    add_message_arguments(parser, "goal", "goal", "{order: 10}")
    add_flag(parser, "--feedback", "print feedback as it arrives", short="-f")
    parser.epilog = "Ctrl-C cancels the goal. The exit code is 0 if the goal succeeded, else 1."


def _send_goal(arguments: argparse.Namespace) -> int:
    """Send the goal and wait for its result; return 0 if the goal succeeded, else 1."""
    from graphengine.messages.goals import STATUS_NAMES, SUCCEEDED
    from graphengine.messages.message_input import full_type, parse
    from graphengine.messages.message_text import TypedValue, to_yaml
    from graphengine.ros.action_caller import ActionCaller

    action, action_type = absolute(arguments.action), full_type(arguments.type, "action")
    with Live(arguments) as live:

        def text(message: Any) -> str:
            return to_yaml(TypedValue.of(message, live.definitions))

        goal_type, _, _ = live.definitions.action_parts(action_type)
        draft = parse(sys.stdin.read() if arguments.stdin else arguments.goal, goal_type, live.definitions)
        clock = live.clock(arguments)
        caller = ActionCaller(live.transport, action, action_type, live.definitions)
        show("Waiting for an action server to become available...")
        live.wait_for_server(action, lambda: caller.ready)
        goal = draft.stamp(clock())
        show(f"Sending goal:\n     {text(goal)}")
        arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        call = caller.send(goal, arrived.put if arguments.feedback else lambda _: None)
        call.result.add_done_callback(lambda _: arrived.put(None))
        try:
            if not call.accepted.result():
                show("Goal was rejected.")
                return 1
            show(f"Goal accepted with ID: {call.goal.hex()}\n")
            while (message := arrived.get()) is not None:
                show(f"Feedback:\n    {text(message)}")
            outcome = call.result.result()
        except KeyboardInterrupt:
            _cancel(caller, call)
            raise
        show(f"Result:\n    {text(outcome.result)}")
        status = outcome.status if outcome.status in range(len(STATUS_NAMES)) else 0
        show(f"Goal finished with status: {STATUS_NAMES[status].upper()}")
        return 0 if status == SUCCEEDED else 1
    return 1


def _cancel(caller: ActionCaller, call: GoalCall) -> None:
    """Cancel the goal and wait for the server's response; do nothing if the server has not accepted the goal."""
    if not call.accepted.done() or not call.accepted.result():
        return
    show("Canceling goal...")
    answer = caller.cancel(call.goal).result(CANCEL_PATIENCE)
    show("Goal canceled." if answer.goals_canceling else "The server did not cancel the goal.")
