"""Every code has a file with the mistake and the exact text that `check` prints for it.

`UPDATE_GOLDENS=1 pytest tests/format` writes the texts anew; read them before they are committed.
"""

from __future__ import annotations

import functools
import importlib
import os
from pathlib import Path
from typing import Any

import pytest

from graphengine.compiler.registry import Registry
from graphengine.format.diagnostics import CODES
from graphengine.format.files import shipped
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, Variable, Vector3d
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene, Options

CASES = Path(__file__).parent / "cases"
FILES = sorted(CASES.glob("*.yaml"))


class Sum(Node, type="example.Sum"):
    """A data node."""

    a: float = In(default=0.0)
    b: float = In(default=0.0)
    value: float = Out()


class Double(Node, type="example.Double"):
    """A data node of several types."""

    number: Any = In(type="double|float|double[3]", couple="number")
    twice: Any = Out(type="double|float|double[3]", couple="number")


class Filter(Node, type="example.Filter"):
    """An action that reads a vector."""

    exec_in = ExecIn()
    velocity: Vector3d = In(default=(0.0, 0.0, 0.0))
    exec_out = ExecOut()


class Broken(Node, type="example.Broken"):
    """A node with a bug in its setup."""

    exec_in = ExecIn()
    gains: float = In(default=0.0)

    def setup(self, context: Context) -> None:
        raise ZeroDivisionError("division by zero")


class ReadSpeed(Node, type="example.ReadSpeed", volatile=True):
    """A data node that reads a variable."""

    value: float = Out()

    variable: Variable = Bound()

    def setup(self, context: Context) -> None:
        self.variable = context.variable("speed")

    def reads(self) -> tuple[str, ...]:
        return ("variable:speed",)


class WriteSpeed(Node, type="example.WriteSpeed"):
    """An action that writes a variable."""

    exec_in = ExecIn()
    value: float = In(default=0.0)

    def writes(self) -> tuple[str, ...]:
        return ("variable:speed",)


@functools.cache
def registry() -> Registry:
    types = Registry()
    types.add_module(importlib.import_module("graphengine.nodes"), "graphengine", built_in=True)
    for cls in (Sum, Double, Filter, Broken, ReadSpeed, WriteSpeed):
        types.add(cls, "tests")
    return types


def assemble(path: Path, monkeypatch: pytest.MonkeyPatch) -> LoadedScene:
    """As a user who stands in the folder of the file."""
    monkeypatch.chdir(path.parent)
    return build.load(Path(path.name), Options(registry=registry(), near=path.parent))


def told(assembly: LoadedScene) -> str:
    text = "\n".join(finding.render() for finding in assembly.findings.sorted())
    return text.replace(str(shipped()), "<shipped>") + "\n"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_output_equals_the_golden_file(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = told(assemble(path, monkeypatch))
    golden = path.with_suffix(".txt")
    if os.environ.get("UPDATE_GOLDENS"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


def test_several_errors_are_reported_together_in_order_of_position(monkeypatch: pytest.MonkeyPatch) -> None:
    findings = assemble(CASES / "many_in_one_graph.yaml", monkeypatch).findings.sorted()
    places = [(finding.span.line, finding.span.column) for finding in findings if finding.span]
    assert len({finding.code for finding in findings}) >= 6
    assert len(places) == len(findings) >= 10
    assert places == sorted(places)


@pytest.mark.parametrize(("code", "loop"), [("G209", "Error Gain Filter"), ("G210", "SubscribeTwist ComputeOdom Once")])
def test_a_cycle_is_reported_completely_with_its_lines(code: str, loop: str, monkeypatch: pytest.MonkeyPatch) -> None:
    (path,) = CASES.glob(f"{code}_*.yaml")
    (finding,) = [f for f in assemble(path, monkeypatch).findings.errors if f.code == code]
    nodes = loop.split()
    assert finding.message.endswith(": " + " -> ".join([*nodes, nodes[0]]))
    lines = path.read_text().split("\n")
    assert [label for _, label in finding.related] == [lines[span.line - 1].strip("- ") for span, _ in finding.related]
    assert len(finding.related) == len(nodes)


TOLD_ELSEWHERE = {"G401", "G402", "W301", "W302", "W303", "N301", "N302", "W109", "W206"}
"""Of files that are imported, exported and recorded, which no check reads, and of machines that lack a border."""


def test_every_code_has_a_golden_and_every_golden_a_code() -> None:
    named = {path.stem.partition("_")[0] for path in FILES if not path.stem.startswith("many_")}
    assert named | TOLD_ELSEWHERE == set(CODES)
