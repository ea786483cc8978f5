"""Runs ticks: each steps physics, executes graphs and sends messages. Also sets up, resets, saves and restores their parts."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, Literal

from graphengine.compiler.graph import Graph
from graphengine.devices.backend import World
from graphengine.format.errors import GraphError, PhysicsError, TransportError
from graphengine.format.wording import listing
from graphengine.messages.endpoints import Network
from graphengine.node.clock import Clock
from graphengine.node.context.session_services import Services
from graphengine.node.node_class import Ending
from graphengine.runtime.executor import Executor
from graphengine.runtime.graph_exchange import Succession, unchanged
from graphengine.runtime.graph_run import GraphRun, make_clock, make_graph_run
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.node_faults import FaultHandler
from graphengine.runtime.reloading import Reloaded

ResetScope = Literal["time", "state", "spawned"]
SCOPES: tuple[ResetScope, ...] = ("time", "state", "spawned")
_CLAMPED = {
    "position": "the range stands in the robot description; a gripper that presses at its limit needs overtravel in its drive",
    "velocity": "if the joint can do more, raise max_velocity of its drive, or its limits in the robot description",
    "effort": "if the joint can do more, raise its limit of effort in the robot description",
}
"""Advice for each kind of clamped command."""


class Ticker:
    """Runs the ticks of graphs in a world and on a network, and keeps the clocks that nodes read.

    Args:
        services: world, network and other services that the contexts of all nodes share.
        fault: receives each exception of a node; the tick then continues without the nodes that the failed node would have
            fired. None: an exception of a node ends the tick.
    """

    def __init__(self, services: Services, fault: FaultHandler | None = None) -> None:
        self.services = services
        self.clock = make_clock(services.world)
        """Clock that counts ticks."""
        self.step_clock = make_clock(services.world, on_step=True)
        """Clock that counts physics steps."""
        self.count = 0
        """Number of ticks that have run since the session was created; a stop does not reset this number."""
        self.running = False
        """Whether nodes are being executed, so that the session must not be changed."""
        self._clamped: set[str] = set()
        self._fault = fault
        self._set_graphs(())

    def add(self, graphs: Iterable[Graph]) -> None:
        """Set up graphs and add them; they run after the graphs that were added before.

        Raises:
            GraphError: a node could not be set up; none of the graphs is added.
        """
        runs: list[GraphRun] = []
        try:
            for graph in graphs:
                runs.append(self._make_run(graph))
                runs[-1].executor.setup()
        except BaseException:
            for run in runs:
                run.contexts.close()
            raise
        self._set_graphs([*self.graphs, *runs])

    def _make_run(self, graph: Graph) -> GraphRun:
        clock = self.step_clock if graph.runs == "physics_step" else self.clock
        return make_graph_run(graph, self.services, clock, self._fault)

    def exchange(self, graphs: Sequence[Graph]) -> Reloaded:
        """Replace all running graphs with `graphs`; nodes with the same name and type keep their state.

        An unchanged graph continues. In a removed graph, the events for the graph's end run first, and their messages are sent.

        Raises:
            GraphError: a node could not be set up; the old graphs continue unchanged.
        """
        known = {run.name: run for run in self.graphs}
        generators = self.services.generators
        random = {path: (one, one.bit_generator.state) for path, one in generators.items()}
        runs, successions = list[GraphRun](), list[Succession]()
        with self.services.network.handing_over():
            try:
                for graph in graphs:
                    old = known.get(graph.name)
                    if old is not None and unchanged(old, graph):
                        runs.append(old)
                        continue
                    runs.append(self._make_run(graph))
                    succession = Succession(old, runs[-1]) if old is not None else None
                    for path in succession.new_paths if succession is not None else runs[-1].paths:
                        generators.pop(path, None)
                    if succession is None:
                        runs[-1].executor.setup()
                    else:
                        successions.append(succession)
                        succession.set_up()
            except BaseException:
                for run in [run for run in runs if run not in self.graphs]:
                    run.contexts.close(random)
                generators |= {path: one for path, (one, _) in random.items()}
                for one, state in random.values():
                    one.bit_generator.state = state
                raise
        return self._take_over(graphs, runs, successions)

    def _take_over(
        self, graphs: Sequence[Graph], runs: Sequence[GraphRun], successions: Sequence[Succession]
    ) -> Reloaded:
        """Replace the running graphs with new runs that are already set up, and close the old runs.

        Args:
            graphs: the new graphs.
            runs: the run of each new graph; for an unchanged graph, its old run.
            successions: transfers of state to the changed graphs.
        """
        names, before = {graph.name for graph in graphs}, self.graphs
        gone = [run for run in before if run.name not in names]
        self.tell("at_close", gone)
        for run, graph in zip(runs, graphs, strict=True):
            run.describe_as(graph)
        self._set_graphs(runs)
        self.close([run for run in before if run not in runs])
        changed = tuple(succession.name for succession in successions)
        return Reloaded(
            changed=changed,
            added=tuple(run.name for run in runs if run not in before and run.name not in changed),
            removed=tuple(run.name for run in gone),
            kept=sum(succession.kept for succession in successions),
            nodes=sum(succession.nodes for succession in successions),
        )

    def close(self, runs: Iterable[GraphRun]) -> None:
        """Close graphs that were replaced or removed; log errors, such as an exception in a script's cleanup."""
        heirs = {context.prim_path for run in self.graphs for _, context in run.contexts}
        for run in runs:
            try:
                run.contexts.close(heirs)
            except Exception as error:
                self.services.log("error", "", f"graph {run.name} could not be closed: {error}")

    def remove(self, runs: Collection[GraphRun]) -> None:
        """Close graphs, and no longer run them in ticks."""
        for run in runs:
            run.contexts.close()
        self._set_graphs([run for run in self.graphs if run not in runs])

    def _set_graphs(self, runs: Sequence[GraphRun]) -> None:
        self.graphs = runs
        """Graphs in execution order: the scene's, then each robot's."""
        self._on_tick = [run.executor for run in runs if not run.on_physics_step]
        self._variables = [variable for run in runs for variable in run.variables.values()]
        self._on_step = [run.executor for run in runs if run.on_physics_step]

    def run(self, inbox: ExternalInputs) -> None:
        """Run one tick; after an error, the joint commands are zero.

        Args:
            inbox: source of the wall clock time; the end of the tick calls its `end_tick`.

        Raises:
            NodeError: a node raised an exception.
            PhysicsError: the simulation diverged.
        """
        services, world = self.services, self.services.world
        self.running = True
        try:
            self._freeze(inbox)
            frame = self.clock.frame + 1
            for substep in range(world.substeps):
                try:
                    world.step()
                except PhysicsError as error:
                    self._put_back(error)
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

    def _put_back(self, error: PhysicsError) -> None:
        """Reset a world that diverged after a command had moved or pushed a body; for other worlds, raise the error."""
        dropped = self.services.dropped
        if not self.services.disturbed or dropped is None or not dropped.drops_set_values:
            raise error
        self.begin_anew("state")
        what = str(error).partition("\n")[0]
        why = "the world is back in its initial state, because a command had moved or pushed a body"
        self.services.warn("", f"{what}\n  {why}")

    def _warn_of_clamped(self) -> None:
        """Log one warning for each kind of command, with the joints whose commands were clamped for the first time."""
        clamped = self.services.world.clamped_commands
        if len(clamped) == len(self._clamped):
            return
        new = [command for command in clamped if command not in self._clamped]
        self._clamped.update(new)
        for kind, advice in _CLAMPED.items():
            commands = [command for command in new if command.startswith(kind)]
            if commands:
                self.services.warn("", f"{listing(commands, 'commands are clamped', most=4)}\n  {advice}")

    def _freeze(self, inbox: ExternalInputs) -> None:
        """Fix the inputs that nodes read in this tick: wall clock, messages, keys, queues and variables.

        Nodes get all later inputs in the next tick.
        """
        self.clock.wall_time = self.step_clock.wall_time = inbox.begin_tick()
        self.services.network.freeze()
        self.services.keys.freeze()
        for queue in self.services.queues.values():
            queue.freeze()
        for variable in self._variables:
            variable.freeze()

    def save(self) -> Any:
        """Return a copy of the state of clocks, world, network and graphs."""
        return [part.save() for part in self._parts()], {run.name: run.save() for run in self.graphs}

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned while the same graphs were running; `count` continues.

        Raises:
            GraphError: a node that was set up after `save` cannot be set up again with its saved inputs.
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
        """Run the events for the end of play (`at_stop`) or of graphs (`at_close`), and send their messages.

        After an error, which is logged, the other graphs continue.
        """
        self._between_ticks(lambda executor: executor.run_ending(ending), graphs)

    def announce_time(self, *, restored: bool) -> None:
        """Let the nodes of all graphs announce the simulation time after a jump, and send their messages.

        `restored` has the same meaning as for `Executor.announce_time`.
        """
        self._between_ticks(lambda executor: executor.announce_time(restored=restored), self.graphs)

    def _between_ticks(self, act: Callable[[Executor], None], graphs: Sequence[GraphRun]) -> None:
        services = self.services
        self.running = True
        try:
            for run in graphs:
                try:
                    act(run.executor)
                except GraphError as error:
                    services.log("error", "", str(error))
                    services.network.log("error", str(error))
            services.network.flush()
        finally:
            self.running = False

    def reseed(self, seed: int) -> None:
        """Restart all random generators with a seed; the noise of sensors changes with their next samples."""
        services = self.services
        services.seed = services.world.seed = seed
        for path in services.generators:
            services.reseed(path)

    def begin_anew(self, *scopes: ResetScope, seed: int | None = None) -> None:
        """Reset parts of the session.

        Args:
            scopes: `state` resets bodies and joints; `time` resets joint commands, clocks, sensors and graphs.
            seed: new seed of all random generators; None: the seed stays.
        """
        services, world = self.services, self.services.world
        if "time" in scopes:
            world.zero_commands()
        if "state" in scopes:
            services.disturbed = False
            world.reset_state()
        if "time" not in scopes:
            return
        world.reset_time()
        services.forget_calls()
        for run in self.graphs:
            run.executor.stop()
            for variable in run.variables.values():
                variable.clear()
        services.keys.clear()
        for queue in services.queues.values():
            queue.clear()
        self.reseed(services.seed if seed is None else seed)
        for product in services.render_products.values():
            product.reset()
        self.clock.stop()
        self.step_clock.stop()
