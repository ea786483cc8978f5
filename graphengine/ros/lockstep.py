"""Lockstep: where a period ends, the next tick waits until a program under test has sent its messages."""

from __future__ import annotations

import time
from collections.abc import Sequence
from fractions import Fraction

from graphengine.format.errors import TransportError
from graphengine.format.spec import LockstepSpec
from graphengine.ros.network import LiveNetwork
from graphengine.ros.topic_endpoints import LiveSubscription

REPEAT = 0.2
"""Wall time of a wait after which /clock is sent again, s, for a program that missed it or has just started."""
MAX_AHEAD = 10
"""Largest number of periods for which messages may wait; if more wait, the program sends more than lockstep takes."""


class Lockstep:
    """Holds back the messages of topics until their periods end, and decides whether the next tick may begin.

    Subscriptions get exactly the first `messages` messages in the first tick after the first period, the next ones after the
    second period, and so on. So the wall time at which a message arrives has no effect.

    Args:
        network: network of the session, whose nodes are not set up yet.
        entries: topics, each with its period.
    """

    def __init__(self, network: LiveNetwork, entries: Sequence[LockstepSpec]) -> None:
        self._network = network
        self._entries = entries
        network.quotas.update((entry.topic, 0) for entry in entries)
        self._since: float | None = None
        """Wall time at which the present wait began; None: no wait."""
        self._repeated = 0.0

    def restart(self) -> None:
        """Restart the wall time of a wait, as after a pause."""
        self._since = None

    def opens(self, frame: int, tick_period: tuple[int, int]) -> bool:
        """Return whether the next tick may begin; call this again and again while it may not.

        Args:
            frame: number of the last tick.
            tick_period: seconds per tick, as numerator and denominator.

        Raises:
            TransportError: messages did not arrive within the timeout of their topic, or far too many have arrived.
        """
        missing = [entry for entry in self._entries if not self._is_complete(entry, frame, Fraction(*tick_period))]
        now = time.monotonic()
        if not missing:
            self._since = None
            return True
        if self._since is None:
            self._since = self._repeated = now
        for entry in missing:
            if now - self._since >= entry.timeout:
                self._since = None
                raise TransportError(self._explain(entry, float(frame * Fraction(*tick_period))))
        if now - self._repeated >= REPEAT:
            self._repeated = now
            self._network.repeat_clock()
        return False

    def _is_complete(self, entry: LockstepSpec, frame: int, tick: Fraction) -> bool:
        """Return whether a topic lets the next tick begin; set the number of its messages that the tick takes."""
        ticks = tick / Fraction(repr(entry.period))
        ends = frame > 0 and frame * ticks // 1 > (frame - 1) * ticks // 1
        self._network.quotas[entry.topic] = entry.messages if ends else 0
        waiting = self._waiting(entry.topic)
        if waiting and max(waiting) > MAX_AHEAD * entry.messages:
            raise TransportError(
                f"{entry.topic}: {max(waiting)} messages wait at t = {float(frame * tick):g} s; lockstep takes"
                f" {entry.messages} where a period of {entry.period:g} s ends\n"
                "  the program sends more: set `period` and `messages` to what it sends"
            )
        return not ends or not waiting or min(waiting) >= entry.messages

    def _subscriptions(self, topic: str) -> list[LiveSubscription]:
        return [one for one in self._network.subscriptions if one.topic == topic]

    def _waiting(self, topic: str) -> list[int]:
        """Return the number of messages that wait at each subscription of a topic."""
        return [one.waiting for one in self._subscriptions(topic)]

    def _explain(self, entry: LockstepSpec, at: float) -> str:
        """Return the message about a program that does not answer."""
        first, *_ = self._subscriptions(entry.topic)
        graph = self._network.transport(first.claim.ros_context).graph({(entry.topic, "publish")})
        if graph.publishers(entry.topic):
            why = "a program publishes the topic: make it answer /clock (use_sim_time), or set its period or a longer timeout"
        else:
            why = "no program publishes the topic: start the program under test, in the ROS domain of this run"
        came = f"{min(self._waiting(entry.topic))} of {entry.messages} messages came within {entry.timeout:g} s"
        return f"{entry.topic}: {came} where lockstep waits for them, at t = {at:g} s\n  {why}"
