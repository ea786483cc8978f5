"""From files to a checked assembly, and from that to a running session: the only room that sees world and network both.

Nothing below `build` reads globals, the environment or the working directory, so sessions live side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.compiler.graph import Graph
from graphengine.compiler.literals import Override
from graphengine.compiler.namespaces import write_namespaces
from graphengine.compiler.planning import share_plans
from graphengine.compiler.registry import default_registry
from graphengine.devices.stage import at_or_below
from graphengine.format import document, spec_reader
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import NodeError, UsageError
from graphengine.format.files import Files, NotFoundError
from graphengine.format.spec import SceneSpec
from graphengine.format.wording import did_you_mean, listing
from graphengine.messages.endpoints import Network
from graphengine.node.clock import Clock
from graphengine.node.context.services import Services
from graphengine.node.dropped_values import BadValues, DroppedValues
from graphengine.node.node_class import UNKNOWN_PRIM
from graphengine.runtime import check
from graphengine.runtime.graph_run import make_graph_run
from graphengine.runtime.session import Session
from graphengine.scene.assembly import Assembly, Options
from graphengine.scene.roster import SceneRoster
from graphengine.scene.uses import GraphFile, find_use, resolve_uses, robot_uses, use_place

if TYPE_CHECKING:
    from graphengine.physics.loading import LoadedWorld


def assemble(path: Path, options: Options | None = None) -> Assembly:
    """Read, resolve, plan and check a scene or a graph file; every mistake is among the findings."""
    options = _with_message_types(options or Options())
    files = Files.of(path, options.allowed, options.near, options.installed, options.shipped)
    assembly = Assembly(path, options, files)
    found = document.load(path, assembly.findings)
    if found is None:
        return assembly
    kind = spec_reader.kind_of(found)
    if kind == "scene":
        _plan(assembly, _scene_uses(assembly, path, files))
        _lint_idle_robots(assembly)
    elif kind == "graph":
        _plan(assembly, _graph_uses(assembly, path, found))
    else:
        what, advice, schema = "a file is a graph or a scene", "begin with `graph: NAME`", "graph"
        if kind == "robot":
            what, schema = "this is a robot file", "scene"
            advice = f"give a scene that has robots: {{{path.stem}: {{use: {path.name}}}}}"
        place, see = found.span().part(0, 1), f"see `graphrun schema {schema}`"
        assembly.findings.add("G107", f"no key `graph` or `scene`: {what}", place, advice, see)
    return assembly


def check_robot(path: Path, options: Options) -> Assembly:
    """Check a robot file by itself; its graphs are checked with a scene that has the robot."""
    from graphengine.physics.loading import load_robot_file

    files = Files.of(path, options.allowed, options.near, options.installed, options.shipped)
    assembly = Assembly(path, options, files)
    load_robot_file(path, files, assembly.findings)
    return assembly


def _with_message_types(options: Options) -> Options:
    """Options whose registry knows the message types of the folders that they name."""
    registry = options.registry or default_registry()
    definitions = registry.definitions.extended(options.message_paths, options.installed)
    return options if definitions is registry.definitions else replace(options, registry=registry.copy(definitions))


def _scene_uses(assembly: Assembly, path: Path, files: Files) -> list[GraphFile]:
    """Load a scene's world; the graphs it uses, the scene's own first, then each robot's."""
    from graphengine.physics.loading import load_world  # MuJoCo takes a quarter of a second to import

    options = assembly.options
    scene = spec_reader.read(SceneSpec, path, assembly.findings)
    if scene is None:
        return []
    uses: list[GraphFile] = []
    for graph, use in scene.spec.graphs.items():
        place = use_place(scene.document, graph, use)
        uses += find_use(use, graph, place, scene.folder, {}, files, assembly.findings)
    loaded = load_world(scene, files, assembly.findings, seed=options.seed, rays=options.rays)
    if loaded is None:
        return uses
    assembly.world, assembly.loaded, assembly.files = loaded.simulation, loaded, files
    for robot in loaded.robots.values():
        stage = assembly.world.stage
        uses += robot_uses(robot, stage, files, assembly.findings, robot_state=options.robot_state)
    return uses


def load_scene(path: Path, options: Options, findings: Findings) -> LoadedWorld | None:
    """The world of a scene file without its graphs; what is wrong with it goes to `findings`, and then None comes back."""
    from graphengine.physics.loading import load_world

    files = Files.of(path, options.allowed, options.near, options.installed, options.shipped)
    scene = spec_reader.read(SceneSpec, path, findings)
    return load_world(scene, files, findings, seed=options.seed, rays=options.rays) if scene is not None else None


def _graph_uses(assembly: Assembly, path: Path, found: document.Document) -> list[GraphFile]:
    """A single graph, in the scene that it or the caller names."""
    files, options = assembly.files, assembly.options
    data = found.data if isinstance(found.data, dict) else {}
    name = str(data.get("graph", "graph"))
    scene_path = options.scene
    if scene_path is None and isinstance(data.get("scene"), str) and data["scene"]:
        try:
            scene_path = files.find(data["scene"], path.parent)
        except NotFoundError as error:
            assembly.findings.add("S101", f"scene: {error.message}", found.span("scene"), *error.help)
    uses = [GraphFile(path, name, {}, "")]
    given = document.load(options.scene, Findings()) if options.scene is not None else None
    if given is not None and spec_reader.kind_of(given) in ("graph", "robot"):
        raise UsageError(f"--scene {options.scene}: this is a {spec_reader.kind_of(given)} file, not a scene")
    if scene_path is not None:
        of_scene = _scene_uses(assembly, scene_path, files.beside(scene_path))
        uses += [use for use in of_scene if use.asked_for]
    elif options.robot_state:
        raise UsageError("--robot-state is for the robots of a scene; give one with --scene")
    return uses


