"""Runs in lockstep with a controller in another process, and with peers in the same process."""

from __future__ import annotations

import math
import random
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from mcap.records import Channel, Message, Metadata
from mcap.stream_reader import StreamReader

import graphengine as ge
from graphengine.api.run_options import RunOptions, read_lockstep
from graphengine.api.runner import Runner
from graphengine.api.scene import start_runner
from graphengine.cli import main
from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import Twist, Vector3, decode, encode
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.ros.conftest import StartPeer, end_peer

CMD_VEL = "/dd100_0000/cmd_vel"
CLOCK = "rosgraph_msgs/msg/Clock"
EVERY_TENTH = {"topic": CMD_VEL, "period": "100ms"}


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("dd100_flat", rays="mujoco")


def content(path: Path) -> Sequence[object]:
    """The content of a recording without the random identity of its process on the network."""
    found: list[object] = []
    with path.open("rb") as file:
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                found.append((record.id, record.topic, record.metadata))
            elif isinstance(record, Message):
                found.append((record.channel_id, record.log_time, record.publish_time, record.data))
            elif isinstance(record, Metadata):
                found.append({key: value for key, value in record.metadata.items() if key != "identity"})
    return found


def commands(path: Path) -> list[tuple[float, float]]:
    """The tick's time and the velocity of each command in a recording."""
    with path.open("rb") as file:
        records = list(StreamReader(file).records)
    topics = {record.id: record.topic for record in records if isinstance(record, Channel)}
    told = [record for record in records if isinstance(record, Message) and topics[record.channel_id] == CMD_VEL]
    return [(record.log_time / 1e9, decode(record.data, "geometry_msgs/msg/Twist").linear.x) for record in told]


def run_over_dds(
    scene: ge.Scene, start_peer: StartPeer, domain_id: int, path: Path, slow: float, seconds: float
) -> None:
    """Record a run whose controller answers each tenth of a second, up to `slow` s late."""
    environ = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    entries = read_lockstep(EVERY_TENTH | {"timeout": 60})
    controller = start_peer("control", SLOW=str(slow))
    with start_runner(scene, RunOptions(transport="dds", environ=environ, record=path, lockstep=entries)) as runner:
        assert runner.run(seconds, math.inf)
    end_peer(controller)


def test_the_recording_does_not_depend_on_the_speed_of_a_controller_in_another_process(
    scene: ge.Scene, start_peer: StartPeer, domain_id: int, tmp_path: Path
) -> None:
    paths = [tmp_path / f"{number}.mcap" for number in range(3)]
    for path, slow in zip(paths, (0.0, 0.2, 0.2), strict=True):
        run_over_dds(scene, start_peer, domain_id, path, slow, 0.55)
    told = commands(paths[0])
    assert [time for time, _ in told] == pytest.approx([(6 * k + 1) / 60 for k in range(1, 6)])
    assert [velocity for _, velocity in told] == pytest.approx([0.5 + k / 100 for k in range(1, 6)])
    assert content(paths[1]) == content(paths[2]) == content(paths[0])
    assert main(["replay", str(paths[1])]) == 0


class Peer:
    """A program in a thread of this process, which acts when it has received a /clock `hears` times."""

    def __init__(self, act: Callable[[Peer, float], None], hears: int = 1) -> None:
        self._hears = hears
        self.transport = MemoryTransport()
        self.clocks: list[float] = []
        self._act = act
        self.transport.reader("/clock", CLOCK, QoS(), self._hear)

    def _hear(self, data: bytes) -> None:
        clock = decode(data, CLOCK).clock
        self.clocks.append(clock.sec + clock.nanosec / 1e9)
        if self.clocks.count(self.clocks[-1]) == self._hears:
            threading.Thread(target=self._act, args=(self, self.clocks[-1])).start()

    def command(self, velocity: float, topic: str = CMD_VEL) -> None:
        with suppress(TransportError):  # the run may have ended
            self.transport.inject(topic, encode(Twist(Vector3(velocity, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))))


@contextmanager
def running(scene: ge.Scene, peer: Peer, *entries: dict[str, Any], record: Path | None = None) -> Iterator[Runner]:
    options = RunOptions(join=lambda _: peer.transport, lockstep=read_lockstep(list(entries)), record=record)
    with start_runner(scene, options) as runner:
        yield runner


def is_tenth(time: float, offset: float = 0.0) -> bool:
    return abs((time - offset) * 10 - round((time - offset) * 10)) < 1e-6


def test_early_messages_wait_for_the_end_of_their_period(scene: ge.Scene, tmp_path: Path) -> None:
    def twice(peer: Peer, now: float) -> None:
        if is_tenth(now, 0.05):
            peer.command(now)
        if is_tenth(now):
            time.sleep(random.uniform(0.0, 0.03))
            peer.command(now)

    with running(scene, Peer(twice), EVERY_TENTH | {"messages": 2}, record=tmp_path / "run.mcap") as runner:
        runner.run(0.35, math.inf)
    told = commands(tmp_path / "run.mcap")
    assert [when for when, _ in told] == pytest.approx([(6 * k + 1) / 60 for k in (1, 1, 2, 2, 3, 3)])
    assert [velocity for _, velocity in told] == pytest.approx([0.05, 0.1, 0.15, 0.2, 0.25, 0.3])


