"""What was read and checked of a scene or a graph file, and what a caller may change about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.compiler.graph import Graph
from graphengine.compiler.registry import Registry, default_registry
from graphengine.devices.backend import World
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.permissions import Permissions
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim

if TYPE_CHECKING:
    from graphengine.physics.loading import LoadedWorld
    from graphengine.physics.sensors.rays import RaysChoice


@dataclass(slots=True)
class Assembly:
    """Everything that was read and checked: graphs and their plans, the stage, and the world if there is one."""

    path: Path
    options: Options
    files: Files
    findings: Findings = field(default_factory=Findings)
    graphs: list[Graph] = field(default_factory=list)
    """Those that cannot be planned too."""
    planned: list[Graph] = field(default_factory=list)
    claims: list[EndpointClaim] = field(default_factory=list)
    world: World = field(default_factory=lambda: DryWorld(Stage()))
    loaded: LoadedWorld | None = None
    """The scene's robots and what they were made from."""

    @property
    def registry(self) -> Registry:
        """The node types that its files can name."""
        return self.options.registry or default_registry()

    @property
    def definitions(self) -> Definitions:
        """The message types that its files can name."""
        return self.registry.definitions

    @property
    def permissions(self) -> Permissions:
        """What its graphs may do."""
        return Permissions(self.files, self.options.environment, self.options.scripts)


@dataclass(frozen=True, slots=True)
class Options:
    """What a caller may change about a file without touching it.

    Attributes:
        overrides: values for inputs of nodes, as `[robot/][graph/]Node.port`.
        allowed: folders beside the given file's own that files may be read from.
        installed: folders of ROS packages, as an ament index has them; files may be read from there too, and message types.
        message_paths: files of message types, packages with such files, or folders that packages lie in.
        shipped: what holds `graphs/` and `scenes/` in the place of those that ship.
        seed: of every generator.
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
