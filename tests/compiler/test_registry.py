"""Node types by name: short names are frozen, old names resolve, clashes and broken plugins are told and harm nobody else."""

from __future__ import annotations

import importlib.metadata
import sys
import types
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from graphengine.compiler.lint_registry import LINTS
from graphengine.compiler.registry import GROUP, OLD_PREFIXES, Registry, default_registry, short_names
from graphengine.format.errors import GraphError
from graphengine.node import ExecIn, Node
from graphengine.node.node_class import NodeMeta
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

SHORT_NAMES: dict[str, list[str]] = yaml.safe_load((Path(__file__).parent / "short_names.yaml").read_text())
BUILT_IN = sorted(name for name, owner in default_registry().owners.items() if owner == "graphengine")


class Mine(Node, type="acme.Mine"):
    exec_in = ExecIn()


class AlsoMine(Node, type="acme.Mine"):
    exec_in = ExecIn()


class Alias(Node, type="acme.Alias", aliases=("acme.Mine",)):
    exec_in = ExecIn()


class Hijack(Node, type="Context"):
    exec_in = ExecIn()


class Fine(Node, type="acme.Fine"):
    exec_in = ExecIn()


def module(name: str, *classes: type[Node]) -> types.ModuleType:
    """A module that defines node classes."""
    made = types.ModuleType(name)
    for cls in classes:
        copy = NodeMeta(cls.__name__, (Node,), {"__module__": name}, type=cls.type_name, aliases=cls.aliases)
        setattr(made, cls.__name__, copy)
    return made


# Names


def test_short_names_are_frozen() -> None:
    frozen = {short: full for full, names in SHORT_NAMES.items() for short in names}
    found = default_registry().short_names
    new = [f"{full}: {short}" for short, full in found.items() if short not in frozen]
    assert found == frozen, f"add to tests/compiler/short_names.yaml, as `TYPE: [SHORT NAME, ...]`: {'; '.join(new)}"


def test_no_short_name_means_two_types() -> None:
    wanted: dict[str, list[str]] = {}
    for name in BUILT_IN:
        if default_registry().types[name].type_name == name:
            for short in short_names(name):
                wanted.setdefault(short, []).append(name)
    assert {short: names for short, names in wanted.items() if len(names) > 1} == {}


@pytest.mark.parametrize(
    ("full", "short"),
    [
        ("isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame", "RunOneSimulationFrame"),
        ("isaacsim.core.nodes.IsaacComputeOdometry", "ComputeOdometry"),
        ("isaacsim.ros2.bridge.ROS2RtxLidarHelper", "RtxLidarHelper"),
        ("omni.graph.action.OnPlaybackTick", "OnPlaybackTick"),
        ("isaacsim.robot.wheeled_robots.DifferentialController", "DifferentialController"),
    ],
)
def test_short_names_leave_out_prefixes(full: str, short: str) -> None:
    assert short in short_names(full)
    found = default_registry().find(short)
    assert found is not None
    assert found.cls.type_name == full


NEW_IN_6 = ("isaacsim.core.experimental.", "isaacsim.sensors.rtx.nodes.")
"""Extensions that Isaac Sim 4.5 did not have."""


@pytest.mark.parametrize(
    "name", [name for name in BUILT_IN if name.startswith("isaacsim.") and not name.startswith(NEW_IN_6)]
)
def test_names_from_before_isaac_sim_4_5_resolve(name: str) -> None:
    prefix, _, last = name.rpartition(".")
    old = [old + last for old, news in OLD_PREFIXES.items() if f"{prefix}." in news]
    assert old, f"no old prefix for {prefix}"
    for spelling in (*old, *(one.replace("OgnIsaac", "Isaac") for one in old)):
        found = default_registry().find(spelling)
        assert found is not None
        assert found.old_name
        assert found.cls is default_registry().types[name]