def test_two_robots_can_have_different_controllers_and_periods(tmp_path: Path) -> None:
    robots = {name: {"use": "robots/dd100.yaml", "position": [0, y, 0.025]} for name, y in (("a", 0), ("b", 2))}
    graphs = {"clock": {"use": "graphs/clock.yaml"}}
    for name, robot in robots.items():
        robot["namespace"] = name
    entries = [{"topic": "/a/cmd_vel", "period": 0.1}, {"topic": "/b/cmd_vel", "period": "50ms"}]
    content = {"scene": "two", "world": "worlds/flat_grid.xml", "robots": robots, "graphs": graphs, "lockstep": entries}

    def answer(peer: Peer, now: float) -> None:
        time.sleep(random.uniform(0.0, 0.03))
        for name, due in (("a", is_tenth(now)), ("b", is_tenth(2 * now))):
            if due:
                peer.command(now, f"/{name}/cmd_vel")

    peer, arrivals = Peer(answer), []
    with start_runner(ge.load(content), RunOptions(join=lambda _: peer.transport)) as runner:

        class Tap:
            def write(self, claim: Any, data: bytes) -> None: ...

            def deliver(self, claim: Any, arrived: Sequence[bytes]) -> None:
                arrivals.append((claim.topic[1], runner.session.clock.frame, len(arrived)))

        runner.network.tap(Tap())
        runner.run(0.25, math.inf)
    assert sorted(arrivals) == [("a", 6, 1), ("a", 12, 1), *(("b", frame, 1) for frame in (3, 6, 9, 12))]


def test_a_lost_clock_is_sent_again_but_not_recorded(scene: ge.Scene, tmp_path: Path) -> None:
    def miss_the_first(peer: Peer, now: float) -> None:
        if is_tenth(now):
            peer.command(now)

    peer = Peer(miss_the_first, hears=2)
    with running(scene, peer, EVERY_TENTH, record=tmp_path / "run.mcap") as runner:
        begun = time.monotonic()
        runner.run(7 / 60, math.inf)
    assert time.monotonic() - begun >= 0.2
    assert peer.clocks == pytest.approx([frame / 60 for frame in (1, 2, 3, 4, 5, 6, 6, 7)])
    assert main(["replay", str(tmp_path / "run.mcap")]) == 0


def test_commands_are_executed_during_a_wait_and_a_pause_stops_its_timeout(scene: ge.Scene) -> None:
    peer = Peer(lambda peer, now: None)
    with running(scene, peer, EVERY_TENTH | {"timeout": 1.0}) as runner:
        session = runner.session
        states: list[int] = []

        def script() -> None:
            while not states or states[-1] < 6:
                states.append(runner.queue.submit("state").result(10)["tick"])
                time.sleep(0.02)
            runner.queue.submit("pause").result(10)
            time.sleep(1.2)
            runner.queue.submit("play").result(10)
            time.sleep(0.1)
            peer.command(0.5)

        threading.Thread(target=script).start()
        session.run(7 / 60, pace=0.1)  # so slow that only the wait could make a tick late, not the machine
        assert (states[-1], session.ticks, session.late_ticks) == (6, 7, 0)


def test_an_interrupt_ends_a_wait(scene: ge.Scene) -> None:
    with running(scene, Peer(lambda peer, now: None), EVERY_TENTH) as runner:
        threading.Timer(0.2, runner.session.interrupt).start()
        assert not runner.run(1.0, math.inf)
        assert runner.session.ticks == 6


def test_a_run_can_continue_after_the_error_about_a_silent_controller(scene: ge.Scene) -> None:
    with running(scene, peer := Peer(lambda peer, now: None), EVERY_TENTH | {"timeout": 0.1, "messages": 2}) as runner:
        peer.command(0.1)
        with pytest.raises(TransportError) as error:
            runner.run(1.0, math.inf)
        assert str(error.value).splitlines() == [
            f"{CMD_VEL}: lockstep received 1 of 2 messages within 0.1 s of wall time, at t = 0.1 s",
            "  no program publishes the topic: start the program under test, in the ROS domain of this run",
        ]
        assert runner.session.state == "paused"
        peer.transport.writer(CMD_VEL, "geometry_msgs/msg/Twist", QoS())
        with pytest.raises(TransportError, match="a program publishes the topic: make it answer /clock"):
            runner.step(1)
        peer.command(0.2)
        runner.step(1)
        assert runner.session.ticks == 7


def test_a_program_that_sends_too_many_messages_is_an_error(scene: ge.Scene) -> None:
    with running(scene, peer := Peer(lambda peer, now: None), EVERY_TENTH) as runner:
        for number in range(10):
            peer.command(number / 10)
        runner.step(1)
        peer.command(1.0)
        with pytest.raises(TransportError, match="11 messages wait at t"):
            runner.step(1)


def test_a_topic_without_a_subscription_is_refused(scene: ge.Scene) -> None:
    with pytest.raises(ge.UsageError, match=f"no graph subscribes to '/dd100_0000/cmd_vl'\n  did you mean '{CMD_VEL}'"):
        scene.session(lockstep={"topic": "/dd100_0000/cmd_vl", "period": 0.1})
    with pytest.raises(ge.UsageError, match="has two entries"):
        scene.session(lockstep=[EVERY_TENTH, EVERY_TENTH])


def test_a_run_of_the_command_line_ends_with_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    entry = f"{CMD_VEL}=0.05s,messages=2,timeout=100ms"
    assert main(["run", "dd100_flat", "--transport", "memory", "--for", "1", "--lockstep", entry]) == 1
    assert "lockstep received 0 of 2 messages within 0.1 s of wall time, at t = 0.05 s" in capsys.readouterr().err
