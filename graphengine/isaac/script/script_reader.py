"""Imports the graphs of an Isaac Sim script by running it in a confined process."""

from __future__ import annotations

import codecs
import io
import os
import tokenize
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from graphengine.descriptions.usd.stage_files import SUFFIXES
from graphengine.format.diagnostics import Finding, Findings, Source, Span
from graphengine.format.files import Files
from graphengine.format.wording import listing
from graphengine.isaac.recorded_graph import RecordedGraph, carried
from graphengine.isaac.script.script_answer import ScriptAnswer
from graphengine.sandbox.borders import admit, missing
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.untrusted import Sources, encoded, read, take_findings

MAX_BYTES = 2_000_000
"""Maximum size of a script, bytes."""
CODECS = ("utf-8", "utf-8-sig", "ascii", "iso8859-1", "iso8859-15", "cp1252", "gb18030", "gbk", "shift_jis", "euc_kr")
"""Allowed encodings of scripts, as named by Python; only encodings that are decoded in linear time."""
MAX_ANSWER = 64_000_000
"""Maximum size of the result of the script process, bytes."""
MAX_STAGES = 10
"""Maximum number of USD files that are read because a script opens them."""
SECONDS = 10.0
"""Default time limit of a script, s."""
STARTING_SECONDS = 20.0
"""Time for the start and the result of the script process, in addition to the time limit of the script, s."""
MAX_RUNS = 4
"""Maximum number of runs in which queried prims are assumed to exist; each run shows which prims the script creates itself."""
ReadStage = Callable[[Path], Iterable[RecordedGraph]]
"""Function that returns the graphs of a USD file."""
_PROCESS = "graphengine.isaac.script.script_process"


@dataclass(frozen=True, slots=True)
class ScriptOptions:
    """The user's options for the import of a script.

    Attributes:
        calls: calls to make after the script is loaded, such as `build("/World/robot")`; if empty, it runs as the main program.
        assume: paths of prims and files that are assumed to exist, and names of stubs that are assumed to be true.
        environment: environment variables of the script.
        impulse_every: period, in ticks, of the OnTick nodes that replace nodes to which a loop of the script sends impulses;
            0: these nodes are not replaced.
    """

    calls: tuple[str, ...] = ()
    impulse_every: int = 0
    assume: tuple[str, ...] = ()
    environment: Mapping[str, str] = field(default_factory=dict)


def read_script(
    path: Path,
    findings: Findings,
    arguments: Sequence[str] = (),
    allowed: Sequence[Path] = (),
    seconds: float = SECONDS,
    namespaces: dict[str, str] | None = None,
    types: Collection[str] = (),
    options: ScriptOptions = ScriptOptions(),
    read_stage: ReadStage = lambda _: (),
    *,
    trusted: bool = False,
) -> list[RecordedGraph]:
    """Run a script and return the graphs that it builds; report its errors and its other actions in `findings`.

    Args:
        path: script to run.
        findings: receives the findings of the run; G401 if the script cannot be imported.
        arguments: command line arguments that the script sees in `sys.argv`.
        allowed: folders that the script may read in addition to its own.
        seconds: time limit of the script, s.
        namespaces: receives the values of `isaac:namespace` by prim path.
        types: names of the available node types, which scripts can query.
        options: the user's options.
        read_stage: returns the graphs of a USD file that the script opens; called only for files that the script may read.
        trusted: whether to run the script even if the kernel cannot confine its process.
    """
    start = Span(Source(str(path), ()), 1, 1)
    with path.open("rb") as file:
        raw = file.read(MAX_BYTES + 1)
    if len(raw) > MAX_BYTES:
        findings.add("G401", f"the script is larger than {MAX_BYTES // 1_000_000} MB", start)
        return []
    try:
        text = decoded(raw)
    except (SyntaxError, ValueError) as error:
        findings.add("G401", f"not valid Python: {error}", start)
        return []
    request = {
        "path": str(path),
        "text": text,
        "arguments": list(arguments),
        "allowed": [str(folder.resolve()) for folder in allowed],
        "seconds": seconds,
        "types": sorted(types),
        **asdict(options),
        "literals": not arguments and options == ScriptOptions(),
        "run": trusted or not missing(),
        "stages": {},
        "assumed": False,
        "forgiving": False,
        "absent": [],
    }
    chosen = _run(path, request, findings, read_stage)
    if chosen.executed and not admit("the script", findings, start, trusted=trusted):
        return []
    take_findings(chosen.findings, findings)
    if chosen.failed:
        return []
    if namespaces is not None:
        namespaces.update(carried(chosen.namespaces.items(), tuple, "namespaces", findings))
    return _with_nodes(carried(chosen.graphs, RecordedGraph.names, "graphs", findings), findings)


