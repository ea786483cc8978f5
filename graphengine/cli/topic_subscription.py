"""The subverbs of `graphrun topic` that subscribe to a topic: `echo`, `hz` and `delay`; and their option `--filter`."""

from __future__ import annotations

import argparse
import sys
import time
from collections import deque
from collections.abc import Callable, Collection, Iterator
from typing import TYPE_CHECKING, Any

from graphengine.cli import terminal
from graphengine.cli.live import Live, absolute, show
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.qos_options import add_quality_arguments, quality_for
from graphengine.cli.quantities import count, positive, size
from graphengine.format.errors import TransportError, UsageError
from graphengine.format.wording import printable
from graphengine.messages.qos import PRESETS
from graphengine.ros.network_graph import Endpoint
from graphengine.ros.rates import SECOND, Intervals, Summary
from graphengine.sandbox.expressions import FUNCTIONS, ForbiddenError, Guard, compiled

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions
    from graphengine.ros.cli_subscription import MessageQueue

TRUNCATED = 128
"""Default maximum number of elements of an array, and of characters of a string, to print."""
WINDOW = 10_000
"""Default number of latest messages over which to average."""
PATIENCE = 3.0
"""Time without a first message after which the verb prints that it still waits, s."""

Filter = Callable[[Any], bool]

_ARRAY = frozenset(
    ("all", "any", "argmax", "argmin", "max", "mean", "min", "ndim", "shape", "size", "std", "sum", "tolist")
)


def echo_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `graphrun topic echo`."""
    add_value(parser, "topic", "TOPIC", "topic, such as /chatter")
    add_value(parser, "type", "TYPE", "message type (default: that of the publishers)", nargs="?")
    add_flag(parser, "--once", "end after the first printed message")
    add_value(parser, "--timeout", "SECONDS", "end after this time (default: no limit)", type=positive)
    add_value(parser, "--field", "PATH", "print only this field of each message, such as pose.pose.position")
    wanted = "print only messages for which this Python expression is true, such as 'm.data > 0'; m is the message, "
    wanted += "or with --field the field"
    add_value(parser, "--filter", "EXPR", wanted)
    add_flag(parser, "--csv", "print each message as one line of comma-separated values")
    add_flag(parser, "--raw", "print the serialized bytes of each message")
    add_flag(parser, "--flow-style", "print lists in brackets on one line")
    add_flag(parser, "--no-arr", "print only the type and length of arrays")
    add_flag(parser, "--no-str", "print the length of each string instead of its text")
    add_flag(parser, "--full-length", "print all elements of arrays and all characters of strings", short="-f")
    cut = f"maximum number of elements of an array, and of characters of a string, to print (default {TRUNCATED})"
    add_value(parser, "--truncate-length", "N", cut, short="-l", type=count)
    summary = (
        "summarize each scan, image and point cloud in a few lines: sizes, extents, and a sparkline or image; on a terminal,"
        " this is the default unless another option sets the format"
    )
    add_flag(parser, "--summary", summary)
    add_quality_arguments(parser, "sensor_data")


def echo(arguments: argparse.Namespace) -> int:
    """Print messages; return 0 after a message or at Ctrl-C, 1 if `--timeout` passes without a message to print."""
    from graphengine.messages.message_input import full_type

    topic, wanted = absolute(arguments.topic), make_filter(arguments.filter)
    with Live(arguments) as live:
        graph = live.graph(lambda graph: graph.publishers(topic))
        publishers = graph.publishers(topic)
        message_type = full_type(arguments.type) if arguments.type else live.type_of(topic, graph)
        _warn_of_other_definitions(publishers, message_type, live.definitions.type_hash(message_type))
        inbox = live.listen(topic, message_type, quality_for(arguments, publishers))
        printed = 0
        try:
            for data in _arriving(inbox, arguments.timeout):
                text = _text(data, message_type, live.definitions, wanted, arguments)
                if text is not None:
                    show(text)
                    printed += 1
                if printed and arguments.once:
                    return 0
        finally:
            if inbox.dropped:
                why = "because they arrived faster than they were printed"
                print(f"WARNING: {inbox.dropped} messages were dropped {why}", file=sys.stderr)
        if not printed:
            print(f"no message to print arrived on {topic} within {arguments.timeout:g} s", file=sys.stderr)
            return 1
    return 0


def _warn_of_other_definitions(publishers: list[Endpoint], message_type: str, known: str) -> None:
    for end in publishers:
        if end.message_type == message_type and end.type_hash not in ("", known):
            what = f"{end.full_node or 'a publisher'} has another definition of {message_type} ({end.type_hash})"
            print(f"WARNING: {what}: its messages are dropped", file=sys.stderr)


def _arriving(inbox: MessageQueue, timeout: float | None) -> Iterator[bytes]:
    """Yield the serialized messages as they arrive, for `timeout` s; None stands for no limit."""
    end = None if timeout is None else time.monotonic() + timeout
    while (arrival := inbox.take(None if end is None else max(0.0, end - time.monotonic()))) is not None:
        yield arrival.data


def _text(
    data: bytes, message_type: str, definitions: Definitions, wanted: Filter, arguments: argparse.Namespace
) -> str | None:
    """Return the text to print for a message; None if the filter rejects the message or its bytes cannot be decoded."""
    from graphengine.messages import messages
    from graphengine.messages.message_text import Style, TypedValue, to_csv, to_plain_text, to_yaml

    if arguments.raw:
        return f"{data!r}\n---"
    try:
        message = messages.decode(data, message_type, definitions)
    except messages.MessageError as error:
        print(f"WARNING: dropped: {printable(str(error))}", file=sys.stderr)
        return None
    part = TypedValue.of(message, definitions).find(arguments.field or "")
    if not wanted(part.value):
        return None
    if part.value is message and _wants_summary(arguments) and (summary := _summary(message)) is not None:
        return f"{summary}\n---"
    if not part.is_message:
        return f"{to_plain_text(part)}\n---"
    longest = TRUNCATED if arguments.truncate_length is None else arguments.truncate_length
    longest = None if arguments.full_length else longest
    style = Style(longest, not arguments.no_arr, not arguments.no_str, arguments.flow_style)
    return to_csv(part, style) if arguments.csv else f"{to_yaml(part, style)}---"


def _wants_summary(arguments: argparse.Namespace) -> bool:
    """Return whether to print summaries: on request, or on a terminal if no option sets the output format."""
    chosen = ("csv", "flow_style", "no_arr", "no_str", "full_length")
    plain = arguments.truncate_length is None and not any(getattr(arguments, option) for option in chosen)
    return arguments.summary or (plain and sys.stdout.isatty())


def _summary(message: Any) -> str | None:
    from graphengine.messages.message_summary import summarize

    return summarize(message, terminal.width(sys.stdout), picture=sys.stdout.isatty())


def hz_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `graphrun topic hz`."""
    add_value(parser, "topic", "TOPIC", "topic, such as /chatter")
    _add_window_argument(parser)
    wanted = "count only messages for which this Python expression is true, such as 'm.data > 0'; m is the message"
    add_value(parser, "--filter", "EXPR", wanted)
    add_flag(parser, "--wall-time", "measure in wall time, even with --use-sim-time")


