"""Whatever a file holds, `assemble` comes back, and every error has a place in a file."""

from __future__ import annotations

import re
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphengine.format.files import shipped
from graphengine.scene import build

FLOW = """graph: flow
evaluator: execution
parameters: {rate: {type: double, default: 10}}
variables:
  count: {type: int, default: 0}
nodes:
  Tick: {type: OnPlaybackTick, every: {ticks: 2}}
  Order: Multisequence
  Loop: {type: omni.graph.action.ForLoop, inputs: {stop: 3}}
  Branch: Branch
  Gate: {type: Gate, every: once, inputs: {startClosed: true}}
  Write: {type: omni.graph.core.WriteVariable, every: {hz: $(rate)}, inputs: {variableName: count}}
  Part: {subgraph: graphs/clock.yaml, inputs: {context: 1}}
connections:
  - Tick.tick -> Order.execIn
  - Order.output0 -> Loop.execIn
  - Order.output1 -> Gate.enter
  - Loop.loopBody -> Branch.execIn
  - Loop.index -> Write.value
  - Branch.execTrue -> Loop.breakLoop
  - Branch.execFalse -> Write.execIn
  - Gate.exit -> Gate.toggle
"""
FILES = [path.read_text() for folder in ("graphs",) for path in sorted((shipped() / folder).rglob("*.yaml"))]
FILES += [FLOW] * len(FILES)
WORD = re.compile(r"[A-Za-z0-9_./$()-]+")
WORDS = sorted({word for text in FILES for word in WORD.findall(text)})
SCALARS = [
    "", "null", "true", "no", "1e3", "0o7", "-1", "0.5", ".nan", "-.inf", "1e999", "9" * 50, "12:30:00",
    "[]", "{}", "[1, 2", "{a: b", "'", '"', "[a, b]", "[[1, 2], [3]]", "{x: 1}", "{type: double, value: 1}",
    "&a", "*a", "!!int", "<<", "? a", ": ", "- ", "#", "|", "@", "%TAG", "---", "...", "\t",
    "$(robot)", "$(x)", "$$", "$(", "a.b -> c.d", "->", "OnPlaybackTick.tick", "inputs:x", "subgraph: clock.yaml",
    "/", "//", "/dd100/../x", "at: /a/./b", "../..", "graphs/clock.yaml", "runs: physics_step", "format: 2",
    "\x00", "\x1b[31m", "\ufeff", "\u2028", "\x85", "\u202e", "é" * 30, "🤖", "x" * 300, '"\\e[31m"',
]  # fmt: skip

few = settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """A graph that ships, with a few lines or words changed."""
    text = draw(st.sampled_from(FILES))
    for _ in range(draw(st.integers(1, 4))):
        lines = text.split("\n")
        one, other = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        change = draw(st.sampled_from(["delete", "repeat", "swap", "indent", "word", "word", "word", "insert"]))
        if change == "delete":
            del lines[one]
        elif change == "repeat":
            lines.insert(other, lines[one])
        elif change == "swap":
            lines[one], lines[other] = lines[other], lines[one]
        elif change == "indent":
            lines[one] = " " * draw(st.integers(0, 6)) + lines[one].lstrip()
        elif change == "insert":
            at = draw(st.integers(0, len(lines[one])))
            lines[one] = lines[one][:at] + draw(st.sampled_from(SCALARS)) + lines[one][at:]
        elif words := list(WORD.finditer(lines[one])):
            word = draw(st.sampled_from(words))
            lines[one] = lines[one][: word.start()] + draw(st.sampled_from(SCALARS + WORDS)) + lines[one][word.end() :]
        text = "\n".join(lines)
    return text


def check(raw: bytes, folder: Path) -> None:
    path = folder / "fuzzed.yaml"
    path.write_bytes(raw)
    assembly = build.load(path)
    findings = assembly.findings.sorted()
    text = "\n".join(finding.render() for finding in findings)
    assert all(character.isprintable() or character == "\n" for character in text)
    for finding in findings:
        finding.record()
        if finding.severity == "error":
            assert finding.span is not None, finding.render()
            assert finding.message
            lines = finding.span.source.lines
            if lines:
                assert 1 <= finding.span.line <= len(lines)
                assert 1 <= finding.span.column <= len(lines[finding.span.line - 1]) + 1
            else:
                assert finding.code == "G101"


@given(st.text(max_size=400))
@few
def test_any_text(tmp_path: Path, text: str) -> None:
    check(text.encode("utf-8", "surrogatepass"), tmp_path)


@given(st.binary(max_size=200))
@settings(few, max_examples=50)
def test_any_bytes(tmp_path: Path, raw: bytes) -> None:
    check(raw, tmp_path)


@given(st.lists(st.sampled_from(SCALARS + WORDS + ["graph: g\n", "nodes:\n", "  ", "\n", ": ", ", "]), max_size=40))
@settings(few, max_examples=100)
def test_any_words(tmp_path: Path, words: list[str]) -> None:
    check("".join(words).encode(), tmp_path)


@given(mutated())
@few
def test_graphs_that_ship_with_a_few_changes(tmp_path: Path, text: str) -> None:
    check(text.encode(), tmp_path)
