"""A tick: physics, then graphs, then what they send; and what takes all of it back to its beginning."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Any, Literal

from graphengine.devices.backend import World
from graphengine.format.errors import GraphError, TransportError
from graphengine.messages.endpoints import Network
from graphengine.node.clock import Clock
from graphengine.node.context.services import Services
from graphengine.node.node_class import Ending
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.inbox import Inbox

ResetScope = Literal["time", "state", "spawned"]
SCOPES: tuple[ResetScope, ...] = ("time", "state", "spawned")


class Ticker:
    """Runs graphs over a world and a network, tick by tick.

    Args:
        services: what the nodes' contexts share.
        clock: of the ticks.
        step_clock: of the physics steps inside of a tick.
        graphs: in the order they run.
    """

    def __init__(self, services: Services, clock: Clock, step_clock: Clock, graphs: Sequence[GraphRun]) -> None:
        self.count = 0
        """Ticks that ran; those before a stop count too."""
        self.running = False
        """Whether nodes are being run."""
        self._clamped: set[str] = set()
        self._services = services
        self._clock = clock
        self._step_clock = step_clock
        self.take(graphs)

    def take(self, graphs: Sequence[GraphRun]) -> None:
        """Run other graphs, between two ticks."""
        self.graphs: Sequence[GraphRun] = list(graphs)
        self._on_tick = [run.executor for run in graphs if not run.on_physics_step]
        self._on_step = [run.executor for run in graphs if run.on_physics_step]

    def run(self, inbox: Inbox) -> None:
        """One tick.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        services, world = self._services, self._services.world
        self.running = True
        try:
            self._freeze(inbox)
            frame = self._clock.frame + 1
            for substep in range(world.substeps):
                world.step()
                if self._on_step:
                    self._step_clock.set_frame((frame - 1) * world.substeps + substep + 1)
                    for executor in self._on_step:
                        executor.run_pass()
                        executor.run_latent()
            self._clock.set_frame(frame)
            self.count += 1
            world.begin_tick(frame)
            for executor in self._on_tick:
                executor.run_pass()
            for executor in self._on_tick:
                executor.run_latent()
            self._warn_of_clamped()
            services.network.flush()
            inbox.end_tick()
        except GraphError as error:
            world.zero_commands()
            services.network.log("error", str(error))
            with contextlib.suppress(TransportError):
                services.network.flush()
            raise
        finally:
            self.running = False

    def _warn_of_clamped(self) -> None:
        """Warn once of each joint that was commanded beyond its limits."""
        clamped = self._services.world.clamped_commands
        if len(clamped) != len(self._clamped):
            for command in [command for command in clamped if command not in self._clamped]:
                self._clamped.add(command)
                advice = "a joint that can do more needs a wider <limit> in its description"
                self._services.warn("", f"commands are clamped: {command}\n  {advice}")

    def _freeze(self, inbox: Inbox) -> None:
        """What has arrived before a tick is what the tick sees."""
        self._clock.wall_time = self._step_clock.wall_time = inbox.begin_tick()
        self._services.network.freeze()
        self._services.keys.freeze()
        for queue in self._services.queues.values():
            queue.freeze()
        for run in self.graphs:
            for variable in run.variables.values():
                variable.freeze()

    def save(self) -> Any:
        """A copy of the state of clocks, world, network and graphs."""
        return [part.save() for part in self._parts()], {run.name: run.save() for run in self.graphs}

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned while the same graphs were there; ticks count on.

        Raises:
            GraphError: a node that was set up again since cannot be set up as it was.
        """
        states, graphs = saved
        for run in self.graphs:
            run.restore(graphs[run.name])
        for part, state in zip(self._parts(), states, strict=True):
            part.restore(state)

    def _parts(self) -> Sequence[Clock | World | Services | Network]:
        services = self._services
        return self._clock, self._step_clock, services.world, services.network, services

    def tell(self, ending: Ending, graphs: Sequence[GraphRun]) -> None:
        """Let graphs do what they have for an ending, and send what comes of it; one that fails ends for itself alone."""
        services = self._services
        self.running = True
        try:
            for run in graphs:
                try:
                    run.executor.run_ending(ending)
                except GraphError as error:
                    services.log("error", "", str(error))
                    services.network.log("error", str(error))
            services.network.flush()
        finally:
            self.running = False

    def begin_anew(self, *scopes: ResetScope) -> None:
        """The world as at the start; with `time` also clocks and graphs as before the first tick."""
        services, world = self._services, self._services.world
        if "time" in scopes:
            world.zero_commands()
        if "state" in scopes:
            world.reset_state()
        if "time" not in scopes:
            return
        world.reset_time()
        services.network.forget_calls()
        for run in self.graphs:
            run.executor.stop()
            for variable in run.variables.values():
                variable.clear()
        services.keys.clear()
        for queue in services.queues.values():
            queue.clear()
        for path in services.generators:
            services.reseed(path)
        for product in services.render_products.values():
            product.reset()
        self._clock.stop()
        self._step_clock.stop()
