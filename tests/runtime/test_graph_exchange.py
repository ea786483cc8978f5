"""What the nodes of a graph keep when its file changes while it runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import GraphError, NodeError, UsageError
from graphengine.messages import messages
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.commands import parse
from graphengine.runtime.reloading import Reloaded
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests.jobs.harness import twist

GRAPH = """graph: g
variables:
  speed: {type: double, default: 1.0}
nodes:
  Tick: OnPlaybackTick
  Counter: omni.graph.action.Counter
  Third: {type: omni.graph.action.Counter, every: {ticks: 3}}
  Random: {type: RandomNumeric, inputs: {max: {type: double, value: 1.0}}}
  Countdown: {type: omni.graph.action.Countdown, every: once, inputs: {duration: 100, period: 1}}
  Limit: {type: ConstantDouble, inputs: {value: 3.0}}
  Write: {type: WriteVariable, inputs: {variableName: speed}}
  Twist: {type: ROS2SubscribeTwist, inputs: {topicName: cmd_vel}}
  Clock: PublishClock
  Impulse: OnImpulseEvent
  Impulses: omni.graph.action.Counter
connections:
  - Tick.tick -> Counter.execIn
  - Tick.tick -> Third.execIn
  - Tick.tick -> Random.execIn
  - Tick.tick -> Countdown.execIn
  - Tick.tick -> Write.execIn
  - Tick.tick -> Twist.execIn
  - Tick.tick -> Clock.execIn
  - Tick.time -> Clock.timeStamp
  - Limit.inputs:value -> Write.value
  - Impulse.execOut -> Impulses.execIn
"""


class Running:
    """A session of one graph file, which can be written anew."""

    def __init__(self, path: Path, stack: ExitStack, **options: Any) -> None:
        self.path = path
        self.transport = MemoryTransport(wants_all=True)
        self.said: list[str] = []
        network = LiveNetwork(lambda _: self.transport, 0, self.said.append)
        loaded = build.load(path, Options(**options))
        self.session = stack.enter_context(build.start(loaded, network, log=lambda *said: self.said.append(said[-1])))
        self.network = network

    def node(self, name: str) -> Any:
        return self.session.graphs[0].executor.node(name)

    def reload(self, *changes: tuple[str, str]) -> Reloaded:
        """Reload after replacing texts in the file."""
        text = self.path.read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        self.path.write_text(text, encoding="utf-8")
        return self.session.reload()

    def ask(self, name: str, /, **arguments: Any) -> None:
        parse(name, arguments).apply(self.session)


@pytest.fixture
def begin(tmp_path: Path) -> Iterator[Any]:
    with ExitStack() as stack:

        def make(text: str = GRAPH, **options: Any) -> Running:
            path = tmp_path / "g.yaml"
            path.write_text(text, encoding="utf-8")
            return Running(path, stack, **options)

        yield make


OTHER = ("  Impulses: omni", "  Spare: ConstantDouble\n  Impulses: omni")
"""A change that none of the other nodes feels."""


def test_counts_gates_latent_nodes_and_variables_continue(begin: Any) -> None:
    run, other = begin(), begin()
    run.session.step(10)
    done = run.reload(OTHER)
    assert (done.changed, done.kept, done.nodes) == (("g",), 11, 12)
    run.session.step(10)
    other.session.step(20)
    for name, fields in {
        "Counter": ["count"],
        "Third": ["count"],
        "Random": ["random"],
        "Countdown": ["tick_value", "alpha", "active"],
    }.items():
        for field in fields:
            assert getattr(run.node(name), field) == getattr(other.node(name), field), name
    assert run.node("Counter").count == 20
    assert run.session.graphs[0].variables["speed"].value == 3.0


def test_a_node_of_another_type_starts_with_new_state(begin: Any) -> None:
    run = begin()
    run.session.step(5)
    done = run.reload(("Counter: omni.graph.action.Counter", "Counter: {type: Countdown}"))
    assert (done.kept, done.nodes) == (10, 11)
    run.session.step()
    assert run.node("Counter").tick_value == 1


def test_an_input_keeps_its_set_value_until_its_value_in_the_file_changes(begin: Any) -> None:
    run = begin()
    run.ask("set", address="Countdown.duration", value=50)
    run.ask("set", address="Limit.value", value=7.0)
    run.session.step()
    run.reload(OTHER)
    run.session.step()
    assert (run.node("Countdown").duration, run.session.graphs[0].variables["speed"].value) == (50, 7.0)
    run.reload(("duration: 100", "duration: 200"), ("value: 3.0", "value: 4.0"))
    run.session.step()
    assert (run.node("Countdown").duration, run.session.graphs[0].variables["speed"].value) == (200, 4.0)
    assert run.node("Countdown").tick_value == 3


RAMPS = """graph: g
nodes:
  Go: OnImpulseEvent
  Other: ConstantDouble
  Controller:
    type: DifferentialController
    inputs: {wheelRadius: 0.1, wheelDistance: 0.5, maxAngularAcceleration: 0.0}