def _plan(assembly: Assembly, uses: Sequence[GraphFile]) -> None:
    """Resolve and plan every graph, then set all nodes up dry."""
    overrides = Override.parse_all(assembly.options.overrides)
    findings = assembly.findings
    assembly.graphs = resolve_uses(uses, assembly.files, assembly.registry, findings, overrides)
    assembly.planned = share_plans(assembly.graphs, findings)
    if assembly.loaded is not None:
        write_namespaces(assembly.loaded.scenery.scene, assembly.loaded.stage, assembly.planned, findings)
    unused = [override for override in overrides if not override.used]
    if unused and not findings.errors:
        raise UsageError(_unmatched(unused[0], assembly.planned))
    assembly.claims = check.check_graphs(
        assembly.planned,
        assembly.world,
        findings,
        prims_known=assembly.loaded is not None,
        permissions=assembly.permissions,
    )


def _lint_idle_robots(assembly: Assembly) -> None:
    """Report robots of a scene that no node of any graph commands or moves."""
    if assembly.loaded is None or assembly.findings.errors:
        return
    keys = {key for graph in assembly.planned for index in graph.plan.order for key in graph.instances[index].writes}
    if UNKNOWN_PRIM in keys:
        return
    moved = {key.partition(":")[2].partition(".")[0] for key in keys if ":/" in key}
    reported: set[str] = set()  # a fleet has one mistake, not one a robot
    for name, robot in assembly.loaded.robots.items():
        path, joints = robot.prim_path, assembly.world.stage.find(robot.prim_path).facts["joints"]
        idle = not any(at_or_below(path, place) or at_or_below(place, path) for place in moved)
        if joints and idle and robot.placement.key not in reported:
            reported.add(robot.placement.key)
            assembly.findings.add(
                "W208",
                f"nothing commands robot {name}, which has {len(joints)} joints that move",
                assembly.loaded.scenery.scene.document.key_span("robots", robot.placement.key),
                "give it a graph with an IsaacArticulationController, below `graphs:` of its robot file or of the scene",
            )


def _unmatched(override: Override, graphs: Sequence[Graph]) -> str:
    """Which part of a `--set` names nothing, and what is near."""
    nodes = {f"{graph.name}/{instance.id}": instance for graph in graphs for instance in graph.instances}
    meant = list(dict.fromkeys(instance.cls for path, instance in nodes.items() if override.matches(path)))
    if meant:
        ports = [port for cls in meant for port in cls.fields.values() if port.side == "inputs" and not port.is_exec]
        names = list(dict.fromkeys(port.name for port in ports))
        near = did_you_mean(override.port, names) or listing(names, "inputs")
        who = f"{meant[0].__name__} has no input" if len(meant) == 1 else "no node that it matches has an input"
        return f"--set {override.text}: {who} {override.port!r}\n  {near}"
    wanted = override.target
    names = [path if "/" in wanted else path.rpartition("/")[2] for path in nodes]
    near = did_you_mean(wanted, names) or listing(dict.fromkeys(names), "nodes")
    return f"--set {override.text}: no node {wanted!r}\n  {near}"


def start(
    assembly: Assembly,
    network: Network,
    *,
    domain_id: int = 0,
    domain_from_environment: int | None = None,
    log: Callable[[str, str, str], None] | None = None,
    fault: Callable[[NodeError], None] | None = None,
    bad_values: BadValues = "drop",
) -> Session:
    """A session of a checked assembly, stopped at time 0; it owns the world and the network from here on.

    Args:
        assembly: without errors.
        network: endpoints for the topics.
        domain_id: the session's ROS 2 domain.
        domain_from_environment: ROS_DOMAIN_ID where the caller found one.
        log: told severity, prim path and text of what nodes say.
        fault: told of a node that raised, whose branch alone then ends; without it the run stops.
        bad_values: `drop` counts a value from a wire that a node cannot use, and clamps commands to the limits of joints; `stop`
            makes such a value a fault of the node, and sets commands as they are.

    Raises:
        CheckError: the assembly has errors.
        GraphError: a node could not be set up.
    """
    assembly.findings.raise_errors()
    for graph in assembly.planned:
        if graph.left_open:
            ports = ", ".join(graph.left_open)
            raise UsageError(f"{graph.name} is a part of other graphs, which give it {ports}; run one of those")
    world = assembly.world
    services = Services(world, network, assembly.options.seed, domain_id, domain_from_environment)
    services.permissions = assembly.permissions
    services.dropped = DroppedValues() if bad_values == "drop" else None
    world.clamps_commands = bad_values == "drop"
    if log is not None:
        services.log = log
    clock = Clock(world.tick_period)
    numerator, denominator = world.tick_period
    step_clock = Clock((numerator, denominator * world.substeps))
    clocks = {"tick": clock, "physics_step": step_clock}
    runs = [make_graph_run(graph, services, clocks[graph.runs], fault) for graph in assembly.planned]
    try:
        for run in runs:
            run.executor.setup()
    except BaseException:
        network.close()
        world.close()
        raise
    roster = SceneRoster(assembly, services, clocks, fault) if assembly.loaded is not None else None
    return Session(services, clock, step_clock, runs, roster)
