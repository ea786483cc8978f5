"""Code that verbs on a live network share: options, joining the network, waiting for peers, and ending at Ctrl-C."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import add_message_path, add_transport_argument, chosen_distro, clean, message_paths
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.quantities import seconds
from graphengine.format import interrupts
from graphengine.format.errors import TransportError
from graphengine.format.files import installed_packages
from graphengine.format.wording import did_you_mean, listing
from graphengine.messages.endpoints import QoS
from graphengine.messages.names import check_namespace, check_topic, full_namespace
from graphengine.ros.domain import Domain
from graphengine.ros.network_graph import NetworkGraph
from graphengine.ros.transport import JoinOptions, Transport, brief, discover

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions
    from graphengine.ros.cli_subscription import Clock, MessageQueue

FEEDBACK = "/_action/feedback"
"""End of the name of the feedback topic of each action."""
POLL = 0.05
"""Time between two checks of the discovered peers, s."""
SERVER_PATIENCE = 2.0
"""Time to wait for a server before a likely reason for its absence is printed, s."""


def add_live_arguments(parser: argparse.ArgumentParser, *, clock: bool = False) -> None:
    """Add the options for joining the network, and `--use-sim-time` if `clock` is set."""
    add_transport_argument(parser)
    spin = "time to wait for the discovery of other nodes (default 0.5 with dds, 2 with rclpy)"
    add_value(parser, "--spin-time", "SECONDS", spin, type=seconds)
    add_flag(parser, "--no-daemon", "has no effect; unlike ros2, graphrun has no daemon")
    if clock:
        add_flag(parser, "--use-sim-time", "use the simulation time on /clock, not wall time", short="-s")
    add_message_path(parser)


def add_message_arguments(parser: argparse.ArgumentParser, name: str, noun: str, example: str) -> None:
    """Add the positional argument for a message to send, written in YAML, and `--stdin`.

    Args:
        parser: parser to add the arguments to.
        name: name of the positional argument.
        noun: noun for the message in the help, such as `request`.
        example: message of the help.
    """
    source = parser.add_mutually_exclusive_group()
    what = (
        f"{noun} as YAML, such as '{example}' (default '{{}}'); the values `auto` of a header and `now` of a time become the"
        " time of sending"
    )
    source.add_argument(name, metavar=name.upper(), nargs="?", default="{}", help=what)
    add_flag(source, "--stdin", f"read the {noun} from standard input")


class Live:
    """A node on the network while a verb runs, used as a context manager. Ctrl-C or SIGTERM ends its block without a traceback.

    Args:
        arguments: arguments that `add_live_arguments` added.
        node: name of the node; None chooses a hidden name, which `ros2 node list` leaves out.
    """

    def __init__(self, arguments: argparse.Namespace, node: str | None = None) -> None:
        from graphengine.messages.definitions import shipped
        from graphengine.ros.transports.select import open_transport

        name = node or f"_graphrun_{os.getpid()}"
        known = shipped(chosen_distro(arguments))
        self.definitions: Definitions = known.extended(message_paths(arguments), installed_packages())
        domain = Domain.from_environment(os.environ)
        joined = JoinOptions(domain, name, environ=os.environ, definitions=self.definitions)
        self.transport: Transport = open_transport(arguments.transport, joined)
        kind, *further = brief(self.transport.description).split(", ")
        self.where = f"{further[0]} ({kind})" if further else kind
        """The domain and the transport, as in `domain 72 (embedded DDS)`."""
        self._alone = domain.discovery_range == "OFF"
        self._node = f"/{name}"
        self._spin_time: float | None = arguments.spin_time
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Live:
        for number in (signal.SIGINT, signal.SIGTERM):  # the first is ignored in what a script puts in the background
            self._before[number] = signal.signal(number, interrupts.interrupt)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> bool:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        for topic, number in self.transport.malformed.items():
            print(f"WARNING: {topic}: dropped messages that do not fit the topic's type: {number}", file=sys.stderr)
        self.transport.close()
        return kind is KeyboardInterrupt

    def graph(self, enough: Callable[[NetworkGraph], object] = lambda _: False, *, names: bool = False) -> NetworkGraph:
        """Wait for the discovery of peers and return their endpoints.

        Args:
            enough: ends the wait as soon as it returns a true value.
            names: also wait for the node names of the endpoints.
        """
        found = discover(self.transport, self._spin_time, lambda graph: enough(graph.without(self._node)), names=names)
        return found.without(self._node)

    def graph_now(self) -> NetworkGraph:
        """Return the endpoints of peers discovered so far."""
        return self.transport.graph().without(self._node)

    def graph_with(self, topic: str) -> NetworkGraph:
        """Wait until a topic has a publisher or subscriber, and return the endpoints of peers.

        If the topic has none after the discovery time, print a warning and wait without limit.
        """
        graph = self.graph(lambda graph: topic in graph.types())
        if topic not in graph.types():
            warning = f"WARNING: topic [{topic}] does not appear to be published yet"
            print("\n".join(filter(None, (warning, near_topic(topic, graph.types())))), file=sys.stderr)
        while topic not in graph.types():
            time.sleep(POLL)
            graph = self.graph_now()
        return graph

    def wait_for_server(self, name: str, ready: Callable[[], bool], why: Callable[[], str] = lambda: "") -> None:
        """Wait for the server of a service or action. After `SERVER_PATIENCE` s, print a likely reason for its absence once.

        Args:
            name: full name of the service or action.
            ready: returns whether the server has been discovered.
            why: returns the likely reason. If this text is empty, a discovered server on an incompatible RMW is the reason.
        """
        begun, told = time.monotonic(), False
        while not ready():
            time.sleep(POLL)
            if not told and time.monotonic() - begun > SERVER_PATIENCE:
                told = True
                foreign = (text for end, text in self.transport.foreign_services.items() if end.startswith(name))
                if reason := why() or next(foreign, ""):
                    print(f"WARNING: {reason}", file=sys.stderr, flush=True)

    def type_of(self, topic: str, graph: NetworkGraph) -> str:
        """Return the message type of a topic.

        Raises:
            TransportError: the topic has no publisher or subscriber, or it has several types.
        """
        types = graph.types().get(topic, [])
        if not types:
            raise self.unknown("topic", topic, graph.types())
        if len(types) > 1:
            raise TransportError(f"{topic} has more than one type: {', '.join(types)}")
        return types[0]

    def show_found(self, what: str, number: int, lines: Sequence[str], *, counted: bool) -> None:
        """Print the names that a verb has found, or their number, and a message if there are none.

        Args:
            what: plural noun of the names, such as `topics`.
            number: number of names.
            lines: lines to print, which contain the names.
            counted: whether to print only the number.
        """
        if counted:
            show(str(number))
        elif lines:
            show("\n".join(lines))
        if not number:
            self.say_none(what)

    def say_none(self, what: str) -> None:
        """Print that the domain has no topics, or no nodes, as the plural noun `what` says; and print a remedy."""
        step = "`graphrun run dd100_warehouse` starts a run; ROS_DOMAIN_ID selects the domain"
        if self._alone:
            step = "unset ROS_AUTOMATIC_DISCOVERY_RANGE: OFF means that no process is found"
        print(f"no {what} on {self.where}\n  {step}", file=sys.stderr)

    def unknown(self, kind: str, name: str, known: Iterable[str]) -> TransportError:
        """Return the error for a name that is not on the network, with a suggestion or the known names.

        Args:
            kind: `topic`, `service`, `action` or `node`.
            name: full name that the user gave.
            known: names of this kind on the network; hidden topics are not listed.
        """
        shown = [each for each in known if kind != "topic" or not is_hidden(each)]
        hint = near_topic(name, shown) or listing(shown, f"{kind}s")
        return TransportError(f"unknown {kind} {name!r}\n{hint}\nsearched {self.where}")

    def listen(
        self, topic: str, message_type: str, qos: QoS, clock: Clock = time.time_ns, waiting: int = 100
    ) -> MessageQueue:
        """Subscribe to a topic and return the queue of received messages.

        Args:
            topic: full name of the topic.
            message_type: message type of the topic.
            qos: quality of service of the subscription.
            clock: returns the time of arrival, ns.
            waiting: maximum number of messages in the queue; a further one replaces the oldest.
        """
        from graphengine.ros.cli_subscription import MessageQueue

        inbox = MessageQueue(waiting, clock)
        self.transport.reader(topic, message_type, qos, inbox.deliver)
        return inbox

    def clock(self, arguments: argparse.Namespace) -> Clock:
        """Return a function that returns the wall time, or with `--use-sim-time` the simulation time, in ns."""
        from graphengine.ros.cli_subscription import SimulationClock

        if not arguments.use_sim_time:
            return time.time_ns
        clock = SimulationClock(self.transport)
        clock.wait(self.transport.spin_time if self._spin_time is None else self._spin_time)
        return clock


def absolute(topic: str) -> str:
    """Return the full name of a topic, service, action or node. A name without a leading slash is in the root namespace.

    Raises:
        TopicError: the name is not legal in ROS 2.
    """
    name = topic if topic.startswith("/") else f"/{topic}"
    check_topic(name, given=topic)
    return name


def absolute_namespace(given: str) -> str:
    """Return the full name of a namespace given by the user; an empty text for the root namespace.

    Raises:
        TopicError: the name is not legal in ROS 2.
    """
    namespace = full_namespace(given)
    check_namespace(namespace or "/", given)
    return namespace


def types_by_name(pairs: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Return a dict from each name to its types, both in the order of the pairs of name and type."""
    types: dict[str, list[str]] = {}
    for name, kind in pairs:
        types.setdefault(name, []).append(kind)
    return types


