"""Scenes: checked files from which sessions are started."""

from __future__ import annotations

import importlib
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any

from graphengine.api.runner import Log, Runner, RunOptions, check_recording, log_to_logging
from graphengine.api.session import Session
from graphengine.api.values import plain
from graphengine.compiler.registry import Registry, default_registry
from graphengine.format.diagnostics import Finding
from graphengine.format.errors import UsageError
from graphengine.format.files import find_file, installed_packages
from graphengine.format.wording import listing, shown
from graphengine.messages.endpoints import EndpointClaim
from graphengine.messages.names import join_namespaces
from graphengine.node.dropped_values import BadValues
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene, Options

if TYPE_CHECKING:
    from graphengine.physics.sensors.rays import RaysChoice
    from graphengine.recording.packing import PackedScene

RAYS = ("auto", "mujoco", "fast")
NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class GraphInfo:
    """A graph of a scene.

    Attributes:
        prim_path: path of the graph's prim.
        file: file that the graph was read from.
        nodes: registered type of each node by the node's name; `subgraph/Node` in subgraphs.
    """

    prim_path: str
    file: Path
    nodes: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class RobotInfo:
    """A robot of a scene.

    Attributes:
        prim_path: path of the robot's prim.
        namespace: absolute namespace of its topics; empty for none.
        joints: names of the movable joints.
    """

    prim_path: str
    namespace: str
    joints: tuple[str, ...]


def load(
    source: str | PathLike[str],
    *,
    set: Mapping[str, Any] = NOTHING,
    scene: str | PathLike[str] | None = None,
    robot_state: bool = False,
    rays: RaysChoice = "auto",
    allow: Sequence[str | PathLike[str]] = (),
    message_paths: Sequence[str | PathLike[str]] = (),
    packages: Sequence[str | PathLike[str]] = (),
    modules: Sequence[str | ModuleType] = (),
    env: Mapping[str, str] = NOTHING,
    allow_scripts: bool = False,
) -> Scene:
    """Read and check a scene or a graph.

    >>> scene = ge.load("dd100_flat", set={"DiffController.maxLinearSpeed": 0.8})
    >>> list(scene.robots)
    ['dd100']

    Args:
        source: path of a file, or name of an included scene or graph: `dd100_warehouse`, `dd100/cmd_vel`.
        set: input values by `[robot/][graph/]Node.port`, globs allowed.
        scene: the scene to put a single graph into.
        robot_state: publish the topics of robot_state_publisher for every robot.
        rays: `mujoco`, `fast` (needs numba), or `auto`, which takes `fast` where possible.
        allow: folders that files may be read from, in addition to the source's own.
        message_paths: packages, folders of packages, or single files with message types.
        packages: `share` folders of ROS packages, in addition to those of AMENT_PREFIX_PATH.
        modules: Python modules with node types, or their names.
        env: environment variables that graphs may read, with their values.
        allow_scripts: let graphs run the Python of their ScriptNodes, without a sandbox.

    Raises:
        CheckError: the files have errors; its `findings` hold all errors, warnings and notes.
        UsageError: an argument is invalid, such as a missing file or a `set` address that matches no input.
    """
    if rays not in RAYS:
        raise UsageError(f"rays: no rays {rays!r}; {listing(RAYS)}")
    for name, several in (
        ("allow", allow),
        ("message_paths", message_paths),
        ("packages", packages),
        ("modules", modules),
    ):
        if isinstance(several, str):
            raise UsageError(f"{name}: expected a list, got {shown(several)}")
    given = {"allow": allow, "message_paths": message_paths, "packages": packages}
    paths = {name: [Path(path) for path in entries] for name, entries in given.items()}
    for name, entries in paths.items():
        for path in entries:
            if not (path.is_dir() or (name == "message_paths" and path.is_file())):
                raise UsageError(f"{name}: no such folder: {path}")
    options = Options(
        overrides=plain(set),
        allowed=paths["allow"],
        installed=[*paths["packages"], *installed_packages()],
        message_paths=paths["message_paths"],
        robot_state=robot_state,
        scene=find_file(str(scene)) if scene is not None else None,
        rays=rays,
        registry=_registry(modules) if modules else None,
        near=Path.cwd(),
        environment=dict(env),
        scripts=allow_scripts,
    )
    names = [module if isinstance(module, str) else module.__name__ for module in modules]
    return open_scene(find_file(str(source)), options, names)


def open_scene(path: Path, options: Options, modules: Sequence[str] = ()) -> Scene:
    """Read and check the scene in a file.

    Raises:
        CheckError: the scene has errors.
    """
    loaded = build.load(path, options)
    loaded.findings.raise_errors()
    return Scene(loaded, modules)


def _registry(modules: Sequence[str | ModuleType]) -> Registry:
    """A registry of the installed node types and those of the given modules.

    Raises:
        UsageError: a module cannot be found.
    """
    registry = default_registry().copy()
    for module in modules:
        try:
            found = importlib.import_module(module) if isinstance(module, str) else module
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
            raise UsageError(f"modules: {error}") from None
        registry.add_module(found, found.__name__)
    return registry


