"""`graphrun topic pub`: publish messages on a topic."""

from __future__ import annotations

import argparse
import itertools
import sys
import time

from graphengine.cli.live import POLL, Live, absolute, add_live_arguments, count, near_topic, positive, seconds, show
from graphengine.cli.topic.qos_options import add_quality_arguments, quality
from graphengine.format.errors import TransportError, UsageError
from graphengine.messages.qos import mismatch
from graphengine.ros.network_graph import Endpoint, NetworkGraph

PATIENCE = 1.0
"""Time between two lines that are printed while the verb waits for subscribers, s."""
HOW_TO_LEAVE = """the topic has too few subscribers yet; press Ctrl-C to end the wait
  next time, limit the wait with --max-wait-time-secs SECONDS, or publish without subscribers with -w 0"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic pub` to its parser."""
    parser.add_argument("topic", metavar="TOPIC", help="topic, such as /cmd_vel")
    parser.add_argument("type", metavar="TYPE", help="message type, such as geometry_msgs/msg/Twist")
    source = parser.add_mutually_exclusive_group()
    values = (
        "message as YAML, such as '{linear: {x: 1.0}}' (default '{}'); the values `auto` of a header and `now` of a time"
        " become the time of sending"
    )
    source.add_argument("values", metavar="VALUES", nargs="?", default="{}", help=values)
    source.add_argument("--stdin", action="store_true", help="read the message from standard input")
    parser.add_argument(
        "-r", "--rate", metavar="HZ", type=positive, default=1.0, help="publishing rate, Hz (default 1)"
    )
    parser.add_argument(
        "-p", "--print", metavar="N", type=count, default=1, help="print every N-th message, 0: none (default 1)"
    )
    number = parser.add_mutually_exclusive_group()
    number.add_argument("-1", "--once", action="store_true", help="publish one message")
    number.add_argument(
        "-t", "--times", metavar="N", type=count, default=0, help="publish N messages (default: until Ctrl-C)"
    )
    wait = "number of matching subscribers to wait for before publishing (default 1 with --once or --times, else 0)"
    parser.add_argument("-w", "--wait-matching-subscriptions", metavar="N", type=count, help=wait)
    longest = "maximum time to wait for subscribers (default: no limit)"
    parser.add_argument("--max-wait-time-secs", metavar="SECONDS", type=positive, help=longest)
    alive = "time to stay connected after the last message (default 0.1)"
    parser.add_argument("--keep-alive", metavar="SECONDS", type=seconds, default=0.1, help=alive)
    parser.add_argument(
        "-n", "--node-name", metavar="NAME", help="name of the publishing node (default: a hidden name)"
    )
    add_quality_arguments(parser, "default")
    add_live_arguments(parser, clock=True)


def execute(arguments: argparse.Namespace) -> int:
    """Publish the given number of messages, or until Ctrl-C; return 0."""
    from graphengine.messages.message_input import full_type, parse
    from graphengine.messages.message_text import TypedValue, to_expression
    from graphengine.messages.messages import encode

    topic, message_type, qos = absolute(arguments.topic), full_type(arguments.type), quality(arguments)
    times = 1 if arguments.once else arguments.times
    wanted = arguments.wait_matching_subscriptions
    wanted = min(times, 1) if wanted is None else wanted
    if arguments.max_wait_time_secs is not None and not wanted:
        raise UsageError("--max-wait-time-secs needs --wait-matching-subscriptions, --once or --times")
    with Live(arguments, arguments.node_name) as live:
        draft = parse(sys.stdin.read() if arguments.stdin else arguments.values, message_type, live.definitions)
        clock = live.clock(arguments)
        writer = live.transport.writer(topic, message_type, qos)
        if wanted:
            offer = Endpoint(b"", "publish", topic, message_type, qos)
            _wait_for_readers(live, offer, wanted, arguments.max_wait_time_secs)
        show("publisher: beginning loop")
        due = time.monotonic()
        for number in itertools.count(1):
            message = draft.stamp(clock())
            if arguments.print and number % arguments.print == 0:
                show(f"publishing #{number}: {to_expression(TypedValue.of(message, live.definitions))}\n")
            writer.write(encode(message, live.definitions))
            if number == times:
                break
            due = max(due + 1.0 / arguments.rate, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
        time.sleep(arguments.keep_alive)
    return 0


def _wait_for_readers(live: Live, offer: Endpoint, wanted: int, limit: float | None) -> None:
    """Wait until `wanted` subscribers match the offered publisher in topic, type and quality of service.

    Raises:
        TransportError: too few subscribers match within `limit` s; None: there is no limit.
    """

    def found(graph: NetworkGraph) -> int:
        return sum(map(offer.serves, graph.subscribers(offer.topic)))

    begun, why = time.monotonic(), ""
    told, hint = begun, begun + PATIENCE
    graph = live.graph(lambda graph: found(graph) >= wanted)
    while found(graph) < wanted:
        now = time.monotonic()
        if limit is not None and now - begun >= limit:
            what = f"Expected {wanted} subscribers but only got {found(graph)} subscribers"
            raise TransportError(f"Timed out waiting for subscribers: {what}{_mismatches(graph, offer)}")
        if now >= told:
            before, why = why, _mismatches(graph, offer)
            show(f"Waiting for at least {wanted} matching subscription(s)...{why if why != before else ''}")
            told = now + PATIENCE
        if limit is None and now >= hint:
            print(HOW_TO_LEAVE, file=sys.stderr, flush=True)
            hint = float("inf")
        time.sleep(POLL)
        graph = live.graph_now()


def _mismatches(graph: NetworkGraph, offer: Endpoint) -> str:
    """Return a line with the reason for each subscriber of the topic that does not match; without subscribers, a suggestion."""
    lines = []
    for end in graph.subscribers(offer.topic):
        if end.message_type != offer.message_type:
            lines.append(f"{end.full_node} subscribes to {end.message_type}")
        elif reason := mismatch(offer.qos, end.qos, "this publisher", end.full_node):
            lines.append(reason)
    read = {end.topic for end in graph.endpoints if end.direction == "subscribe"}
    hint = "" if offer.topic in read else near_topic(offer.topic, read)
    return "".join(f"\n  {line}" for line in (*lines, hint) if line)