connections: [Go.execOut -> Controller.execIn]
"""
RAMP = ("maxAngularAcceleration: 0.0", "maxAngularAcceleration: 1.0")
"""Inputs within their bounds that do not go together: a ramp needs `dt`."""


def test_a_bad_value_from_a_reload_is_dropped(begin: Any) -> None:
    run = begin(RAMPS)
    run.reload(RAMP)
    run.ask("impulse", node="Go")
    run.session.step()
    assert run.session.services.dropped.ticks == {"/World/g/Controller": 1}
    run.session.reset()
    run.session.step()
    run.ask("impulse", node="Go")
    run.session.step()
    assert run.session.services.dropped.ticks == {"/World/g/Controller": 2}


def test_a_value_from_the_start_still_ends_the_run_after_a_reload_of_other_nodes(begin: Any) -> None:
    run = begin(RAMPS.replace(*RAMP))
    run.reload(("Other: ConstantDouble", "Other: ConstantInt"))
    run.ask("impulse", node="Go")
    with pytest.raises(NodeError, match="for acceleration limits"):
        run.session.step()


def test_a_value_out_of_bounds_is_refused_by_a_reload(begin: Any) -> None:
    run = begin(RAMPS)
    with pytest.raises(CheckError, match=r"wheelRadius: expected a value > 0, got 0\.0"):
        run.reload(("wheelRadius: 0.1", "wheelRadius: 0.0"))
    run.session.step()
    assert run.node("Controller").wheel_radius == 0.1


def test_a_variable_keeps_its_value_until_its_default_changes(begin: Any) -> None:
    run = begin(GRAPH.replace("  - Tick.tick -> Write.execIn\n", ""))
    run.session.graphs[0].variables["speed"].value = 5.0
    run.reload(OTHER)
    assert run.session.graphs[0].variables["speed"].value == 5.0
    run.reload(("default: 1.0", "default: 2.0"))
    assert run.session.graphs[0].variables["speed"].value == 2.0


def test_an_unwired_input_has_the_value_of_the_file(begin: Any) -> None:
    run = begin()
    run.session.step(3)
    run.reload(("  - Tick.time -> Clock.timeStamp\n", ""))
    run.session.step()
    assert run.transport.messages("/clock")[-1].clock.nanosec == 0


def test_an_endpoint_with_an_equal_claim_stays_open(begin: Any) -> None:
    run = begin()
    run.session.step()
    publisher, subscription = run.network.publishers[0], run.network.subscriptions[0]
    run.transport.inject("/cmd_vel", twist(0.5, 0.0))
    run.reload(OTHER)
    assert run.network.publishers == [publisher]
    assert run.network.subscriptions == [subscription]
    run.session.step()
    assert run.node("Twist").linear_velocity[0] == 0.5, "a message that was on its way arrives"
    run.reload(("{topicName: cmd_vel}", "{topicName: other}"))
    assert (run.network.publishers, [end.topic for end in run.network.subscriptions]) == ([publisher], ["/other"])
    assert subscription not in run.network.hearing
    run.session.close()
    assert run.network.publishers == []


def test_claims_and_endpoints_equal_those_of_a_new_session(begin: Any) -> None:
    run = begin()
    for change in (OTHER, (OTHER[1], OTHER[0])):
        run.reload(change)
    other = begin()
    assert sorted(map(str, run.session.services.claims)) == sorted(map(str, other.session.services.claims))


def test_an_impulse_before_a_change_takes_effect(begin: Any) -> None:
    run = begin()
    run.ask("impulse", node="Impulse")
    run.reload(OTHER)
    run.session.step(2)
    assert run.node("Impulses").count == 1


def test_after_a_change_stop_resets_to_the_state_of_a_new_session(begin: Any) -> None:
    run = begin()
    run.session.step(7)
    run.reload(OTHER)
    run.session.step(7)
    run.ask("reset")
    first = len(run.transport.raw("/clock"))
    run.session.step(5)
    other = begin(run.path.read_text(encoding="utf-8"))
    other.session.step(5)
    assert run.transport.raw("/clock")[first:] == other.transport.raw("/clock")
    assert run.node("Random").random == other.node("Random").random


def test_a_checkpoint_after_a_change_can_be_restored(begin: Any) -> None:
    run = begin()
    run.session.step(7)
    run.reload(OTHER)
    run.ask("checkpoint", name="mark")
    run.session.step(7)
    number = run.node("Random").random
    run.ask("restore", name="mark")
    run.session.step(7)
    assert (run.node("Random").random, run.node("Counter").count) == (number, 14)


def test_after_a_failed_setup_the_old_graphs_continue_unchanged(begin: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    run, other = begin(), begin()
    run.session.step(5)
    claims, ends = list(run.session.services.claims), list(run.network.publishers)
    opened: list[Any] = []
    publisher = run.network.publisher

    def refuse(claim: Any) -> Any:
        opened.append(claim)
        raise GraphError("no memory for another topic")

    monkeypatch.setattr(run.network, "publisher", refuse)
    with pytest.raises(GraphError, match="no memory for another topic"):
        run.reload(OTHER, ("Clock: PublishClock", "Clock: {type: PublishClock, inputs: {topicName: other}}"))
    assert (len(opened), run.session.findings) == (1, ("no memory for another topic",))
    assert (run.session.services.claims, run.network.publishers) == (claims, ends)
    run.session.step(5)
    other.session.step(10)
    assert run.node("Random").random == other.node("Random").random
    assert run.transport.raw("/clock") == other.transport.raw("/clock")
    monkeypatch.setattr(run.network, "publisher", publisher)
    assert run.session.reload().mended
    run.session.step()
    assert run.transport.raw("/other")


@pytest.mark.parametrize(
    "other_type", [[], [("RandomNumeric, inputs: {max: {type: double, value: 1.0}}", "RandomGaussian")]]
)
def test_random_numbers_continue_after_a_failed_reload(
    begin: Any, monkeypatch: pytest.MonkeyPatch, other_type: list[tuple[str, str]]
) -> None:
    run, other = begin(), begin()
    run.session.step(5)
    kind = type(run.node("Random"))
    set_up = kind.setup

    def draw_in_setup(random: Any, context: Any) -> None:
        set_up(random, context)
        context.random().random()

    def refuse(claim: Any) -> Any:
        raise GraphError("no memory for another topic")

    monkeypatch.setattr(kind, "setup", draw_in_setup)
    monkeypatch.setattr(run.network, "publisher", refuse)
    generators = dict(run.session.services.generators)
    more = ("  Counter: omni", "  Spare: RandomBoolean\n  Counter: omni")
    wired = ("  - Tick.tick -> Counter", "  - Tick.tick -> Spare.execIn\n  - Tick.tick -> Counter")
    clock = ("Clock: PublishClock", "Clock: {type: PublishClock, inputs: {topicName: other}}")
    with pytest.raises(GraphError, match="no memory for another topic"):
        run.reload(*other_type, more, wired, clock)
    assert run.session.services.generators == generators
    run.session.step(5)
    other.session.step(10)
    assert run.node("Random").random == other.node("Random").random


def test_the_command_reload_has_no_arguments() -> None:
    with pytest.raises(UsageError, match="reload: unknown key 'files'"):
        parse("reload", {"files": {"/etc/passwd": None}})


SCRIPT = """graph: g
nodes:
  Tick: OnPlaybackTick
  Script:
    type: omni.graph.scriptnode.ScriptNode
    inputs: {usePath: true, scriptPath: own.py, attributes: ["outputs:number double"]}
