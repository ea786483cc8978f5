"""Scripts of strangers: whatever they try, nothing outside of their process changes and one line tells why they failed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.diagnostics import Findings
from graphengine.omnigraph.script.places import Script
from graphengine.omnigraph.script.plain import evaluate
from graphengine.omnigraph.script.reading import read_script

GRAPH = (
    'import omni.graph.core as og\nog.Controller.edit("/g", {"create_nodes": [("T", "omni.graph.action.OnTick")]})\n'
)
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
        ("while True: pass", "3:1: error G401: the script takes too long"),
        ("while True:\n    try:\n        while True: pass\n    except BaseException: pass", "takes too long"),
        (
            "import os\nos.system('touch owned')",
            "4:1: error G401: the script may not do this: os.system is not allowed",
        ),
        ("open('/etc/passwd')", "3:1: error G401: the script may not do this: '/etc/passwd' lies outside"),
        ("import os\nos.listdir('/')", "'/' lies outside the folder of the file you gave"),
        ("import os\nos.open('owned', os.O_CREAT | os.O_RDWR)", "'owned' cannot be written from here"),
        (
            "open('owned', 'w').write('x')",
            "3:1: note N302: the file 'owned', which the script writes, belongs to no graph",
        ),
        ("from pathlib import Path\nPath(__file__).unlink()", "os.remove is not allowed here"),
        ("import os\nos.fork()", "os.fork is not allowed here"),
        ("import os\nos.kill(os.getppid(), 9)", "os.kill is not allowed here"),
        ("x = [0] * 10 ** 10", "3:5: error G401: the script takes more than 1024 MiB"),
        ("def f(): f()\nf()", "3:10: error G401: the script calls itself without end"),
        ("import sys\nsys.exit('no')", "4:1: warning W302: the script ends itself: exit('no')"),
        ("raise ValueError('bad \\x1b[31m')", "3:1: warning W302: ValueError: bad \N{REPLACEMENT CHARACTER}[31m"),
        ("raise BaseException", "3:1: warning W302: BaseException: no more is told"),
        ("import os\nos.write(1, b'{}')\nos._exit(0)", "it spoils the answer of the process that runs it"),
        ("import os\nos._exit(3)", "the script cannot be run"),
        ("import os\nos.abort()", "the script cannot be run: breaks off: Aborted"),
        ("og.Controller.edit('/h', {'create_node': []})", "unknown key 'create_node'; did you mean 'create_nodes'?"),
        ("og.Controller.edit('/h', {'create_nodes': [3]})", "create_nodes: 3 is not of its form"),
        ("og.Controller.edit({'graph_path': '/g'})", "OmniGraphError: there is a graph at '/g' already"),
        ("og.Controller.set('/g/X.inputs:a', 1)", "OmniGraphError: no node 'X' in /g"),
    ],
    ids=lambda text: text[:30],
)
def test_it_is_contained_and_told(attempt: str, complaint: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, attempt)
    assert complaint in finding
    assert "Traceback" not in finding


@pytest.mark.parametrize(
    ("raw", "complaint"),
    [
        (b"def", "1:4: error G401: this is no Python: invalid syntax"),
        (b'x = "\xff"', "script.py:1:1: error G401: this is no Python: invalid or missing encoding"),
        (b"x = 1\0", "this is no Python"),
        (b"(" * 100_000, "this is no Python: too many nested parentheses"),
        (b"x = " + b"-" * 100_000 + b"1", "this is no Python"),
        (b"#" * 2_000_001, "a script of more than 2 MB"),
    ],
    ids=["syntax", "utf-8", "nul", "parentheses", "signs", "size"],
)
def test_what_is_no_script_is_told_without_a_process(raw: bytes, complaint: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, raw)
    assert complaint in finding


def test_a_huge_graph_ends_at_a_limit(tmp_path: Path) -> None:
    text = 'og.Controller.edit("/h", {"create_nodes": [(f"n{i}", "x.y") for i in range(10**6)]})'
    (finding,) = told(tmp_path, text, seconds=30.0)
    assert "more than 200000 nodes, wires and values" in finding


def test_a_module_of_python_that_reaches_out_is_a_stand_in(tmp_path: Path) -> None:
    text = 'import socket\nsocket.create_connection(("127.0.0.1", 22))'
    assert "socket.create_connection() belongs to no graph" in told(tmp_path, text)[1]


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
    assert "cannot be told: it is nested too deep" in finding


@pytest.mark.parametrize(
    ("value", "complaint"),
    [
        ("10**5000", "it is no number of 64 bits"),
        ("-2**63 - 1", "it is no number of 64 bits"),
        ("'x' * 1_000_001", "it has more than 1000000 characters"),
        ("range(10**9)", "it has more than 100000 items"),
        ("Endless()", "it has more than 100000 items"),
    ],
)
def test_a_value_beyond_measure_is_left_out(value: str, complaint: str, tmp_path: Path) -> None:
    text = "class Endless(list):\n    def __iter__(self):\n        while True: yield 1\n"
    (finding,) = told(tmp_path, f"{text}og.Controller.edit('/g', {{'set_values': ('T.inputs:x', {value})}})", 5.0)
    assert f"the value of T.inputs:x cannot be told: {complaint}" in finding


@pytest.mark.parametrize("name", ["'n' * 1001", "'n\\n  b: evil'", "'\\x1b[2J'", "'\\ud800'", "3", "''"])
def test_a_name_that_nobody_writes_is_refused(name: str, tmp_path: Path) -> None:
    (finding,) = told(tmp_path, f"og.Controller.edit('/h', {{'create_nodes': [({name}, 'x.y')]}})")
    assert "error G401: OmniGraphError: expected the name of a node, got " in finding
    assert "\x1b" not in finding


DOUBLED = "import omni.graph.core as og\nfrom pxr import Gf\nx = ('double', 0)\n" + "x = {}\n" * 60


@pytest.mark.parametrize("doubling", ["(x, x)", "[x, x]", "{'k': x, 'l': x}", "Gf.Vec2d(x, x)"])
def test_a_value_that_holds_another_twice_and_so_on_is_not_evaluated_here(doubling: str) -> None:
    text = DOUBLED.format(*[doubling] * 60) + "og.Controller.edit('/g', {'create_variables': [('v', x)]})\n"
    assert evaluate(Script("doubled.py", text)) is None


def test_a_script_says_in_which_encoding_it_is(tmp_path: Path) -> None:
    text = GRAPH.replace('"/g"', '"/caf\xe9"')
    (tmp_path / "script.py").write_bytes(
        b"# -*- coding: latin-1 -*-\r\n" + text.replace("\n", "\r\n").encode("latin-1")
    )
    findings = Findings()
    (graph,) = read_script(tmp_path / "script.py", findings)
    assert (graph.path, findings.items) == ("/caf\xe9", [])
    assert graph.span is not None
    assert [graph.span.source.lines[n] for n in (0, 1)] == ["# -*- coding: latin-1 -*-", "import omni.graph.core as og"]


UNHOOK = """import os, sys
class Everything:
    def __contains__(self, _):
        return True
