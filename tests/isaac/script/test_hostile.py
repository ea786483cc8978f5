"""Scripts of strangers: whatever they try, nothing outside of their process changes and one line tells why they failed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.compiler.registry import default_registry
from graphengine.format.diagnostics import Finding, Findings, Source, Span, to_json
from graphengine.format.errors import GraphError
from graphengine.isaac.graph_file import compose, file_names
from graphengine.isaac.recorded_graph import RecordedGraph, RecordedNode, RecordedValue, RecordedWire
from graphengine.isaac.script import script_reader
from graphengine.isaac.script.script_answer import ScriptAnswer
from graphengine.isaac.script.script_reader import read_script
from graphengine.sandbox.borders import missing
from graphengine.sandbox.untrusted import encoded
from tests.descriptions.files.forging import forged
from tests.isaac.harness import kept_answers

GRAPH = 'import omni.graph.core as og\nog.Controller.edit("/g", {"create_nodes": ("T", "omni.graph.action.OnTick")})\n'
SECONDS = 0.5


def told(folder: Path, text: str | bytes, seconds: float = SECONDS) -> list[str]:
    path = folder / "script.py"
    path.write_bytes(text if isinstance(text, bytes) else (GRAPH + text).encode())
    before = sorted(folder.iterdir())
    findings = Findings()
    graphs = read_script(path, findings, seconds=seconds)
    assert sorted(folder.iterdir()) == before
    assert bool(graphs) == (not findings.errors)
    return [finding.render() for finding in findings.items]


@pytest.mark.parametrize(
    ("attempt", "complaint"),
    [
        ("while True: pass", "3:1: error G401: the script takes longer than its time limit"),
        (
            "while True:\n    try:\n        while True: pass\n    except BaseException: pass",
            "takes longer than its time limit",
        ),
        (
            "import os\nos.system('touch owned')",
            "4:1: error G401: not allowed for scripts: os.system is not allowed",
        ),
        ("open('/etc/passwd')", "3:1: error G401: not allowed for scripts: '/etc/passwd' lies outside"),
        ("import os\nos.listdir('/')", "'/' lies outside the folder of the file you gave"),
        ("import os\nos.open('owned', os.O_CREAT | os.O_RDWR)", "'owned' may not be written"),
        (
            "open('owned', 'w').write('x')",
            "note N302: the file 'owned', which the script writes, does not belong to a graph",
        ),
        ("from pathlib import Path\nPath(__file__).unlink()", "os.remove is not allowed here"),
        ("import os\nos.fork()", "os.fork is not allowed here"),
        ("import os\nos.kill(os.getppid(), 9)", "os.kill is not allowed here"),
        ("x = [0] * 10 ** 10", "3:5: error G401: the script takes more than 1024 MiB"),
        ("def f(): f()\nf()", "3:10: error G401: the script recurses without end"),
        ("import sys\nsys.exit('no')", "4:1: warning W302: the script ended with exit('no')"),
        ("raise ValueError('bad \\x1b[31m')", "3:1: warning W302: ValueError: bad \N{REPLACEMENT CHARACTER}[31m"),
        ("raise BaseException", "3:1: warning W302: BaseException: no message"),
        ("import os\nos.write(1, b'{}')\nos._exit(0)", "sends a malformed answer"),
        ("import os\nos._exit(3)", "the script cannot be run"),
        ("import os\nos.abort()", "the script cannot be run: its process crashed: Aborted"),
        ("og.Controller.edit('/h', {'create_node': []})", "unknown key 'create_node'; did you mean 'create_nodes'?"),
        ("og.Controller.edit('/h', {'create_nodes': [3]})", "create_nodes: 3 has the wrong form"),
        ("og.Controller.edit({'graph_path': '/g'})", "OmniGraphError: there is a graph at '/g' already"),
        ("og.Controller.set('/g/X.inputs:a', 1)", "OmniGraphError: no node 'X' in /g"),
    ],
    ids=lambda text: text[:30],
)
def test_a_hostile_script_is_contained(attempt: str, complaint: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, attempt)
    assert complaint in finding
    assert "Traceback" not in finding


@pytest.mark.parametrize(
    ("raw", "complaint"),
    [
        (b"def", "1:4: error G401: not valid Python: invalid syntax"),
        (b'x = "\xff"', "script.py:1:1: error G401: not valid Python: invalid or missing encoding"),
        (b"x = 1\0", "not valid Python"),
        (b"(" * 100_000, "not valid Python: too many nested parentheses"),
        (b"x = " + b"-" * 100_000 + b"1", "not valid Python"),
        (b"#" * 2_000_001, "the script is larger than 2 MB"),
    ],
    ids=["syntax", "utf-8", "nul", "parentheses", "signs", "size"],
)
def test_a_file_that_is_no_script_is_reported_in_one_line(raw: bytes, complaint: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, raw)
    assert complaint in finding


def test_a_huge_graph_ends_at_a_limit(tmp_path: Path) -> None:
    text = 'og.Controller.edit("/h", {"create_nodes": [(f"n{i}", "x.y") for i in range(10**6)]})'
    (finding,) = told(tmp_path, text, seconds=200.0)
    assert "more than 100000 nodes, wires and values" in finding


def test_a_module_of_python_that_reaches_out_is_a_stub(tmp_path: Path) -> None:
    text = 'import socket\nsocket.create_connection(("127.0.0.1", 22))'
    assert "socket.create_connection() does not belong to a graph" in told(tmp_path, text)[1]


def test_compiled_code_beside_a_script_is_not_loaded(tmp_path: Path) -> None:
    (tmp_path / "beside.pyc").write_bytes(b"\0" * 64)
    assert any("ImportError" in line for line in told(tmp_path, "import beside"))


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/etc/passwd")
    (finding,) = told(tmp_path, "open('link')")
    assert "error G401" in finding


def test_a_value_that_holds_itself_is_left_out(tmp_path: Path) -> None:
    text = 'l = []\nl.append(l)\nog.Controller.edit("/g", {"set_values": [("T.inputs:x", l)]})'
    (finding,) = told(tmp_path, text)
    assert "is left out: it is nested too deeply" in finding


@pytest.mark.parametrize(
    ("value", "complaint"),
    [
        ("10**5000", "it does not fit into 64 bits"),
        ("-2**63 - 1", "it does not fit into 64 bits"),
        ("'x' * 1_000_001", "it has more than 1000000 characters"),
        ("range(10**9)", "it has more than 100000 items"),
        ("Endless()", "it has more than 100000 items"),
    ],
)
def test_a_value_beyond_measure_is_left_out(value: str, complaint: str, tmp_path: Path) -> None:
    text = "class Endless(list):\n    def __iter__(self):\n        while True: yield 1\n"
    (finding,) = told(tmp_path, f"{text}og.Controller.edit('/g', {{'set_values': ('T.inputs:x', {value})}})", 5.0)
    assert f"the value of T.inputs:x is left out: {complaint}" in finding


@pytest.mark.parametrize("name", ["'n' * 1001", "'n\\n  b: evil'", "'\\x1b[2J'", "'\\ud800'", "3", "''"])
def test_a_name_that_nobody_writes_is_refused(name: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, f"og.Controller.edit('/h', {{'create_nodes': [({name}, 'x.y')]}})")
    assert "error G401: OmniGraphError: expected the name of a node, got " in finding
    assert "\x1b" not in finding


DOUBLED = "from pxr import Gf\nx = ('double', 0)\n" + "x = {}\n" * 60


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        *(
            (DOUBLED.format(*[doubling] * 60) + "og.Controller.edit('/g', {'create_variables': [('v', x)]})", complaint)
            for doubling, complaint in [
                ("(x, x)", ""),
                ("[x, x]", "the script takes longer than its time limit"),
                ("{'k': x, 'l': x}", "expected the name of a type, got a mapping"),
                ("Gf.Vec2d(x, x)", ""),
            ]
        ),
        ("a0 = 'a' * 60_000\n" + "".join(f"a{n + 1} = a{n} + 'b'\n" for n in range(20_000)), "the script takes"),
        ("a0 = 'a'\n" + "".join(f"a{n + 1} = a{n} + a{n}\n" for n in range(40)), "the script takes"),
        ("x = 1\n" + "x = [x]\n" * 20_000, ""),
    ],
    ids=["tuple", "list", "mapping", "vector", "texts", "doubled text", "nested"],
)
def test_literals_that_grow_are_evaluated_where_time_and_memory_are_bounded(
    text: str, complaint: str, tmp_path: Path
) -> None:
    found = told(
        tmp_path,
        text,
        {"the script takes longer than its time limit": 2.0, "the script takes": 5.0}.get(complaint, 20.0),
    )
    assert [complaint in line for line in found] == [True] * bool(complaint)


def test_a_script_says_in_which_encoding_it_is(tmp_path: Path) -> None:
    text = GRAPH.replace('"/g"', '"/caf\xe9"')
    text = f"# -*- coding: latin-1 -*-\n{text}".replace("\n", "\r\n")
    (tmp_path / "script.py").write_bytes(text.encode("latin-1"))
    findings = Findings()
    (graph,) = read_script(tmp_path / "script.py", findings)
    assert (graph.path, findings.items) == ("/caf\xe9", [])
    assert graph.span is not None
    assert [graph.span.source.lines[n] for n in (0, 1)] == ["# -*- coding: latin-1 -*-", "import omni.graph.core as og"]


UNHOOK = """import os, sys
class Everything:
    def __contains__(self, _):
        return True