connections:
  - Tick.tick -> Script.execIn
"""


def test_a_script_in_a_separate_file_is_read_again(tmp_path: Path, begin: Any) -> None:
    (tmp_path / "own.py").write_text("def compute(db):\n    db.outputs.number = 1.0\n", encoding="utf-8")
    run = begin(SCRIPT, scripts=True)
    run.session.step()
    assert not run.session.reload().changed
    (tmp_path / "own.py").write_text("def compute(db):\n    db.outputs.number = 2.0\n", encoding="utf-8")
    done = run.session.reload()
    assert (done.changed, [path.name for path in done.files]) == (("g",), ["own.py"])
    run.session.step()
    assert run.node("Script").outputs_number == 2.0
    (tmp_path / "own.py").write_text("def compute(db):\n    db.outputs.number = (\n", encoding="utf-8")
    with pytest.raises(CheckError, match=r"own\.py: line 2"):
        run.session.reload()
    run.session.step()


SERVICE = """graph: g
nodes:
  Tick: OnPlaybackTick
  Serve:
    type: ROS2ServiceServerRequest
    inputs: {messagePackage: std_srvs, messageName: SetBool, serviceName: set_bool}
  Delay: {type: omni.graph.action.Delay, inputs: {duration: 0.1}}
  Answer:
    type: ROS2ServiceServerResponse
    inputs: {messagePackage: std_srvs, messageName: SetBool}
connections:
  - Tick.tick -> Serve.execIn
  - Serve.onReceived -> Delay.execIn
  - Delay.finished -> Answer.onReceived
  - Serve.serverHandle -> Answer.serverHandle
"""


def test_a_request_gets_a_response_although_the_graph_has_changed(begin: Any) -> None:
    run = begin(SERVICE)
    answers: list[Any] = []
    client = run.transport.client(
        "/set_bool", "std_srvs/srv/SetBool", run.session.services.claims[0].qos, lambda *answer: answers.append(answer)
    )
    run.session.step()
    request = run.network.definitions.initial("std_srvs/srv/SetBool_Request")
    client.call(messages.encode(request, run.network.definitions))
    run.session.step(2)
    run.reload(("  Delay:", "  Spare: ConstantDouble\n  Delay:"))
    assert list(run.session.services.servers) == [1]
    run.session.step(10)
    assert len(answers) == 1
    run.session.close()


def test_only_unused_resources_are_closed(begin: Any) -> None:
    run = begin()
    run.reload(
        ("  - Tick.tick -> Clock.execIn\n  - Tick.time -> Clock.timeStamp\n", ""), ("  Clock: PublishClock\n", "")
    )
    assert run.network.publishers == []
    assert [claim.topic for claim in run.session.services.claims] == ["/cmd_vel"]
