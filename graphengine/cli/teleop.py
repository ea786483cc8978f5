"""`graphrun teleop`: drive a robot from the keyboard."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from graphengine.cli.live import Live, absolute, add_live_arguments
from graphengine.cli.options import add_value
from graphengine.cli.quantities import positive
from graphengine.cli.terminal_keyboard import ENDS, TerminalKeyboard
from graphengine.format.errors import UsageError
from graphengine.format.wording import listing
from graphengine.messages.endpoints import QoS
from graphengine.ros.network_graph import Endpoint, NetworkGraph

if TYPE_CHECKING:
    from graphengine.ros.cli_subscription import Clock
    from graphengine.ros.transport import Writer

TOPIC = "/cmd_vel"
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
KEYS = {"up": (1.0, 0.0), "down": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}
"""Driving direction (1 forwards, -1 backwards) and turning direction (1 left, -1 right) of each key."""
KEYS |= {letter: KEYS[arrow] for letter, arrow in (("w", "up"), ("s", "down"), ("a", "left"), ("d", "right"))}
FACTORS = {"+": 1.1, "=": 1.1, "-": 1 / 1.1}
HELP = "arrows or w a s d: drive and turn;   space: stop;   + or -: faster or slower;   q or Ctrl-C: quit"
RATE = 20.0
"""Rate of publishing while the robot is driven, Hz."""
STOPPING = 10
"""Number of messages with velocity 0 after the last key; then the verb publishes nothing, to let other nodes drive the robot."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun teleop` to its parser."""
    topic = f"velocity topic to publish (default: the only one with subscribers, else {TOPIC})"
    add_value(parser, "topic", "TOPIC", topic, nargs="?")
    add_value(parser, "--speed", "M/S", "forward speed, m/s (default 0.5)", type=positive, default=0.5)
    add_value(parser, "--turn", "RAD/S", "turn rate, rad/s (default 1)", type=positive, default=1.0)
    hold = "time for which a key press acts; it must be longer than the keyboard's repeat delay (default 0.5)"
    add_value(parser, "--hold", "SECONDS", hold, type=positive, default=0.5)
    kind = "message type (default: that of the topic's subscribers, else Twist)"
    parser.add_argument("--type", choices=("Twist", "TwistStamped"), help=kind)
    add_value(parser, "--frame-id", "FRAME", "frame_id in the header of a TwistStamped", default="")
    parser.epilog = f"Keys: {HELP}."
    add_live_arguments(parser, clock=True)


def execute(arguments: argparse.Namespace) -> int:
    """Publish velocities for the pressed keys until the user quits; return 0."""
    keyboard = TerminalKeyboard()
    given = absolute(arguments.topic) if arguments.topic else ""
    with Live(arguments) as live:
        graph = live.graph(lambda graph: graph.subscribers(given))
        topic = given or only_topic(graph)
        message_type = f"geometry_msgs/msg/{arguments.type}" if arguments.type else type_of(topic, graph)
        clock = live.clock(arguments)
        writer = live.transport.writer(topic, message_type, QoS())
        publisher = VelocityPublisher(writer, message_type, clock, arguments.frame_id)
        stick = Stick(arguments.hold, arguments.speed, arguments.turn)
        print(f"{topic} [{message_type}]; {live.where}\n{HELP}", file=sys.stderr)
        with keyboard:
            try:
                _follow(keyboard, stick, publisher)
            finally:
                publisher.drive(0.0, 0.0)
                print(file=sys.stderr)
    return 0


def only_topic(graph: NetworkGraph) -> str:
    """Return the only topic to which peers subscribe with the type Twist or TwistStamped; `/cmd_vel` without subscribers.

    Raises:
        UsageError: peers subscribe to several topics with these types.
    """
    topics = sorted({end.topic for end in _readers(graph)})
    if len(topics) > 1:
        advice = listing(topics, "give one as TOPIC")
        raise UsageError(f"several topics have subscribers of type Twist or TwistStamped\n  {advice}")
    return topics[0] if topics else TOPIC


def type_of(topic: str, graph: NetworkGraph) -> str:
    """Return the type to publish: TwistStamped if all subscribers of the topic use it, else Twist."""
    types = {end.message_type for end in _readers(graph) if end.topic == topic}
    return STAMPED if types == {STAMPED} else TWIST


def _readers(graph: NetworkGraph) -> list[Endpoint]:
    return [end for end in graph.endpoints if end.direction == "subscribe" and end.message_type in (TWIST, STAMPED)]


@dataclass(slots=True)
class Stick:
    """Converts pressed keys to velocities. A press acts for a fixed time, because a terminal does not report releases of keys.

    Args:
        hold: time for which a press acts, s.
        speed: forward speed of the keys, m/s.
        turn: turn rate of the keys, rad/s.
    """

    hold: float
    speed: float
    turn: float
    _held: dict[int, tuple[float, float]] = field(default_factory=dict)
    """For driving (key 0) and turning (key 1): the direction, 1 or -1, and the time until which the direction acts, s."""

    def press(self, key: str, now: float) -> None:
        """Add the effect of a key pressed at the time `now`, s; other keys than those of `HELP` have no effect."""
        if key == " ":
            self._held.clear()
        elif key in FACTORS:
            self.speed, self.turn = self.speed * FACTORS[key], self.turn * FACTORS[key]
        for axis, direction in enumerate(KEYS.get(key, ())):
            if direction:
                self._held[axis] = direction, now + self.hold

    def command(self, now: float) -> tuple[float, float]:
        """Return the forward speed (m/s) and turn rate (rad/s) at the time `now`, s."""
        held = {axis: direction for axis, (direction, until) in self._held.items() if now < until}
        return held.get(0, 0.0) * self.speed, held.get(1, 0.0) * self.turn


@dataclass(slots=True)
class VelocityPublisher:
    """Publishes velocities as Twist or TwistStamped."""

    writer: Writer
    message_type: str
    clock: Clock
    frame_id: str

    def drive(self, speed: float, turn: float) -> None:
        """Publish a forward speed (m/s) and a turn rate (rad/s)."""
        from graphengine.messages import messages

        message: Any = messages.Twist(messages.Vector3(speed, 0.0, 0.0), messages.Vector3(0.0, 0.0, turn))
        if self.message_type == STAMPED:
            stamp = messages.Time(*divmod(self.clock(), 1_000_000_000))
            message = messages.TwistStamped(messages.Header(stamp, self.frame_id), message)
        self.writer.write(messages.encode(message))


def _follow(keyboard: TerminalKeyboard, stick: Stick, publisher: VelocityPublisher) -> None:
    """Publish velocities for the pressed keys and show them on one line, until q, Ctrl-C or Ctrl-D is pressed."""
    due, still, told = time.monotonic(), STOPPING, ""
    while True:
        due = max(due + 1.0 / RATE, time.monotonic())
        while (left := due - time.monotonic()) > 0.0:
            for key in keyboard.pressed(left):
                if key in (*ENDS, "q"):
                    return
                stick.press(key, time.monotonic())
        speed, turn = stick.command(time.monotonic())
        still = 0 if speed or turn else still + 1
        if still <= STOPPING:
            publisher.drive(speed, turn)
        listeners = "" if publisher.writer.matched else "   no subscriber"
        keys = f"keys give {stick.speed:.2f} m/s, {stick.turn:.2f} rad/s"
        line = f"{speed:6.2f} m/s {turn:6.2f} rad/s   {keys}{listeners}"
        if line != told:
            print(f"\r{line}\x1b[K", end="", file=sys.stderr, flush=True)
            told = line
