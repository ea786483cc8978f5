"""Measures the status of a running session for displays: speed, messages, and problems such as dropped values."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from graphengine.runtime.run_control import SessionState
    from graphengine.runtime.session_core import SessionCore

WINDOW = 1.0
"""Wall time over which rates are averaged, s; if the previous reading is older, since the previous reading."""


@dataclass(frozen=True, slots=True)
class RunStatus:
    """The status of a session at one moment. Values that depend on the wall clock are not reproducible.

    Attributes:
        state: stopped, playing, paused or failed.
        time: simulation time since play, s.
        tick: number of ticks since play.
        pace: target real-time factor; None: as fast as possible.
        real_time_factor: measured seconds of simulation per second of wall time.
        tick_cpu: CPU time of the session's thread per tick, s.
        late_ticks: number of ticks that ended after the next tick was due.
        messages: number of messages sent since the start of the session.
        message_rate: messages sent per second of wall time.
        subscribers: number of subscribers of all topics that nodes publish.
        dropped_values: number of bad values that nodes dropped; all values of a node in one tick count as one.
        recorded_bytes: size of the recording, bytes; None without a recording.
        file_errors: number of errors in changed files; with errors, the session runs the previous version of the files.
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
    """Reads the status of a session. Not thread-safe: create and use it in the session's thread.

    Rates exclude the time before the meter was created.

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
        """Return the current status, with rates over about the last `WINDOW` seconds."""
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
