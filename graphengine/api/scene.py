"""Scenes: files that were read and checked, from which sessions are started."""

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
        prim_path: where the graph is on the stage.
        file: that it was read from.
        nodes: registered type of each node, by the node's name; `subgraph/Node` for those of subgraphs.
    """

    prim_path: str
    file: Path
    nodes: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class RobotInfo:
    """A robot of a scene.

    Attributes:
        prim_path: of the robot's prim.
        namespace: of its topics, absolute; empty for none.
        joints: names of the joints that move.
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
        source: path of a file, or the name of a scene or graph that ships: `dd100_warehouse`, `dd100/cmd_vel`.
        set: values of inputs by `[robot/][graph/]Node.port`, globs allowed.
        scene: the scene to put a single graph into.
        robot_state: publish what robot_state_publisher would, for every robot.
        rays: `mujoco`, or `fast`, which needs numba; `auto` takes the latter where it serves.
        allow: folders that files may be read from, beside the given file's own.
        message_paths: packages, folders of packages, or single files with message types.
        packages: `share` folders of ROS packages, beside those of AMENT_PREFIX_PATH.
        modules: Python modules with node types, or their names.
        env: variables of the environment that graphs may read, with their values.
        allow_scripts: let graphs run the Python of their ScriptNodes, which is not confined.

    Raises:
        CheckError: the files have errors; its `findings` are all errors, warnings and notes.
        UsageError: an argument makes no sense: no such file, no node that `set` matches.
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
    """The scene of a file with options, checked.

    Raises:
        CheckError: it has errors.
    """
    loaded = build.load(path, options)
    loaded.findings.raise_errors()
    return Scene(loaded, modules)


def _registry(modules: Sequence[str | ModuleType]) -> Registry:
    """The installed node types and those of some modules.

    Raises:
        UsageError: there is no module of that name.
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
    """A scene, or a graph, that was read and checked without errors. `load` makes it.

    Any number of sessions can be started from it. It can be pickled, as the bytes of its files, and is loaded from these in
    another process, where none of the files need be; modules of node types are imported there.
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
        """Name of its file, without folder and ending."""
        return self._loaded.path.stem

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warnings and notes, in order of their places; `str(finding.span)` is the place, `finding.render()` the text."""
        return self._findings

    @property
    def topics(self) -> tuple[EndpointClaim, ...]:
        """What nodes publish, subscribe to, serve and call, by name: what `graphrun topics` prints."""
        return self._topics

    @property
    def graphs(self) -> Mapping[str, GraphInfo]:
        """Graphs by name, `robot/graph` for those of robots, in the order in which they run."""
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
            transport: `memory` reaches nobody; `auto`, `dds` and `rclpy` reach ROS 2 programs.
            seed: of every random generator.
            keep_going: a node that raises ends its branch, not the run.
            bad_values: `drop` counts a value from a wire that a node cannot use; `stop` makes it a NodeError.
            domain: ROS 2 domain; that of ROS_DOMAIN_ID, or 0, when None.
            record: MCAP file for the recording, which begins before the first tick.
            force: write over a recording that is there.
            control: name by which `graphrun ctl` finds the session; None hides it.
            simulation_interfaces: namespace for the services of simulation_interfaces, such as `/`; None offers none.
            log: receives severity, prim path and text of messages; None sends them to the logger `graphengine`.

        Raises:
            ControlError: there is no place for the socket that `control` needs.
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
        """As the bytes of its files and the arguments it was loaded with; modules are imported anew."""
        from graphengine.recording.packing import PackedScene

        return _unpack, (PackedScene.of(self._loaded), self._modules)

    def __repr__(self) -> str:
        robots = ", ".join(list(self._robots)[:5]) + (", …" if len(self._robots) > 5 else "")
        return f"<Scene {self.name}: {len(self._graphs)} graphs, robots: {robots or 'none'}>"


def loaded_of(scene: Scene) -> LoadedScene:
    """What a scene was read as, for `graphrun`, which shows more of it than `Scene` does."""
    return scene._loaded


def start_runner(scene: Scene, options: RunOptions, seed: int | None = None) -> Runner:
    """What runs a new session of a scene, for `graphrun`, which shows more of it than `Session` does.

    Args:
        scene: any number of runners can be started from it.
        options: of the session.
        seed: of every random generator; the one that the scene was loaded with when None.
    """
    if options.record is not None:
        check_recording(options.record, force=options.force)
    return Runner(scene._loaded, options, seed, scene._modules)


def _unpack(packed: PackedScene, modules: Sequence[str]) -> Scene:
    """The scene that was pickled; its files lie in a folder of their own as long as it, or a session of it, is used."""
    from graphengine.recording.sources import Workspace

    folder = tempfile.TemporaryDirectory(prefix="graphengine-")
    path, options = packed.lay_out(Workspace(Path(folder.name)))
    scene = open_scene(path, replace(options, registry=_registry(modules) if modules else None), modules)
    weakref.finalize(scene._loaded, folder.cleanup)
    return scene
