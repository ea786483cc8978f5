"""Reloads changed files of a running session: replaces the graphs, or restarts the session with a new world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.compiler.graph import Graph
from graphengine.devices.backend import World
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format.errors import UsageError
from graphengine.format.files import Files, Signature
from graphengine.node.context.session_services import Services
from graphengine.runtime.addresses import NodePort
from graphengine.runtime.node_faults import FaultHandler
from graphengine.runtime.reloading import Reloaded, Reloader
from graphengine.runtime.roster import Roster
from graphengine.runtime.session_core import SessionCore
from graphengine.runtime.ticker import Ticker
from graphengine.scene.loaded_scene import LoadedScene
from graphengine.scene.scene_roster import SceneRoster, begin
from graphengine.scene.value_edits import Change, ValueEdits

if TYPE_CHECKING:
    from graphengine.physics.loaded_world import LoadedWorld
    from graphengine.physics.model.scenery import Scenery

MAX_READINGS = 5
"""Maximum number of attempts to read the files if they change while they are read."""

LoadAgain = Callable[[LoadedScene], LoadedScene]
"""A function that loads the current version of a scene's files, and returns the new scene."""


class SceneReloader(Reloader):
    """Reloads the scene of a session.

    The session runs the old scene until the new scene is loaded and checked, and changes only if the new scene has no errors.

    Args:
        session: session that runs the scene.
        scene: scene that the session runs.
        files: the session's record of the files that were read; each reload updates the record.
        load_again: loads the scene again from its files.
        fault: called with each NodeError, as for `Ticker`; None lets a NodeError end the run.
    """

    def __init__(
        self, session: SessionCore, scene: LoadedScene, files: Files, load_again: LoadAgain, fault: FaultHandler | None
    ) -> None:
        self._session = session
        self.scene, self._files = scene, files
        """The scene that the session runs, and the record of the scene's files."""
        self._load_again, self._fault = load_again, fault
        self._read = files
        """The files that the last reload read, even if the reload failed; these files are watched for changes."""
        self._edits = ValueEdits(session.reload)

    def propose_value(self, port: NodePort, value: Any) -> Change:
        """Return the change of a file that writes a value of an input."""
        return self._edits.propose_value(self.scene, self._files, port, value)

    def propose_position(self, graph: Graph, node: str, at: Sequence[float]) -> Change:
        """Return the change of a graph file that writes the position of a node in drawings."""
        return self._edits.propose_position(self.scene, self._files, graph, node, at)

    def write(self, change: Change) -> None:
        """Write a proposed change, and reload."""
        self._edits.write(change)

    def undo(self) -> Change:
        """Take back the newest change and return it."""
        return self._edits.undo()

    def redo(self) -> Change:
        """Write the change that was undone last, and return it."""
        return self._edits.redo()

    def watched(self) -> Mapping[Path, Signature]:
        """Return the signature of each file that the last reload read or did not find, from before the reading. Thread-safe."""
        return self._read.noted()

    def save(self) -> tuple[LoadedScene, Files, Scenery | None]:
        """Return the scene that the session runs, the record of its files, and the descriptions of all current robots."""
        roster = self._session.roster
        scenery = roster.world.scenery if isinstance(roster, SceneRoster) else None
        return self.scene, _copy(self._files), scenery.copy(self._files) if scenery is not None else None

    def restore(self, saved: tuple[LoadedScene, Files, Scenery | None]) -> None:
        """Restore the version of the scene that `save` returned, and restart the session at time 0."""
        scene, files, scenery = saved
        self._session.begin_with(*self._begin(scene, scenery))
        self._take(scene, files)

    def reload(self) -> Reloaded:
        """Read the files again, run the changed scene and return what has changed. Call this between two ticks.

        Raises:
            CheckError: the files have errors.
            GraphError: the changed scene cannot start.
            UsageError: the files changed during each attempt to read them, or the graph is only a subgraph.
        """
        session = self._session
        for _ in range(MAX_READINGS):
            fresh = self._load_again(self.scene)
            files = self._read = _copy(fresh.files)
            fresh.require_runnable()
            successor = self._successor(fresh, files)
            session.inbox.reading(files)
            if not files.changed():
                break
        else:
            raise UsageError("the files changed while they were read; reload again when all files have been written")
        if successor is None:
            done = self._restart(fresh)
        else:
            graphs, move_in = successor
            done = session.exchange(graphs)
            move_in()
        return self._keep(fresh, files, done)

    def _keep(self, fresh: LoadedScene, files: Files, done: Reloaded) -> Reloaded:
        """Store `fresh` as the scene of the session; return a copy of `done` with the changed files and the new warnings."""
        changed = [path for path, now in files.used.items() if self._files.used.get(path) != now]
        gone = [path for path in files.sought if path in self._files.used]
        known = {finding.render() for finding in self.scene.findings.warnings}
        warnings = [finding.render() for finding in fresh.findings.warnings]
        self._take(fresh, files)
        return replace(done, files=(*changed, *gone), warnings=tuple(text for text in warnings if text not in known))

    def _take(self, scene: LoadedScene, files: Files) -> None:
        for mine, theirs in ((self._files.used, files.used), (self._files.sought, files.sought)):
            mine.clear()
            mine.update(theirs)
        self.scene, self._read = scene, self._files

    def _successor(self, fresh: LoadedScene, files: Files) -> tuple[Sequence[Graph], Callable[[], None]] | None:
        """Return the graphs that replace the running graphs, and a function that then lets the roster use the new scene.

        The result is None if the world or a robot has changed.

        Raises:
            CheckError: a spawned robot or one of its graphs has errors.
        """
        before, roster = self.scene.world, self._session.roster
        if before is None or fresh.world is None:
            return (fresh.planned, lambda: None) if before is fresh.world else None
        assert isinstance(roster, SceneRoster)
        if before is not fresh.world and not before.begins_as(fresh.world):
            return None
        world = roster.world.reread(fresh.world, files)
        if world is None:
            return None
        return _graphs(fresh, world, files, roster), lambda: roster.follow(fresh, world)

    def _restart(self, fresh: LoadedScene) -> Reloaded:
        """Restart at time 0 with the changed world; graphs that the new scene lacks run their events for the end first."""
        session, lost = self._session, tuple(self._session.roster.spawned)
        ticker, roster = self._begin(fresh)
        names = [graph.name for graph in fresh.planned]
        session.end_play([run for run in session.graphs if run.name not in names])
        session.begin_with(ticker, roster)
        return Reloaded(changed=tuple(names), restarted=True, lost=lost)

    def _begin(self, scene: LoadedScene, scenery: Scenery | None = None) -> tuple[Ticker, Roster]:
        """Create a world and set up the graphs of a scene in it; return the ticker and the roster.

        Args:
            scene: scene without errors.
            scenery: descriptions for robots that are spawned later; None takes the descriptions of the scene.

        Raises:
            GraphError: physics or a node cannot start.
        """
        before = self._session.services
        loaded = scene.world.copy(self._files, before.seed) if scene.world is not None else None
        if loaded is not None and scenery is not None:
            loaded = replace(loaded, scenery=scenery.copy(self._files))
        world: World = loaded.simulation if loaded is not None else DryWorld(Stage())
        world.clamps_commands = before.world.clamps_commands
        services = Services(world, before.network, before.seed, before.domain_id, before.domain_from_environment)
        services.log, services.permissions, services.dropped = before.log, before.permissions, before.dropped
        services.started = True
        try:
            with before.network.handing_over():
                return begin(scene, loaded, self._files, services, self._fault)
        except BaseException:
            world.close()
            raise


def _copy(files: Files) -> Files:
    return replace(files, used=dict(files.used), sought=dict(files.sought))


def _graphs(fresh: LoadedScene, world: LoadedWorld, files: Files, roster: SceneRoster) -> Sequence[Graph]:
    """Return the graphs of a scene and of all robots in the given world, in execution order.

    Raises:
        CheckError: a graph of a spawned robot has errors.
    """
    assert fresh.world is not None
    spawned = [robot for name, robot in world.robots.items() if robot is not fresh.world.robots.get(name)]
    gone = [name for name, robot in fresh.world.robots.items() if world.robots.get(name) is not robot]
    graphs = [graph for graph in fresh.planned if not graph.name.startswith(tuple(f"{name}/" for name in gone))]
    named = {graph.name for graph in graphs}
    claimed = [claim for claim in fresh.claims if claim.graph in named]
    for robot in spawned:
        graphs += roster.plan(robot, replace(fresh, files=files), graphs, claimed)
    return graphs


def scene_of(session: SessionCore) -> LoadedScene:
    """Return the scene that a session runs now; after a reload, this is the changed scene."""
    assert isinstance(session.reloader, SceneReloader)
    return session.reloader.scene