sys.modules["graphengine.sandbox.confinement"]._HARMLESS = Everything()
ctypes = sys.modules["graphengine.sandbox.system_calls"].ctypes
libc = ctypes.CDLL(None, use_errno=True)
def call(name, *arguments):
    if getattr(libc, name)(*arguments) < 0:
        raise OSError(ctypes.get_errno(), name)
"""
ATTEMPTS = [
    "open('/etc/passwd')",
    "os.open('owned', os.O_CREAT | os.O_RDWR)",
    "os.open(folder + 'script.py', os.O_RDWR)",
    "os.open(folder, os.O_TMPFILE | os.O_RDWR)",
    "os.mkfifo('owned')",
    "os.chmod(folder + 'script.py', 0)",
    "os.utime(folder + 'script.py', (0, 0))",
    "os.setxattr(folder + 'script.py', 'user.owned', b'')",
    "os.rename(folder + 'script.py', folder + 'owned')",
    "os.truncate(folder + 'script.py', 0)",
    "os.chdir('/')",
    "os.execv('/bin/sh', ['sh', '-c', 'true'])",
    "os.posix_spawn('/bin/sh', ['sh', '-c', 'true'], {})",
    "os.fork() or (os.setsid(), __import__('time').sleep(60))",
    "os.forkpty()",
    "os.setsid()",
    "os.memfd_create('owned')",
    "os.pidfd_open(os.getppid())",
    "os.kill(os.getppid(), 0)",
    "os.kill(0, 0)",
    "os.setpriority(os.PRIO_PROCESS, os.getppid(), 19)",
    "os.sched_setaffinity(os.getppid(), [0])",
    "call('socket', 1, 1, 0)",
    "call('socket', 2, 2, 0)",
    "call('prlimit', os.getppid(), 7, (ctypes.c_uint64 * 2)(3, 3), None)",
    "call('prlimit', os.getppid(), 7, None, (ctypes.c_uint64 * 2)())",
    "call('tgkill', os.getppid(), os.getppid(), 0)",
    "call('unshare', 0x10000000)",
    "call('ptrace', 16, os.getppid(), 0, 0)",
    "call('prctl', 0x59616d61, -1, 0, 0, 0)",
    "call('fcntl', 1, 8, os.getppid())",  # F_SETOWN
    "call('fcntl', 1, 10, 9)",  # F_SETSIG
    "call('fcntl', 1, 1031, 4096)",  # F_SETPIPE_SZ
    "call('flock', os.open(folder + 'script.py', 0), 2)",
    "call('ioctl', 0, 0x5412, b'x')",  # TIOCSTI
    "call('shmget', 1, 4096, 0o1666)",
    "call('inotify_init1', 0)",
    "call('syscall', 425, 1, ctypes.create_string_buffer(120))",  # io_uring_setup
]
TRY = """
folder, outcomes = os.path.dirname(os.path.abspath(__file__)) + "/", []
for attempt in {!r}:
    try:
        exec(attempt)
    except PermissionError:
        continue
    except BaseException as error:
        outcomes.append((attempt, repr(error)))
    else:
        outcomes.append((attempt, "done"))