def _add_window_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--window`, the number of latest messages over which to average."""
    averaged = f"number of latest messages over which to average (default {WINDOW})"
    add_value(parser, "--window", "N", averaged, short="-w", type=size, default=WINDOW)


def hz(arguments: argparse.Namespace) -> int:
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


def delay_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `graphrun topic delay`."""
    add_value(parser, "topic", "TOPIC", "topic whose messages have a header, such as /scan")
    _add_window_argument(parser)


def delay(arguments: argparse.Namespace) -> int:
    """Print delays until Ctrl-C; return 0."""
    from graphengine.messages import messages

    topic = absolute(arguments.topic)
    with Live(arguments) as live:
        message_type = live.type_of(topic, live.graph_with(topic))
        if "header" not in dict(live.definitions.fields(message_type)):
            raise TransportError(f"{topic}: the delay is unknown, because {message_type} has no header with a stamp")
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


class _MessageGuard(Guard):
    """Lets expressions read all fields of messages, and those attributes and methods of arrays that are in `_ARRAY`."""

    def attributes(self, value: Any) -> Collection[str]:
        if hasattr(value, "__msgtype__"):
            return frozenset(value.__dataclass_fields__) - {"__msgtype__"}
        return _ARRAY if hasattr(value, "__array_interface__") else super().attributes(value)


def make_filter(text: str | None) -> Filter:
    """Return a function that evaluates a filter for a message; if `text` is None, the function always returns True.

    The function raises UsageError if the expression fails for a message.

    Raises:
        UsageError: the text is not a legal expression.
    """
    if text is None:
        return lambda message: True
    try:
        code = compiled(text, known=("m", *FUNCTIONS))
    except (SyntaxError, ValueError, ForbiddenError) as error:
        raise UsageError(f"--filter {text!r} is not an expression: {error}") from None

    def wanted(message: Any) -> bool:
        try:
            return bool(_MessageGuard().evaluate(code, {**FUNCTIONS, "m": message}))
        except ForbiddenError as error:
            raise UsageError(f"--filter {text!r}: {error}") from None
        except Exception as error:
            raise UsageError(f"--filter {text!r}: {type(error).__name__}: {error}") from None

    return wanted
