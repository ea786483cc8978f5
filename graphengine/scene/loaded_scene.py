"""A loaded and checked scene or graph, and the options of loading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from graphengine.compiler.graph import Graph
from graphengine.compiler.registry import Registry, default_registry
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import Files
from graphengine.messages.definitions import Definitions
from graphengine.messages.distros import JAZZY, Distro
from graphengine.messages.endpoints import EndpointClaim

if TYPE_CHECKING:
    from graphengine.format.spec import SceneSpec
    from graphengine.physics.loaded_world import LoadedWorld
    from graphengine.physics.sensors.rays import RaysChoice


@dataclass(frozen=True, slots=True)
class Options:
    """Options of loading, which override settings of the files.

    Attributes:
        overrides: values for inputs of nodes, by `[robot/][graph/]Node.port`.
        allowed: additional folders that files may be read from, besides the folder of the given file.
        installed: folders with installed ROS packages, as in an ament index; files and message types may be read from them.
        message_paths: message types: definition files, packages, or folders with packages.
        distro: distribution of ROS 2 whose message types are known.
        shipped: folder with `graphs/` and `scenes/` to use instead of the included one.
        seed: seed of all random generators, for sessions that are started without one.
        robot_state: publish the topics of robot_state_publisher for each robot.
        localization: `truth` publishes map -> odom from the true pose of each mobile robot; None: nothing does.
        scene: scene for a single graph; None: the scene that its `scene` key names.
        rays: ray casting of lidars: MuJoCo's (`mujoco`), numba's (`fast`), or `fast` where it is available (`auto`).
        registry: node types; None: the installed ones.
        near: working directory, to which paths in messages are relative.
        environment: names and values of the environment variables that graphs may read.
        scripts: whether graphs may run Python code.
    """

    overrides: Mapping[str, Any] = field(default_factory=dict)
    allowed: Sequence[Path] = ()
    installed: Sequence[Path] = ()
    message_paths: Sequence[Path] = ()
    distro: Distro = JAZZY
    shipped: Path | None = None
    seed: int = 0
    robot_state: bool = False
    localization: Literal["truth"] | None = None
    scene: Path | None = None
    rays: RaysChoice = "auto"
    registry: Registry | None = None
    near: Path | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    scripts: bool = False


@dataclass(frozen=True, slots=True)
class WorldSource:
    """The sources of a world; equal sources give the same world.

    Attributes:
        spec: content of the scene file without its graphs.
        files: all files that were read, except for the scene file.
        findings: warnings and notes about the world.
    """

    spec: SceneSpec
    files: Files
    findings: Sequence[Finding]


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class LoadedScene:
    """A loaded scene or graph. It can start any number of sessions, which do not change it.

    Attributes:
        path: path of the given file.
        options: options of loading.
        files: files that references may name, and the files that were read.
        findings: errors, warnings and notes.
        graphs: all graphs that could be read, including those that cannot be planned.
        planned: graphs to run, in this order: graphs of the scene, then graphs of each robot.
        claims: topics and services that nodes request in setup.
        world: initial robots, prims and model; None for a graph without a scene.
        world_source: sources of the world.
    """

    path: Path
    options: Options
    files: Files
    findings: Findings
    graphs: Sequence[Graph] = ()
    planned: Sequence[Graph] = ()
    claims: Sequence[EndpointClaim] = ()
    world: LoadedWorld | None = None
    world_source: WorldSource | None = None

    def require_runnable(self) -> None:
        """Check that sessions can be started.

        Raises:
            CheckError: the scene has errors.
            UsageError: a graph is only a subgraph, whose inputs come from another graph.
        """
        self.findings.raise_errors()
        for graph in self.planned:
            if graph.left_open:
                ports = ", ".join(graph.left_open)
                raise UsageError(
                    f"{graph.name} is a subgraph and gets {ports} from the graph that uses it; run that graph"
                )

    @property
    def stage(self) -> Stage:
        """Prims at the start of a session; empty without a world."""
        return self.world.stage if self.world is not None else Stage()

    @property
    def registry(self) -> Registry:
        """Node types that graphs can use."""
        return self.options.registry or default_registry()

    @property
    def definitions(self) -> Definitions:
        """Message types that graphs can use."""
        return self.registry.definitions
