"""One tick: step physics, execute graphs, flush messages. Also starts, resets, saves and restores what a tick runs."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, Literal

from graphengine.compiler.graph import Graph
from graphengine.devices.backend import World
from graphengine.format.errors import GraphError, NodeError, TransportError
from graphengine.messages.endpoints import Network
from graphengine.node.clock import Clock
from graphengine.node.context.session_services import Services
from graphengine.node.node_class import Ending
from graphengine.runtime.graph_run import GraphRun, make_clock, make_graph_run
from graphengine.runtime.inbox import ExternalInputs

ResetScope = Literal["time", "state", "spawned"]
SCOPES: tuple[ResetScope, ...] = ("time", "state", "spawned")


class Ticker:
    """Graphs over a world and a network, and the clocks that they run on.

    Args:
        services: what the nodes' contexts share.
        fault: receives each NodeError where a node that raises ends its branch only; None ends the tick.
    """

    def __init__(self, services: Services, fault: Callable[[NodeError], None] | None = None) -> None:
        self.services = services
        self.clock = make_clock(services.world)
        """Of the ticks."""
        self.step_clock = make_clock(services.world, on_step=True)
        """Of the physics steps inside of a tick."""
        self.count = 0
        """Ticks that ran; those before a stop count too."""
        self.running = False
        """Whether nodes are being run."""
        self._clamped: set[str] = set()
        self._fault = fault
        self._set_graphs(())

    def add(self, graphs: Iterable[Graph]) -> None:
        """Set graphs up, to run after the others.

        Raises:
            GraphError: a node could not be set up; none of the graphs is added.
        """
        runs: list[GraphRun] = []
        try:
            for graph in graphs:
                clock = self.step_clock if graph.runs == "physics_step" else self.clock
                runs.append(make_graph_run(graph, self.services, clock, self._fault))
                runs[-1].executor.setup()
        except BaseException:
            for run in runs:
                run.contexts.close()
            raise
        self._set_graphs([*self.graphs, *runs])

    def remove(self, runs: Collection[GraphRun]) -> None:
        """Close graphs and run them no more."""
        for run in runs:
            run.contexts.close()
        self._set_graphs([run for run in self.graphs if run not in runs])

    def _set_graphs(self, runs: Sequence[GraphRun]) -> None:
        self.graphs = runs
        """In the order they run: the scene's, then each robot's."""
        self._on_tick = [run.executor for run in runs if not run.on_physics_step]
        self._variables = [variable for run in runs for variable in run.variables.values()]
        self._on_step = [run.executor for run in runs if run.on_physics_step]

    def run(self, inbox: ExternalInputs) -> None:
        """One tick.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        services, world = self.services, self.services.world
        self.running = True
        try:
            self._freeze(inbox)
            frame = self.clock.frame + 1
            for substep in range(world.substeps):
                world.step()
                if self._on_step:
                    self.step_clock.set_frame((frame - 1) * world.substeps + substep + 1)
                    for executor in self._on_step:
                        executor.run_pass()
                        executor.run_latent()
            self.clock.set_frame(frame)
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
        clamped = self.services.world.clamped_commands
        if len(clamped) != len(self._clamped):
            for command in [command for command in clamped if command not in self._clamped]:
                self._clamped.add(command)
                advice = "a joint that can do more needs a wider <limit> in its description"
                self.services.warn("", f"commands are clamped: {command}\n  {advice}")

    def _freeze(self, inbox: ExternalInputs) -> None:
        """What has arrived before a tick is what the tick sees."""
        self.clock.wall_time = self.step_clock.wall_time = inbox.begin_tick()
        self.services.network.freeze()
        self.services.keys.freeze()
        for queue in self.services.queues.values():
            queue.freeze()
        for variable in self._variables:
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
        services = self.services
        return self.clock, self.step_clock, services.world, services.network, services

    def tell(self, ending: Ending, graphs: Sequence[GraphRun]) -> None:
        """Let graphs do what they have for an ending, and send what comes of it; one that fails ends for itself alone."""
        services = self.services
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

    def begin_anew(self, *scopes: ResetScope, seed: int | None = None) -> None:
        """The world as at the start; with `time` also clocks and graphs as before the first tick; `seed` replaces the seed."""
        services, world = self.services, self.services.world
        if seed is not None:
            services.seed = world.seed = seed
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
        self.clock.stop()
        self.step_clock.stop()
