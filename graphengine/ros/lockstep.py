"""Lockstep: at the end of each period, the next tick waits until a program under test has sent its messages."""

from __future__ import annotations

import time
from collections.abc import Sequence
from fractions import Fraction

from graphengine.format.errors import TransportError
from graphengine.format.scene_spec import LockstepSpec
from graphengine.ros.network import LiveNetwork
from graphengine.ros.topic_endpoints import LiveSubscription

REPEAT = 0.2
"""Wall time after which a wait sends /clock again, s, for a program that missed it or has just started.

A program also gets this time between its discovery and its first answer, to discover the subscriptions of this run.
"""
PAUSE = 0.25
"""Wall time without a call of `opens` after which the timeout of a wait restarts, s; the run was paused meanwhile."""
MAX_AHEAD = 10
"""Maximum number of periods of waiting messages; if more wait, the program sends more messages than lockstep takes."""


class Lockstep:
    """Holds back the messages of topics until their periods end, and decides whether the next tick may begin.

    Subscriptions get exactly the first `messages` messages in the first tick after the first period, the next ones after the
    second period, and so on. So the wall time at which a message arrives has no effect. The tick that ends the first period also
    waits until a program publishes the topic: the program's first answer would be lost before it discovers the subscriptions.

    Args:
        network: network of the session, whose nodes are not set up yet.
        entries: topics, each with its period.
    """

    def __init__(self, network: LiveNetwork, entries: Sequence[LockstepSpec]) -> None:
        self._network = network
        self._entries = entries
        network.quotas.update((entry.topic, 0) for entry in entries)
        self._since: float | None = None
        """Wall time at which the current wait began; None outside of a wait."""
        self._asked = self._repeated = 0.0
        self._found: dict[str, float] = {}
        """Wall time at which a publisher of each topic was discovered."""

    def opens(self, frame: int, tick_period: tuple[int, int]) -> bool:
        """Return whether the next tick may begin; while it may not, call this method repeatedly.

        Args:
            frame: number of the last tick.
            tick_period: seconds per tick, as numerator and denominator.

        Raises:
            TransportError: messages did not arrive within the timeout of their topic, or more wait than `MAX_AHEAD` permits.
        """
        if not self._entries:
            return True
        tick, now = Fraction(*tick_period), time.monotonic()
        missing = [entry for entry in self._entries if not self._is_complete(entry, frame, tick)]
        if not missing:
            self._since = None
            return True
        if self._since is None or now - self._asked > PAUSE:
            self._since = self._repeated = now
        self._asked = now
        for entry in missing:
            if now - self._since >= entry.timeout:
                self._since = None
                raise TransportError(self._explain(entry, float(frame * tick)))
        if now - self._repeated >= REPEAT:
            self._repeated = now
            self._network.repeat_clock()
        return False

    def _is_complete(self, entry: LockstepSpec, frame: int, tick: Fraction) -> bool:
        """Return whether the next tick need not wait for a topic; set the number of its messages that the tick takes."""
        ends = _ends(entry, frame, tick)
        self._network.quotas[entry.topic] = entry.messages if ends else 0
        subscriptions = self._subscriptions(entry.topic)
        waiting = [one.waiting for one in subscriptions]
        if waiting and max(waiting) > MAX_AHEAD * entry.messages:
            raise TransportError(
                f"{entry.topic}: {max(waiting)} messages wait at t = {float(frame * tick):g} s; lockstep takes"
                f" {entry.messages} at the end of each period of {entry.period:g} s\n"
                "  the program sends more: set `period` and `messages` to its rate"
            )
        if not waiting or min(waiting) >= entry.messages:
            return True
        return not ends and (not _ends(entry, frame + 1, tick) or self._is_found(subscriptions[0]))

    def _is_found(self, subscription: LiveSubscription) -> bool:
        """Return whether a publisher of the topic has existed for `REPEAT`, in which it discovers the subscription."""
        transport, topic = self._network.transport(subscription.claim.ros_context), subscription.topic
        now = time.monotonic()
        if transport.spin_time == 0.0:  # there is no discovery
            return True
        if topic not in self._found and transport.graph({(topic, "publish")}).publishers(topic):
            self._found[topic] = now
        return now - self._found.get(topic, now) >= REPEAT

    def _subscriptions(self, topic: str) -> list[LiveSubscription]:
        return [one for one in self._network.subscriptions if one.topic == topic]

    def _explain(self, entry: LockstepSpec, at: float) -> str:
        """Return the error message for a program that does not answer."""
        subscriptions = self._subscriptions(entry.topic)
        graph = self._network.transport(subscriptions[0].claim.ros_context).graph({(entry.topic, "publish")})
        if graph.publishers(entry.topic):
            why = "a program publishes the topic: make it answer /clock (use_sim_time), or set its period or a longer timeout"
        else:
            why = "no program publishes the topic: start the program under test, in the ROS domain of this run"
        came = f"{min(one.waiting for one in subscriptions)} of {entry.messages} messages"
        return (
            f"{entry.topic}: lockstep received {came} within {entry.timeout:g} s of wall time, at t = {at:g} s\n  {why}"
        )


def _ends(entry: LockstepSpec, frame: int, tick: Fraction) -> bool:
    """Return whether a period of a topic ends with tick `frame`."""
    ticks = tick / Fraction(repr(entry.period))
    return frame > 0 and frame * ticks // 1 > (frame - 1) * ticks // 1