def actions_of(topics: Iterable[tuple[str, str]]) -> set[tuple[str, str]]:
    """Return name and type of each action whose feedback topic is among `topics`, which are pairs of name and type."""
    return {
        (topic.removesuffix(FEEDBACK), kind.removesuffix("_FeedbackMessage"))
        for topic, kind in topics
        if topic.endswith(FEEDBACK)
    }


def near_topic(topic: str, known: Iterable[str]) -> str:
    """Return a suggestion such as `did you mean '/robot/odom'?`, with the same name in another namespace, or a similar name.

    Return an empty text if `known` contains neither.
    """
    shown = [name for name in known if not is_hidden(name)]
    same = [name for name in shown if name.rpartition("/")[2] == topic.rpartition("/")[2]]
    return f"did you mean {' or '.join(map(repr, same))}?" if same else did_you_mean(topic, shown)


def is_hidden(topic: str) -> bool:
    """Return whether ROS 2 tools hide a name by default, because a part of the name begins with `_`."""
    return any(part.startswith("_") for part in topic.split("/"))


def show(text: str, end: str = "\n") -> None:
    """Print and flush a text from peers, in which `clean` replaces characters that control a terminal or mislead its reader.

    Tabs and carriage returns stay if standard output is not a terminal, for example a file.
    """
    print(clean(text, "" if sys.stdout.isatty() else "\t\r"), end=end, flush=True)
