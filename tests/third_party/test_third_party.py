"""A package of node types by somebody else, installed beside graphengine: registered by its entry point, checked, run."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from graphengine import testing
from graphengine.compiler.registry import default_registry
from graphengine.node.node_class import NodeClassError
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build
from tests.third_party.installed import lay_out

ACME = Path(__file__).parent / "acme"
GRAPH = """
graph: teleop
nodes:
  Tick: OnPlaybackTick
  Small: {type: acme.Deadband, inputs: {deadWidth: 2.5}}
  IsDown: {type: Compare, inputs: {operation: '>', b: {type: double, value: 0}}}
  Edge: acme.ButtonEdge
connections:
  - Tick.frame -> Small.command
  - Small.value -> IsDown.a
  - IsDown.result -> Edge.isDown
  - Tick.tick -> Edge.execIn
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of installed packages with Acme's in it."""
    folder = tmp_path_factory.mktemp("site")
    lay_out(ACME, "acme_nodes", folder)
    return folder


@pytest.fixture
def acme(site: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """Acme's nodes, of which the registry knows."""
    monkeypatch.syspath_prepend(site)
    default_registry.cache_clear()
    yield importlib.import_module("acme_nodes.joystick")
    default_registry.cache_clear()
    for name in ("acme_nodes", "acme_nodes.joystick"):
        sys.modules.pop(name, None)


@pytest.fixture
def teleop(tmp_path: Path) -> Path:
    path = tmp_path / "teleop.yaml"
    path.write_text(GRAPH)
    return path


def test_its_types_are_registered_with_their_owner(acme: ModuleType) -> None:
    registry = default_registry()
    assert registry.types["acme.ButtonEdge"] is acme.ButtonEdge
    assert {registry.owners[name] for name in ("acme.Deadband", "acme.ButtonEdge")} == {"acme-nodes"}
    assert registry.broken == {}


def test_its_types_have_full_names_only(acme: ModuleType) -> None:
    assert default_registry().find("ButtonEdge") is None


def test_check_node_finds_them_sound(acme: ModuleType) -> None:
    for cls in (acme.Deadband, acme.ButtonEdge):
        testing.check_node(cls)


def test_check_node_tells_its_author_what_is_missing(acme: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(acme.ButtonEdge, "__doc__", "this node finds edges")
    with pytest.raises(NodeClassError, match="must say what the node does"):
        testing.check_node(acme.ButtonEdge)


def test_a_graph_of_them_runs(acme: ModuleType, teleop: Path) -> None:
    assembly = build.load(teleop)
    assembly.findings.raise_errors()
    session = build.start(assembly, LiveNetwork(lambda _: MemoryTransport(), 0, print))
    edge = session.graphs[0].executor.node("Edge")
    presses = []
    for _ in range(4):
        session.step()
        presses.append(edge.press_count)  # type: ignore[attr-defined]
    session.close()
    assert presses == [0, 0, 1, 1]


def test_the_command_line_knows_them(site: Path, teleop: Path) -> None:
    paths = [str(site), *sys.path]
    program = f"import sys; sys.path[:] = {paths!r}; from graphengine.cli import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", program, "show", str(teleop)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "Edge: acme.ButtonEdge" in done.stdout
