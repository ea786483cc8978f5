"""Robots that come and go while a session runs."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from graphengine.compiler.graph import Graph
from graphengine.compiler.literals import Override
from graphengine.compiler.namespaces import write_namespaces
from graphengine.compiler.planning import share_plans
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import NodeError, UnknownEntityError, UsageError
from graphengine.format.files import Files
from graphengine.format.spec import RobotUse
from graphengine.format.wording import did_you_mean, listing
from graphengine.node.clock import Clock
from graphengine.node.context.services import Services
from graphengine.runtime import check
from graphengine.runtime.graph_run import GraphRun, make_graph_run
from graphengine.runtime.session import Roster
from graphengine.scene.loaded_scene import LoadedScene
from graphengine.scene.uses import resolve_uses, robot_uses

if TYPE_CHECKING:
    from graphengine.physics.loading import LoadedWorld
    from graphengine.physics.model.robot import Robot


class SceneRoster(Roster):
    """The robots of a session that was built from a scene.

    Args:
        scene: that the session was made from.
        world: the session's own; robots are added to it and removed from it.
        files: where the references of robots that come may lead.
        services: of the session.
        clocks: of its ticks and of its physics steps, by what graphs run on.
        fault: who hears of nodes that raise.
    """

    def __init__(
        self,
        scene: LoadedScene,
        world: LoadedWorld,
        files: Files,
        services: Services,
        clocks: Mapping[str, Clock],
        fault: Callable[[NodeError], None] | None,
    ) -> None:
        from graphengine.physics.population import Population  # not before a scene has brought MuJoCo in

        self._scene, self._files = scene, files
        self._robots, self._specified = world.robots, world.scenery.scene
        self._population = Population(world)
        self._services = services
        self._clocks = clocks
        self._fault = fault

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the robots that came and are still there, oldest first."""
        stage = self._services.stage
        return [name for name, robot in self._robots.items() if stage.find(robot.prim_path).facts.get("spawned")]

    def add(self, name: str, use: RobotUse, running: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Put a robot into the scene; its graphs, set up.

        Raises:
            CheckError: with all that is wrong with it.
            GraphError: physics, rays or one of its nodes cannot begin. After an error of any kind all is as it was.
        """
        self._population.add(name, use, Findings())
        return self._begin(name, running)

    def _begin(self, name: str, running: Sequence[GraphRun]) -> list[GraphRun]:
        """The graphs of a robot that was put into the world, set up; after an error the robot is gone again."""
        runs: list[GraphRun] = []
        try:
            graphs = self._plan(name, running)
            for graph in graphs:
                runs.append(make_graph_run(graph, self._services, self._clocks[graph.runs], self._fault))
                runs[-1].executor.setup()
        except BaseException:
            self._dismiss(name, runs)
            raise
        return runs

    def _plan(self, name: str, running: Sequence[GraphRun]) -> list[Graph]:
        """A robot's graphs, planned and checked beside those that run."""
        scene, services, findings = self._scene, self._services, Findings()
        robot, files = self._robots[name], self._files
        uses = robot_uses(robot, services.stage, files, findings, robot_state=scene.options.robot_state)
        overrides = Override.parse_all(scene.options.overrides)
        graphs = share_plans(resolve_uses(uses, files, scene.registry, findings, overrides), findings)
        findings.raise_errors()
        write_namespaces(self._specified, services.stage, graphs, findings, within=robot.prim_path)
        check.check_graphs(
            graphs,
            services.world,
            findings,
            prims_known=True,
            beside=[run.executor.graph for run in running],
            claimed=services.claims,
            permissions=services.permissions,
        )
        findings.raise_errors()
        return graphs

    def own(self, name: str, graphs: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Which of the session's graphs are a robot's, which can be removed.

        Raises:
            UnknownEntityError: there is no such robot.
            UsageError: a graph that is not its own reads something of it.
        """
        if name not in self._robots:
            near = did_you_mean(name, self._robots) or listing(self._robots, "robots")
            raise UnknownEntityError(f"no robot {name!r}\n  {near}")
        own = [run for run in graphs if _belongs(run.name, name)]
        for run in graphs:
            reader = None if run in own else run.contexts.bound(self._robots[name].prim_path)
            if reader is not None:
                raise UsageError(f"{name} cannot be removed: {reader} of graph {run.name} reads something of it")
        return own

    def remove(self, name: str, own: Sequence[GraphRun]) -> None:
        """Take a robot away, with its graphs and topics."""
        self._dismiss(name, own)

    def save(self) -> Sequence[tuple[Robot, bool]]:
        """The robots in their order, and which of them came while the session ran."""
        return [(robot, name in self.spawned) for name, robot in self._robots.items()]

    def restore(self, saved: Sequence[tuple[Robot, bool]], running: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Put back the robots that were there, and take away the others; the graphs that run then, in their order."""
        pairs = zip(self._robots.values(), saved, strict=False)
        same = sum(1 for _ in itertools.takewhile(lambda pair: pair[0] is pair[1][0], pairs))
        for name in reversed(list(self._robots)[same:]):
            own = self.own(name, running)
            running = [run for run in running if run not in own]
            self.remove(name, own)
        for robot, spawned in saved[same:]:
            self._population.put(robot.placement, Findings())
            self._services.stage.find(robot.prim_path).facts["spawned"] = spawned
            running = [*running, *self._begin(robot.name, running)]
        return running

    def _dismiss(self, name: str, own: Sequence[GraphRun]) -> None:
        """Take a robot away, with its graphs and with what the session keeps for it."""
        for run in own:
            run.close()
        self._services.forget(self._robots[name].prim_path)
        self._population.remove(name)


def _belongs(graph: str, robot: str) -> bool:
    """Whether a graph is a robot's, by its name."""
    return graph.startswith(f"{robot}/")