raise ValueError(outcomes)
"""


@pytest.mark.skipif(bool(missing()), reason="this machine lacks a border")
def test_a_script_that_gets_past_the_audit_hook_meets_the_kernel(tmp_path: Path) -> None:
    (finding,) = told(tmp_path, UNHOOK + TRY.format(ATTEMPTS), 10.0)
    assert "warning W302: ValueError: []" in finding


@pytest.mark.skipif(bool(missing()), reason="this machine lacks a border")
def test_a_script_may_start_threads(tmp_path: Path) -> None:
    text = "import threading\nfound = []\n"
    text += "thread = threading.Thread(target=lambda: found.append(open(__file__).read(1)))\n"
    text += "thread.start()\nthread.join()\nassert found\nthreading.Thread(target=open, args=['/etc/passwd']).start()"
    assert told(tmp_path, text, 5.0) == []


@pytest.mark.parametrize(
    ("raw", "complaint"),
    [
        (b"# coding: punycode\n" + b"a" * 100_000, "the encoding 'punycode' is not supported; legal: utf-8"),
        (b"# coding: ../../evil\n", "unknown encoding"),
        (b"# coding: hex\n", "not valid Python"),
        (b"# coding: rot13\n", "not valid Python"),
        (b"\xef\xbb\xbf# coding: latin-1\n", "encoding problem"),
    ],
)
def test_an_encoding_that_is_not_legal_is_refused(raw: bytes, complaint: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, raw)
    assert complaint in finding


@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "gbk"])
def test_a_legal_encoding_is_read(encoding: str, tmp_path: Path) -> None:
    head = "" if encoding == "utf-8-sig" else f"# coding: {encoding}\n"
    assert told(tmp_path, f"{head}# \u2026\r\n{GRAPH}".encode(encoding), 5.0) == []


def answered(folder: Path, answer: bytes | ScriptAnswer, patch: pytest.MonkeyPatch) -> list[str]:
    """What is said of a script whose process sends an answer, the graph files written."""
    sent = encoded(answer).encode() if isinstance(answer, ScriptAnswer) else answer
    patch.setattr(script_reader, "ask", lambda *_: sent)
    script, findings, namespaces = folder / "script.py", Findings(), dict[str, str]()
    script.write_text(GRAPH)
    graphs = read_script(script, findings, namespaces=namespaces, read_stage=lambda _: [])
    for graph, name in zip(graphs, file_names(graphs), strict=True):
        compose(graph, name, default_registry(), findings, "script.py").encode()
    to_json(findings.sorted())
    return [finding.render() for finding in findings.items]


def at(path: object, line: int = 1, column: int = 1) -> ScriptAnswer:
    return ScriptAnswer(findings=[Finding("N302", "here", Span(Source(str(path), ()), line, column))])


MANY = [Finding("N302", str(number)) for number in range(5000)]
NODE = RecordedNode("n", "x.y")
FORGED = [
    "stages",
    "many stages",
    "column",
    "line",
    "loop",
    "name",
    "path",
    "findings",
    "lines",
    "code",
    "many",
    "graphs",
]
FORGED += ["no path", "path of lines", "node", "type", "port", "variable", "namespace", "texts"]
GRAPHS = [RecordedGraph("/" + "g/" * 100_000), *(RecordedGraph("/g", nodes={"n": RecordedNode("n", "x.y")}),) * 5000]


@pytest.mark.parametrize(
    ("answer", "complaint"),
    [
        (ScriptAnswer(stages=["\0.usda", "\ud800.usda", "loop.usda", "n" * 300 + ".usda"]), ""),
        (
            ScriptAnswer(stages=[f"{number}.usda" for number in range(1000)]),
            "990 of the USD files that the script opens",
        ),
        (at("script.py", 1, 1 << 31), "here"),
        (at("script.py", 10**4000, -1), "here"),
        (at("loop"), "sends a malformed answer"),
        (at("n" * 300), "sends a malformed answer"),
        (at("/etc/passwd"), "sends a malformed answer"),
        (ScriptAnswer(findings=MANY), "4000 further findings are not listed"),
        (ScriptAnswer(findings=[Finding("N302", "\n" * 10**7, None, ("",) * 10**5)]), "\ufffd\u2026"),
        (encoded(at("script.py")).replace("N302", "X999").encode(), "sends a malformed answer"),
        (ScriptAnswer(findings=MANY * 5), "sends a malformed answer"),
        (ScriptAnswer(GRAPHS), "4001 graphs are left out; legal: at most 1000"),
        *(
            (ScriptAnswer([graph]), "1 graphs are left out")
            for graph in (
                RecordedGraph("", nodes={"n": NODE}),
                RecordedGraph("/g\nat: /h", nodes={"n": NODE}),
                RecordedGraph("/g", nodes={"a\nb: c": RecordedNode("a\nb: c", "x.y")}),
                RecordedGraph("/g", nodes={"n": RecordedNode("n", "x\n.y")}),
                RecordedGraph("/g", nodes={"n": NODE}, wires=[RecordedWire("n", "outputs:a", "n", "inputs:b\x1b")]),
                RecordedGraph("/g", nodes={"n": NODE}, variables={"v": RecordedValue(1, "t\n: y")}),
            )
        ),
        (ScriptAnswer(namespaces={"/p": "n" * 1_000_000}), "1 namespaces are left out"),
        (ScriptAnswer(findings=[Finding("W302", "x" * 10**7, None, ("y" * 10**7,))]), "xxx\u2026\n"),
    ],
    ids=FORGED,
)
def test_a_forged_answer_is_refused_or_bounded(
    answer: Any, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("loop", "loop.usda"):
        (tmp_path / name).symlink_to(name)
    monkeypatch.chdir(tmp_path)
    found = answered(tmp_path, answer, monkeypatch)
    assert any(complaint in line for line in found) or not complaint
    assert sum(map(len, found)) < 1_000_000


def test_one_file_under_many_names_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [f"link{number}" for number in range(5)] + ["./" * number + "big.usda" for number in range(5)]
    (tmp_path / "big.usda").write_bytes(b"x" * 5_000_000)
    for name in names[:5]:
        (tmp_path / name).symlink_to("big.usda")
    places = [Span(Source(str(tmp_path / "x" / ".." / name), ()), 1, 1) for name in names]
    (tmp_path / "x").mkdir()
    found = [Finding("N302", "here", place) for place in places]
    sent = encoded(ScriptAnswer([GRAPHS[1]], findings=found, stages=names)).encode()
    monkeypatch.setattr(script_reader, "ask", lambda *_: sent)
    read, findings = list[Path](), Findings()

    def read_stage(path: Path) -> list[RecordedGraph]:
        read.append(path)
        return []

    (tmp_path / "script.py").write_text(GRAPH)
    read_script(tmp_path / "script.py", findings, read_stage=read_stage)
    assert read == [tmp_path / "big.usda"]
    sources = {finding.span.source.path: finding.span.source for finding in findings.items if finding.span}
    assert sum(len(line) for source in sources.values() for line in source.lines) <= 8_000_000


def test_a_position_that_is_no_number_is_not_written() -> None:
    graph = RecordedGraph("/g", nodes={"n": RecordedNode("n", "x.y", position=(float("nan"), 1.0))})
    assert "layout" not in compose(graph, "g", default_registry(), Findings(), "script.py")


def test_no_forged_answer_raises_anything_but_errors_of_this_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = kept_answers(script_reader, monkeypatch)
    (tmp_path / "loop").symlink_to("loop")
    script = Path(__file__).parents[1] / "scripts" / "typed_values.py"
    assert read_script(script, Findings())
    for answer in forged(real[0].replace(str(script).encode(), str(tmp_path / "script.py").encode()), 300):
        try:
            answered(tmp_path, answer, monkeypatch)
        except GraphError:
            continue
