"""Imports the graphs of a USD stage and the namespaces of its prims.

`stage_process` reads the file with USD's own library (`usd-core`) in a confined process; `graphs` converts the result.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import yaml

from graphengine.compiler.registry import Registry
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd.stage_files import (
    AS_IT_IS,
    SUFFIXES,
    StageChoice,
    needed,
    tell_failure,
    tell_left_out,
    tell_process,
)
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import Files
from graphengine.isaac.recorded_graph import NAMESPACE, RecordedGraph, carried
from graphengine.isaac.stage.graphs import TooManyError, graphs_of
from graphengine.isaac.stage.stage_contents import StageContents
from graphengine.sandbox.borders import admit
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.untrusted import note_used, read

MAX_SECONDS = 60.0
"""Maximum time to read a USD stage, s."""
MAX_ANSWER = 32_000_000
"""Maximum size of the result of the stage process, bytes."""
_PROCESS = "graphengine.isaac.stage.stage_process"


@dataclass(slots=True)
class ImportedStage:
    """The imported parts of a stage.

    Attributes:
        graphs: graphs in stage order.
        namespaces: values of `isaac:namespace` by prim path.
        choices: variant selections on which the graphs may depend, such as `/World: ros = none, of none, ros2`.
    """

    graphs: list[RecordedGraph] = field(default_factory=list)
    namespaces: dict[str, str] = field(default_factory=dict)
    choices: list[str] = field(default_factory=list)

    def scene_lines(self) -> str:
        """Return the namespaces as YAML text for a scene file, because the scene defines the namespaces of graphs."""
        return yaml.safe_dump({"namespaces": self.namespaces}, sort_keys=False, allow_unicode=True)


def read_stage(
    path: Path,
    files: Files,
    registry: Registry,
    findings: Findings,
    *,
    trusted: bool = False,
    choice: StageChoice = AS_IT_IS,
) -> ImportedStage | None:
    """Return the graphs and namespaces of a stage, or None, with an error in `findings`, if the stage cannot be read.

    Args:
        path: `.usd`, `.usda` or `.usdc` file.
        files: decides which layers may be read.
        registry: registry with the current names of node types.
        findings: receives errors, and a finding for each part that is left out or changed.
        choice: variants, and places of assets.
        trusted: whether to read the stage even if the kernel cannot confine USD's readers.

    Raises:
        UsageError: usd-core is not installed, or the file has another suffix.
    """
    _check_usage(path)
    spans = PrimSpans(path)
    if not admit("the stage", findings, spans.start, trusted=trusted):
        return None
    try:
        answer = ask(_PROCESS, choice.request(path, files), MAX_SECONDS)
        contents = read(answer, StageContents, MAX_ANSWER)
    except ProcessError as error:
        tell_process(error, "G401", spans, findings)
        return None
    note_used(contents.used, files)
    if contents.failure:
        tell_failure(contents.failure, "G401", spans, findings)
        return None
    tell_left_out(contents.left_out, spans, findings)
    try:
        graphs = carried(graphs_of(contents, registry, spans, findings), RecordedGraph.names, "graphs", findings)
    except TooManyError as error:
        findings.add("G401", str(error), spans.start, "each use of a compound or instanced graph counts")
        return None
    namespaces = {prim.path: text for prim in contents.prims.values() if (text := prim.text(NAMESPACE))}
    return ImportedStage(graphs, dict(carried(namespaces.items(), tuple, "namespaces", findings)), contents.choices)


def _check_usage(path: Path) -> None:
    if path.suffix not in SUFFIXES:
        raise UsageError(f"{path}: not a .usd, .usda, .usdc or .usdz file")
    if absent := needed():
        raise UsageError(absent)
