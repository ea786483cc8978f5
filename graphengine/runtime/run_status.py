"""Measures the status of a running session for displays: speed, messages and losses."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore, SessionState

WINDOW = 1.0
"""Wall time over which rates are measured, s; the time since the last reading if that is longer."""


@dataclass(frozen=True, slots=True)
class RunStatus:
    """The status of a session at one time. Some values depend on the wall clock, so they are not reproducible.

    Attributes:
        state: stopped, playing, paused or failed.
        time: simulation time since play, s.
        tick: number of the tick since play.
        pace: target real-time factor; None for as fast as possible.
        real_time_factor: seconds of simulation per second of wall time.
        tick_cpu: CPU time per tick, s.
        late_ticks: ticks that ended after the next one was due.
        messages: messages sent since the start.
        message_rate: messages sent per second of wall time.
        subscribers: number of subscribers of all topics that nodes publish.
        dropped_values: number of bad values that nodes dropped; values of the same node in one tick count once.
        recorded_bytes: size of the recording; None if nothing is recorded.
        file_errors: number of errors in changed files; while there are any, the session runs the previous version.
    """

    state: SessionState
    time: float
    tick: int
    pace: float | None
    real_time_factor: float
    tick_cpu: float
    late_ticks: int
    messages: int
    message_rate: float
    subscribers: int
    dropped_values: int
    recorded_bytes: int | None
    file_errors: int


class _Sample(NamedTuple):
    wall: float
    cpu: float
    ticks: int
    sent: int


class StatusMeter:
    """Reads the status of a session, in the session's thread; measuring begins at once.

    Args:
        session: session to measure.
    """

    def __init__(self, session: SessionCore) -> None:
        self._session = session
        self._samples = deque([self._sample()])

    def _sample(self) -> _Sample:
        session = self._session
        return _Sample(time.perf_counter(), time.thread_time(), session.ticks, session.services.network.sent)

    def read(self) -> RunStatus:
        """Return the current status, with rates over the last second."""
        session, now = self._session, self._sample()
        while len(self._samples) > 1 and now.wall - self._samples[1].wall >= WINDOW:
            self._samples.popleft()
        before = self._samples[0]
        self._samples.append(now)
        elapsed, ticks = now.wall - before.wall, now.ticks - before.ticks
        dropped = session.services.dropped
        return RunStatus(
            state=session.state,
            time=session.time,
            tick=session.clock.frame,
            pace=session.pace,
            real_time_factor=ticks * session.clock.delta / elapsed if elapsed else 0.0,
            tick_cpu=(now.cpu - before.cpu) / ticks if ticks else 0.0,
            late_ticks=session.late_ticks,
            messages=now.sent,
            message_rate=(now.sent - before.sent) / elapsed if elapsed else 0.0,
            subscribers=session.services.network.subscribers,
            dropped_values=sum(dropped.ticks.values()) if dropped is not None else 0,
            recorded_bytes=session.inbox.recorded_bytes,
            file_errors=len(session.findings),
        )