class Scene:
    """A scene or graph that was checked and has no errors. `load` returns it.

    Any number of sessions can be started from it. A pickle holds the bytes of its files, so another process needs none of
    them; it imports the modules of node types.
    """

    def __init__(self, loaded: LoadedScene, modules: Sequence[str] = ()) -> None:
        self._loaded = loaded
        self._modules = modules
        self._findings = tuple(loaded.findings.sorted())
        self._topics = tuple(sorted(loaded.claims, key=lambda claim: (claim.topic, claim.direction, claim.node)))
        self._graphs = {
            graph.name: GraphInfo(
                graph.prim_path,
                Path(graph.flat.loaded.document.source.path),
                {one.id: one.cls.type_name for one in graph.instances if not one.part_of},
            )
            for graph in loaded.planned
        }
        stage = loaded.stage
        self._robots = {
            prim.entity_name: RobotInfo(
                prim.path, join_namespaces(stage.namespaces(prim.facts["base_link"])), tuple(prim.facts["joints"])
            )
            for prim in stage.prims("robot")
        }

    @property
    def name(self) -> str:
        """Name of its file, without folder and suffix."""
        return self._loaded.path.stem

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warnings and notes in file order; `str(finding.span)` is the place, `finding.render()` the text."""
        return self._findings

    @property
    def topics(self) -> tuple[EndpointClaim, ...]:
        """Topics and services that nodes use, by name, as `graphrun topics` prints them."""
        return self._topics

    @property
    def graphs(self) -> Mapping[str, GraphInfo]:
        """Graphs by name (`robot/graph` for those of robots), in execution order."""
        return MappingProxyType(self._graphs)

    @property
    def robots(self) -> Mapping[str, RobotInfo]:
        """Robots by name."""
        return MappingProxyType(self._robots)

    def session(
        self,
        *,
        transport: str = "memory",
        seed: int = 0,
        keep_going: bool = False,
        bad_values: BadValues = "drop",
        domain: int | None = None,
        record: str | PathLike[str] | None = None,
        force: bool = False,
        control: str | None = None,
        simulation_interfaces: str | None = None,
        log: Log | None = None,
    ) -> Session:
        """Start a session at time 0, stopped. Close it, or use it in a `with` statement.

        >>> with scene.session(seed=7) as sim:
        ...     sim.step()

        Args:
            transport: `memory` stays within the process; `auto`, `dds` and `rclpy` connect to ROS 2 programs.
            seed: seed of all random generators.
            keep_going: an exception in a node ends its branch of the graph, not the run.
            bad_values: `drop` discards and counts a wire's value that a node cannot use; `stop` raises NodeError for it.
            domain: ROS 2 domain; None takes ROS_DOMAIN_ID, or 0.
            record: MCAP file of the recording, which begins before the first tick.
            force: overwrite an existing recording.
            control: name of the session for `graphrun ctl`; None gives it no control channel.
            simulation_interfaces: namespace of the services of simulation_interfaces, such as `/`; None offers none.
            log: receives severity, prim path and text of each message; None sends them to the logger `graphengine`.

        Raises:
            ControlError: the socket of `control` cannot be created.
            GraphError: a node cannot be set up.
            RecordingError: the recording cannot be written.
            TransportError: the network cannot be joined.
        """
        options = RunOptions(
            transport=transport,
            keep_going=keep_going,
            bad_values=bad_values,
            domain=domain,
            record=Path(record) if record is not None else None,
            force=force,
            control=control,
            simulation_interfaces=simulation_interfaces,
            log=log or log_to_logging,
        )
        return Session(start_runner(self, options, seed))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the scene as the bytes of its files, the arguments of `load` and the names of modules."""
        from graphengine.recording.packing import PackedScene

        return _unpack, (PackedScene.of(self._loaded), self._modules)

    def __repr__(self) -> str:
        robots = ", ".join(list(self._robots)[:5]) + (", …" if len(self._robots) > 5 else "")
        return f"<Scene {self.name}: {len(self._graphs)} graphs, robots: {robots or 'none'}>"


def loaded_of(scene: Scene) -> LoadedScene:
    """The internal form of a scene, for `graphrun`, which shows more of it than `Scene` does."""
    return scene._loaded


def start_runner(scene: Scene, options: RunOptions, seed: int | None = None) -> Runner:
    """Start a session and return its runner, for `graphrun`, which shows more of it than `Session` does.

    Args:
        scene: scene to run; it can be shared by several runners.
        options: options of the session.
        seed: seed of all random generators; None takes the scene's.
    """
    if options.record is not None:
        check_recording(options.record, force=options.force)
    return Runner(scene._loaded, options, seed, scene._modules)


def _unpack(packed: PackedScene, modules: Sequence[str]) -> Scene:
    """Load a pickled scene. Its files are kept in a temporary folder while the scene or one of its sessions exists."""
    from graphengine.recording.sources import Workspace

    folder = tempfile.TemporaryDirectory(prefix="graphengine-")
    path, options = packed.lay_out(Workspace(Path(folder.name)))
    scene = open_scene(path, replace(options, registry=_registry(modules) if modules else None), modules)
    weakref.finalize(scene._loaded, folder.cleanup)
    return scene
