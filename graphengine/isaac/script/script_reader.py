"""Reads Isaac Sim scripts as recorded graphs, in a confined process."""

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

from graphengine.format.diagnostics import Finding, Findings, Source, Span
from graphengine.format.files import Files
from graphengine.format.wording import listing
from graphengine.isaac.recorded_graph import RecordedGraph, carried
from graphengine.isaac.script.script_answer import ScriptAnswer
from graphengine.isaac.stage.stage_contents import SUFFIXES
from graphengine.sandbox.borders import admit, missing
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.untrusted import Sources, encoded, read, take_findings

MAX_BYTES = 2_000_000
"""Of a script."""
CODECS = ("utf-8", "utf-8-sig", "ascii", "iso8859-1", "iso8859-15", "cp1252", "gb18030", "gbk", "shift_jis", "euc_kr")
"""Encodings of scripts, by Python's names. Each is decoded in linear time."""
MAX_ANSWER = 64_000_000
"""Bytes."""
MAX_STAGES = 10
"""USD files that are read for a script that opens them."""
SECONDS = 10.0
"""That a script may run."""
STARTING_SECONDS = 20.0
"""That its process gets beside, to start and to answer."""
MAX_RUNS = 4
"""Of a script on a stage that holds what it asks for; each shows what else the script makes itself."""
ReadStage = Callable[[Path], Iterable[RecordedGraph]]
"""Returns the graphs of a USD file."""
_PROCESS = "graphengine.isaac.script.script_process"


@dataclass(frozen=True, slots=True)
class ScriptOptions:
    """What a user says of a script that the script cannot say itself.

    Attributes:
        calls: made in order once it is loaded, such as `build("/World/robot")`; empty to run it as the main program.
        assume: paths of prims and files that are there.
        environment: variables that the script finds.
        impulse_every: ticks after which a node fires to which a loop of the script sends impulses; 0 leaves them out.
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
    """The graphs that a script builds; what it does beside, and what is wrong with it, goes to the findings.

    Args:
        path: the script.
        findings: G401 among them if it cannot be imported.
        arguments: what it finds in `sys.argv`.
        allowed: folders that it may read, beside its own.
        seconds: that it may run.
        namespaces: takes `isaac:namespace` by prim.
        types: names of the node types that there are, for scripts that look for them.
        options: what the user says of the script.
        read_stage: reads the graphs of a USD file that the script opens, if it lies where the script may read.
        trusted: whether it runs where the kernel cannot confine it.
    """
    start = Span(Source(str(path), ()), 1, 1)
    with path.open("rb") as file:
        raw = file.read(MAX_BYTES + 1)
    if len(raw) > MAX_BYTES:
        findings.add("G401", f"a script of more than {MAX_BYTES // 1_000_000} MB", start)
        return []
    try:
        text = decoded(raw)
    except (SyntaxError, ValueError) as error:
        findings.add("G401", f"this is no Python: {error}", start)
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
    """The text of a Python file.

    Raises:
        SyntaxError, ValueError: it says another encoding than it has, or one that is none of `CODECS`.
    """
    encoding, _ = tokenize.detect_encoding(io.BytesIO(raw).readline)
    if codecs.lookup(encoding).name not in CODECS:
        raise SyntaxError(f"the encoding {encoding!r} is not read; {listing(CODECS)}; save it as UTF-8")
    return io.IncrementalNewlineDecoder(None, translate=True).decode(raw.decode(encoding))


def _run(path: Path, request: dict[str, Any], findings: Findings, read_stage: ReadStage) -> ScriptAnswer:
    """Run a script on an empty stage; if it fails or builds nothing there, on one that holds what it asks for.

    Of what it asks for, that stage lacks what the script makes itself: which prims these are, an earlier run shows.
    """
    start = Span(Source(str(path), ()), 1, 1)
    first = _run_once(path, request)
    stages = list(dict.fromkeys(first.stages))
    graphs_of = cache(read_stage)  # several names may mean one file
    if len(stages) > MAX_STAGES:
        findings.add("W302", f"{len(stages) - MAX_STAGES} of the stages that the script opens are left out", start)
    for name in stages[:MAX_STAGES]:
        file = path.parent / name
        readable = file.suffix in SUFFIXES and os.path.isfile(file) and _readable(path, request).may_read(file)
        if readable and (graphs := list(graphs_of(file.resolve()))):
            request["stages"][name] = graphs
    if request["stages"]:
        request["literals"] = False  # it is executed on the stages
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
        findings.add("N302", "what the script asks for and does not make is taken to be there", start)
    return chosen


def _run_on_a_full_stage(path: Path, request: dict[str, Any], first: ScriptAnswer) -> ScriptAnswer:
    """Run a script on a stage that holds what it asks for, but for what it makes itself."""
    absent: set[str] = set()
    for _ in range(MAX_RUNS):
        other = _run_once(path, {**request, "assumed": True, "absent": sorted(absent)})
        own = other.granted & (first.made | other.made)
        if not own or not other.may_differ:
            break
        absent |= own
    return other


def _with_nodes(graphs: Iterable[RecordedGraph], findings: Findings) -> list[RecordedGraph]:
    """Those that are not empty."""
    for graph in graphs:
        if not graph.nodes:
            findings.add("N302", f"the graph {graph.path} has no nodes and is left out", graph.span)
    return [graph for graph in graphs if graph.nodes]


def _readable(path: Path, request: dict[str, Any]) -> Files:
    """The folders that a script may read."""
    return Files((path.absolute().parent.resolve(), *map(Path, request["allowed"])))


def _run_once(path: Path, request: dict[str, Any]) -> ScriptAnswer:
    """Read what a script builds on one kind of stage."""
    sources = Sources(_readable(path, request), Source(str(path), tuple(request["text"].split("\n"))))
    try:
        answer = ask(_PROCESS, encoded(request).encode(), request["seconds"] + STARTING_SECONDS)
        return read(answer, ScriptAnswer, MAX_ANSWER, sources.span)
    except ProcessError as error:
        finding = Finding("G401", f"the script cannot be run: {error}", Span(Source(str(path), ()), 1, 1))
        return ScriptAnswer(findings=[finding])
