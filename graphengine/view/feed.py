"""Tells a page what happens in a session."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.runtime.command_queue import Desk
from graphengine.view.layers import Layers
from graphengine.view.live_graphs import NodeCosts, draw, port_values
from graphengine.view.page_client import Page
from graphengine.view.viewers import Driver, RecordingControls, Viewers
from graphengine.view.wire import LiveMarks, LiveScene, LiveState

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

PERIOD = 0.05
"""Seconds of wall time between two frames."""


class Feed:
    """Feeds a page from a session, in the thread of its ticks.

    Args:
        session: what is seen.
        desk: where commands of viewers are queued.
        title: name of the scene.
        host: address of the page.
        port: port of the page; 0 takes a free one.
        driver: publishes what viewers drive.
        lost: called once, if the page's process ends before `close`.
        read_only: whether viewers may only look.
        playback: the recording that the session replays; None for a run.
    """

    def __init__(
        self,
        session: SessionCore,
        desk: Desk,
        title: str,
        host: str,
        port: int,
        driver: Driver,
        lost: Callable[[str], None],
        *,
        read_only: bool = False,
        playback: RecordingControls | None = None,
    ) -> None:
        self._session = session
        self._title = title
        self._driver = driver
        self._lost: Callable[[str], None] | None = lost
        self._viewers = Viewers(desk, driver, read_only=read_only, playback=playback)
        self._playback = playback
        self._marked = 0
        self._layers = Layers(session.services)
        self._costs = NodeCosts()
        self._next = 0.0
        self._shown: tuple[object, ...] = ()
        self._rate = _Rate()
        self.page = Page(host, port, self._viewers.ask)
        self.url = self.page.url

    @property
    def asked(self) -> bool:
        """Whether viewers wait for `after_tick` to do what they asked for."""
        return self._viewers.waiting

    def after_tick(self) -> None:
        """Do what viewers asked for, and tell the page if it is time to; call it after each tick, and while there are none."""
        now = time.monotonic()
        if self.page.lost:
            self._tell_loss()
            return
        self._viewers.obey(self.page, now)
        if not self._viewers.number:
            self._costs.end()
        elif now >= self._next and not self.page.busy:
            self._next = now + PERIOD
            poses = self._session.services.world.poses()
            self._tell_scene(len(poses))
            self._tell_marks()
            self.page.show(self._state(now, poses))

    def forget_costs(self) -> None:
        """Leave out of the costs of nodes what ran since the last frame."""
        self._costs.forget()

    def _tell_loss(self) -> None:
        """Tell once that the page's process has ended, and stop what viewers drove."""
        self._viewers.leave()
        if self._lost is not None:
            self._lost("the process of the page has ended; the run goes on\n  `graphrun ctl view` opens a new page")
            self._lost = None

    def close(self) -> None:
        """End the page."""
        self.page.close()

    def _tell_scene(self, bodies: int) -> None:
        """Send the scene if it is another one than before: other graphs, or another number of bodies."""
        graphs, services = self._session.graphs, self._session.services
        present = (*map(id, graphs), bodies)
        if present == self._shown:
            return
        self._shown = present
        self._layers.find()
        robots = list(services.stage.prims("robot"))
        focus = services.world.entities.state(robots[0].entity_name).position if robots else (0.0, 0.0, 0.0)
        folder = self._playback.folder if self._playback is not None else ""
        drawings = [draw(run, folder) for run in graphs]
        self.page.tell(
            LiveScene(
                self._title, services.world.bodies(), drawings, self._driver.topics(), self._layers.beams(), focus
            )
        )

    def _tell_marks(self) -> None:
        """Send the events of a recording if there are more than before."""
        marks = self._playback.marks() if self._playback is not None else ()
        if len(marks) != self._marked:
            self._marked = len(marks)
            self.page.tell(LiveMarks(marks))

    def _state(self, now: float, poses: NDArray[np.float64]) -> LiveState:
        session = self._session
        clock = session.clock
        facts = {
            "time": clock.time,
            "tick": clock.frame,
            "state": session.state,
            "pace": session.pace,
            "rate": self._rate.of(now, session.ticks * clock.delta),
            "messages": getattr(session.services.network, "sent", 0),
            "dropped": len(session.services.dropped.ticks) if session.services.dropped else 0,
        }
        if self._playback is not None:
            facts |= self._playback.facts()
        wanted = set(self._viewers.graphs.values())
        runs = [run for run in session.graphs if run.name in wanted]
        values = {run.name: port_values(run) for run in runs}
        scans = self._layers.scans(self._viewers.layers)
        return LiveState(facts, poses, scans, values, self._costs.since_last(session.ticks, runs))


class _Rate:
    """Seconds of simulation in a second of wall time, over the last second."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, float]] = deque(maxlen=round(1.0 / PERIOD))

    def of(self, now: float, simulated: float) -> float:
        self._seen.append((now, simulated))
        (begun, first), elapsed = self._seen[0], now - self._seen[0][0]
        return (simulated - first) / elapsed if elapsed > 0.0 and begun < now else 0.0
