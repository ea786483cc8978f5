"""The class `Scene`: a scene or graph whose files were read and checked, and from which sessions are started."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from graphengine.api.run_options import Log, RunOptions, log_to_logging, read_lockstep
from graphengine.api.runner import Runner
from graphengine.api.session import Session
from graphengine.api.values import plain
from graphengine.format.errors import UsageError
from graphengine.messages.names import join_namespaces
from graphengine.scene.loaded_scene import BadValues, LoadedScene

if TYPE_CHECKING:
    from graphengine.physics.loaded_world import LoadedWorld


@dataclass(frozen=True, slots=True)
class GraphInfo:
    """A graph of a scene.

    Attributes:
        prim_path: path of the graph's prim.
        file: file that the graph was read from.
        nodes: node types by node name; the name of a node in a subgraph is `subgraph/Node`.
    """

    prim_path: str
    file: Path
    nodes: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class RobotInfo:
    """A robot of a scene.

    Attributes:
        prim_path: path of the robot's prim.
        namespace: namespace of the robot's topics, without a leading slash; empty if there is no namespace.
        joints: names of the movable joints.
    """

    prim_path: str
    namespace: str
    joints: tuple[str, ...]


class Scene:
    """A scene or graph that was checked and has no errors. `load` returns it.

    Any number of sessions can be started from one scene. A pickled scene contains the content of its files, so it can be
    unpickled on a machine that does not have these files. Unpickling imports the `modules` that were passed to `load`.

    Attributes:
        name: name of the scene's file, without folder and suffix.
        findings: warnings and notes in file order; `str(finding.span)` is the place in the file, `finding.render()` the text.
        topics: topics and services that nodes use, sorted by name; `graphrun topics` prints the same list.
        graphs: graphs by name, in execution order; the name of a robot's graph is `robot/graph`.
        robots: robots by name.
    """

    def __init__(self, loaded: LoadedScene, modules: Sequence[str] = ()) -> None:
        self._loaded = loaded
        self._modules = modules
        stage = loaded.stage
        self.name = loaded.path.stem
        self.findings = tuple(loaded.findings.sorted())
        self.topics = tuple(sorted(loaded.claims, key=lambda claim: (claim.topic, claim.direction, claim.node)))
        self.graphs: Mapping[str, GraphInfo] = MappingProxyType(
            {
                graph.name: GraphInfo(
                    graph.prim_path,
                    Path(graph.flat.loaded.document.source.path),
                    {one.id: one.cls.type_name for one in graph.instances if not one.part_of},
                )
                for graph in loaded.planned
            }
        )
        self.robots: Mapping[str, RobotInfo] = MappingProxyType(
            {
                prim.entity_name: RobotInfo(
                    prim.path, join_namespaces(stage.namespaces(prim.facts["base_link"])), tuple(prim.facts["joints"])
                )
                for prim in stage.prims("robot")
            }
        )

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
        lockstep: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        ports: Sequence[str] = (),
        log: Log | None = None,
    ) -> Session:
        """Start a session and return it, stopped at time 0. Close the session, or use it in a `with` statement.

        >>> with scene.session(seed=7) as sim:
        ...     sim.step()

        Args:
            transport: `memory` keeps messages within the process; `auto`, `dds` and `rclpy` connect to ROS 2 programs.
            seed: seed of all random generators.
            keep_going: if True, an exception in a node ends only the node's branch of the graph, not the run.
            bad_values: reaction to a value that a node cannot use, if the value comes from a wire or was set while the session
                runs: `drop` discards and counts the value, `stop` raises NodeError. An unusable value in the files that were
                loaded at the start always raises NodeError. `drop` also clamps commands to joint limits.
            domain: ROS 2 domain ID; None takes `ROS_DOMAIN_ID` if it is set, otherwise 0.
            record: MCAP file for a recording of the session; the recording begins before the first tick. None records nothing.
            force: whether to overwrite an existing recording.
            control: name of the session for `graphrun ctl`; None creates no control channel.
            simulation_interfaces: namespace of the services of simulation_interfaces, such as `/`; None creates no services.
            lockstep: topic on which the run waits for another program, with the keys of `lockstep` in a scene file, such as
                `{"topic": "/cmd_vel", "period": 0.1}`, or a list of topics. None takes those of the scene file; `[]` waits
                for no program.
            ports: addresses of ports whose values the recording also contains, as channels `/_graph/ADDRESS`; their parts
                may be globs, such as `*/ComputeOdom.*`.
            log: function to call for each log message of a node; its arguments are the severity, the prim path of the node
                and the text. None sends the messages to the Python logger `graphengine`.

        Raises:
            ControlError: the socket of the control channel cannot be created.
            GraphError: a node cannot be set up.
            RecordingError: the recording cannot be written.
            TransportError: the session cannot join the ROS 2 network.
            UsageError: an argument is invalid, or a graph that uses prims was loaded without a scene.
        """
        options = RunOptions(
            transport=transport,
            seed=seed,
            keep_going=keep_going,
            bad_values=bad_values,
            domain=domain,
            record=Path(record) if record is not None else None,
            force=force,
            control=control,
            simulation_interfaces=simulation_interfaces,
            lockstep=read_lockstep(plain(lockstep)) if lockstep is not None else None,
            ports=tuple(ports),
            log=log or log_to_logging,
        )
        return Session(start_runner(self, options))

    def __repr__(self) -> str:
        robots = ", ".join(list(self.robots)[:5]) + (", …" if len(self.robots) > 5 else "")
        return f"<Scene {self.name}: {len(self.graphs)} graphs, robots: {robots or 'none'}>"


def loaded_of(scene: Scene) -> LoadedScene:
    """Return the internal LoadedScene of a scene, which has details that `Scene` does not expose."""
    return scene._loaded


def world_of(scene: Scene) -> LoadedWorld:
    """Return the world of a scene at time 0, with its robots and its MuJoCo model.

    Raises:
        UsageError: a graph was loaded without a scene.
    """
    loaded = loaded_of(scene)
    if loaded.world is None:
        raise UsageError(f"{loaded.path} is a graph without a scene and has no world; give a scene")
    return loaded.world


def modules_of(scene: Scene) -> Sequence[str]:
    """Return the names of the modules with node types that were passed to `load`."""
    return scene._modules


def start_runner(scene: Scene, options: RunOptions) -> Runner:
    """Start a session and return its runner, which has features that `Session` does not expose."""
    return Runner(scene._loaded, options, scene._modules)
