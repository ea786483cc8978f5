"""Publishes the health of a session and its robots on /diagnostics, as diagnostic_aggregator and rqt_robot_monitor expect it.

Rates and lateness depend on the wall clock, which a replay cannot reproduce. Recordings do not contain these messages.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, Publisher, QoS
from graphengine.runtime.run_status import StatusMeter

if TYPE_CHECKING:
    from graphengine.ros.network import LiveNetwork
    from graphengine.runtime.session_core import SessionCore

TOPIC, TYPE = "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"
PERIOD = 1.0
"""Wall time between two messages, s."""
ENOUGH = 0.9
"""A topic below this share of its nominal rate, or a simulation below this share of the requested pace, gets a warning."""
MOST_FAULTS = 20
"""Maximum number of problems with other ROS 2 participants to keep; the oldest are dropped."""
OK, WARN, ERROR = range(3)


class Diagnostics:
    """Publishes one DiagnosticArray a second while the topic has subscribers; without subscribers, nothing is measured.

    Args:
        session: session to watch.
        network: network of this session.
        name: name of the scene, used as `hardware_id` of the session.
        faults: problems with other ROS 2 participants, such as incompatible QoS, oldest first; the caller adds new ones.
        clock: function that returns wall time, s.
    """

    def __init__(
        self,
        session: SessionCore,
        network: LiveNetwork,
        name: str,
        faults: Collection[str] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._session, self._network, self._name, self._faults = session, network, name, faults
        self._definitions = network.definitions
        self._writer = network.transport(0).writer(TOPIC, TYPE, QoS())
        self._clock = clock
        self._meter: StatusMeter | None = None
        self._due = 0.0
        self._counts: Counter[tuple[str, str]] = Counter()
        """Number of messages since the last DiagnosticArray, by node and topic."""
        self._before: Counter[str] = Counter()
        """Totals at the last DiagnosticArray: lost messages by kind of loss, and dropped values by node."""
        self._began = (0, 0)

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Count a message that a node published."""
        self._counts[claim.node, claim.topic] += 1

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Ignore received messages; only published messages are counted."""

    def after_tick(self) -> None:
        """Publish a DiagnosticArray if `PERIOD` has passed. Call this after each tick, also while the session is paused."""
        now = self._clock()
        if now < self._due:
            return
        self._due = now + PERIOD
        if not self._writer.matched:
            self._end()
        elif self._meter is None:
            self._begin()
        else:
            self._writer.write(messages.encode(self._message(self._meter), self._definitions))
            self._note()

    def _begin(self) -> None:
        self._meter = StatusMeter(self._session)
        self._network.tap(self)
        self._note()

    def _end(self) -> None:
        if self._meter is not None:
            self._meter = None
            self._network.untap(self)

    def _note(self) -> None:
        """Begin a measuring period: store the current totals of ticks and lost messages, and clear the message counts."""
        self._counts.clear()
        self._began = self._session.ticks, self._session.late_ticks
        self._before = Counter({name: sum(one.values()) for name, one in self._losses().items()} | self._dropped())

    def _losses(self) -> dict[str, Counter[str]]:
        network = self._network
        return {
            "malformed messages": network.malformed,
            "messages dropped for slow readers": network.given_up,
            "messages overwritten before a tick": network.overwritten,
        }

    def _dropped(self) -> dict[str, int]:
        dropped = self._session.services.dropped
        return dict(dropped.ticks) if dropped is not None else {}

    def _message(self, meter: StatusMeter) -> Any:
        statuses = [self._simulation(meter), self._peers(), *self._robots()]
        header = messages.header(self._session.time, "")
        return self._definitions.message_class(TYPE)(header, statuses)

    def _status(self, part: str, hardware: str, level: int, text: str, values: dict[str, object]) -> Any:
        make, pair = (
            self._definitions.message_class(f"diagnostic_msgs/msg/{name}") for name in ("DiagnosticStatus", "KeyValue")
        )
        pairs = [pair(key, str(value)) for key, value in values.items()]
        return make(level, f"graphengine: {part}", text, hardware, pairs)

    def _simulation(self, meter: StatusMeter) -> Any:
        """Return the DiagnosticStatus of the session: its state, speed and late ticks."""
        session, status = self._session, meter.read()
        late = status.late_ticks - self._began[1]
        slow = status.state == "playing" and status.pace is not None
        slow = slow and status.real_time_factor < ENOUGH * (status.pace or 0.0)
        level, text = (WARN, f"slow: {status.real_time_factor:.2f} of real time") if slow else (OK, status.state)
        if status.state == "failed":
            level, text = ERROR, session.failure.partition("\n")[0]
        values = {
            "state": status.state,
            "simulation time (s)": f"{status.time:.3f}",
            "real time factor": f"{status.real_time_factor:.3f}",
            "target": "max" if status.pace is None else f"{status.pace:g}",
            "late ticks": status.late_ticks,
            "late ticks in the last second": late,
            "CPU time of a tick (ms)": f"{status.tick_cpu * 1e3:.3f}",
            "dropped values": status.dropped_values,
        }
        return self._status("simulation", self._name, level, text, values)

    def _peers(self) -> Any:
        """Return the DiagnosticStatus of the network: lost messages, and problems with other ROS 2 participants."""
        totals = {name: sum(counts.values()) for name, counts in self._losses().items()}
        losing = [name for name, total in totals.items() if total > self._before[name]]
        faults = {f"peer {number}": fault.replace("\n", " ") for number, fault in enumerate(self._faults, 1)}
        texts = [*losing, *([f"problems with peers: {len(faults)}"] if faults else [])]
        return self._status(
            "network", self._name, WARN if texts else OK, ", ".join(texts) or "OK", {**totals, **faults}
        )

    def _robots(self) -> Iterator[Any]:
        """Yield the DiagnosticStatus of each robot: rates of its topics with subscribers, and values that its nodes dropped."""
        session = self._session
        elapsed = (session.ticks - self._began[0]) * session.clock.delta
        wanted = [end for end in self._network.publishers if _is_measured(end) and elapsed > 0.0]
        dropped = self._dropped()
        for robot in session.services.stage.prims("robot"):
            below = f"{robot.path}/"
            values: dict[str, object] = {}
            texts: list[str] = []
            for claim in (end.claim for end in wanted if end.claim.node.startswith(below)):
                reached, rate = self._counts[claim.node, claim.topic] / elapsed, claim.rate or 0.0
                values[f"{claim.topic} (Hz)"] = f"{reached:.1f} of {rate:g}"
                if reached * elapsed < ENOUGH * rate * elapsed - 1.0:  # the period can cut off one message
                    texts.append(f"{claim.topic}: {reached:.1f} Hz instead of {rate:g} Hz")
            for node in (node for node in dropped if node.startswith(below)):
                values[f"dropped values of {node}"] = dropped[node]
                if dropped[node] > self._before[node]:
                    texts.append(f"{node} dropped values")
            level, text = (WARN, "; ".join(texts)) if texts else (OK, "OK")
            yield self._status(robot.entity_name, robot.entity_name, level, text, values)


def _is_measured(publisher: Publisher) -> bool:
    """Return whether a publisher's rate is measured: its topic has subscribers and a nominal rate and is not latched."""
    return bool(publisher.subscribers and publisher.claim.rate and not publisher.claim.latched)
