"""A running simulation: the tick, its pace, and play, pause, step, stop, reset."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from typing import Literal, Protocol

from graphengine.diagnostics import GraphError, TransportError, UsageError
from graphengine.graph_run import GraphRun
from graphengine.node_context import Services
from graphengine.simulation_clock import SimulationClock
from graphengine.spec import RobotUse

SessionState = Literal["stopped", "playing", "paused"]


class Roster(Protocol):
    """Puts robots into a running session and takes them out; between two ticks."""

    def add(self, name: str, use: RobotUse) -> Sequence[GraphRun]:
        """A robot, and its graphs, set up."""

    def remove(self, name: str, graphs: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Take a robot away; which of the session's graphs were its own."""


class Inbox(Protocol):
    """What comes into a session from outside beside messages: a recorder takes it down, a replay brings it again."""

    @property
    def exact(self) -> bool:
        """Whether a tick waits for its pictures at any pace, so that another run gets the same."""

    def begin_tick(self) -> float:
        """The wall clock (s since 1970) that nodes read in the tick which begins."""

    def end_tick(self) -> None:
        """A tick is over, and its messages were sent."""


class LiveInbox:
    """The wall clock of this machine."""

    exact = False

    def begin_tick(self) -> float:
        """The time."""
        return time.time()

    def end_tick(self) -> None:
        """Nothing is kept."""


