"""Loads and checks scene and graph files, and starts sessions of them.

The functions take all settings as arguments. They and all modules that they call read no global variables, no environment
variables and no working directory. A process can therefore run several sessions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.compiler.graph import Graph
from graphengine.compiler.literals import Override, ends_with, no_node, no_port
from graphengine.compiler.namespaces import write_namespaces
from graphengine.compiler.planning import share_plans
from graphengine.compiler.registry import default_registry
from graphengine.devices.backend import World
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format import document, spec_reader
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import Files
from graphengine.format.permissions import Permissions
from graphengine.format.prim_paths import at_or_below
from graphengine.format.scene_spec import LockstepSpec, SceneSpec
from graphengine.format.spec_reader import Loaded
from graphengine.format.wording import did_you_mean, listing
from graphengine.messages.endpoints import EndpointClaim, Network
from graphengine.node.context.session_services import Services
from graphengine.node.dropped_values import DroppedValues
from graphengine.node.node_class import UNKNOWN_PRIM
from graphengine.runtime import check
from graphengine.runtime.node_faults import FaultHandler
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.graph_loading import GraphFile, find_use, resolve_uses, robot_uses, use_place
from graphengine.scene.hot_reload import SceneReloader
from graphengine.scene.loaded_scene import BadValues, LoadedScene, Options, WorldSource
from graphengine.scene.scene_roster import begin

if TYPE_CHECKING:
    from graphengine.physics.loaded_world import LoadedWorld


def load(path: Path, options: Options | None = None) -> LoadedScene:
    """Read, resolve, plan and check a scene or graph file; the `findings` of the result contain all errors."""
    return _load(path, _with_message_types(options or Options()))


def load_again(scene: LoadedScene) -> LoadedScene:
    """Load a scene's file again with the same options; reuse the world if the files of the world are unchanged."""
    return _load(scene.path, scene.options, scene)


def _load(path: Path, options: Options, before: LoadedScene | None = None) -> LoadedScene:
    files = _files(path, options)
    unread = LoadedScene(path, options, files, Findings())
    found = document.load(path, unread.findings, given=files.text(path))
    if found is None:
        return unread
    kind = spec_reader.kind_of(found)
    if kind == "scene":
        scene = _plan(*_scene_uses(unread, path, before))
        _check_lockstep(scene)
        _lint_idle_robots(scene)
        return scene
    if kind == "graph":
        return _plan(*_graph_uses(unread, path, found, before))
    what, advice, schema = "a file is a graph or a scene", "begin with `graph: NAME`", "graph"
    if kind == "robot":
        what, schema = "this is a robot file", "scene"
        advice = f"give a scene that has robots: {{{path.stem}: {{use: {path.name}}}}}"
    place, see = found.span().part(0, 1), f"see `graphrun schema {schema}`"
    unread.findings.add("G107", f"no key `graph` or `scene`: {what}", place, advice, see)
    return unread


def _files(path: Path, options: Options) -> Files:
    return Files.of(path, options.allowed, options.near, options.installed, options.shipped, options.given)


def check_robot(path: Path, options: Options) -> LoadedScene:
    """Check a robot file, and return the findings in a LoadedScene; the robot's graphs are checked only as part of a scene."""
    from graphengine.physics.loading import load_robot_file

    files, findings = _files(path, options), Findings()
    load_robot_file(path, files, findings)
    return LoadedScene(path, options, files, findings)


def load_without_graphs(path: Path, options: Options) -> LoadedScene:
    """Read and check a scene file and its robots, but not the graphs."""
    files, findings = _files(path, options), Findings()
    read = spec_reader.read(SceneSpec, path, findings, given=files.text(path))
    world = _world(read, files, findings, options) if read is not None else None
    return LoadedScene(path, options, files, findings, world=world)


def _with_message_types(options: Options) -> Options:
    """Return options whose registry has the message types of `distro`, `message_paths` and the installed packages."""
    registry = options.registry or default_registry()
    definitions = registry.definitions.for_distro(options.distro).extended(options.message_paths, options.installed)
    return options if definitions is registry.definitions else replace(options, registry=registry.copy(definitions))


def _scene_uses(scene: LoadedScene, path: Path, before: LoadedScene | None) -> tuple[LoadedScene, list[GraphFile]]:
    """Return a scene with its world, and the graph files: first those in the scene file, then those of each robot."""
    files, findings = scene.files, scene.findings
    read = spec_reader.read(SceneSpec, path, findings, given=files.text(path))
    if read is None:
        return scene, []
    uses: list[GraphFile] = []
    for graph, use in read.spec.graphs.items():
        uses += find_use(use, graph, use_place(read.document, graph, use), read.folder, {}, files, findings)
    scene = _with_world(scene, read, before)
    for robot in scene.world.robots.values() if scene.world is not None else ():
        uses += robot_uses(robot, scene.stage, scene)
    return scene, uses


