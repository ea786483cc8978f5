"""Checks graphs without a run: sets up all nodes in a world without physics, compares the nodes' topics, and runs the lints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from graphengine.compiler.every_gates import EveryHz, rate
from graphengine.compiler.graph import Graph, Instance
from graphengine.compiler.lint_registry import LINTS, LintContext
from graphengine.compiler.subgraph_expansion import NodeEntry, WireEntry
from graphengine.devices.backend import World
from graphengine.devices.dry_world import DryWorld
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.errors import ContextError, GraphError, JointError, PrimError
from graphengine.format.permissions import Permissions
from graphengine.format.prim_paths import at_or_below
from graphengine.format.wording import listing
from graphengine.messages.endpoints import EndpointClaim, Network
from graphengine.messages.names import action_of
from graphengine.node.clock import Clock
from graphengine.node.context.frame_names import frame_prefix
from graphengine.node.context.session_services import Services
from graphengine.runtime.graph_run import make_clock, make_graph_run
from graphengine.runtime.message_lints import check_qos, check_stamps


def check_graphs(
    graphs: Sequence[Graph],
    world: World,
    findings: Findings,
    *,
    prims_known: bool,
    beside: Sequence[Graph] = (),
    claimed: Sequence[EndpointClaim] = (),
    permissions: Permissions | None = None,
) -> list[EndpointClaim]:
    """Set up all nodes in a world without physics and run the lints; return the topics and services that the nodes claim.

    Args:
        graphs: graphs to check, in execution order.
        world: world that has the prims of the scene.
        findings: receives errors, warnings and notes.
        prims_known: whether `world` has the prims of a scene; if not, missing prims are not errors.
        beside: graphs that were already checked and run before `graphs`.
        claimed: topics and services that the nodes of `beside` claim.
        permissions: permissions of the nodes; None permits nothing.
    """
    for graph in graphs:
        lint_structure(graph, findings)
    dry = DryWorld(world.stage, world.tick_period, world.substeps)
    services = Services(dry, Network(), permissions=permissions or Permissions())
    for graph in graphs:
        _set_up(graph, services, findings, prims_known=prims_known)
    if prims_known:  # otherwise the rate of ticks is unknown
        lint_rates(graphs, dry, findings)
    lint_claims(LintContext([*beside, *graphs], world.stage, [*claimed, *services.claims], findings))
    return services.claims


def _set_up(graph: Graph, services: Services, findings: Findings, *, prims_known: bool) -> None:
    """Set up the nodes of a graph without a network, and add the errors to `findings`."""
    skipped = 0
    faulty, failed = _faulty(graph, findings), set[int]()
    sources: dict[int, set[int]] = {}
    for wire in graph.data_wires:
        sources.setdefault(wire.target, set()).add(wire.source)

    def fail(index: int, error: GraphError) -> None:
        nonlocal skipped
        failed.add(index)
        if index in faulty and _follows(graph.instances[index], error):
            return
        if sources.get(index, set()) & failed:  # it may lack only the outputs of a failed node
            return
        if isinstance(error, PrimError | JointError) and not prims_known:
            skipped += 1
        else:
            findings.put(explain(graph.instances[index], error))

    run = make_graph_run(graph, services, _clock(graph, services.world))
    run.executor.setup(fail)
    for index, path, prim in run.contexts.asked():
        robot = services.stage.robot_of(prim)
        if robot is not None and not services.stage.is_literal(path, prim):
            _, span = graph.instances[index].asking(path)
            below = prim.path.removeprefix(f"{robot.path}/")  # so that a fleet gets one note, not one for each robot
            findings.add("N105", f"the path omits links; the full path within the robot is {below}", span)
    if skipped:
        nodes = f"{skipped} nodes of graph {graph.name} use" if skipped > 1 else f"a node of graph {graph.name} uses"
        span = graph.flat.loaded.document.span("graph")
        no_scene = any(finding.code.startswith("S") for finding in findings.errors)
        remedy = "the scene could not be loaded" if no_scene else "give the scene with --scene"
        findings.add("N102", f"{nodes} prims, which were not checked", span, remedy)


def _faulty(graph: Graph, findings: Findings) -> set[int]:
    """Return the indices of the nodes for which an error was already reported, and may be the cause of a setup error."""
    told = {str(finding.span) for finding in findings.errors}
    refused = {wire.target.node for wire in _refused(graph)}
    faulty = set()
    for instance in graph.instances:
        if instance.refused or instance.id in refused or (told and not told.isdisjoint(_places(instance.entry))):
            faulty.add(instance.index)
    return faulty


def _places(entry: NodeEntry) -> Iterator[str]:
    """Yield the file positions of a node's key, input keys and input values, as text `path:line:column`."""
    yield str(entry.key_span())
    for name in entry.spec.inputs:
        yield str(entry.span("inputs", name))
        yield str(entry.key_span("inputs", name))


def _follows(instance: Instance, error: GraphError) -> bool:
    """Return whether a setup error of a node follows from an error that was already reported for the node.

    The result is true if the setup error is about an empty value, about an input whose value was refused, or about no input.
    """
    if not isinstance(error, ContextError) or error.value == "":
        return True
    return instance.asking(error.value)[0] in instance.refused


