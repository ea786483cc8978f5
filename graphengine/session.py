"""A running simulation: the tick, its pace, and play, pause, step, stop, reset."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from graphengine.diagnostics import GraphError, NodeError
from graphengine.executor import Executor
from graphengine.node_context import GraphVariable, Services, SimulationClock

SessionState = Literal["stopped", "playing", "paused"]


@dataclass(slots=True)
class GraphRun:
    """A graph of the session, and its variables."""

    executor: Executor
    variables: dict[str, GraphVariable]
    on_physics_step: bool = False


class Session:
    """Owns world, network and graphs; one thread runs all of it.

    Args:
        services: what the nodes' contexts share.
        clock: of the ticks.
        step_clock: of the physics steps inside of a tick.
        graphs: in the order they run: the scene's, then each robot's.
    """

    def __init__(
        self, services: Services, clock: SimulationClock, step_clock: SimulationClock, graphs: Sequence[GraphRun]
    ) -> None:
        self.services = services
        self.clock = clock
        self.step_clock = step_clock
        self.graphs = list(graphs)
        self.state: SessionState = "stopped"
        self._on_tick = [run.executor for run in graphs if not run.on_physics_step]
        self._on_step = [run.executor for run in graphs if run.on_physics_step]

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
        if self.state == "stopped":
            self.state = "paused"
        for _ in range(ticks):
            self._tick()

    def _tick(self) -> None:
        services, world = self.services, self.services.world
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
        except GraphError as error:
            world.zero_commands()
            self.state = "paused"
            services.network.log("error", str(error))
            raise

    def _freeze(self) -> None:
        """What has arrived before a tick is what the tick sees."""
        self.clock.wall_time = self.step_clock.wall_time = time.time()
        self.services.network.freeze()
        for mailbox in self.services.mailboxes.values():
            mailbox.freeze()
        for run in self.graphs:
            for variable in run.variables.values():
                variable.freeze()

    def stop(self) -> None:
        """Back to time 0: commands zero, world at its start, outputs and state at their defaults."""
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
        self.play()
        self.services.world.realtime = pace is not None
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
            run.executor.close()
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


FaultListener = Callable[[NodeError], None]