def _with_world(scene: LoadedScene, read: Loaded[SceneSpec], before: LoadedScene | None) -> LoadedScene:
    """Return a scene with its world; reuse the world of the previous scene `before` if it is unchanged."""
    files, findings, options = scene.files, scene.findings, scene.options
    spec = read.spec.model_copy(update={"graphs": {}, "doc": ""})
    known = before.world_source if before is not None else None
    written = spec.namespaces  # adds prims to the world, so the world must not be shared with another scene
    if before is not None and known is not None and known.spec == spec and not written and not known.files.changed():
        for finding in known.findings:
            findings.put(finding)
        files.include(known.files)
        return replace(scene, world=before.world, world_source=known)
    count, own = len(findings.items), replace(files, used={}, sought={})
    world = _world(read, own, findings, options)
    files.include(own)
    if world is None:
        return scene
    return replace(scene, world=world, world_source=WorldSource(spec, own, findings.items[count:]))


def _world(read: Loaded[SceneSpec], files: Files, findings: Findings, options: Options) -> LoadedWorld | None:
    from graphengine.physics.loading import load_world  # importing MuJoCo takes a quarter of a second

    choices: Any = {"seed": options.seed, "rays": options.rays, "sees_own_robots": options.sees_own_robots}
    return load_world(read, files, findings, **choices)


def _graph_uses(
    scene: LoadedScene, path: Path, found: document.Document, before: LoadedScene | None
) -> tuple[LoadedScene, list[GraphFile]]:
    """Return the scene in which a single graph runs, and the graph files: the graph, then those that options add.

    The options name the scene, or else the key `scene` of the graph; without either, the result has no world.
    """
    files, options = scene.files, scene.options
    data = found.data if isinstance(found.data, dict) else {}
    name = str(data.get("graph", "graph"))
    scene_path = options.scene
    if scene_path is None and isinstance(data.get("scene"), str) and data["scene"]:
        scene_path = files.look_up(data["scene"], path.parent, scene.findings, found.span("scene"), "scene: ")
    uses = [GraphFile(path, name, {}, "")]
    given = document.load(options.scene, Findings()) if options.scene is not None else None
    if given is not None and spec_reader.kind_of(given) in ("graph", "robot"):
        raise UsageError(f"--scene {options.scene}: this is a {spec_reader.kind_of(given)} file, not a scene")
    if scene_path is not None:
        scene, of_scene = _scene_uses(replace(scene, files=files.beside(scene_path)), scene_path, before)
        uses += [use for use in of_scene if use.asked_for]
    elif options.robot_state:
        raise UsageError("a graph alone has no robots and no robot states; give a scene with --scene")
    elif options.localization:
        raise UsageError("--localization needs a scene with robots; give one with --scene")
    return scene, uses


def _plan(scene: LoadedScene, uses: Sequence[GraphFile]) -> LoadedScene:
    """Resolve, plan and check the graphs in `uses`; return the scene with these graphs."""
    overrides, findings = Override.parse_all(scene.options.overrides), scene.findings
    graphs = resolve_uses(uses, scene, overrides)
    planned = share_plans(graphs, findings)
    world = scene.world
    if world is not None:
        write_namespaces(world.scenery.scene, world.stage, planned, findings)
    unused = [override for override in overrides if not override.used]
    if unused and not findings.errors:
        raise UsageError(_unmatched(unused[0], planned))
    for override in overrides if not scene.options.recorded else ():
        if override.wired:
            raise UsageError(f"--set {override.text}: {override.wired} is wired\n  only unwired inputs can be set")
    claims = check.check_graphs(
        planned,
        world.simulation if world is not None else DryWorld(Stage()),
        findings,
        prims_known=world is not None,
        permissions=Permissions(scene.files, scene.options.environment, scene.options.scripts),
    )
    return replace(scene, graphs=graphs, planned=planned, claims=claims)


def lockstep_of(scene: LoadedScene, given: Sequence[LockstepSpec] | None) -> Sequence[LockstepSpec]:
    """Return the topics on which a run of the scene waits for programs: the given topics, else those of the scene file.

    Raises:
        UsageError: no graph subscribes to a given topic.
    """
    for entry in given or ():
        if wrong := _unread(entry.topic, scene.claims):
            raise UsageError("\n  ".join(("lockstep: " + wrong[0], *wrong[1:])))
    return scene.lockstep if given is None else given


def _unread(topic: str, claims: Sequence[EndpointClaim]) -> tuple[str, ...]:
    """Return the message that no graph subscribes to a topic, and a help line; empty if a graph subscribes to the topic."""
    read = sorted({claim.topic for claim in claims if claim.direction == "subscribe"})
    if topic in read:
        return ()
    return f"no graph subscribes to {topic!r}", did_you_mean(topic, read) or listing(read, "topics")


