"""Namespaces that a scene writes on prims of its stage, and on those of graphs and nodes."""

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
    """Put the scene's namespaces where nodes collect them.

    Args:
        scene: what is written, and where.
        stage: takes it; a graph's prim is added.
        graphs: whose prims may be meant.
        findings: takes paths at which there is neither a prim nor a graph, unless mistakes may be why there is no graph.
        within: a prim whose part of the stage alone is written on; everything when empty.
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
