"""Finds the graph files that scenes and robots use, and resolves them with their parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.compiler.filled_document import Use
from graphengine.compiler.graph import Graph
from graphengine.compiler.library import GraphLibrary
from graphengine.compiler.literals import Override
from graphengine.compiler.registry import Registry
from graphengine.compiler.resolve import resolve
from graphengine.compiler.subgraph_expansion import load_graph
from graphengine.devices.stage import Prim, Stage, normalize
from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.spec import GraphUse

if TYPE_CHECKING:
    from graphengine.physics.description.robot_file import RobotFile
    from graphengine.physics.model.robot import RobotInstance
    from graphengine.scene.loaded_scene import Options

MAX_SCENE_PARTS = 100_000
"""Nodes, wires and variables of all graphs of a scene; a dd100 has 70."""


@dataclass(frozen=True, slots=True)
class GraphFile:
    """A graph file to load, with its parameters and the name of the graph in messages."""

    path: Path
    name: str
    parameters: Mapping[str, Any]
    at: str
    use: Use | None = None
    """Where a file says so."""
    asked_for: bool = False
    """By an option, whatever the files say."""


def robot_uses(
    robot: RobotInstance, stage: Stage, files: Files, findings: Findings, options: Options
) -> list[GraphFile]:
    """Return the graph files of a robot, in the order of the robot file, then those that options add."""
    uses: list[GraphFile] = []
    prim = stage.find(robot.prim_path)
    for graph, use in robot.spec.graphs.items():
        place, folder = use_place(robot.file, graph, use), robot.file.folder("graphs", graph, "use")
        uses += find_use(use, f"{robot.name}/{graph}", place, folder, {"robot": prim.path}, files, findings)
    if options.robot_state or robot.placement.use.robot_state:
        uses.append(_shipped_graph("robot_state", robot, prim, files, asked_for=options.robot_state))
    if options.localization == "truth" and robot.disabled.free_link is not None:
        uses.append(_shipped_graph("localization", robot, prim, files, asked_for=True))
    return uses


def _shipped_graph(name: str, robot: RobotInstance, prim: Prim, files: Files, *, asked_for: bool) -> GraphFile:
    """Return the graph file of an included graph, such as `robot_state`, for a robot."""
    root = str(prim.facts.get("articulation_root") or prim.facts.get("base_link"))
    path = files.find(f"graphs/{name}.yaml", files.base)
    return GraphFile(path, f"{robot.name}/{name}", {"robot": prim.path, "root": root}, "", asked_for=asked_for)


def use_place(file: document.Document | RobotFile, graph: str, use: GraphUse) -> Use:
    """Return the places of a graph's `use` key and of its parameters, for error messages."""
    return Use(file.span("graphs", graph, "use"), file, ("graphs", graph, "parameters"), use.parameters.keys())


def find_use(
    use: GraphUse, name: str, place: Use, folder: Path, bindings: Mapping[str, Any], files: Files, findings: Findings
) -> list[GraphFile]:
    """Return the graph file that a scene or robot file refers to; empty, with an error in `findings`, if it does not exist."""
    path = files.look_up(use.use, folder, findings, place.span, f"graph {name!r}: ")
    return [GraphFile(path, name, {**bindings, **use.parameters}, use.at, place)] if path is not None else []


def resolve_uses(
    uses: Sequence[GraphFile], files: Files, registry: Registry, findings: Findings, overrides: Sequence[Override] = ()
) -> list[Graph]:
    """Return the graphs of the files, with their parameters inserted; errors in files are added to `findings`."""
    graphs: list[Graph] = []
    library, parts = GraphLibrary(files), 0
    for use in uses:
        declared = _declared_parameters(library.read(use.path, findings))
        parameters = {k: v for k, v in use.parameters.items() if k in declared or k not in ("robot", "root")}
        flat = load_graph(use.path, parameters, library, findings, use.use)
        if flat is None:
            continue
        parts += len(flat.nodes) + len(flat.wires) + len(flat.variables)
        if parts > MAX_SCENE_PARTS:
            message = f"more than {MAX_SCENE_PARTS} nodes, wires and variables in the graphs of one scene"
            findings.add("G105", message, use.use.span if use.use else None, "use fewer graphs or fewer robots")
            return []
        at = use.at or flat.spec.at or f"/World/{flat.spec.graph}"
        prim_path = normalize(at) if at.startswith("/") else f"/{at}"
        graphs.append(resolve(flat, use.name, prim_path, registry, findings, overrides))
    return graphs


def _declared_parameters(found: document.Document | None) -> Sequence[str]:
    declared = found.data.get("parameters") if found and isinstance(found.data, dict) else None
    return list(declared) if isinstance(declared, dict) else []
