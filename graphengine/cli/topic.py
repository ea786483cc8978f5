"""`graphrun topic`: inspect topics on a live network, with or without ROS installed, like `ros2 topic`."""

from __future__ import annotations

import argparse
import itertools
import sys
import time

from graphengine.cli.common import counted
from graphengine.cli.live import POLL, Live, absolute, add_message_arguments, is_hidden, near_topic, show
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.qos_options import add_quality_arguments, quality, shouted
from graphengine.cli.quantities import count, positive, seconds
from graphengine.cli.subverbs import add_live_subverbs
from graphengine.cli.topic_subscription import delay, delay_arguments, echo, echo_arguments, hz, hz_arguments
from graphengine.format.errors import TransportError, UsageError
from graphengine.messages.qos import mismatch
from graphengine.ros.network_graph import Direction, Endpoint, NetworkGraph

PATIENCE = 1.0
"""Time between two lines that the verb prints while it waits for subscribers, s."""
HOW_TO_LEAVE = """the topic has too few subscribers yet; press Ctrl-C to end the wait
  next time, limit the wait with --max-wait-time-secs SECONDS, or publish without subscribers with -w 0"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subverbs with their arguments to the parser of the verb."""
    details = "print the type of a topic and its numbers of publishers and subscribers, or with -v all details"
    age = "measure the age of messages on arrival, from the stamp in their header"
    subverbs = {
        "list": ("list topics that have a publisher or subscriber", _list_arguments, _list),
        "info": (details, _info_arguments, _info),
        "echo": ("print the messages of a topic as they arrive", echo_arguments, echo),
        "hz": ("measure the rate of the messages of a topic", hz_arguments, hz),
        "delay": (age, delay_arguments, delay),
        "pub": ("publish messages on a topic", _pub_arguments, _pub),
    }
    where = "`graphrun topics SCENE` lists the topics of a scene without running it."
    add_live_subverbs(parser, subverbs, where, ("hz", "delay", "pub"))


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_flag(parser, "--show-types", "also print the type of each topic", short="-t")
    add_flag(parser, "--count-topics", "print only the number of topics", short="-c")
    add_flag(parser, "--include-hidden-topics", "include topics with a name part that begins with _")
    add_flag(parser, "--verbose", "also print the types and the numbers of publishers and subscribers", short="-v")


def _list(arguments: argparse.Namespace) -> int:
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


def _counts(graph: NetworkGraph, topics: list[str], direction: Direction) -> str:
    """Return lines with type and number of publishers, or of subscribers, of each topic that has any."""
    title, who = {"publish": ("Published", "publisher"), "subscribe": ("Subscribed", "subscriber")}[direction]
    types, numbers = graph.types(), {topic: len(graph.ends(topic, direction)) for topic in topics}
    lines = [f" * {topic} [{', '.join(types[topic])}] {counted(n, who)}" for topic, n in numbers.items() if n]
    return "\n".join([f"{title} topics:", *lines, ""])


def _info_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "topic", "TOPIC", "topic, such as /chatter")
    what = "also print node, type, type hash, GID and quality of service of each publisher and subscriber"
    add_flag(parser, "--verbose", what, short="-v")


def _info(arguments: argparse.Namespace) -> int:
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
    """Return all details of a publisher or subscriber as text; UNKNOWN stands for details that the peer does not announce."""
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


def _pub_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "topic", "TOPIC", "topic, such as /cmd_vel")
    add_value(parser, "type", "TYPE", "message type, such as geometry_msgs/msg/Twist")
    add_message_arguments(parser, "values", "message", "{linear: {x: 1.0}}")
    add_value(parser, "--rate", "HZ", "publishing rate, Hz (default 1)", short="-r", type=positive, default=1.0)
    printed = "print every N-th message, or none if N is 0 (default 1)"
    add_value(parser, "--print", "N", printed, short="-p", type=count, default=1)
    number = parser.add_mutually_exclusive_group()
    add_flag(number, "--once", "publish one message", short="-1")
    add_value(number, "--times", "N", "publish N messages (default: until Ctrl-C)", short="-t", type=count, default=0)
    wait = "number of matching subscribers to wait for before publishing (default 1 with --once or --times, else 0)"
    add_value(parser, "--wait-matching-subscriptions", "N", wait, short="-w", type=count)
    longest = "maximum time to wait for subscribers (default: no limit)"
    add_value(parser, "--max-wait-time-secs", "SECONDS", longest, type=positive)
    alive = "time to stay connected after the last message (default 0.1)"
    add_value(parser, "--keep-alive", "SECONDS", alive, type=seconds, default=0.1)
    add_value(parser, "--node-name", "NAME", "name of the publishing node (default: a hidden name)", short="-n")
    add_quality_arguments(parser, "default")


def _pub(arguments: argparse.Namespace) -> int:
    """Publish the number of messages that the user gave, or publish until Ctrl-C; return 0."""
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
