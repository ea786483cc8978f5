"""`graphrun action send_goal`: send a goal and wait for its result."""

from __future__ import annotations

import argparse
import queue
import sys
from typing import TYPE_CHECKING, Any

from graphengine.cli.live import Live, absolute, add_live_arguments, show

if TYPE_CHECKING:
    from graphengine.ros.action_caller import ActionCaller, GoalCall

CANCEL_PATIENCE = 5.0
"""Maximum time to wait for the server's response to a cancel request, s."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun action send_goal` to its parser."""
    parser.add_argument("action", metavar="ACTION", help="action, such as /fibonacci")
    parser.add_argument("type", metavar="TYPE", help="action type, such as example_interfaces/action/Fibonacci")
    source = parser.add_mutually_exclusive_group()
    goal = "goal as YAML, such as '{order: 10}' (default '{}'); the values `auto` of a header and `now` of a time become the"
    goal += " time of sending"
    source.add_argument("goal", metavar="GOAL", nargs="?", default="{}", help=goal)
    source.add_argument("--stdin", action="store_true", help="read the goal from standard input")
    parser.add_argument("-f", "--feedback", action="store_true", help="print feedback as it arrives")
    parser.epilog = "Ctrl-C cancels the goal. The exit code is 0 if the goal succeeded, else 1."
    add_live_arguments(parser, clock=True)


def execute(arguments: argparse.Namespace) -> int:
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
        call = caller.send(goal, arrived.put if arguments.feedback else _nothing)
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


def _nothing(message: Any) -> None:
    """Ignore a feedback message; used without `--feedback`."""


def _cancel(caller: ActionCaller, call: GoalCall) -> None:
    """Cancel the goal and wait for the server's response; do nothing if the server has not accepted the goal."""
    if not call.accepted.done() or not call.accepted.result():
        return
    show("Canceling goal...")
    answer = caller.cancel(call.goal).result(CANCEL_PATIENCE)
    show("Goal canceled." if answer.goals_canceling else "The server did not cancel the goal.")
