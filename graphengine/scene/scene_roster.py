"""Adds robots to a running session and removes them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from graphengine.compiler.graph import Graph
from graphengine.compiler.literals import Override
from graphengine.compiler.namespaces import write_namespaces
from graphengine.compiler.planning import share_plans
from graphengine.devices.entity import refuse
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UnknownEntityError, UsageError
from graphengine.format.files import Files
from graphengine.format.spec import RobotUse
from graphengine.format.wording import unknown
from graphengine.messages.endpoints import EndpointClaim
from graphengine.node.context.session_services import Services
from graphengine.runtime import check
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.node_faults import FaultHandler
from graphengine.runtime.roster import Roster
from graphengine.runtime.ticker import Ticker
from graphengine.scene.graph_loading import resolve_uses, robot_uses
from graphengine.scene.loaded_scene import LoadedScene

if TYPE_CHECKING:
    from graphengine.physics.loaded_world import LoadedWorld
    from graphengine.physics.model.robot import RobotInstance


def begin(
    scene: LoadedScene, world: LoadedWorld | None, files: Files, services: Services, fault: FaultHandler | None
) -> tuple[Ticker, Roster]:
    """Set up the graphs of a scene; return the ticker that runs them and the roster that adds and removes robots.

    Args:
        scene: scene without errors.
        world: world of the session; None for a graph without a scene.
        files: folders from which files of robots may be read.
        services: services of the session, with the same world.
        fault: function called with each NodeError, as for `Ticker`; None lets a NodeError end the run.

    Raises:
        GraphError: a node could not be set up.
    """
    ticker = Ticker(services, fault)
    ticker.add(scene.planned)
    return ticker, SceneRoster(scene, world, files, ticker) if world is not None else Roster()


class SceneRoster(Roster):
    """The robots of a session with a scene; adds and removes robots.

    Args:
        scene: scene of the session.
        world: world of the session, in which robots are added and removed.
        files: folders from which files of robots may be read.
        ticker: ticker that runs the robots' graphs.
    """

    def __init__(self, scene: LoadedScene, world: LoadedWorld, files: Files, ticker: Ticker) -> None:
        self._files = files
        self._ticker, self._services = ticker, ticker.services
        self.follow(scene, world)

    def follow(self, scene: LoadedScene, world: LoadedWorld) -> None:
        """Use a new version of the scene for robots that are added later; both versions must have equal worlds."""
        self._scene, self._robots = replace(scene, files=self._files), world.robots
        self.world = world
        """World of the session with its current robots."""
        world.scenery.library.files = self._files

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the spawned robots that still exist, oldest first."""
        stage = self._services.stage
        return [name for name, robot in self._robots.items() if stage.find(robot.prim_path).facts.get("spawned")]

    @property
    def uses(self) -> Mapping[str, str]:
        """Robot file or description of each robot by name, as in the key `use` of a scene file."""
        return {name: robot.placement.use.use for name, robot in self._robots.items()}

    def add(self, name: str, use: RobotUse, *, forced: bool = True) -> None:
        """Add a robot to the world, and set up its graphs, which run after all other graphs; see `Roster.add`."""
        self.world.add(name, use)
        beside = [run.executor.graph for run in self._ticker.graphs]
        claims = self._services.claims

        def plan() -> Sequence[Graph]:
            graphs = self.plan(self._robots[name], self._scene, beside, claims)
            if not forced:
                refuse(name, self._services.world.entities.overlaps(name, floors=False))
            return graphs

        self._begin(name, plan)

    def _begin(self, name: str, plan: Callable[[], Sequence[Graph]]) -> None:
        """Set up the graphs of a robot that is already in the world; after an error, remove the robot again."""
        try:
            self._ticker.add(plan())
        except BaseException:
            self._dismiss(name, ())
            raise

    def plan(
        self, robot: RobotInstance, scene: LoadedScene, beside: Sequence[Graph], claimed: Sequence[EndpointClaim]
    ) -> list[Graph]:
        """Return a robot's graphs, planned and checked.

        Args:
            robot: robot in the world; it may have a new description.
            scene: scene whose options, files and message types apply.
            beside: graphs that run before the robot's graphs.
            claimed: topics and services that the graphs in `beside` use.

        Raises:
            CheckError: a graph has errors.
        """
        services, findings = self._services, Findings()
        scene = replace(scene, findings=findings)
        overrides = Override.parse_all(scene.options.overrides)
        uses = robot_uses(robot, services.stage, scene)
        graphs = share_plans(resolve_uses(uses, scene, overrides), findings)
        findings.raise_errors()
        assert scene.world is not None
        write_namespaces(scene.world.scenery.scene, services.stage, graphs, findings, within=robot.prim_path)
        check.check_graphs(
            graphs,
            services.world,
            findings,
            prims_known=True,
            beside=beside,
            claimed=claimed,
            permissions=services.permissions,
        )
        findings.raise_errors()
        return graphs

    def remove(self, name: str) -> None:
        """Remove a robot, its graphs and its topics, after the robot's graphs have run their closing events."""
        own = self._own(name)
        self._ticker.tell("at_close", own)
        self._dismiss(name, own)

    def _own(self, name: str) -> Sequence[GraphRun]:
        """Check that a robot can be removed, and return the graphs of the robot.

        Raises:
            UnknownEntityError: no robot has the name.
            UsageError: a node of another graph uses the robot.
        """
        if name not in self._robots:
            raise UnknownEntityError(unknown("robot", name, self._robots))
        graphs = self._ticker.graphs
        own = [run for run in graphs if run.name.startswith(f"{name}/")]
        for run in graphs:
            reader = None if run in own else run.contexts.bound(self._robots[name].prim_path)
            if reader is not None:
                raise UsageError(f"{name} cannot be removed: {reader} of graph {run.name} uses the robot")
        return own

    def save(self) -> Sequence[tuple[RobotInstance, bool, Sequence[Graph]]]:
        """Return a tuple for each robot: the robot, whether the robot was spawned, and the robot's graphs."""
        graphs = [run.executor.graph for run in self._ticker.graphs]
        return [
            (robot, name in self.spawned, [graph for graph in graphs if graph.name.startswith(f"{name}/")])
            for name, robot in self._robots.items()
        ]

    def restore(self, saved: Sequence[tuple[RobotInstance, bool, Sequence[Graph]]]) -> None:
        """Add and remove robots until the session has the robots that `save` returned."""
        pairs = zip(self._robots.values(), saved, strict=False)
        same = sum(1 for _ in itertools.takewhile(lambda pair: pair[0] is pair[1][0], pairs))
        for name in reversed(list(self._robots)[same:]):
            self._dismiss(name, self._own(name))
        stage = self._services.stage
        for robot, spawned, graphs in saved[same:]:
            self.world.put(robot.placement)
            stage.find(robot.prim_path).facts["spawned"] = spawned
            scene, path = self.world.scenery.scene, robot.prim_path
            write_namespaces(scene, stage, graphs, Findings(), within=path)
            self._begin(robot.name, partial(list, graphs))

    def _dismiss(self, name: str, own: Sequence[GraphRun]) -> None:
        """Remove a robot, its graphs, and the data that the session keeps for it."""
        self._ticker.remove(own)
        self._services.forget(self._robots[name].prim_path)
        self.world.remove(name)