def test_an_old_name_of_a_type_runs_with_a_note(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(
        "graph: a\nnodes:\n  Tick: OnPlaybackTick\n  Clock: omni.isaac.ros2_bridge.ROS2PublishClock\n"
        "connections: [Tick.tick -> Clock.execIn]\n"
    )
    assembly = build.load(path)
    assert [finding.code for finding in assembly.findings.items] == ["N101", "W213"]
    assert assembly.findings.items[0].help == ("its current name is 'isaacsim.ros2.bridge.ROS2PublishClock'",)
    assert not assembly.findings.errors


@pytest.mark.parametrize(
    "name", ["omni.isaac.core_nodes.Nothing", "omni.isaac.", "", "Ogn", ".", "isaacsim.core.nodes."]
)
def test_unknown_type_names_are_not_found(name: str) -> None:
    assert default_registry().find(name) is None
    assert default_registry().suggest(name)


def test_the_nearest_names_are_suggested() -> None:
    suggest = default_registry().suggest
    assert suggest("OnPlaybackTik") == "did you mean 'OnPlaybackTick'?"
    assert suggest("onplaybacktick") == "did you mean 'OnPlaybackTick'?"
    assert suggest("omni.graph.action.OnPlaybakTick") == "did you mean 'omni.graph.action.OnPlaybackTick'?"
    assert suggest("Zzz") == "`graphrun nodes` lists every type"
    assert suggest("my_nodes.Zzz") == "`graphrun nodes` lists every type; if it is yours, add `--import my_nodes`"


# Clashes


def test_a_clash_is_one_error_that_names_both() -> None:
    types_ = Registry()
    types_.add_module(module("one.nodes", Mine), "acme-one")
    with pytest.raises(GraphError) as clash:
        types_.add_module(module("two.nodes", Fine, AlsoMine), "acme-two")
    assert str(clash.value) == (
        "two node types are called 'acme.Mine': one.nodes.Mine of acme-one, and two.nodes.AlsoMine of acme-two"
    )
    assert list(types_.types) == ["acme.Mine"]  # nothing of the second is half there


def test_an_alias_that_is_taken_is_an_error() -> None:
    types_ = Registry()
    types_.add(Mine, "acme-one")
    with pytest.raises(GraphError, match=r"called 'acme\.Mine'"):
        types_.add(Alias, "acme-two")
    assert "acme.Alias" not in types_.types


def test_a_plugin_cannot_take_the_short_name_of_a_built_in() -> None:
    types_ = default_registry().copy()
    with pytest.raises(GraphError, match=r"two node types are called 'Context': .*ROS2Context of graphengine"):
        types_.add(Hijack, "acme")


def test_a_class_can_be_registered_twice() -> None:
    types_ = Registry()
    types_.add(Mine, "acme")
    types_.add(Mine, "acme")
    assert list(types_.types) == ["acme.Mine"]


# Plugins


class Entry:
    """An entry point of an installed distribution."""

    def __init__(self, owner: str, value: str, loaded: types.ModuleType | BaseException) -> None:
        self.name = value.partition(".")[0]
        self.value = value
        self.dist = types.SimpleNamespace(name=owner)
        self._loaded = loaded

    def load(self) -> types.ModuleType:
        if isinstance(self._loaded, BaseException):
            raise self._loaded
        return self._loaded


@pytest.fixture
def fresh() -> Iterator[None]:
    default_registry.cache_clear()
    yield
    default_registry.cache_clear()


def installed(monkeypatch: pytest.MonkeyPatch, *entries: Entry) -> Registry:
    def entry_points(*, group: str) -> list[Entry]:
        assert group == GROUP
        return list(entries)

    monkeypatch.setattr(importlib.metadata, "entry_points", entry_points)
    return default_registry()


@pytest.mark.usefixtures("fresh")
def test_a_broken_plugin_does_not_affect_other_node_types(monkeypatch: pytest.MonkeyPatch) -> None:
    found = installed(
        monkeypatch,
        Entry("acme-bad", "a_bad.nodes", ImportError("no module named 'torch'")),
        Entry("acme-exit", "b_exit.nodes", SystemExit(3)),
        Entry("acme-clash", "c_clash.nodes", module("c_clash.nodes", Fine, Hijack)),
        Entry("acme-good", "d_good.nodes", module("d_good.nodes", Mine)),
        Entry("acme-twice", "e_twice.nodes", module("e_twice.nodes", AlsoMine)),
    )
    assert found.owners["acme.Mine"] == "acme-good"
    assert "acme.Fine" not in found.types
    assert found.find("OnPlaybackTick") is not None
    assert list(found.broken) == [
        "acme-bad: a_bad.nodes",
        "acme-exit: b_exit.nodes",
        "acme-clash: c_clash.nodes",
        "acme-twice: e_twice.nodes",
    ]
    assert found.broken["acme-bad: a_bad.nodes"] == "ImportError: no module named 'torch'"
    assert "d_good.nodes.Mine of acme-good, and e_twice.nodes.AlsoMine" in found.broken["acme-twice: e_twice.nodes"]


@pytest.mark.usefixtures("fresh")
def test_help_for_an_unknown_type_names_the_broken_plugin(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    installed(monkeypatch, Entry("acme-bad", "acme.nodes", ImportError("no module named 'torch'")))
    path = tmp_path / "a.yaml"
    path.write_text("graph: a\nnodes: {Arm: acme.Torch}\n")
    (finding,) = build.load(path, Options()).findings.items
    assert finding.code == "G201"
    missing = "acme-bad: acme.nodes could not be imported (ImportError: no module named 'torch')"
    assert finding.help == (f"`graphrun nodes` lists every type; if it is yours, add `--import acme`; {missing}",)


def test_a_file_cannot_have_code_imported(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    names = ["antigravity", "os.system", "antigravity.Node", "tests.compiler.test_registry.Mine", "../nodes"]
    path.write_text("graph: a\nnodes: {" + ", ".join(f"N{i}: {name!r}" for i, name in enumerate(names)) + "}\n")
    findings = build.load(path).findings
    assert [finding.code for finding in findings.errors] == ["G201"] * len(names)
    assert "antigravity" not in sys.modules


def test_the_lints_beside_a_node_type_are_registered_when_it_is_found() -> None:
    found = default_registry().find("DifferentialController")
    assert found is not None
    assert found.cls.__module__ in {function.__module__ for function in LINTS["W201"]}
