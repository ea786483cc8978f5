"""A scene or a graph that was read and checked, and what a caller may change about its file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.compiler.graph import Graph
from graphengine.compiler.registry import Registry, default_registry
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import Files
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim

if TYPE_CHECKING:
    from graphengine.format.spec import SceneSpec
    from graphengine.physics.loaded_world import LoadedWorld
    from graphengine.physics.sensors.rays import RaysChoice


@dataclass(frozen=True, slots=True)
class Options:
    """What a caller may change about a file without touching it.

    Attributes:
        overrides: values for inputs of nodes, as `[robot/][graph/]Node.port`.
        allowed: folders beside the given file's own that files may be read from.
        installed: folders of ROS packages, as an ament index has them; files may be read from there too, and message types.
        message_paths: files of message types, packages with such files, or folders that packages lie in.
        shipped: what holds `graphs/` and `scenes/` in the place of those that ship.
        seed: of every random generator of its sessions, where they are given no other.
        robot_state: publish what robot_state_publisher would, for every robot.
        scene: scene to put a single graph into; its own `scene:` key when empty.
        rays: what lidars see with: MuJoCo's own rays, the fast ones that need numba, or these where they serve.
        registry: node types; the installed ones when None.
        near: the working directory, where messages are to name paths from there.
        environment: variables of the environment that graphs may read, with their values.
        scripts: whether graphs may run Python.
    """

    overrides: Mapping[str, Any] = field(default_factory=dict)
    allowed: Sequence[Path] = ()
    installed: Sequence[Path] = ()
    message_paths: Sequence[Path] = ()
    shipped: Path | None = None
    seed: int = 0
    robot_state: bool = False
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
    """A loaded scene or graph. Any number of sessions can be started from it; none of them changes it.

    Attributes:
        path: path of the given file.
        options: options of loading.
        files: files that references may name, and the files that were read.
        findings: errors, warnings and notes.
        graphs: all graphs that could be read, including those that cannot be planned.
        planned: graphs to run, in this order: graphs of the scene, then graphs of each robot.
        claims: topics and services that nodes name before the run.
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
        """Check that a session can be started from it.

        Raises:
            CheckError: it has errors.
            UsageError: it is a part of other graphs.
        """
        self.findings.raise_errors()
        for graph in self.planned:
            if graph.left_open:
                ports = ", ".join(graph.left_open)
                raise UsageError(f"{graph.name} is a part of other graphs, which give it {ports}; run one of those")

    @property
    def stage(self) -> Stage:
        """The prims at the start; none without a world."""
        return self.world.stage if self.world is not None else Stage()

    @property
    def registry(self) -> Registry:
        """The node types that its files can name."""
        return self.options.registry or default_registry()

    @property
    def definitions(self) -> Definitions:
        """The message types that its files can name."""
        return self.registry.definitions
