"""Makes the project of a whole USD stage for `graphrun new`: its robots, its world and its ActionGraphs as one scene."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli import import_urdf
from graphengine.cli.common import clean, print_findings
from graphengine.cli.import_report import report
from graphengine.cli.progress import progress
from graphengine.cli.project import WORLDS, Project
from graphengine.format.diagnostics import CheckError, Findings
from graphengine.format.prim_paths import prim_name
from graphengine.format.wording import listing
from graphengine.format.yaml_text import flow, scalar

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported
    from graphengine.descriptions.usd.articulations import Articulation
    from graphengine.descriptions.usd.stage_files import StageChoice
    from graphengine.descriptions.usd_model import PhysicsContents
    from graphengine.format.files import Files
    from graphengine.isaac.recorded_graph import RecordedGraph


@dataclass(slots=True)
class StageProject:
    """The parts of a stage.

    Attributes:
        path: path of the stage.
        files: files that the stage may read.
        choice: what to read of the stage.
        contents: its physics.
        trees: its robots.
        graphs: its graphs.
        namespaces: values of `isaac:namespace` by prim path.
        robots: imported robots, by name.
        at: prim paths of the robots in the scene.
        moved: prim paths in the scene by paths in the stage, where they differ.
        world: whether the world of the scene is that of the stage.
    """

    path: Path
    files: Files
    choice: StageChoice
    contents: PhysicsContents
    trees: list[Articulation]
    graphs: list[RecordedGraph]
    namespaces: dict[str, str]
    robots: dict[str, Imported] = field(default_factory=dict)
    at: dict[str, str] = field(default_factory=dict)
    moved: dict[str, str] = field(default_factory=dict)
    world: bool = False

    @property
    def whole(self) -> bool:
        """Whether there is more than one robot without a world and graphs."""
        return self.world or bool(self.graphs) or len(self.trees) > 1


def read_whole(arguments: argparse.Namespace, path: Path, findings: Findings) -> StageProject | None:
    """Return the robots, graphs and namespaces of a stage before any robot is imported; None after an error."""
    from graphengine.compiler.registry import default_registry
    from graphengine.descriptions.usd.articulations import articulations
    from graphengine.descriptions.usd.prim_spans import PrimSpans
    from graphengine.descriptions.usd.usd_reader import chosen, read_physics
    from graphengine.isaac.stage.stage_reader import read_stage

    files, choice = import_urdf.stage_choice(arguments, path)
    contents = read_physics(path, files, findings, choice)
    graphs = read_stage(path, files, default_registry(), findings, choice=choice) if contents is not None else None
    if contents is None or graphs is None:
        return None
    trees = [tree for tree in articulations(contents) if tree.moves]
    if choice.robot:
        tree = chosen(contents, choice.robot, PrimSpans(path), findings)
        trees = [tree] if tree is not None else []
    found = StageProject(path, files, choice, contents, trees, graphs.graphs, graphs.namespaces)
    found.world = arguments.world is None and any(shape.solid for shape in contents.shapes)
    return found


def make(arguments: argparse.Namespace, project: Project, stage: StageProject, findings: Findings) -> int:
    """Write the project of a stage; return 0, or 1 after an error, when nothing is written."""
    from graphengine.bringup.robots.bundle import bundle_stage

    with progress("importing"):
        _import_robots(arguments, project, stage, findings)
    texts = _graph_texts(stage, findings)
    print_findings(findings, notes=False)
    if findings.errors:
        print(f"{project.folder} is not written", file=sys.stderr)
        return 1
    used = [Path(each) for each in stage.contents.used if stage.files.may_read(Path(each))]
    robots = project.robot_file.parent
    copies = {robots / to: source for to, source in bundle_stage(used, project.name).items()}
    world = WORLDS[arguments.world or "flat"].file
    if stage.world:
        copied = next(to for to, source in copies.items() if source == stage.path.resolve())
        world = os.path.relpath(copied, project.folder)

    def write(left_out: Mapping[str, str]) -> None:
        text = "\n".join([*_scene(project.name, world, stage, texts, left_out), ""])
        project.add_stage([*stage.robots.values()], text, texts, copies, str(stage.path))
        project.write()

    write({})
    unusable = _unusable(project.scene_file)
    if unusable:
        write(unusable)
    for imported in stage.robots.values():
        print(clean("\n".join(report(imported, findings))))
    print(clean("\n".join(_told(stage, texts, unusable))))
    print(project.told())
    return 0


def _import_robots(arguments: argparse.Namespace, project: Project, stage: StageProject, findings: Findings) -> None:
    from graphengine.bringup.robots.import_robot import import_robot
    from graphengine.bringup.robots.stage_places import moved_paths, robot_path
    from graphengine.descriptions.usd.usd_reader import description_of
    from graphengine.descriptions.usd.usd_world import world_names

    for tree in stage.trees:
        name = project.name if len(stage.trees) == 1 else _free(prim_name(tree.prim.rpartition("/")[2]), stage.robots)
        description = description_of(stage.contents, tree, stage.path, stage.files, findings)
        if description is None or description.usd is None:
            continue
        target = project.robot_file.with_stem(name)
        choice = replace(stage.choice, robot=tree.prim)
        origin = import_urdf.stage_origin(arguments, stage.path, target, description, choice)
        commanded = any(drive.commands for drive in description.usd.drives.values())
        origin = replace(origin, path=None, bundled=True, stage_name=project.name, commanded=commanded)
        imported = import_robot(origin, findings)
        if imported is not None:
            at = robot_path(tree, stage.trees, name)
            stage.robots[name], stage.at[name] = imported, at
            stage.moved |= moved_paths(imported, tree, at)
    if stage.world:
        names = {path: f"/World/{prim_name(name)}" for path, name in world_names(stage.contents).items()}
        stage.moved |= {path: place for path, place in names.items() if path != place}


def _free(name: str, taken: Mapping[str, Any]) -> str:
    while name in taken:
        name += "_"
    return name


def _graph_texts(stage: StageProject, findings: Findings) -> dict[str, str]:
    """Return the texts of the graph files by name."""
    from graphengine.compiler.registry import default_registry
    from graphengine.isaac.graph_file import compose, file_names

    for graph in stage.graphs:
        graph.move_prims(stage.moved)
    names = file_names(stage.graphs)
    registry, origin = default_registry(), stage.path.name
    return {
        name: compose(graph, name, registry, findings, origin) for name, graph in zip(names, stage.graphs, strict=True)
    }


def _scene(
    name: str, world: str, stage: StageProject, graphs: Mapping[str, str], left_out: Mapping[str, str]
) -> Iterator[str]:
    """Yield the lines of the scene file.

    Args:
        name: name of the scene.
        world: path of the world.
        stage: parts of the stage.
        graphs: texts of the graph files by name.
        left_out: errors of graphs that the scene does not use, by name.
    """
    yield f"# The scene that `graphrun run {name}.yaml` runs: the robots, the world and the graphs of {stage.path.name}."
    yield "format: 1"
    yield f"scene: {scalar(name)}"
    yield f"world: {scalar(world)}"
    if stage.world:
        yield from (f"{key}: {flow(value)}" for key, value in stage.choice.keys().items() if key != "usd_robot")
    yield "physics: {tick_rate: 60, substeps: 4}"
    yield "settle: true    # let the robots come to rest before t = 0"
    yield "robots:" if stage.robots else "robots: {}"
    for key, imported in stage.robots.items():
        yield f"  {key}: {flow(_robot_use(imported, stage.at[key], stage))}"
    yield "graphs:" if graphs else "graphs: {}"
    if not any("ROS2PublishClock" in text for text in graphs.values()):
        yield "  clock_of_scene: {use: graphs/clock.yaml, at: /World/clock_of_scene}"
    for key in graphs:
        entry = f"{key}: {{use: ./graphs/{key}.yaml}}"
        yield f"  # {entry}    # {left_out[key]}" if key in left_out else f"  {entry}"
    known = {
        path
        for imported in stage.robots.values()
        if (usd := imported.robot.description.usd)
        for path in usd.paths.values()
    }
    if namespaces := {path: text for path, text in stage.namespaces.items() if path not in known}:
        yield "namespaces:"
        yield from (f"  {flow(stage.moved.get(path, path))}: {flow(text)}" for path, text in namespaces.items())


def _robot_use(imported: Imported, at: str, stage: StageProject) -> dict[str, Any]:
    usd = imported.robot.description.usd
    assert usd is not None
    (x, y, z), turn = usd.pose
    if not stage.world:
        z = imported.lift + imported.rise
    use: dict[str, Any] = {"use": f"robots/{imported.robot.name}.yaml", "at": at}
    use["position"] = [round(part, 6) + 0.0 for part in (x, y, z)]
    quaternion = [round(part, 9) + 0.0 for part in turn]
    if quaternion != [0.0, 0.0, 0.0, 1.0]:
        use["orientation"] = {"quaternion_xyzw": quaternion}
    if not stage.graphs:
        use["robot_state"] = True
    return use


def _unusable(scene: Path) -> dict[str, str]:
    """Return the first error of each graph with errors of a written scene, by the name of its file."""
    from graphengine.api.scene_loading import load

    try:
        load(scene)
    except CheckError as error:
        errors = [each for each in error.findings if each.severity == "error" and each.span is not None]
        places = [(Path(each.span.source.path), each.message) for each in errors if each.span is not None]
        in_graphs = {path.stem: message for path, message in reversed(places) if path.parent.name == "graphs"}
        if not in_graphs:
            raise
        return in_graphs
    return {}


def _told(stage: StageProject, graphs: Mapping[str, str], unusable: Mapping[str, str]) -> Iterator[str]:
    """Yield lines about the world and the graphs."""
    loose = len(stage.contents.bodies) - sum(len([path for path in tree.bodies if path]) for tree in stage.trees)
    if stage.world:
        yield f"world: that of the stage, with {len(stage.contents.shapes)} shapes and {loose} bodies beside the robots"
    elif loose:
        yield f"the world of the stage is left out, with its {loose} bodies beside the robots: it has no floor"
    if used := [name for name in graphs if name not in unusable]:
        yield listing(used, "graphs", 12)
    for name, message in unusable.items():
        yield f"not carried over: the scene leaves out the graph {name}: {message}"
