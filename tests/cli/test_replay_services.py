"""Services in recordings: requests and answers at their ticks, calls and responses compared, events as rosbag2 has them."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

from rosbags.rosbag2 import Reader

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.transports.memory.memory_services import MemoryClient, MemoryServer
from tests import service_graph
from tests.cli.harness import Graphrun
from tests.nodes.test_service_prim import FILES, Asking
from tests.recording.harness import Run, put, record
from tests.ros.test_service_endpoints import INFO
from tests.service_graph import ANSWER, ASK, CLIENT, SERVER, SET_BOOL

TOPIC = "/light/_service_event"
LIGHT, CALLING, BOTH = f"graph: light\n{SERVER}", f"graph: calling\n{CLIENT}", f"graph: light\n{service_graph.BOTH}"


def asking(*ticks: int) -> Callable[[int, Run], None]:
    """Somebody who asks before some ticks, in turn for on and off."""
    clients: list[MemoryClient] = []

    def before(tick: int, run: Run) -> None:
        if not clients:
            clients.append(run.transport.client("/light", SET_BOOL, QoS(), lambda number, data: None))
        if tick in ticks:
            clients[0].call(messages.encode(ASK(ticks.index(tick) % 2 == 0)))
            clients[0].call(messages.encode(ASK(False)))

    return before


def answering(late: int) -> Callable[[int, Run], None]:
    """A server that answers some ticks later, and stops the session once."""
    requests: list[tuple[int, bytes]] = []
    servers: list[MemoryServer] = []

    def before(tick: int, run: Run) -> None:
        if not servers:
            servers.append(
                run.transport.server("/light", SET_BOOL, QoS(), lambda name, _: requests.append((tick, name)))
            )
        if tick % late == 0:
            for number, (_, name) in enumerate(requests):
                servers[0].answer(name, messages.encode(ANSWER(True, f"{tick}:{number}")))
            requests.clear()
        if tick == 25:
            run.session.stop()

    return before


def test_requests_are_replayed_and_answers_compared(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 40, put(tmp_path / "light.yaml", LIGHT), before=asking(3, 7, 8))
    result = graphrun("replay", str(path))
    assert (result.code, result.err) == (0, "")
    assert result.out == "identical: 6 messages in 40 ticks, 0.667 s\n"


def test_answers_are_replayed_and_calls_compared_also_over_a_stop(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 40, put(tmp_path / "calling.yaml", CALLING), before=answering(3))
    result = graphrun("replay", str(path))
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith("identical: ")


def test_a_client_and_a_server_of_one_graph_are_replayed(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 10, put(tmp_path / "both.yaml", BOTH))
    result = graphrun("replay", str(path))
    assert (result.code, result.err) == (0, "")
    # Ten calls, nine answers to those that were heard, and what is said of each from the fourth tick on.
    assert result.out == "identical: 26 messages in 10 ticks, 0.167 s\n"


def test_the_same_run_makes_the_same_file(tmp_path: Path) -> None:
    scene, files = put(tmp_path / "both.yaml", BOTH), [tmp_path / name for name in ("one.mcap", "two.mcap")]
    for path in files:
        record(path, 10, scene)
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_different_answer_is_reported_with_its_field(graphrun: Graphrun, tmp_path: Path) -> None:
    path, scene = tmp_path / "out.mcap", put(tmp_path / "light.yaml", LIGHT)
    record(path, 20, scene, before=asking(3))
    put(scene, LIGHT.replace("done", "did"))
    result = graphrun("replay", str(path), "--against", str(scene))
    assert result.code == 1
    assert f"different in tick 3, t = 0.050000 s: {TOPIC}" in result.out
    assert "published by /World/light/Server" in result.out
    assert "response[0].message: recorded 'done', replayed 'did'" in result.out


def test_a_missing_answer_is_reported_with_the_node(graphrun: Graphrun, tmp_path: Path) -> None:
    path, scene = tmp_path / "out.mcap", put(tmp_path / "light.yaml", LIGHT)
    record(path, 20, scene, before=asking(3))
    put(scene, LIGHT.replace("  - Server.onReceived -> Answer.onReceived\n", ""))
    result = graphrun("replay", str(path), "--against", str(scene))
    assert result.code == 1
    assert f"different in tick 3, t = 0.050000 s: {TOPIC}\n  published by /World/light/Server" in result.out
    assert "the replay sends no such message\n" in result.out


def test_a_missing_server_is_reported(graphrun: Graphrun, tmp_path: Path) -> None:
    path, scene = tmp_path / "out.mcap", put(tmp_path / "light.yaml", LIGHT)
    record(path, 20, scene, before=asking(3))
    put(scene, LIGHT.replace("serviceName: light", "serviceName: lamp"))
    result = graphrun("replay", str(path), "--against", str(scene))
    assert result.code == 1
    assert f"messages of {TOPIC} ({SET_BOOL}_Event) were recorded" in result.err


def test_other_readers_of_bags_find_events_of_service_introspection(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 10, put(tmp_path / "light.yaml", LIGHT), before=asking(3))
    with Reader(path) as reader:
        found = [
            (c.msgtype, messages.decode(bytes(data), c.msgtype)) for c, _, data in reader.messages() if c.topic == TOPIC
        ]
    assert {kind for kind, _ in found} == {f"{SET_BOOL}_Event"}
    assert [event.info.event_type for _, event in found] == [INFO.REQUEST_RECEIVED] * 2 + [INFO.RESPONSE_SENT] * 2
    assert [event.response[0].success for _, event in found[2:]] == [True, False]


def test_a_recording_of_the_verb_run_is_replayed_identically(graphrun: Graphrun, tmp_path: Path) -> None:
    path, scene = tmp_path / "out.mcap", put(tmp_path / "both.yaml", BOTH)
    ran = graphrun("run", str(scene), "--for", "1s", "--record", str(path), "--transport", "memory")
    assert ran.code == 0
    assert graphrun("replay", str(path)).out.startswith("identical: ")


def test_changes_of_the_world_by_services_are_replayed(graphrun: Graphrun, tmp_path: Path) -> None:
    for name, text in FILES.items():
        put(tmp_path / name, textwrap.dedent(text).lstrip())
    tree = "  Tree: {type: ROS2PublishTransformTree, inputs: {targetPrims: [/World/box, /arm]}}\nconnections:\n"
    graph = (tmp_path / "prims.yaml").read_text("utf-8")
    put(tmp_path / "prims.yaml", graph.replace("connections:\n", f"{tree}  - Tick.tick -> Tree.execIn\n"))
    asking: list[Asking] = []

    def before(tick: int, run: Run) -> None:
        if not asking:
            asking.append(Asking(run.transport))
        if tick == 5:
            asking[0].ask("SetPrimAttribute", "/World/box", "xformOp:translate", "[4, 5, 6]")
            asking[0].ask("SetPrimAttribute", "/arm/Physics/turn", "drive:angular:physics:targetPosition", "30")

    path = tmp_path / "out.mcap"
    record(path, 30, tmp_path / "scene.yaml", before=before)
    assert asking[0].answer().success
    assert graphrun("replay", str(path)).out == "identical: 32 messages in 30 ticks, 0.500 s\n"
