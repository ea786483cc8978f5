"""Sets the namespaces that a scene file lists on prims of the stage, including the prims of graphs and nodes."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.compiler.graph import Graph
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import PrimError
from graphengine.format.prim_paths import at_or_below
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import Loaded


def write_namespaces(
    scene: Loaded[SceneSpec], stage: Stage, graphs: Sequence[Graph], findings: Findings, within: str = ""
) -> None:
    """Set the namespaces that a scene file lists on the prims of the stage.

    Args:
        scene: scene file with the namespaces by prim path.
        stage: stage that has the prims; the prims of graphs and nodes are added if they are missing.
        graphs: graphs to whose prims and nodes the paths can refer.
        findings: receives an error for each path without a prim, unless there are other errors or `within` is given: then the
            prim may be missing for another reason.
        within: path of a prim; namespaces are set only at this prim and below it. Empty: on the whole stage.
    """
    complete = not within and not findings.errors
    nodes = [f"{graph.prim_path}/{instance.id}" for graph in graphs for instance in graph.instances]
    for path, namespace in scene.spec.namespaces.items():
        try:
            if path not in stage and any(stage.leads_by(node, path) for node in nodes):
                stage.define(path)
            prim = stage.find(path)
            if at_or_below(prim.path, within):
                prim.namespace = namespace
        except PrimError as error:
            if complete:
                findings.add("S104", error.message, scene.document.key_span("namespaces", path), *error.help)
