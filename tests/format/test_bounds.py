"""What a hostile or broken file may cost: bounded time and memory, no hang, and nothing that steers a terminal."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
import time
import tracemalloc
from pathlib import Path

import pytest

from graphengine.format import document
from graphengine.format.diagnostics import MAX_ERRORS, Findings, to_json
from graphengine.format.document import MAX_BYTES, MAX_DEPTH, MAX_VALUES, Document
from graphengine.scene import build


def load(path: Path) -> tuple[Document | None, Findings]:
    findings = Findings()
    return document.load(path, findings), findings


def refusal(raw: bytes, folder: Path) -> str:
    path = folder / "a.yaml"
    path.write_bytes(raw)
    loaded, findings = load(path)
    assert loaded is None
    (finding,) = findings.items
    return f"{finding.code} {finding.message}"


# Depth and number of values


@pytest.mark.parametrize(
    "text",
    [
        "[" * 10_000,
        "{a: " * 10_000,
        "[{a: " * 10_000,
        "- " * 10_000,
        "".join(f"{' ' * depth}a:\n" for depth in range(1000)),
        "a0: &a0 [x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 800)),
        "a0: &a0 {x: y}\n" + "".join(f"a{i}: &a{i} {{x: *a{i - 1}}}\n" for i in range(1, 800)),
    ],
    ids=["lists", "mappings", "both", "block lists", "block mappings", "aliases of lists", "aliases of mappings"],
)
def test_the_nesting_is_limited(text: str, tmp_path: Path) -> None:
    begun = time.process_time()
    assert refusal(text.encode(), tmp_path) == f"G105 nested more than {MAX_DEPTH} levels deep"
    assert time.process_time() - begun < 5


def test_nesting_up_to_the_limit_is_legal(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("[" * MAX_DEPTH + "]" * MAX_DEPTH)
    assert load(path)[0] is not None
    path.write_text("a: &a " + "[" * (MAX_DEPTH - 2) + "]" * (MAX_DEPTH - 2) + "\nb: [*a]\n")
    assert load(path)[0] is not None
    path.write_text("a: &a " + "[" * (MAX_DEPTH - 2) + "]" * (MAX_DEPTH - 2) + "\nb: [[*a]]\n")
    assert load(path)[0] is None


def test_each_alias_counts_the_values_that_it_repeats(tmp_path: Path) -> None:
    bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n"
    bomb += "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 20))
    tracemalloc.start()
    told = f"G105 more than {MAX_VALUES} values in one file, including values that aliases repeat"
    assert refusal(bomb.encode(), tmp_path) == told
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


def test_values_up_to_the_limit_are_legal(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    repeated, single = divmod(MAX_VALUES - 1001, 999)  # beside the mapping, a list of 998 values, and the list of all
    for more in (0, 1):
        values = ["*a"] * repeated + ["x"] * (single + more)
        path.write_text(f"a: &a [{', '.join(['x'] * 998)}]\nb: [{', '.join(values)}]\n")
        loaded, findings = load(path)
        assert [found.code for found in findings.items] == ["G105"] * more
        assert more or (loaded is not None and loaded.size == MAX_VALUES)


# Size


def test_a_file_of_100_megabytes_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.touch()
    os.truncate(path, 100_000_000)
    tracemalloc.start()
    begun = time.process_time()
    loaded, findings = load(path)
    assert time.process_time() - begun < 5
    assert tracemalloc.get_traced_memory()[1] < 3 * MAX_BYTES
    tracemalloc.stop()
    assert loaded is None
    assert findings.items[0].message.endswith("a.yaml' is larger than 8 MB")


@pytest.mark.skipif(sys.platform != "linux", reason="no /proc")
@pytest.mark.parametrize(
    "content", ['b"- 1\\n" * 1_000_000', 'b"\\n" * 3_000_000', 'b"%TAG !a! x\\n" * 600_000', 'b"a: 1\\n" * 100_000']
)
def test_large_files_stay_within_half_a_gigabyte(content: str, tmp_path: Path) -> None:
    script = f"""
        import sys
        from graphengine.format import document
        from graphengine.format.diagnostics import Findings
        with open(sys.argv[1], "wb") as file:
            file.write({content})
        findings = Findings()
        document.load(sys.argv[1], findings)
        assert findings.errors
        with open("/proc/self/status") as status:  # not ru_maxrss, in which the memory of the parent counts
            print(*(line.split()[1] for line in status if line.startswith("VmHWM")))
    """
    root = Path(document.__file__).parents[2]
    command = [sys.executable, "-c", textwrap.dedent(script), str(tmp_path / "a.yaml")]
    told = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=60, check=True)
    assert int(told.stdout) < 500_000  # kB


def test_after_a_thousand_errors_further_findings_are_dropped(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("graph: g\n" + "a: 1\n" * 20_000)
    begun = time.process_time()
    assembly = build.load(path)
    assert time.process_time() - begun < 5
    assert len(assembly.findings.items) == MAX_ERRORS + 1
    assert assembly.findings.items[-1].message == f"more than {MAX_ERRORS} errors; further findings are not listed"


def many(kind: str, count: int) -> str:
    """Nodes of one type, and the beginning of the connections."""
    return "nodes:\n" + "".join(f"  A{i}: {kind}\n" for i in range(count)) + "connections:\n"


@pytest.mark.parametrize(
    "body",
    [
        "doc: '" + "$(" * 1_000_000 + "'\n",
        "doc: '" + "$(a" * 700_000 + "'\n",
        "doc: '" + "$(a)" * 500_000 + "'\n",
        "nodes: {T: OnPlaybackTick}\nconnections:\n" + "".join(f"- X{i}.a -> Y{i}.b\n" for i in range(20_000)),
        many("OnPlaybackTick", 10_000) + "".join(f"- B{i}.a -> C{i}.b\n" for i in range(20_000)),
        many("IsaacComputeOdometry", 5_000) + "".join(f"- A{i}.execOut -> A{i + 1}.execIn\n" for i in range(4_999)),
    ],
    ids=["open", "open names", "unknown parameters", "unknown nodes", "among many nodes", "missing inputs"],
)
def test_very_many_errors_are_reported_in_time(body: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(f"graph: g\n{body}")
    begun = time.process_time()
    assembly = build.load(path)
    assert time.process_time() - begun < 30
    assert len(assembly.findings.errors) <= MAX_ERRORS + 1


@pytest.mark.parametrize("use", ["$(p)$(p)", "$(p)"], ids=["in a text", "as the whole"])
def test_the_size_of_graphs_with_parameters_is_limited(use: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(
        f"graph: g\nparameters: {{p: {{type: string, default: {'x' * 60_000}}}}}\nnodes:\n"
        + "".join(f"  A{i}: {{type: ROS2PublishClock, inputs: {{topicName: {use}}}}}\n" for i in range(1000))
    )
    tracemalloc.start()
    findings = build.load(path).findings
    assert tracemalloc.get_traced_memory()[1] < 100_000_000
    tracemalloc.stop()
    (finding,) = (finding for finding in findings.errors if finding.code == "G105")
    assert finding.message == "the values that replace parameters are larger than 8 MB in total"


def test_a_very_long_line_is_shown_as_a_window_around_the_caret(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(f"a: [{'x, ' * 30_000}here: 1, here: 2, !t {'x, ' * 30_000}]")
    findings = load(path)[1]
    excerpts = [finding.render().split("\n")[1:3] for finding in findings.items]
    assert excerpts
    for line, caret in excerpts:
        assert len(line) <= 170
        assert line.startswith("     1 | …")
        assert line.endswith("…")
        assert line[caret.index("^")] == "!"


def test_the_window_can_reach_both_ends_of_the_line() -> None:
    findings = Findings()
    document.parse("a: 1, " + "x" * 500 + ": 2", "a.yaml", findings)
    document.parse(f'"{"x" * 500}": !t', "a.yaml", findings)
    first, last = (finding.render().split("\n") for finding in findings.items)
    assert first[2].index("^") > 0
    assert last[1].endswith("!t")
    assert last[1][last[2].index("^")] == "!"


# Encodings


@pytest.mark.parametrize(
    ("raw", "told"),
    [
        ("a: é\n".encode("latin-1"), "G101 'a.yaml' is not UTF-8 text: byte 0xe9"),
        ("a: 1\n".encode("utf-16"), "G101 'a.yaml' is not UTF-8 text: byte 0xff"),
        (b"\x7fELF\x02\x01\x01\0\0", "G102 YAML syntax: character U+007F is not allowed"),
        (b"\x89PNG\r\n\x1a\n", "G101 'a.yaml' is not UTF-8 text: byte 0x89"),
        (b"\0" * 1000, "G102 YAML syntax: character U+0000 is not allowed"),
        (b"a: \xed\xa0\x80\n", "G101 'a.yaml' is not UTF-8 text: byte 0xed"),
        (b"a: \xc0\x80\n", "G101 'a.yaml' is not UTF-8 text: byte 0xc0"),
    ],
)
def test_binary_data_is_refused(raw: bytes, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_bytes(raw)
    findings = load(Path("a.yaml"))[1]
    assert [f"{finding.code} {finding.message}" for finding in findings.items] == [told]


def test_a_byte_that_is_not_utf8_is_reported_at_its_position(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("\ufeffé: 1\r\né: ".encode() + b"\xe9\n")
    (finding,) = load(path)[1].items
    assert finding.span is not None
    assert (finding.span.line, finding.span.column) == (2, 4)


def test_a_byte_order_mark_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("\ufeffgraph: a\r\n".encode())
    loaded, findings = load(path)
    assert not findings.items
    assert loaded is not None
    assert loaded.data == {"graph": "a"}
    assert loaded.key_span("graph").column == 1


# Files that are no files


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
@pytest.mark.parametrize("write", [False, True], ids=["nobody writes", "somebody writes"])
def test_a_pipe_is_refused_without_waiting(write: bool, tmp_path: Path) -> None:
    path = tmp_path / "pipe.yaml"
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR) if write else None
    try:
        assert load(path)[1].items[0].message == f"cannot read {str(path)!r}: not a regular file"
        assert build.load(path).findings.items[0].code == "G101"
    finally:
        if writer is not None:
            os.close(writer)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no devices in the file system")
def test_a_device_is_not_read() -> None:
    assert "not a regular file" in load(Path("/dev/zero"))[1].items[0].message


def test_files_that_cannot_be_opened_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder.yaml").mkdir()
    Path("dangling.yaml").symlink_to("nowhere.yaml")
    Path("loop.yaml").symlink_to("loop.yaml")
    Path("secret.yaml").write_text("a: 1\n")
    real_open = os.open

    def guarded(path: str, flags: int, mode: int = 0o777) -> int:
        if path == "secret.yaml":
            raise PermissionError(13, "Permission denied")
        return real_open(path, flags, mode)

    monkeypatch.setattr(os, "open", guarded)
    names = ("folder.yaml", "dangling.yaml", "loop.yaml", "secret.yaml", "missing.yaml", "x" * 5000, "a\0b.yaml", "")
    told = {name: load(Path(name))[1].items for name in names}
    assert all(len(findings) == 1 and findings[0].code == "G101" for findings in told.values())
    reasons = {name: findings[0].message.rpartition(": ")[2] for name, findings in told.items() if len(name) < 20}
    assert reasons["folder.yaml"] == "Is a directory"
    assert reasons["dangling.yaml"] == "No such file or directory"
    assert reasons["secret.yaml"] == "Permission denied"
    assert reasons["missing.yaml"] == "No such file or directory"
    assert reasons["a\0b.yaml"] == "embedded null byte"


# Terminals

HOSTILE = "\x1b]0;owned\x07\x1b[31m\x9b2J\u202e\r"


def test_control_characters_of_a_file_are_not_printed(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    escaped = "\\e]0;owned\\a\\e[31m\\x9b2J\\u202e\\r\\n"
    text = f"""
        graph: "{escaped}"
        "{escaped}": 1
        "{escaped}": 2
        runs: "{escaped}"
        at: "{escaped}/../x"
        doc: "$(x{escaped})"
        parameters: {{"{escaped}": {{type: "{escaped}"}}, a: {{type: double, default: "{escaped}"}}}}
        inputs: {{"{escaped}": 1}}
        nodes: {{"{escaped}": OnPlaybackTick, A: "{escaped}", B: {{subgraph: "{escaped}"}}}}
        connections: ["{escaped}", "{escaped}.a -> b.{escaped}"]
    """
    path.write_text(textwrap.dedent(text))
    first = build.load(path)
    path.write_text(
        f'graph: g\nnodes:\n  A: "{escaped}"\n  B: {{subgraph: "{escaped}"}}\n'
        f'  C: {{type: ROS2SubscribeTwist, inputs: {{"{escaped}": 1, topicName: "{escaped}", qosProfile: "{escaped}"}}}}\n'
        f'connections: ["A.{escaped} -> B.x", "C.{escaped} -> C.execIn"]\n'
    )
    second = build.load(path)
    findings = [*first.findings.items, *second.findings.items]
    assert {finding.code for finding in findings} >= {"G103", "G106", "G108", "G109", "G111", "G201", "G202", "G204"}
    for text in ("\n".join(finding.render() for finding in findings), to_json(findings)):
        assert all(character.isprintable() or character == "\n" for character in text)


def test_text_of_a_file_cannot_forge_a_line_of_output(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text('graph: g\ninputs: {"x\\nfine.yaml:1:1: error G999: forged": 1}\n')
    (finding,) = build.load(path).findings.items
    assert not any(line.startswith("fine.yaml") for line in finding.render().split("\n"))


@pytest.mark.skipif(sys.platform == "win32", reason="no such names")
def test_control_characters_in_a_file_name_are_not_printed(tmp_path: Path) -> None:
    path = tmp_path / f"{HOSTILE}.yaml"
    path.write_text("graph: g\ndoc: a\ndoc: b\nnodes: {A: {subgraph: secret.yaml}}\n")
    (tmp_path / "\x1b[31msecret.yaml").write_text("")
    missing = tmp_path / f"{HOSTILE}missing.yaml"
    findings = [*build.load(path).findings.items, *build.load(missing).findings.items]
    assert [finding.code for finding in findings] == ["G103", "G214", "G101"]
    assert findings[1].help[0] == r"did you mean '\x1b[31msecret.yaml'?"
    text = "\n".join(finding.render() for finding in findings)
    assert all(character.isprintable() or character == "\n" for character in text)