def _refused(graph: Graph) -> list[WireEntry]:
    """Return the wires of the file that the resolved graph lacks because of errors."""
    made = {id(wire.entry) for wire in (*graph.data_wires, *graph.exec_wires)}
    return [entry for entry in graph.flat.wires if id(entry) not in made]


def explain(instance: Instance, error: GraphError) -> Finding:
    """Return the finding for a failed setup of a node, if possible at the position of the input that caused the error."""
    via = instance.entry.via
    if isinstance(error, ContextError):
        return instance.refusal(error)
    if isinstance(error.__cause__, ValueError):  # the node's own sentence about its inputs
        return Finding("G307", f"{instance.id}: {error.__cause__}", instance.span, related=via)
    cause, details = error.__cause__ or error, [line.strip() for line in str(error).split("\n")]
    message = f"{instance.id} cannot be set up: {type(cause).__name__}: {cause}"
    return Finding("G307", message, instance.span, tuple(d for d in details if d.startswith("inputs: ")), via)


def lint_structure(graph: Graph, findings: Findings) -> None:
    """Add a warning for each node that never runs.

    Skipped are graphs whose wires have errors, and files that declare ports for use as a subgraph.
    """
    if _refused(graph) or graph.flat.unread or graph.flat.declared:
        return
    running = set(graph.plan.order)
    events = [i.id for i in graph.instances if i.cls.kind() == "event"]
    for instance in graph.instances:
        if instance.index in running or instance.part_of:
            continue
        if instance.cls.kind() == "data":
            hint = "wire its outputs to a node with an execution input, or remove it"
            code, message = "W102", f"no executed node reads {instance.id}"
        else:
            hint = "the graph has no event node; add one, such as OnPlaybackTick"
            if events:
                hint = f"wire its execution input, for instance from {events[0]}"
            code, message = "W101", f"no event reaches {instance.id}"
        findings.add(code, message, instance.span, hint, related=instance.entry.via)


def lint_rates(graphs: Sequence[Graph], world: World, findings: Findings) -> None:
    """Add a warning for each `every: {hz: …}` above the rate at which the node is executed."""
    for graph in graphs:
        passes = 1.0 / _clock(graph, world).delta
        for gate in graph.instances:
            most = rate(graph, gate.index, passes) or passes
            if not issubclass(gate.cls, EveryHz) or gate.value("hz") <= most:
                continue
            often = f"{gate.value('hz'):g} times a second, but can run at most {most:g} times"
            remedy = "leave `every` out, or raise `tick_rate` of the scene"
            findings.add("W106", f"{gate.part_of} should run {often}", gate.span, remedy, related=gate.entry.via)


def _clock(graph: Graph, world: World) -> Clock:
    return make_clock(world, on_step=graph.runs == "physics_step")


def lint_claims(context: LintContext) -> None:
    """Report conflicts between the topics, services and TF frames that nodes claim, and run the lints of all node types."""
    _check_places(context)
    _check_topic_types(context)
    _check_servers(context)
    _check_clocks(context)
    check_qos(context)
    check_stamps(context)
    _check_transforms(context)
    for code in sorted(LINTS):
        for function in sorted(LINTS[code], key=lambda function: function.__module__):  # the import order has no effect
            function(context)


def _check_places(context: LintContext) -> None:
    """Add a warning for each robot's graph whose prim is not below the robot: the robot's namespace does not apply there."""
    told: set[str] = set()  # a fleet gets one warning, not one for each robot
    prims = {name: robot.path for name, robot in context.stage.robots().items()}
    for graph in context.graphs:
        robot, _, name = graph.name.partition("/")
        path, document = graph.prim_path, graph.flat.loaded.document
        own = prims.get(robot, f"/{robot}")
        if not name or at_or_below(path, own) or str(document.path) in told or "$(" in path:  # an undeclared parameter
            continue
        told.add(str(document.path))
        below = path.removeprefix("/World").split("/")[2:]  # the path below the robot for which the graph was written
        context.findings.add(
            "W107",
            f"graph {name} of robot {robot} has the prim path {path}, which is not below {own}",
            document.span("at" if "at" in document.data else "graph"),
            f"write at: $(robot)/{'/'.join(below) or name}, with parameters: {{robot: {{type: target}}}}",
            "$(robot) is the prim path of the robot that uses the graph",
        )


def _check_topic_types(context: LintContext) -> None:
    users_last = sorted(context.claims, key=lambda claim: claim.direction in ("subscribe", "call"))
    for claim, other in _later(users_last):
        if other.message_type != claim.message_type and not _is_told_elsewhere(claim):
            _, name, here = _what(claim)
            message = f"{name} has the type {here} here and {_what(other)[2]} at {other.node}"
            rule = "a topic has one message type"
            if claim.is_service:
                rule = "an action has one type" if action_of(claim.topic) else "a service has one type"
            context.disagree("G305", message, claim, other, f"{rule}; rename one of them")