def decoded(raw: bytes) -> str:
    """Return the text of a Python file, decoded with its declared encoding.

    Raises:
        SyntaxError, ValueError: the file does not have the declared encoding, or the encoding is not one of `CODECS`.
    """
    encoding, _ = tokenize.detect_encoding(io.BytesIO(raw).readline)
    if codecs.lookup(encoding).name not in CODECS:
        raise SyntaxError(f"the encoding {encoding!r} is not supported; {listing(CODECS)}; save the file as UTF-8")
    return io.IncrementalNewlineDecoder(None, translate=True).decode(raw.decode(encoding))


def _run(path: Path, request: dict[str, Any], findings: Findings, read_stage: ReadStage) -> ScriptAnswer:
    """Run a script on an empty stage, and again with assumed prims if it fails or builds nothing; return the better result.

    If the script opens USD files that may be read, it first runs again with the graphs of these files.
    """
    start = Span(Source(str(path), ()), 1, 1)
    first = _run_once(path, request)
    stages = list(dict.fromkeys(first.stages))
    graphs_of = cache(read_stage)  # several names may refer to one file
    if len(stages) > MAX_STAGES:
        findings.add("W302", f"{len(stages) - MAX_STAGES} of the USD files that the script opens are left out", start)
    for name in stages[:MAX_STAGES]:
        file = path.parent / name
        readable = file.suffix in SUFFIXES and os.path.isfile(file) and _readable(path, request).may_read(file)
        if readable and (graphs := list(graphs_of(file.resolve()))):
            request["stages"][name] = graphs
    if request["stages"]:
        request["literals"] = False  # the script must run as Python
        first = _run_once(path, request)
    chosen = other = first
    for forgiving in (False, True):
        if not other.may_differ or not (chosen.failed or chosen.stopped or not (chosen.graphs or forgiving)):
            break
        other = _run_on_a_full_stage(path, {**request, "forgiving": forgiving}, first)
        more = chosen.failed or (chosen.nodes < other.nodes if forgiving else chosen.nodes <= other.nodes)
        if other.graphs and not other.failed and more and (forgiving or chosen.failed or not other.stopped):
            chosen = other
    if chosen is not first:
        findings.add("N302", "objects that the script uses but does not create are assumed to exist", start)
    return chosen


def _run_on_a_full_stage(path: Path, request: dict[str, Any], first: ScriptAnswer) -> ScriptAnswer:
    """Run a script on a stage on which each prim exists that it queries, except prims that it creates itself."""
    absent: set[str] = set()
    for _ in range(MAX_RUNS):
        other = _run_once(path, {**request, "assumed": True, "absent": sorted(absent)})
        own = other.granted & (first.made | other.made)
        if not own or not other.may_differ:
            break
        absent |= own
    return other


def _with_nodes(graphs: Iterable[RecordedGraph], findings: Findings) -> list[RecordedGraph]:
    """Return the graphs that have nodes; report each graph without nodes."""
    for graph in graphs:
        if not graph.nodes:
            findings.add("N302", f"the graph {graph.path} has no nodes and is left out", graph.span)
    return [graph for graph in graphs if graph.nodes]


def _readable(path: Path, request: dict[str, Any]) -> Files:
    """Return the file access policy of a script, which may read its own folder and the folders that the user allows."""
    return Files((path.absolute().parent.resolve(), *map(Path, request["allowed"])))


def _run_once(path: Path, request: dict[str, Any]) -> ScriptAnswer:
    """Run a script once in a confined process and return the result; if the process fails, return a result with G401."""
    sources = Sources(_readable(path, request), Source(str(path), tuple(request["text"].split("\n"))))
    try:
        answer = ask(_PROCESS, encoded(request).encode(), request["seconds"] + STARTING_SECONDS)
        return read(answer, ScriptAnswer, MAX_ANSWER, sources.span)
    except ProcessError as error:
        finding = Finding("G401", f"the script cannot be run: its process {error}", Span(Source(str(path), ()), 1, 1))
        return ScriptAnswer(findings=[finding])