class Session:
    """Owns world, network and graphs.

    One thread runs all of it, and no method is for any other: who is in another leaves word for `on_tick` to find. Within a
    tick a session refuses to step, to stop, and to take robots in or out.

    Args:
        services: what the nodes' contexts share.
        clock: of the ticks.
        step_clock: of the physics steps inside of a tick.
        graphs: in the order they run: the scene's, then each robot's.
        roster: who adds and removes robots; None where there is no scene.
    """

    def __init__(
        self,
        services: Services,
        clock: SimulationClock,
        step_clock: SimulationClock,
        graphs: Sequence[GraphRun],
        roster: Roster | None = None,
    ) -> None:
        self.services = services
        self.clock = clock
        self.step_clock = step_clock
        self.graphs: list[GraphRun] = []
        self.state: SessionState = "stopped"
        self.inbox: Inbox = LiveInbox()
        """Where what comes from outside is read, or was; to be exchanged before the first tick."""
        self._roster = roster
        self._within_tick = False
        self._take(graphs)

    def _take(self, graphs: Sequence[GraphRun]) -> None:
        self.graphs = list(graphs)
        self._on_tick = [run.executor for run in graphs if not run.on_physics_step]
        self._on_step = [run.executor for run in graphs if run.on_physics_step]

    def spawn(self, name: str, use: RobotUse) -> None:
        """Put a robot into the scene, between two ticks: time goes on, what others do and publish stays as it is.

        Its graphs run after those that are there. On `stop` it goes back to where it was put.

        Args:
            name: in the scene, as a scene file's key would be.
            use: as in a scene file; one robot.

        Raises:
            CheckError: with all that is wrong with it.
            GraphError: physics, rays or one of its nodes cannot begin. After an error of any kind all is as it was.
            UsageError: the session has no scene, or is within a tick.
        """
        self._refuse_within_tick()
        if self._roster is None:
            raise UsageError("a session without a scene has no place for robots")
        self._take([*self.graphs, *self._roster.add(name, use)])

    def remove(self, name: str) -> None:
        """Take a robot, its graphs and its topics away, between two ticks; time and the others' state stay.

        Raises:
            UsageError: there is no such robot, a graph that is not its own reads something of it, or within a tick.
        """
        self._refuse_within_tick()
        if self._roster is None:
            raise UsageError("a session without a scene has no robots")
        gone = [id(run) for run in self._roster.remove(name, self.graphs)]
        self._take([run for run in self.graphs if id(run) not in gone])

    @property
    def time(self) -> float:
        """Seconds of simulation since play."""
        return self.clock.time

    def play(self) -> None:
        """Let ticks run."""
        self.state = "playing"

    def pause(self) -> None:
        """Hold; `step` still runs single ticks."""
        if self.state == "playing":
            self.state = "paused"

    def step(self, ticks: int = 1) -> None:
        """Run single ticks; a stopped session is paused first.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        self._refuse_within_tick()
        if self.state == "stopped":
            self.state = "paused"
        for _ in range(ticks):
            self._tick()

    def _refuse_within_tick(self) -> None:
        if self._within_tick:
            raise UsageError("a session can be asked for this between two ticks only, as from `on_tick`")

    def _tick(self) -> None:
        services, world = self.services, self.services.world
        self._within_tick = True
        try:
            self._freeze()
            frame = self.clock.frame + 1
            for substep in range(world.substeps):
                world.step()
                if self._on_step:
                    self.step_clock.set_frame((frame - 1) * world.substeps + substep + 1)
                    for executor in self._on_step:
                        executor.run_pass()
                        executor.run_latent()
            self.clock.set_frame(frame)
            world.begin_tick(frame)
            for executor in self._on_tick:
                executor.run_pass()
            for executor in self._on_tick:
                executor.run_latent()
            services.network.flush()
            self.inbox.end_tick()
        except GraphError as error:
            world.zero_commands()
            self.state = "paused"
            services.network.log("error", str(error))
            with contextlib.suppress(TransportError):
                services.network.flush()
            raise
        finally:
            self._within_tick = False

    def _freeze(self) -> None:
        """What has arrived before a tick is what the tick sees."""
        self.clock.wall_time = self.step_clock.wall_time = self.inbox.begin_tick()
        self.services.network.freeze()
        for mailbox in self.services.mailboxes.values():
            mailbox.freeze()
        for run in self.graphs:
            for variable in run.variables.values():
                variable.freeze()

    def stop(self) -> None:
        """Back to time 0: commands zero, world at its start, outputs and state at their defaults."""
        self._refuse_within_tick()
        self.state = "stopped"
        self.services.world.zero_commands()
        self.services.world.reset()
        for run in self.graphs:
            run.executor.stop()
            for variable in run.variables.values():
                variable.clear()
        for mailbox in self.services.mailboxes.values():
            mailbox.clear()
        for path in self.services.generators:
            self.services.reseed(path)
        for product in self.services.render_products.values():
            product.reset()
        self.clock.stop()
        self.step_clock.stop()

    def reset(self) -> None:
        """Stop, then go on as before."""
        state = self.state
        self.stop()
        self.state = state

    def run(
        self,
        seconds: float | None = None,
        pace: float | None = None,
        on_tick: Callable[[Session], bool] | None = None,
    ) -> None:
        """Play for some time of simulation.

        Args:
            seconds: how long; None for ever.
            pace: seconds of simulation in a second of wall time; None for as fast as possible.
            on_tick: called after each tick; returning False ends the run.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        self._refuse_within_tick()
        self.play()
        self.services.world.realtime = pace is not None and not self.inbox.exact
        first = self.clock.frame
        ticks = None if seconds is None else round(seconds / self.clock.delta)
        pacer = Pacer(self.clock.delta / pace) if pace else None
        while self.state == "playing" and (ticks is None or self.clock.frame - first < ticks):
            self._tick()
            if on_tick is not None and not on_tick(self):
                break
            if pacer is not None:
                pacer.wait()

    def close(self) -> None:
        """Leave the network and release the world; safe to call twice."""
        for run in self.graphs:
            run.close()
        self.services.network.close()
        self.services.world.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Pacer:
    """Absolute deadlines; what is more than five periods late starts a new count instead of a race to catch up."""

    PATIENCE = 5

    def __init__(self, period: float) -> None:
        self.period = period
        self.late = 0
        """How often a deadline had passed before it was waited for."""
        self._deadline = time.perf_counter() + period

    def wait(self) -> None:
        """Sleep until the next deadline."""
        now = time.perf_counter()
        remaining = self._deadline - now
        if remaining > 0:
            time.sleep(remaining)
        else:
            self.late += 1
            if -remaining > self.PATIENCE * self.period:
                self._deadline = now
        self._deadline += self.period
