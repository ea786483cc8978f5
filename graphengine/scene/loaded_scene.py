"""Loaded and checked scenes and graphs, and the options for loading and running them."""

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
from graphengine.format.given_text import GivenText
from graphengine.messages.definitions import Definitions
from graphengine.messages.distros import JAZZY, Distro
from graphengine.messages.endpoints import EndpointClaim

if TYPE_CHECKING:
    from graphengine.format.scene_spec import LockstepSpec, SceneSpec
    from graphengine.physics.loaded_world import LoadedWorld
    from graphengine.physics.ray_casting.rays import RaysChoice

BadValues = Literal["drop", "stop"]
"""Reaction to a value that a node cannot use, if the value comes from a wire or was set while the session ran.

`drop` ignores the value, `stop` ends the run. A value in the files from which the session started always ends the run.
"""


@dataclass(frozen=True, slots=True)
class Options:
    """Options for loading scenes and graphs; they take precedence over the files.

    Attributes:
        overrides: input values by address `[robot/][graph/]Node.port`.
        allowed: folders from which files may be read, in addition to the folder of the given file.
        installed: folders with installed ROS packages, as in an ament index; files and message types may be read from them.
        message_paths: message type definitions: ROS packages, folders of packages, or single files.
        distro: ROS 2 distribution whose message types are known.
        shipped: folder with `graphs/` and `scenes/` in place of the package's folder; None takes the package's folder.
        seed: seed of all random generators in sessions that are started without a seed.
        robot_state: whether to publish the topics of robot_state_publisher for each robot.
        localization: `truth` publishes map -> odom from the true pose of each mobile robot; None publishes no such transform.
        scene: scene in which to run a single graph; None takes the scene that the key `scene` of the graph names.
        rays: ray casting method of lidars: `mujoco`, `fast` (needs numba), or `auto`: `fast` if numba works and supports all
            shapes of the model, otherwise `mujoco`.
        registry: known node types and message types; None takes the installed node types.
        near: working directory; messages show paths relative to it.
        environment: values of the environment variables that graphs may read, by name.
        scripts: whether graphs may run Python code.
        recorded: whether the files come from a recording; a value out of its port's bounds is then only a warning, because the
            bounds may be newer than the recording.
        given: text of the scene or graph instead of a file.
        sees_own_robots: whether ray sensors whose robot file does not say so see their own robot.
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
    recorded: bool = False
    given: GivenText | None = None
    sees_own_robots: bool = True


@dataclass(frozen=True, slots=True)
class WorldSource:
    """The sources of a world; while they are unchanged, the world can be used again.

    Attributes:
        spec: content of the scene file without graphs.
        files: record of all files that were read, except for the scene file.
        findings: findings from the loading of the world.
    """

    spec: SceneSpec
    files: Files
    findings: Sequence[Finding]


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class LoadedScene:
    """A loaded scene or graph, from which any number of sessions can be started; sessions do not change a LoadedScene.

    Attributes:
        path: path of the scene or graph file.
        options: options with which the file was loaded.
        files: folders from which files may be read, and a record of the files that were read.
        findings: errors, warnings and notes.
        graphs: all graphs that could be read, including graphs that cannot be planned.
        planned: graphs to run, in execution order: first the graphs of the scene file, then the graphs of each robot.
        claims: topics and services that nodes use.
        world: world at time 0 with robots, prims and MuJoCo model; None for a graph without a scene.
        world_source: sources of the world; None without a world.
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
        """Check that sessions of the scene can be started.

        Raises:
            CheckError: the scene has errors.
            UsageError: a graph is only a subgraph, whose inputs another graph must set.
        """
        self.findings.raise_errors()
        for graph in self.planned:
            if graph.left_open:
                what = f"{graph.name} is a subgraph and gets {', '.join(graph.left_open)} from the graph that uses it"
                raise UsageError(f"{what}; run that graph")

    @property
    def stage(self) -> Stage:
        """Prims of the world at time 0; an empty stage for a graph without a scene."""
        return self.world.stage if self.world is not None else Stage()

    @property
    def lockstep(self) -> Sequence[LockstepSpec]:
        """Topics on which a run of the scene file waits for programs."""
        return self.world.scenery.scene.spec.lockstep if self.world is not None else ()

    @property
    def registry(self) -> Registry:
        """Node types that graphs can use."""
        return self.options.registry or default_registry()

    @property
    def definitions(self) -> Definitions:
        """Message types that graphs can use."""
        return self.registry.definitions