def _check_servers(context: LintContext) -> None:
    servers = [claim for claim in context.claims if claim.direction == "serve" and not _is_told_elsewhere(claim)]
    for claim, other in _later(servers):
        what, name, _ = _what(claim)
        message = f"the {what} {name} has a server here and another in {other.node}"
        article = "an" if what == "action" else "a"
        remedy = f"{article} {what} has one server; rename one of the two, or set its nodeNamespace"
        context.disagree("G309", message, claim, other, remedy)


def _later(claims: Iterable[EndpointClaim]) -> Iterator[tuple[EndpointClaim, EndpointClaim]]:
    """Yield each later claim of a topic or service, together with the first claim of the same topic or service."""
    first: dict[tuple[int, str, bool], EndpointClaim] = {}
    for claim in claims:
        other = first.setdefault((_domain(claim), claim.topic, claim.is_service), claim)
        if other is not claim:
            yield claim, other


def _domain(claim: EndpointClaim) -> int:
    """Return the handle of the claim's ROS 2 domain; without a ROS2Context, the handle of domain 0."""
    return claim.ros_context or 1


def _what(claim: EndpointClaim) -> tuple[str, str, str]:
    """Return for a claimed endpoint: `topic`, `service` or `action`, then the name and the type."""
    if action := action_of(claim.topic):
        return "action", action, claim.message_type.rpartition("_")[0]
    return "service" if claim.is_service else "topic", claim.topic, claim.message_type


def _is_told_elsewhere(claim: EndpointClaim) -> bool:
    """Return whether a claim is an endpoint of an action other than `send_goal`; conflicts are reported for `send_goal`."""
    return bool(action_of(claim.topic)) and not claim.topic.endswith("/send_goal")


def _check_clocks(context: LintContext) -> None:
    clocks = (claim for claim in context.claims if claim.message_type == "rosgraph_msgs/msg/Clock")
    for claim, other in _later(clock for clock in clocks if clock.direction == "publish"):
        message = f"{claim.topic} is published by both {other.node} and {claim.node}"
        remedy = "subscribers get each time twice; remove one of the two nodes"
        context.disagree("W212", message, claim, other, remedy)


def _check_transforms(context: LintContext) -> None:
    groups: dict[tuple[int, str], list[tuple[str, str, EndpointClaim]]] = {}
    for claim in context.claims:
        for parent, child in claim.transforms:
            if parent == child:  # tf2 ignores it
                continue
            groups.setdefault((_domain(claim), claim.topic.rpartition("/")[0]), []).append((parent, child, claim))
    for (_, namespace), edges in groups.items():
        _check_parents(context, edges)
        _check_pieces(context, namespace, edges)


def _check_parents(context: LintContext, edges: Iterable[tuple[str, str, EndpointClaim]]) -> None:
    parents: dict[str, tuple[str, EndpointClaim]] = {}
    repeated: dict[tuple[str, str, bool], list[tuple[str, str, EndpointClaim, EndpointClaim]]] = {}
    for parent, child, claim in edges:
        known, first = parents.setdefault(child, (parent, claim))
        if first is not claim or known != parent:
            repeated.setdefault((first.node, claim.node, known == parent), []).append((parent, child, claim, first))
    for frames in repeated.values():
        parent, child, claim, first = frames[0]
        known, _ = parents[child]
        twice = f"frame {child!r} below {parent!r} is published by both {first.node} and {claim.node}"
        parents_differ = f"frame {child!r} has two parents: {known!r} from {first.node}, {parent!r} from {claim.node}"
        more = listing((f"{frame!r}" for _, frame, *_ in frames[1:]), "; also", most=4) if frames[1:] else ""
        remedy = "a frame has one parent and one publisher; rename a frame, or remove one of the two"
        if any(one.graph.endswith("/robot_state") for one in (claim, first)):
            remedy += "; `robot_state: true` of a robot in the scene publishes the transforms of all links"
        message = (twice if known == parent else parents_differ) + more
        context.disagree("G306", message, claim, first, remedy)


def _check_pieces(context: LintContext, namespace: str, edges: Sequence[tuple[str, str, EndpointClaim]]) -> None:
    piece_of: dict[str, set[str]] = {}
    for parent, child, _ in edges:
        smaller, larger = sorted((piece_of.get(frame, {frame}) for frame in (parent, child)), key=len)
        larger |= smaller
        piece_of |= dict.fromkeys((parent, child, *smaller), larger)
    by_robot: dict[str, list[tuple[str, EndpointClaim]]] = {}
    for _, child, claim in edges:
        by_robot.setdefault(namespace or frame_prefix(context.stage, claim.node).rstrip("/"), []).append((child, claim))
    for robot, children in by_robot.items():
        pieces = list({id(piece_of[child]): piece_of[child] for child, _ in children}.values())
        if len(pieces) < 2:
            continue
        roots = [f"{{{', '.join(sorted(piece))}}}" for piece in pieces]
        context.findings.add(
            "W203",
            f"the TF tree{f' of {robot}' if robot else ''} is in {len(pieces)} pieces: {' and '.join(roots)}",
            context.span(children[-1][1]),
            "robot_state_publisher connects them by the robot's fixed joints; "
            "start it, run with --robot-state, or publish the missing transform",
        )