sys.modules["graphengine.world.files.confinement"]._HARMLESS = Everything()
"""


@pytest.mark.parametrize(
    "attempt",
    [
        "open('/etc/passwd')",
        "os.open('owned', os.O_CREAT | os.O_RDWR)",
        "os.mkfifo('owned')",
        "os.execv('/bin/sh', ['sh', '-c', 'true'])",
    ],
)
def test_a_script_that_gets_past_the_audit_hook_meets_the_kernel(attempt: str, tmp_path: Path) -> None:
    if not restricts():
        pytest.skip("this kernel has no Landlock")
    (finding,) = told(tmp_path, UNHOOK + attempt)
    assert "PermissionError" in finding


def restricts() -> bool:
    code = "from graphengine.world.files.landlock import restrict; print(restrict(()))"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "True\n"


LEAVE = "from graphengine.omnigraph.script.process import _leave_network as leave; "
SHOW = "import pathlib; print(*(line.split(':')[0] for line in pathlib.Path('/proc/self/net/dev').read_text().split('\\n')[2:]))"


@pytest.mark.skipif(
    shutil.which("unshare") is None or subprocess.run(["unshare", "-rn", "true"], capture_output=True).returncode != 0,
    reason="this kernel gives nobody a network of their own",
)
def test_the_process_leaves_the_network_for_good() -> None:
    environment = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", f"{LEAVE}leave(); {SHOW}"], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["lo"]
