"""`graphrun topic delay`: measure the age of messages on arrival, from the stamp in their header."""

from __future__ import annotations

import argparse
import time
from collections import deque

from graphengine.cli.live import Live, absolute, add_live_arguments, show
from graphengine.cli.topic.hz import WINDOW, add_window_argument
from graphengine.format.errors import TransportError
from graphengine.messages.qos import PRESETS
from graphengine.ros.rates import SECOND, Summary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic delay` to its parser."""
    parser.add_argument("topic", metavar="TOPIC", help="topic whose messages have a header, such as /scan")
    add_window_argument(parser)
    add_live_arguments(parser, clock=True)


def execute(arguments: argparse.Namespace) -> int:
    """Print delays until Ctrl-C; return 0."""
    from graphengine.messages import messages

    topic = absolute(arguments.topic)
    with Live(arguments) as live:
        message_type = live.type_of(topic, live.graph_with(topic))
        if "header" not in dict(live.definitions.fields(message_type)):
            raise TransportError(
                f"{topic}: the delay is unknown, because its type {message_type} has no header with a stamp"
            )
        inbox = live.listen(topic, message_type, PRESETS["Sensor Data"], live.clock(arguments), WINDOW)
        window: deque[int] = deque(maxlen=arguments.window)
        tell, fresh = time.monotonic() + 1.0, False
        while True:
            arrival = inbox.take(max(0.0, tell - time.monotonic()))
            if arrival is not None:
                stamp = messages.decode(arrival.data, message_type, live.definitions).header.stamp
                window.append(arrival.time - stamp.sec * SECOND - stamp.nanosec)
                fresh = True
            if time.monotonic() >= tell:
                tell += 1.0
                if summary := Summary.of(window):
                    show(f"average delay: {summary.mean / SECOND:.3f}\n{summary}" if fresh else "no new messages")
                fresh = False
    return 0
