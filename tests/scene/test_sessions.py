"""Sessions of one scene: each has a world and nodes of its own, and all share plans and generated code."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import pytest

from graphengine.compiler.codegen import source_of
from graphengine.node.node_class import Node
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.entity_commands import Delete
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene
from tests.jobs.harness import assemble, twist


@pytest.fixture(scope="module")
def flat() -> LoadedScene:
    return assemble("dd100_flat")


class Sessions:
    """Starts sessions, and closes them in the end."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack

    def __call__(self, scene: LoadedScene) -> tuple[SessionCore, MemoryTransport]:
        transport = MemoryTransport(wants_all=True)
        session = build.start(scene, LiveNetwork(lambda _: transport, 0, print))
        return self._stack.enter_context(session), transport


@pytest.fixture
def begin() -> Iterator[Sessions]:
    with ExitStack() as stack:
        yield Sessions(stack)


def sent(transport: MemoryTransport) -> dict[str, list[bytes]]:
    return {topic: transport.raw(topic) for topic in ("/dd100_0000/odom", "/dd100_0000/scan", "/clock")}


def test_one_session_drives_while_the_other_is_stopped(flat: LoadedScene, begin: Sessions) -> None:
    (driven, road), (other, _) = begin(flat), begin(flat)
    for _ in range(120):
        road.inject("/dd100_0000/cmd_vel", twist(0.5, 0.0))
        driven.step()
        other.step()
    far, near = (session.services.world.entities.state("dd100").position for session in (driven, other))
    assert far[0] - near[0] > 0.7
    start = flat.world.simulation.entities.state("dd100").position if flat.world is not None else None
    assert start is not None
    assert near == pytest.approx(start, abs=1e-3)


def test_a_session_sends_the_same_bytes_after_any_other_session(flat: LoadedScene, begin: Sessions) -> None:
    first, early = begin(flat)
    first.step(60)
    wild, road = begin(flat)
    road.inject("/dd100_0000/cmd_vel", twist(1.0, 2.0))
    wild.services.world.set_gravity((0.0, 0.0, -1.0))
    wild.step(60)
    last, late = begin(flat)
    last.step(60)
    assert sent(early) == sent(late)
    assert sent(early) != sent(road)


def test_a_robot_removed_from_one_session_stays_in_the_others(flat: LoadedScene, begin: Sessions) -> None:
    (one, _), (other, _) = begin(flat), begin(flat)
    Delete(name="dd100").apply(one)
    one.step(2)
    other.step(2)
    assert [entity.name for entity in other.services.world.entities.all() if entity.kind == "robot"] == ["dd100"]
    assert other.services.stage.find("/dd100").kind == "robot"
    assert "dd100" in [entity.name for entity in begin(flat)[0].services.world.entities.all()]


def test_robots_of_one_file_share_a_plan_and_its_code() -> None:
    scene = assemble("dd100_fleet")
    drives = [graph for graph in scene.planned if graph.name.endswith("/cmd_vel")]
    assert len(drives) == 10
    assert len({id(graph.plan) for graph in drives}) == 1
    assert len({id(source_of(graph.plan).code) for graph in drives}) == 1
    rows = [[instance.literals for instance in graph.instances] for graph in drives]
    assert str(rows[0]) != str(rows[1])


def test_graphs_of_one_file_with_different_wires_have_separate_plans(tmp_path: Path) -> None:
    # A parameter decides a literal, and with it which variable is written: order, and so the plan, depends on it.
    (tmp_path / "part.yaml").write_text(
        "format: 1\ngraph: part\nparameters: {name: {type: string}}\n"
        "variables: {a: {type: int, default: 0}, b: {type: int, default: 0}}\n"
        "nodes:\n  Tick: OnPlaybackTick\n"
        "  Write: {type: omni.graph.core.WriteVariable, inputs: {variableName: $(name), value: {type: int, value: 3}}}\n"
        "  Read: {type: omni.graph.core.ReadVariable, inputs: {variableName: a}}\n"
        "  Copy: {type: omni.graph.core.WriteVariable, inputs: {variableName: b}}\n"
        "connections: [Tick.tick -> Write.execIn, Write.execOut -> Copy.execIn, Read.value -> Copy.value]\n"
    )
    (tmp_path / "scene.yaml").write_text(
        "format: 1\nscene: two\nworld: worlds/flat_grid.xml\ngraphs:\n"
        "  one: {use: part.yaml, parameters: {name: a}}\n  two: {use: part.yaml, parameters: {name: b}}\n"
        "  three: {use: part.yaml, parameters: {name: a}}\n"
    )
    one, two, three = build.load(tmp_path / "scene.yaml").planned
    assert one.plan is three.plan
    assert one.plan is not two.plan


def test_a_robot_file_places_a_graph_below_each_of_its_robots(tmp_path: Path) -> None:
    graph = "format: 1\ngraph: empty\nnodes: {Tick: OnPlaybackTick}\n"
    bot = "format: 1\nrobot: bot\nextends: robots/dd100.yaml\n"
    bot += "graphs: {own: {use: empty.yaml, at: $(robot)/base_link/own}}\n"
    scene = "format: 1\nscene: fleet\nworld: worlds/flat_grid.xml\n"
    scene += "robots: {bot: {use: bot.yaml, count: 2, spacing: [2, 2], position: [0, 0, 0.025]}}\n"
    for name, text in {"empty": graph, "bot": bot, "scene": scene}.items():
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    paths = [graph.prim_path for graph in build.load(tmp_path / "scene.yaml").planned if graph.name.endswith("/own")]
    assert paths == ["/bot_0000/base_link/own", "/bot_0001/base_link/own"]


def test_a_scene_holds_no_references_to_nodes(flat: LoadedScene) -> None:
    seen: set[int] = set()
    waiting: list[Any] = [flat.graphs, flat.planned, flat.claims]
    while waiting:
        found = waiting.pop()
        if id(found) in seen or isinstance(found, type | FunctionType | ModuleType):
            continue
        seen.add(id(found))
        assert not isinstance(found, Node)
        waiting += gc.get_referents(found)
    assert len(seen) > 1000


def test_a_closed_session_is_not_kept_alive(flat: LoadedScene) -> None:
    session = build.start(flat, LiveNetwork(lambda _: MemoryTransport(), 0, print))
    session.step(3)
    session.close()
    world = weakref.ref(session.services.world)
    del session
    gc.collect()
    assert world() is None


def test_kernels_are_compiled_before_the_first_endpoint_appears(
    flat: LoadedScene, begin: Sessions, monkeypatch: pytest.MonkeyPatch
) -> None:
    fast = pytest.importorskip("graphengine.physics.ray_casting.fast.rays")
    order: list[str] = []

    def noted(word: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def note(*given: Any) -> Any:
            order.append(word)
            return call(*given)

        return note

    monkeypatch.setattr(fast, "trouble", noted("kernels", fast.trouble))
    monkeypatch.setattr(MemoryTransport, "writer", noted("writer", MemoryTransport.writer))
    monkeypatch.setattr(MemoryTransport, "reader", noted("reader", MemoryTransport.reader))
    begin(flat)
    assert {"kernels", "writer", "reader"} <= set(order)
    assert order[0] == "kernels"
