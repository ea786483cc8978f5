"""Cases of simulation time, physics steps, stamps, the clock and subscribers."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.messages import messages
from graphengine.nodes.core.time import IsaacReadSimulationTime, IsaacTimeSplitter
from graphengine.nodes.ros2.state import ROS2PublishClock
from graphengine.nodes.ros2.subscribers import ROS2SubscribeTwist
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, ready, twist
from tests.nodes.isaac.book import Case, differs, runs

CLOCK = "isaacsim.ros2.bridge.ROS2PublishClock"


@differs(
    "ROS2Subscribe{JointState,Clock,Twist,AckermannDrive}", "queue: N newest kept, one consumed per tick, oldest first"
)
def what_a_subscriber_delivers_of_a_burst(case: Case, play: Player) -> Any:
    context = RecordingContext()
    node = ready(ROS2SubscribeTwist, context, queue_size=3)
    for speed in range(1, 10):
        context.transport.inject("/cmd_vel", twist(float(speed), 0.0))
    delivered = []
    for _ in range(5):
        context.tick()
        if node.compute():
            delivered.append(node.linear_velocity[0])
    return "the newest, once" if delivered == [9.0] else delivered


@differs("SimulationManager", "step counter with warm-up")
def ticks_after_play(case: Case, play: Player) -> Any:
    playing = play.graph("nodes: {T: OnPlaybackTick, C: PublishClock}\nconnections: [T.tick -> C.execIn]")
    ticks = []
    for _ in case["inputs"]["updates_after_play"]:
        playing.tick()
        ticks.append(playing.session.clock.frame)
    playing.session.stop()
    return {"ticks": ticks, "after stop": playing.session.clock.frame}


@runs("simulation time", "no drift: time = stepCount/stepsPerSecond")
def time_does_not_drift(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(IsaacReadSimulationTime, context)
    context.tick(case["inputs"]["steps"])
    node.compute()
    limit = case["expect"]["|simTime - steps/60|"]["lt"]
    assert abs(node.simulation_time - case["inputs"]["steps"] / 60) < limit


@runs("simulation time", "resets on stop")
def time_is_0_after_a_stop(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(IsaacReadSimulationTime, context)
    context.tick(case["inputs"]["steps"])
    context.stop()
    node.compute()
    assert node.simulation_time == case["expect"]["simulation_time"]


@runs("simulation time monotonic", "persists over stop/start")
def monotonic_time_only_grows(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(IsaacReadSimulationTime, context, reset_on_stop=False)
    times, ends = [0.0], []
    for _ in range(case["inputs"]["runs"]):
        for _ in range(10):
            context.tick()
            node.compute()
            times.append(node.simulation_time)
        ends.append(times[-1])
        context.stop()
        node.compute()
        times.append(node.simulation_time)
    assert times == sorted(times)
    assert ends[0] < ends[1]


@runs("timestamps", "seconds->sec/nanosec truncation")
def stamps_are_truncated_to_nanoseconds(case: Case, play: Player) -> None:
    stamps = [messages.stamp(seconds) for seconds in case["inputs"]["t"]]
    assert [[stamp.sec, stamp.nanosec] for stamp in stamps] == case["expect"]["sec,nanosec"]


@runs(CLOCK, "sim clock from OnTick exceeds 2 s within 150 frames")
def the_clock_is_beyond_two_seconds_after_150_frames(case: Case, play: Player) -> None:
    playing = play.shipped("clock", RecordingWorld((1, 60))).tick(150)
    assert playing.published("/clock")[-1].clock.sec >= case["expect"]["clock"]["gt"]


@differs(CLOCK, "impulse: first impulse only creates the publisher, second publishes")
def clocks_after_each_execution(case: Case, play: Player) -> Any:
    context = RecordingContext()
    node, sent = ready(ROS2PublishClock, context, time_stamp=0.5), []
    for _ in range(case["inputs"]["impulses"]):
        node.compute()
        sent.append(len(context.transport.raw("/clock")))
    return {"messages after 1st": sent[0], "messages after 2nd": sent[1]}


@runs("isaacsim.core.nodes.IsaacTimeSplitter", "double", "float", "int", "int64", "uint64")
def a_time_is_split(case: Case, play: Player) -> None:
    given = case["inputs"]
    held = float(np.float32(given["time"])) if given["type"] == "float" else given["time"]
    node = IsaacTimeSplitter(time=held)
    node.compute()
    assert {name: getattr(node, name) for name in case["expect"]} == case["expect"]


@runs("isaacsim.core.nodes.OnPhysicsStep", "fires once per physics step (on-demand graph)")
def every_step_fires_once(case: Case, play: Player) -> None:
    playing = play.graph(
        """
        runs: physics_step
        nodes:
          Step: OnPhysicsStep
          Other: OnPhysicsStep
          One: {type: PublishClock, inputs: {topicName: one}}
          Two: {type: PublishClock, inputs: {topicName: two}}
        connections: [Step.step -> One.execIn, Other.step -> Two.execIn]
        """,
        RecordingWorld(substeps=4),
    )
    start = case["inputs"]["cube_size0"]
    assert case["expect"]["cube size after k steps"] == f"{start} + k"
    for ticks in range(1, 4):
        playing.tick()
        assert start + len(playing.published("/one")) == start + len(playing.published("/two")) == start + 4 * ticks