def _check_lockstep(scene: LoadedScene) -> None:
    """Add an error for each topic of `lockstep` to which no graph subscribes."""
    for index, entry in enumerate(scene.lockstep if not scene.findings.errors else ()):
        if wrong := _unread(entry.topic, scene.claims):
            assert scene.world is not None  # only a scene has the key
            document = scene.world.scenery.scene.document
            place = ("lockstep", index) if document.find("lockstep", index) else ("lockstep",)
            scene.findings.add("G311", f"lockstep: {wrong[0]}", document.span(*place, "topic"), *wrong[1:])


def _lint_idle_robots(scene: LoadedScene) -> None:
    """Add a warning for each robot that no node of any graph commands or moves."""
    world = scene.world
    if world is None or scene.findings.errors:
        return
    keys = {key for graph in scene.planned for index in graph.plan.order for key in graph.instances[index].writes}
    if UNKNOWN_PRIM in keys:
        return
    moved = {key.partition(":")[2].partition(".")[0] for key in keys if ":/" in key}
    reported: set[str] = set()  # a fleet gets one warning, not one for each robot
    for name, robot in world.robots.items():
        path, joints = robot.prim_path, world.stage.find(robot.prim_path).facts["joints"]
        idle = not any(at_or_below(path, place) or at_or_below(place, path) for place in moved)
        if joints and idle and robot.placement.key not in reported:
            reported.add(robot.placement.key)
            number = "1 movable joint" if len(joints) == 1 else f"{len(joints)} movable joints"
            scene.findings.add(
                "W208",
                f"no graph commands robot {name}, which has {number}",
                world.scenery.scene.document.key_span("robots", robot.placement.key),
                "add a graph with an IsaacArticulationController under `graphs:` in the robot file or the scene file",
            )


def _unmatched(override: Override, graphs: Sequence[Graph]) -> str:
    """Return the error text for a `--set` option that matches no input, with similar names."""
    if not override.target:
        more = "other values, such as those of physics and drives, are keys of the scene and robot files"
        return f"--set {override.text}: write NODE.PORT\n{more}"
    nodes = {f"{graph.name}/{instance.id}": instance for graph in graphs for instance in graph.instances}
    meant = [instance.cls for path, instance in nodes.items() if ends_with(path, override.target)]
    wrong = no_port(meant, override.port) if meant else no_node(override.target, nodes)
    return f"--set {override.text}: {wrong}"


def start(
    scene: LoadedScene,
    network: Network,
    *,
    seed: int | None = None,
    domain_id: int = 0,
    domain_from_environment: int | None = None,
    log: Callable[[str, str, str], None] | None = None,
    fault: FaultHandler | None = None,
    bad_values: BadValues = "drop",
    world: World | None = None,
) -> SessionCore:
    """Create a session with its own world and nodes, and return it stopped at time 0. The session closes the network.

    Args:
        scene: scene without errors.
        network: network for topics and services.
        seed: seed of all random generators; None takes the seed in the scene's options.
        domain_id: ROS 2 domain ID of the session.
        domain_from_environment: value of ROS_DOMAIN_ID; None if the variable is not set.
        log: function called with severity, prim path and text of each log message of a node.
        fault: function called with each NodeError, which then ends only the node's branch of the graph. None: the first
            NodeError ends the run.
        bad_values: reaction to a bad value from a wire, or set while the session runs. `drop` discards and counts the value, and
            clamps commands to joint limits; `stop` treats the value as an exception of the node, and clamps no commands.
        world: world for a graph without a scene; None creates a world without physics.

    Raises:
        CheckError: the scene has errors.
        GraphError: a node could not be set up.
    """
    scene.require_runnable()
    seed = scene.options.seed if seed is None else seed
    files = replace(scene.files, used=dict(scene.files.used), sought=dict(scene.files.sought))
    loaded = scene.world.copy(files, seed) if scene.world is not None else None
    world = loaded.simulation if loaded is not None else world or DryWorld(Stage())
    services = Services(world, network, seed, domain_id, domain_from_environment)
    services.permissions = Permissions(files, scene.options.environment, scene.options.scripts)
    services.dropped = DroppedValues() if bad_values == "drop" else None
    world.clamps_commands = bad_values == "drop"
    if log is not None:
        services.log = log
    if loaded is not None:
        loaded.simulation.compile_kernels()  # the endpoints of nodes appear when the session can answer them
    try:
        ticker, roster = begin(scene, loaded, files, services, fault)
    except BaseException:
        network.close()
        world.close()
        raise
    session = SessionCore(ticker, roster)
    session.reloader = SceneReloader(session, scene, files, load_again, fault)
    return session
