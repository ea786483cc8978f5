"""Finds the graph files of scenes and robots, and resolves them to graphs with their parameters inserted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.compiler.filled_document import Places, Use
from graphengine.compiler.graph import Graph
from graphengine.compiler.library import GraphLibrary
from graphengine.compiler.literals import Override
from graphengine.compiler.resolve import resolve
from graphengine.compiler.subgraph_expansion import load_graph
from graphengine.devices.stage import Prim, Stage
from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.prim_paths import normalize
from graphengine.format.spec import GraphUse
from graphengine.scene.loaded_scene import LoadedScene

if TYPE_CHECKING:
    from graphengine.physics.model.robot import RobotInstance

MAX_SCENE_PARTS = 100_000
"""Maximum total number of nodes, wires and variables in all graphs of a scene; a dd100 robot has 70."""


@dataclass(frozen=True, slots=True)
class GraphFile:
    """A graph file to load.

    Attributes:
        path: path of the file.
        name: name of the graph, `robot/graph` for a robot's graph.
        parameters: values of the graph's parameters.
        at: prim path for the graph; empty takes the path in the graph file.
        use: position of the entry that refers to the graph file in a scene or robot file; None without an entry.
        asked_for: whether an option, such as `--robot-state`, adds the graph.
    """

    path: Path
    name: str
    parameters: Mapping[str, Any]
    at: str
    use: Use | None = None
    asked_for: bool = False


def robot_uses(robot: RobotInstance, stage: Stage, scene: LoadedScene) -> list[GraphFile]:
    """Return the graph files of a robot: those in the robot file in the file's order, then those that options add.

    Args:
        robot: robot of the scene.
        stage: prims of the world, with those of the robot.
        scene: gives the options and the files that may be read, and receives the findings.
    """
    uses: list[GraphFile] = []
    prim, files, options = stage.find(robot.prim_path), scene.files, scene.options
    for graph, use in robot.spec.graphs.items():
        place, folder = use_place(robot.file, graph, use), robot.file.folder("graphs", graph, "use")
        uses += find_use(use, f"{robot.name}/{graph}", place, folder, {"robot": prim.path}, files, scene.findings)
    if options.robot_state or robot.placement.use.robot_state:
        uses.append(_shipped_graph("robot_state", robot, prim, files, asked_for=options.robot_state))
    if options.localization == "truth" and robot.disabled.free_link is not None:
        uses.append(_shipped_graph("localization", robot, prim, files, asked_for=True))
    return uses


def _shipped_graph(name: str, robot: RobotInstance, prim: Prim, files: Files, *, asked_for: bool) -> GraphFile:
    """Return the graph file of an included graph, such as `robot_state`, with the parameters for a robot."""
    root = str(prim.facts.get("articulation_root") or prim.facts.get("base_link"))
    path = files.find(f"graphs/{name}.yaml", files.base)
    return GraphFile(path, f"{robot.name}/{name}", {"robot": prim.path, "root": root}, "", asked_for=asked_for)


def use_place(file: Places, graph: str, use: GraphUse) -> Use:
    """Return the positions of the key `use` and of the parameters in a graph's entry, for error messages."""
    return Use(file.span("graphs", graph, "use"), file, ("graphs", graph, "parameters"), use.parameters.keys())


def find_use(
    use: GraphUse, name: str, place: Use, folder: Path, bindings: Mapping[str, Any], files: Files, findings: Findings
) -> list[GraphFile]:
    """Return a list with the graph file of an entry in a scene or robot file; empty, with an error, if the file is missing.

    The robot's prim path in `bindings` replaces `$(robot)` in the prim path of the entry.
    """
    path = files.look_up(use.use, folder, findings, place.span, f"graph {name!r}: ")
    at = use.at.replace("$(robot)", str(bindings.get("robot", "$(robot)")))
    return [GraphFile(path, name, {**bindings, **use.parameters}, at, place)] if path is not None else []


def resolve_uses(uses: Sequence[GraphFile], scene: LoadedScene, overrides: Sequence[Override]) -> list[Graph]:
    """Return the graphs of the given files with their parameters inserted; add errors to the findings of the scene."""
    graphs: list[Graph] = []
    library, parts, findings = GraphLibrary(scene.files), 0, scene.findings
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
        recorded = scene.options.recorded
        graphs.append(resolve(flat, use.name, prim_path, scene.registry, findings, overrides, recorded=recorded))
    return graphs


def _declared_parameters(found: document.Document | None) -> Sequence[str]:
    declared = found.data.get("parameters") if found and isinstance(found.data, dict) else None
    return list(declared) if isinstance(declared, dict) else []
