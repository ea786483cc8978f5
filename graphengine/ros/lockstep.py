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
"""Wall time after which a wait sends /clock again, s: the program may have missed /clock, or just started.

After the discovery of a program, lockstep also gives the program this time to discover the subscriptions of this run.
"""
PAUSE = 0.25
"""Wall time without a call of `opens` after which the timeout of a wait restarts, s, because the run was paused."""
MAX_AHEAD = 10
"""Maximum number of waiting messages, in periods; with more, the program sends faster than lockstep takes messages."""


class Lockstep:
    """Holds back the messages of each topic until the topic's period ends, and decides whether the next tick may begin.

    In the first tick after each period, a subscription gets exactly the next `messages` messages. So the wall time at which a
    message arrives has no effect. The tick that ends the first period also waits until a program publishes the topic, because
    an answer that the program sends before it discovers the subscriptions would be lost.

    Args:
        network: network of the session before the setup of the nodes.
        entries: topics with their periods.
    """

    def __init__(self, network: LiveNetwork, entries: Sequence[LockstepSpec]) -> None:
        self._network = network
        self._entries = entries
        network.quotas.update((entry.topic, 0) for entry in entries)
        self._since: float | None = None
        """Wall time at which the current wait began; None outside of a wait."""
        self._asked = self._repeated = 0.0
        self._found: dict[str, float] = {}
        """Wall time at which the first publisher of each topic was discovered, s."""

    def opens(self, frame: int, tick_period: tuple[int, int]) -> bool:
        """Return whether the next tick may begin; call the method repeatedly until it returns True.

        Args:
            frame: number of the last tick.
            tick_period: seconds per tick, as numerator and denominator.

        Raises:
            TransportError: messages did not arrive within their topic's timeout, or more messages wait than `MAX_AHEAD` permits.
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
        """Return whether the next tick may begin without waiting for a topic; set how many of its messages the tick takes."""
        ends = _ends(entry, frame, tick)
        self._network.quotas[entry.topic] = entry.messages if ends else 0
        subscriptions = self._subscriptions(entry.topic)
        waiting = [one.waiting for one in subscriptions]
        if waiting and max(waiting) > MAX_AHEAD * entry.messages:
            what = f"{entry.topic}: {max(waiting)} messages wait at t = {float(frame * tick):g} s"
            taken = f"lockstep takes {entry.messages} at the end of each period of {entry.period:g} s"
            remedy = "the program sends more: set `period` and `messages` to its rate"
            raise TransportError(f"{what}; {taken}\n  {remedy}")
        if not waiting or min(waiting) >= entry.messages:
            return True
        return not ends and (not _ends(entry, frame + 1, tick) or self._is_found(subscriptions[0]))

    def _is_found(self, subscription: LiveSubscription) -> bool:
        """Return whether a publisher of the topic was discovered at least `REPEAT` s ago, and so knows the subscription."""
        transport, topic = self._network.transport(subscription.claim.ros_context), subscription.topic
        now = time.monotonic()
        if transport.spin_time == 0.0:  # the transport has no discovery
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
        what = f"lockstep received {came} within {entry.timeout:g} s of wall time, at t = {at:g} s"
        return f"{entry.topic}: {what}\n  {why}"


def _ends(entry: LockstepSpec, frame: int, tick: Fraction) -> bool:
    """Return whether one of a topic's periods ends with tick `frame`."""
    ticks = tick / Fraction(repr(entry.period))
    return frame > 0 and frame * ticks // 1 > (frame - 1) * ticks // 1
