"""Sets the namespaces of a scene file on prims of the stage, including the prims of graphs and nodes."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.compiler.graph import Graph
from graphengine.devices.stage import Stage, at_or_below
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import PrimError
from graphengine.format.spec import SceneSpec
from graphengine.format.spec_reader import Loaded


def write_namespaces(
    scene: Loaded[SceneSpec], stage: Stage, graphs: Sequence[Graph], findings: Findings, within: str = ""
) -> None:
    """Set the namespaces of a scene file on the prims of the stage, from which nodes collect them.

    Args:
        scene: scene file with the namespaces by prim path.
        stage: stage to change; missing prims of graphs and nodes are added.
        graphs: graphs whose prims, and those of their nodes, can have a namespace.
        findings: findings to add an error to for a path without a prim; not after other errors, which may have removed a graph.
        within: path of the prim at and below which namespaces are set; empty for the whole stage.
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
