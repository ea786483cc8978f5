"""Scenes: checked files from which sessions are started."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, get_args

from graphengine.api.run_options import Log, RunOptions, log_to_logging
from graphengine.api.runner import Runner
from graphengine.api.session import Session
from graphengine.format.errors import UsageError
from graphengine.format.wording import listing
from graphengine.messages.names import join_namespaces
from graphengine.node.dropped_values import BadValues
from graphengine.scene.loaded_scene import LoadedScene

if TYPE_CHECKING:
    from graphengine.api.calibration.figures import Calibration
    from graphengine.physics.occupancy.localizability import Localizability
    from graphengine.physics.occupancy.map_files import Convention, Format
    from graphengine.physics.occupancy.occupancy_map import OccupancyMap, Point, Rectangle


@dataclass(frozen=True, slots=True)
class GraphInfo:
    """A graph of a scene.

    Attributes:
        prim_path: path of the graph's prim.
        file: file that the graph was read from.
        nodes: registered type of each node, by the node's name; in a subgraph, the name is `subgraph/Node`.
    """

    prim_path: str
    file: Path
    nodes: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class RobotInfo:
    """A robot of a scene.

    Attributes:
        prim_path: path of the robot's prim.
        namespace: absolute namespace of the robot's topics; empty for none.
        joints: names of the movable joints.
    """

    prim_path: str
    namespace: str
    joints: tuple[str, ...]


class Scene:
    """A scene or graph that was checked and has no errors. `load` returns it.

    Any number of sessions can be started from it. A pickled scene contains its files, so it can be unpickled
    where they do not exist. Unpickling imports the `modules` that were passed to `load`.

    Attributes:
        name: name of the scene's file, without folder and suffix.
        findings: warnings and notes in file order; `str(finding.span)` is the place, `finding.render()` the text.
        topics: topics and services that nodes use, sorted by name, as `graphrun topics` prints them.
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
        log: Log | None = None,
    ) -> Session:
        """Start a session at time 0, stopped. Close it, or use it in a `with` statement.

        >>> with scene.session(seed=7) as sim:
        ...     sim.step()

        Args:
            transport: `memory` stays within the process; `auto`, `dds` and `rclpy` connect to ROS 2 programs.
            seed: seed of all random generators.
            keep_going: whether an exception in a node ends only the node's branch of the graph, instead of the run.
            bad_values: `drop` discards and counts values from wires that a node cannot use; `stop` raises NodeError for them.
            domain: ROS 2 domain; None: `ROS_DOMAIN_ID` if it is set, otherwise 0.
            record: MCAP file of the recording, which begins before the first tick.
            force: overwrite an existing recording.
            control: name of the session for `graphrun ctl`; None: no control channel.
            simulation_interfaces: namespace of the services of simulation_interfaces, such as `/`; None: no services.
            log: called with severity, prim path and text of each message; None: use the logger `graphengine`.

        Raises:
            ControlError: the socket of `control` cannot be created.
            GraphError: a node cannot be set up.
            RecordingError: the recording cannot be written.
            TransportError: the network cannot be joined.
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
            log=log or log_to_logging,
        )
        return Session(start_runner(self, options))

    def occupancy_map(
        self,
        path: str | PathLike[str] | None = None,
        *,
        heights: tuple[float, float] = (0.2, 0.62),
        cell: float = 0.05,
        bounds: Rectangle | None = None,
        origin: Point = (0.0, 0.0),
        free: Sequence[Point] = (),
        select: Sequence[str] = (),
        include: Sequence[str] = (),
        exclude: Sequence[str] = (),
        image: Format = "png",
        convention: Convention = "ros",
    ) -> OccupancyMap:
        """Make an occupancy map of the scene at time 0, as `graphrun map` does for nav2's map_server.

        >>> floor = scene.occupancy_map(bounds=((-2, -1), (2, 1)), cell=0.5)
        >>> floor.cells.shape
        (4, 8)

        Args:
            path: path of the image and of PATH.yaml, without suffix; None writes no files.
            heights: height range of obstacles, m.
            cell: side of a cell, m.
            bounds: south-west and north-east corner, m, rounded outwards to cells; None fits the map to `select`.
            origin: point to align the grid with: a corner of four cells, m.
            free: points from which free space is filled, m; empty: the position of the first robot.
            select: prims whose extent the map covers if `bounds` is None; empty: all obstacles.
            include: robots and movable bodies to map as obstacles.
            exclude: prims to leave out of the obstacles.
            image: file format of the image.
            convention: `isaac` maps and writes as Isaac Sim does: height range half a cell wider, origin shifted by half a
                cell, RGBA.

        Returns:
            The map; `cells` is (rows, columns) from south to north and west to east, 100 occupied, 0 free, -1 unknown.

        Raises:
            OSError: a file cannot be written.
            PrimError: no prim is at a path.
            UsageError: an argument is invalid, or a graph was loaded without a scene.
        """
        from graphengine.physics.occupancy.map_files import Convention, Format, isaac_window, write_map
        from graphengine.physics.occupancy.occupancy_map import MapRequest, make_map

        for name, value, legal in (
            ("image", image, get_args(Format)),
            ("convention", convention, get_args(Convention)),
        ):
            if value not in legal:
                raise UsageError(f"{name}: unknown value {value!r}; {listing(legal)}")
        if self._loaded.world is None:
            raise UsageError(f"{self._loaded.path} is a graph without a scene and has no map; give a scene")
        request = MapRequest(heights, cell, bounds, select, origin, free, include, exclude)
        if convention == "isaac":
            request = replace(request, window=isaac_window(heights, cell))
        made = make_map(self._loaded.world, request)
        if path is not None:
            write_map(made, Path(path), image, convention)
        return made

    def localizability(
        self,
        chart: OccupancyMap,
        path: str | PathLike[str] | None = None,
        *,
        robot: str | None = None,
        lidar: str | None = None,
        spacing: float = 0.5,
        scans: int = 8,
        alpha: float = 0.01,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Localizability:
        """Measure how well AMCL could localise a robot at each place of a map, as `graphrun map --localizability` does.

        >>> floor = scene.occupancy_map(bounds=((-2, -1), (2, 1)))
        >>> result = scene.localizability(floor, spacing=1.0)
        >>> float((result.spread <= 0.1).mean())  # a floor without obstacles
        0.0

        Args:
            chart: map of the scene.
            path: path of a PNG and a CSV file, without suffix; None writes no files.
            robot: name of the robot; None: the first one.
            lidar: path of the lidar's prim; None: the only one of the robot.
            spacing: distance between places, m.
            scans: number of scans whose likelihoods are multiplied to find the ambiguity.
            alpha: noise of the motion model, alpha3 of AMCL.
            progress: called with the completed share of the work, 0 to 1.

        Returns:
            Spread and ambiguity of each place and heading, as `graphengine.physics.occupancy.localizability` defines them.

        Raises:
            OSError: a file cannot be written.
            PrimError: no prim is at a path.
            UsageError: there is no such robot or lidar, or no free place, or the scene is a graph.
        """
        from graphengine.physics.occupancy.localizability import localizability
        from graphengine.physics.occupancy.localizability_report import write_report
        from graphengine.physics.occupancy.robot_lidar import robot_lidar

        if self._loaded.world is None:
            raise UsageError(f"{self._loaded.path} is a graph without a scene and has no map; give a scene")
        sensor, radius = robot_lidar(self._loaded.world, robot, lidar)
        result = localizability(chart, sensor, radius, spacing=spacing, scans=scans, alpha=alpha, progress=progress)
        if path is not None:
            write_report(result, chart, Path(path))
        return result

    def calibrate(
        self,
        robot: str | None = None,
        *,
        command_topic: str | None = None,
        speed: float = 0.3,
        turn_speed: float = 0.6,
        seed: int = 0,
    ) -> Calibration:
        """Drive a robot alone on a flat floor and measure how it follows its commands, as `graphrun calibrate` does.

        The robot file and its graphs are used as they are; the scene's world and its own graphs are not. The same files
        give the same figures.

        >>> result = scene.calibrate()
        >>> result.kinematics, f"{result.wheel_radius:.3f} m", result.outside(0.02)
        ('differential', '0.049 m', ())

        Args:
            robot: name of the robot; None if the scene has only one, or only robots of one file.
            command_topic: topic to drive it with, of type Twist, TwistStamped or AckermannDriveStamped; a unique end of the
                name is enough; None if it has only one.
            speed: speed to command, m/s; at most what the robot's controllers allow.
            turn_speed: turn rate to command, rad/s; at most what the robot's controllers allow.
            seed: seed of all random generators.

        Raises:
            CheckError: the robot or one of its graphs has errors on the flat floor.
            UsageError: an argument is invalid, or the scene has several robots or the robot several topics.
        """
        from graphengine.api.calibration.calibrator import calibrate

        return calibrate(self._loaded, robot, command_topic, speed, turn_speed, seed=seed, modules=self._modules)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the scene as the bytes of its files, the arguments of `load` and the names of modules."""
        from graphengine.api.scene_loading import unpack
        from graphengine.recording.packing import PackedScene

        return unpack, (PackedScene.of(self._loaded), self._modules)

    def __repr__(self) -> str:
        robots = ", ".join(list(self.robots)[:5]) + (", …" if len(self.robots) > 5 else "")
        return f"<Scene {self.name}: {len(self.graphs)} graphs, robots: {robots or 'none'}>"


def loaded_of(scene: Scene) -> LoadedScene:
    """Return the internal form of a scene, with details that `Scene` does not offer."""
    return scene._loaded


def start_runner(scene: Scene, options: RunOptions) -> Runner:
    """Start a session and return its runner, which has features that `Session` does not offer."""
    return Runner(scene._loaded, options, scene._modules)
