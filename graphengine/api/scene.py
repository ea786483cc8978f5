"""The class `Scene`: a scene or graph whose files were read and checked, and from which sessions are started."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, get_args

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
        """Return an occupancy map of the scene at time 0; `graphrun map` makes the same map for Nav2's map_server.

        >>> floor = scene.occupancy_map(bounds=((-2, -1), (2, 1)), cell=0.5)
        >>> floor.cells.shape
        (4, 8)

        Args:
            path: path without suffix; the map is written to an image and to PATH.yaml. None writes no files.
            heights: lowest and highest z in the world at which bodies count as obstacles, m.
            cell: side of a cell, m.
            bounds: south-west and north-east corner (x, y), m, rounded outwards to whole cells; None fits the map to the prims
                in `select`.
            origin: point (x, y) at which corners of cells meet, m; aligns the grid.
            free: points (x, y) from which free space is flood-filled, m; empty takes the position of the first robot.
            select: paths of prims whose extent the map covers if `bounds` is None; empty takes all obstacles.
            include: paths of robots and movable bodies to map as obstacles.
            exclude: paths of prims that are not mapped as obstacles.
            image: file format of the image.
            convention: `ros`, or `isaac` for a map as Isaac Sim makes it: the height range is rounded outwards to cells and
                extended by half a cell at both ends, the origin is shifted by half a cell, and the image is RGBA.

        Returns:
            The map. `cells` has the shape (rows, columns), with rows from south to north and columns from west to east; 100
            is occupied, 0 free, -1 unknown.

        Raises:
            OSError: a file cannot be written.
            PrimError: there is no prim at a path in `select`, `include` or `exclude`.
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
        """Compute how well AMCL could localize a robot at each place of a map, as `graphrun map --localizability` does.

        >>> floor = scene.occupancy_map(bounds=((-2, -1), (2, 1)))
        >>> result = scene.localizability(floor, spacing=1.0)
        >>> float((result.spread <= 0.1).mean())  # a floor without obstacles
        0.0

        Args:
            chart: map of the scene.
            path: path without suffix; the result is written to a PNG and a CSV file. None writes no files.
            robot: name of the robot; None takes the first robot.
            lidar: path of the lidar's prim; None takes the robot's only lidar.
            spacing: distance between neighbouring places, m.
            scans: number of scans whose likelihoods are multiplied to compute the ambiguity.
            alpha: translation noise of the motion model, alpha3 of AMCL.
            progress: function called with the completed share of the work, 0 to 1.

        Returns:
            Spread and ambiguity of each place and heading, as `graphengine.physics.occupancy.localizability` defines them.

        Raises:
            OSError: a file cannot be written.
            PrimError: there is no prim at the path `lidar`.
            UsageError: the robot or lidar does not exist, the robot has several lidars and `lidar` is None, the lidar is not
                level, the map has no free place, or a graph was loaded without a scene.
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

        The test drives use the robot file and its graphs unchanged. They do not use the scene's world and the graphs of the scene
        file. The same files and arguments give the same results.

        >>> result = scene.calibrate()
        >>> result.kinematics, f"{result.wheel_radius:.3f} m", result.outside(0.02)
        ('differential', '0.049 m', ())

        Args:
            robot: name of the robot; None takes the only robot, or the first one if all robots have the same robot file.
            command_topic: topic to drive the robot with, of type Twist, TwistStamped or AckermannDriveStamped. The last part
                of the name is enough if it is unique. None takes the robot's only command topic.
            speed: speed to command, m/s; lowered to the limits of the robot's controllers.
            turn_speed: turn rate to command, rad/s; lowered to the limits of the robot's controllers.
            seed: seed of all random generators.

        Raises:
            CheckError: the robot or one of its graphs has errors in the scene with the flat floor.
            UsageError: an argument is invalid, or the robot or its command topic is ambiguous.
        """
        from graphengine.api.calibration.calibrator import calibrate

        return calibrate(self._loaded, robot, command_topic, speed, turn_speed, seed=seed, modules=self._modules)

    def __repr__(self) -> str:
        robots = ", ".join(list(self.robots)[:5]) + (", …" if len(self.robots) > 5 else "")
        return f"<Scene {self.name}: {len(self.graphs)} graphs, robots: {robots or 'none'}>"


def loaded_of(scene: Scene) -> LoadedScene:
    """Return the internal LoadedScene of a scene, which has details that `Scene` does not expose."""
    return scene._loaded


def start_runner(scene: Scene, options: RunOptions) -> Runner:
    """Start a session and return its runner, which has features that `Session` does not expose."""
    return Runner(scene._loaded, options, scene._modules)
