"""Sends the state of a session to its page."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.format.diagnostics import Finding
from graphengine.format.errors import NodeError, UsageError
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.node_problems import NodeProblems
from graphengine.runtime.run_status import StatusMeter
from graphengine.view.camera_images import CameraImages
from graphengine.view.layer_data import FloorMap
from graphengine.view.layers import Layers
from graphengine.view.live_findings import finding_rows
from graphengine.view.live_graphs import NodeCosts, describe, summarize, values_of
from graphengine.view.live_robots import list_robots, states_of, with_joints
from graphengine.view.live_topics import Listen, LiveTopics
from graphengine.view.page_client import Page
from graphengine.view.viewers import Driver, RecordingControls, Viewers
from graphengine.view.wire import Ended, LiveScene, LiveState, LogMessages, PaneContent, PlotSamples

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

PERIOD, PANE_PERIOD = 0.05, 0.25
"""Wall time between two frames, and between two updates of panes, s."""


class Plots(Protocol):
    """The values of expressions over time, which viewers plot."""

    status: dict[str, Mapping[str, Any]]
    """For each expression an error, or the parts that can be plotted instead of a value that is not a number."""
    restarts: int
    """Number of changes of the expressions; a recording is sampled again from its beginning after each change."""

    def sampling(self) -> AbstractContextManager[None]:
        """Return a context for the samples of a recording."""

    @property
    def wanted(self) -> bool:
        """Whether viewers plot expressions."""

    def want(self, texts: Collection[str]) -> None:
        """Set the expressions to evaluate."""

    def rebind(self) -> None:
        """Look up ports and topics again."""

    def sample(self, time: float) -> None:
        """Evaluate all expressions after a tick; `time` is the time of the sample, s."""

    def take(self) -> PlotSamples | None:
        """Return the samples since the last call; None without samples."""


class Feed:
    """Sends the state of a session to its page, in the session's thread.

    Args:
        session: session to show.
        queue: queue for commands of viewers.
        title: name of the scene.
        host: IP address on which to serve the page.
        port: TCP port of the page; 0 selects a free port.
        driver: publishes the drive commands of viewers.
        lost: called once, with a warning for the user, if the page cannot be served or its process ends before `close`.
        make_floor: makes the occupancy map of the scene.
        plots: evaluates the expressions that viewers plot.
        listen: subscribes to a topic that a viewer selected; None if topics are not measured.
        findings: returns the findings in the scene's files; a string is a finding that is already rendered as text.
        definitions: message types.
        read_only: whether viewers can watch but not send commands.
        playback: controls of the recording that the session replays; None for a live run.
        problems: counts of node problems so far; None to count from now on.
        served: called once with the URL of the page, in the session's thread, as soon as the page can be opened.
    """

    def __init__(
        self,
        session: SessionCore,
        queue: CommandQueue,
        title: str,
        host: str,
        port: int,
        driver: Driver,
        lost: Callable[[str], None],
        *,
        make_floor: Callable[[], FloorMap],
        plots: Plots,
        listen: Listen | None = None,
        findings: Callable[[], Sequence[Finding | str]] = tuple,
        definitions: Definitions = DEFINITIONS,
        read_only: bool = False,
        playback: RecordingControls | None = None,
        problems: NodeProblems | None = None,
        served: Callable[[str], None] | None = None,
    ) -> None:
        self._session = session
        self._title = title
        self._driver = driver
        self._findings = findings
        self._definitions = definitions
        self._lost: Callable[[str], None] | None = lost
        self._served = served
        self._viewers = Viewers(queue, driver, read_only=read_only, playback=playback)
        self._playback = playback
        self._folder = playback.folder if playback is not None else ""
        self._marked = 0
        self._layers = Layers(session, make_floor, read_only=read_only or playback is not None)
        self._images = CameraImages(session)
        self._costs = NodeCosts()
        self._topics = LiveTopics(session, listen) if listen is not None else None
        self._problems = problems if problems is not None else NodeProblems(session.services.dropped)
        self.plots = plots
        """The values that viewers plot; in a recording, `Playback` samples them."""
        self._ticks = session.ticks
        self._plot_status: Mapping[str, Any] = {}
        self._logged = 0
        """Number of the last log message that was sent."""
        self._error = ""
        self._next = self._next_panes = 0.0
        self._shown: tuple[object, ...] = ()
        self._shown_findings: Sequence[Finding | str] | None = () if playback is not None else None
        self._shown_problems: Mapping[str, Any] = {}
        self._meter = StatusMeter(session)
        # A tab of a run that only showed must not control, nor a tab of any earlier run write files.
        self.page = Page(host, port, self._viewers.ask, keep_token=not (read_only or session.edits))
        try:
            self._tell_scene(len(session.services.world.poses()))  # drawn before the first viewer comes
        except BaseException:
            self.page.close()
            raise

    @property
    def asked(self) -> bool:
        """Whether requests of viewers are waiting; `after_tick` executes them."""
        return self._viewers.asked

    def wait(self) -> str:
        """Wait until the page can be opened, and return its URL.

        Raises:
            UsageError: the page cannot be served; `lost` is not called for it.
        """
        try:
            return self.page.wait()
        except UsageError:
            self._lost = None
            raise

    def after_tick(self) -> None:
        """Execute requests of viewers, and send a frame if it is due. Call this after each tick, and also while no ticks run."""
        now = time.monotonic()
        if self.page.lost:
            self._tell_loss()
            return
        if self._served is not None and self.page.url:
            self._served(self.page.url)
            self._served = None
        self._viewers.obey(self.page, now)
        self._sample()
        if not self._viewers.number:
            self._costs.end()
            self._end_topics()
        elif now >= self._next and not self.page.busy:
            self._tell(now)

    def _sample(self) -> None:
        """Evaluate what viewers plot, if a tick has run."""
        self.plots.want(self._viewers.plotted)
        ticks, self._ticks = self._ticks, self._session.ticks
        if self._playback is None and self.plots.wanted and ticks != self._ticks:
            self.plots.sample(self._session.time)

    def end_run(self, error: BaseException | None) -> None:
        """Show viewers the error that ended the run; do nothing if `error` is None."""
        self._error = self._session.failure if error is not None else ""
        if isinstance(error, NodeError):
            self._problems.add(error.node, str(error))
        if self._error:  # also for later viewers
            self._next_panes = 0.0
            self._tell(time.monotonic())

    def _tell(self, now: float) -> None:
        """Send the scene if it has changed, then a frame; also send new content of panes if an update of the panes is due."""
        self._next = now + PERIOD
        poses = self._session.services.world.poses()
        self._tell_scene(len(poses))
        for viewer in self._viewers.newcomers:
            for run in self._session.graphs:
                if run.name == self._viewers.graphs[viewer]:
                    self.page.tell(describe(viewer, run, self._folder))
        self._viewers.newcomers.clear()
        self._tell_marks()
        if (samples := self.plots.take()) is not None:
            self.page.tell(samples)
        for image in self._images.take(self._viewers.images, now, self._session.clock.frame):
            self.page.tell(image)
        self.page.show(self._state(now, poses))
        if now >= self._next_panes:
            self._next_panes = now + PANE_PERIOD
            self._tell_panes()

    def _tell_panes(self) -> None:
        problems, findings = self._problems.all(), self._findings()
        if problems != self._shown_problems:
            self._shown_problems = problems
            self.page.tell(PaneContent("problems", problems))
        if findings != self._shown_findings:
            self._shown_findings = findings
            self.page.tell(PaneContent("findings", finding_rows(findings)))
        if lines := self._problems.lines.after(self._logged):
            self._logged = lines[-1].number
            self.page.tell(LogMessages([asdict(line) for line in lines]))
        if self.plots.status != self._plot_status:
            self._plot_status = dict(self.plots.status)
            self.page.tell(PaneContent("plotting", self._plot_status))
        if self._topics is None or not self._viewers.topics:
            self._end_topics()
            return
        self._topics.watch({topic for topic in self._viewers.topics.values() if topic})
        self.page.tell(PaneContent("topics", self._topics.rows(self._session.time)))
        for message in self._topics.messages():
            self.page.tell(message)

    def _end_topics(self) -> None:
        if self._topics is not None:
            self._topics.end()

    def forget_costs(self) -> None:
        """Exclude the node executions since the last frame from the computing times that viewers see."""
        self._costs.forget()

    def _tell_loss(self) -> None:
        """Report once that the page's process has ended; stop driving robots and measuring for viewers."""
        self._viewers.leave()
        self._end_topics()
        self._costs.end()
        if self._lost is not None:
            self._lost(f"{self.page.failure}\n  the run goes on without its page; `graphrun ctl view` opens a new one")
            self._lost = None

    def close(self) -> None:
        """Tell viewers that the run has ended, and end the page's process."""
        self._end_topics()
        self.page.close(Ended(self._error))

    def _tell_scene(self, bodies: int) -> None:
        """Send the scene if its graphs, its version or its number of bodies has changed."""
        graphs, services = self._session.graphs, self._session.services
        present = (*(id(run.executor.graph) for run in graphs), self._session.version, bodies)
        if present == self._shown:
            return
        self._shown = present
        found = services.world.bodies()
        robots = list(services.stage.prims("robot"))
        focus = services.world.entities.state(robots[0].entity_name).position if robots else (0.0, 0.0, 0.0)
        names = [robot.entity_name for robot in robots]
        self.plots.rebind()
        self._problems.keep([run.executor.graph.prim_path for run in graphs])
        layers = self._layers.find(found.names)
        self.page.tell(
            LiveScene(
                self._title,
                found,
                [summarize(run, names, self._folder) for run in graphs],
                self._driver.topics(),
                layers,
                focus,
                list_robots(self._session),
                self._definitions,
                sorted({claim.topic for claim in services.claims if not claim.is_service}),
                [entity.mount.name for entity in layers.entities if not entity.robot],
                services.keys.asked,
            )
        )

    def _tell_marks(self) -> None:
        """Send all events of a recording that were found so far, if there are new events."""
        marks = self._playback.marks() if self._playback is not None else ()
        if len(marks) != self._marked:
            self._marked = len(marks)
            self.page.tell(PaneContent("marks", {"all": marks}))

    def _state(self, now: float, poses: NDArray[np.float64]) -> LiveState:
        session = self._session
        facts = {**asdict(self._meter.read()), "failure": session.failure, "seed": session.services.seed}
        if self._playback is not None:
            facts |= self._playback.facts()
        wanted = set(self._viewers.graphs.values())
        runs = [run for run in session.graphs if run.name in wanted]
        values = {run.name: values_of(run) for run in runs}
        layers = self._layers.read(self._viewers.layers, now, session.clock.frame)
        selected = set(self._viewers.robots.values())
        robots = with_joints(session, states_of(session, selected))
        return LiveState(facts, poses, layers, values, self._costs.since_last(session.ticks, runs), robots)
