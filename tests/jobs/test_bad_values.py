"""Messages that nodes cannot use: the run goes on, counts them and warns once, and its recording replays."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.cli import main
from graphengine.format.errors import NodeError
from graphengine.messages.definitions import DEFINITIONS
from tests.jobs.bad_messages import NAMES, TOPICS, bad_messages, write_scene
from tests.jobs.harness import Job, twist
from tests.recording.harness import Run, record

WHEELS = list(NAMES[:2])
CMD_VEL, ODOM = "/dd100_0000/cmd_vel", "/dd100_0000/odom"


def joint_state(names: list[str], **values: list[float]) -> Any:
    message = DEFINITIONS.initial("sensor_msgs/msg/JointState")
    message.name = names
    for name, numbers in values.items():
        setattr(message, name, np.array(numbers))
    return message


def number(value: int) -> Any:
    message = DEFINITIONS.initial("std_msgs/msg/Int32")
    message.data = value
    return message


BAD = (
    ("/joint_command", joint_state(["no_such_joint"], velocity=[1.0]), "/World/joints/Controller", "no_such_joint"),
    ("/joint_command", joint_state(WHEELS, velocity=[1e308, 0.0]), "/World/joints/Controller", "velocityCommand"),
    ("/joint_command", joint_state(WHEELS, effort=[1e9, 0.0]), "", "effort of /dd100/front_left_wheel_joint"),
    ("/number", number(0), "/World/arrivals/Ratio", "b must be other than 0"),
)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_scene(tmp_path)


@pytest.fixture
def job(scene: Path) -> Iterator[Job]:
    with Job(scene, heard=False) as job:
        yield job


@pytest.mark.parametrize(("topic", "message", "node", "word"), BAD)
def test_a_bad_message_is_counted_and_warned_of_once_and_the_robot_drives_afterwards(
    job: Job, topic: str, message: Any, node: str, word: str
) -> None:
    said: list[tuple[str, str, str]] = []
    job.session.services.log = lambda *line: said.append(line)
    job.transport.inject(topic, message)
    job.run(0.5)
    services = job.session.services
    assert services.dropped is not None
    assert services.dropped.ticks == ({node: 1} if node else {})
    assert len(services.world.clamped_commands) == (not node)
    ((severity, where, text),) = said
    assert (severity, where) == ("warning", node)
    assert word in text
    job.transport.inject("/joint_command", joint_state(WHEELS, velocity=[0.0, 0.0], effort=[0.0, 0.0]))
    job.run(1.0)
    robot = services.world.entities
    start = np.array(robot.state("dd100").position)
    job.drive(CMD_VEL, 0.5, 0.0, 2.0)
    assert 0.4 < math.dist(start, robot.state("dd100").position) < 1.5


def test_a_twist_that_is_not_a_number_leaves_nothing_behind(scene: Path) -> None:
    ends = []
    for value in (0.0, math.nan):
        with Job(scene, heard=False) as job:
            job.transport.inject(CMD_VEL, twist(value, value))
            job.run(1.0)
            job.drive(CMD_VEL, 0.5, 0.2, 2.0)
            ends.append(job.session.services.world.entities.state("dd100").position)
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


def test_where_bad_values_are_to_stop_the_run_they_end_it_with_their_node(scene: Path) -> None:
    with Job(scene, heard=False, bad_values="stop") as job:
        job.transport.inject("/number", number(0))
        with pytest.raises(
            NodeError, match=r"node Ratio \(omni.graph.nodes.Divide\) raised BadValueError: b must be other"
        ):
            job.session.step()


def test_hundreds_of_random_messages_of_each_type_are_lived_through_and_replayed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    draw = np.random.default_rng(1)
    makers = {topic: bad_messages(kind, draw) for topic, kind in TOPICS.items()}

    def send(tick: int, run: Run) -> None:
        for topic, made in makers.items():
            for message in itertools.islice(made, 2):
                run.transport.inject(topic, message)

    path = tmp_path / "bad.mcap"
    run = record(path, 100, write_scene(tmp_path), before=send)
    dropped = run.session.services.dropped
    assert dropped is not None
    assert {"/World/joints/Controller", "/World/arrivals/Ratio"} <= set(dropped.ticks)
    assert main(["replay", str(path)]) == 0
    assert capsys.readouterr().out.startswith("identical: ")
