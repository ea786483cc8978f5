"""`--distro`: the message types of a distribution of ROS 2, and recordings that keep the choice."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.harness import Graphrun

MEMORY = ("--transport", "memory")
STEERED = """format: 1
graph: steered
nodes:
  Tick: OnPlaybackTick
  Hear: {type: ROS2Subscriber, inputs: {topicName: heard, messagePackage: PACKAGE, messageName: NAME}}
connections:
  - Tick.tick -> Hear.execIn
"""


@pytest.fixture
def steered(project: Path) -> str:
    text = STEERED.replace("PACKAGE", "geometry_msgs").replace("NAME", "Pose2D")
    (project / "steered.yaml").write_text(text, "utf-8")
    return "steered.yaml"


def test_a_check_knows_the_types_of_the_distribution(graphrun: Graphrun, steered: str) -> None:
    graphrun("check", steered, code=0)
    graphrun("check", steered, "--distro", "kilted", code=0)
    assert "no message type 'geometry_msgs/msg/Pose2D'" in graphrun("check", steered, "--distro", "lyrical", code=1).out


def test_a_sourced_ros_selects_the_distribution_unless_an_option_does(
    graphrun: Graphrun, steered: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DISTRO", "lyrical")
    graphrun("check", steered, code=1)
    graphrun("check", steered, "--distro", "jazzy", code=0)


def test_a_recording_is_replayed_with_its_distribution(
    graphrun: Graphrun, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = STEERED.replace("PACKAGE", "nav_msgs").replace("NAME", "Trajectory")  # Lyrical has it
    (project / "followed.yaml").write_text(text, "utf-8")
    graphrun("run", "followed.yaml", "--distro", "lyrical", "--for", "1", "--record", "out.mcap", *MEMORY, code=0)
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    assert graphrun("replay", "out.mcap", code=0).out.startswith("identical")
