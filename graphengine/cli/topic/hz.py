"""`graphrun topic hz`: measure the rate of the messages of a topic."""

from __future__ import annotations

import argparse
import sys
import time

from graphengine.cli.live import Live, absolute, add_live_arguments, show, size
from graphengine.cli.topic.expression import make_filter
from graphengine.messages.qos import PRESETS
from graphengine.ros.rates import Intervals

WINDOW = 10_000
"""Default size of the window: number of latest messages over which to average."""
PATIENCE = 3.0
"""Time without a first message after which the command says that it waits, s."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic hz` to its parser."""
    parser.add_argument("topic", metavar="TOPIC", help="topic, such as /chatter")
    add_window_argument(parser)
    wanted = "count only messages for which this Python expression is true, such as 'm.data > 0'; m is the message"
    parser.add_argument("--filter", metavar="EXPR", help=wanted)
    parser.add_argument("--wall-time", action="store_true", help="measure in wall time, even with --use-sim-time")
    add_live_arguments(parser, clock=True)


def add_window_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--window`, the number of latest messages over which to average."""
    averaged = f"number of latest messages over which to average (default {WINDOW})"
    parser.add_argument("-w", "--window", metavar="N", type=size, default=WINDOW, help=averaged)


def execute(arguments: argparse.Namespace) -> int:
    """Print rates until Ctrl-C; return 0."""
    from graphengine.messages import messages

    topic, wanted = absolute(arguments.topic), make_filter(arguments.filter)
    intervals = Intervals(arguments.window)
    with Live(arguments) as live:
        message_type = live.type_of(topic, live.graph_with(topic))
        clock = time.time_ns if arguments.wall_time else live.clock(arguments)
        inbox = live.listen(topic, message_type, PRESETS["Sensor Data"], clock, WINDOW)
        patience: float | None = PATIENCE
        while True:
            arrival, patience = inbox.take(patience), None
            if arrival is None:
                print(f"no message after {PATIENCE:g} s; still waiting", file=sys.stderr, flush=True)
                continue
            if arguments.filter and not wanted(messages.decode(arrival.data, message_type, live.definitions)):
                continue
            if not intervals.add(arrival.time):
                show("time has reset, resetting counters")
            if summary := intervals.report():
                show(f"average rate: {1e9 / summary.mean if summary.mean else 0.0:.3f}\n{summary}")
    return 0
