"""The message types of each distribution of ROS 2: what differs on the wire, and that nothing else does."""

from __future__ import annotations

import itertools
import pickle
from pathlib import Path

import pytest

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, shipped
from graphengine.messages.distros import DISTROS, Distro, sourced_distro
from graphengine.messages.interfaces import MessageTypeError
from tests.interop import distros
from tests.jobs.harness import Job

TRANSITION, FEEDBACK = "lifecycle_msgs/msg/TransitionEvent", "control_msgs/action/FollowJointTrajectory_Feedback"
POSE_2D = "geometry_msgs/msg/Pose2D"


def test_these_fields_differ_between_the_distributions() -> None:
    index, stamp = ("int32 index", "int32 multi_dof_index"), ("uint64 timestamp",)
    tracking = ("float32 position_tracking_error", "float32 heading_tracking_error")
    assert distros.fields() == {
        FEEDBACK: [(), index, index],
        TRANSITION: [stamp, stamp, ("builtin_interfaces/Time stamp",)],
        "nav2_msgs/action/NavigateToPose_Feedback": [(), (), tracking],
    }


def test_these_types_are_missing_in_a_distribution() -> None:
    gone = {name for name, (jazzy, _, lyrical) in distros.missing() if jazzy and not lyrical}
    assert gone == {POSE_2D, *(f"actionlib_msgs/msg/Goal{name}" for name in ("ID", "Status", "StatusArray"))}
    assert not [name for name, (jazzy, kilted, _) in distros.missing() if jazzy != kilted]


@pytest.mark.parametrize("distro", DISTROS)
def test_a_message_of_each_type_is_read_as_it_was_written(distro: Distro) -> None:
    known, own = shipped(distro), distros.fields().keys() | distros.containing(set(distros.fields()))
    for name in sorted(distros.types_of(known)):
        if known.definition(name).is_message:
            message = known.initial(name)
            data = messages.encode(message, known)
            assert messages.encode(messages.decode(data, name, known), known) == data
            if name not in own and name in distros.types_of(DEFINITIONS):
                assert data == messages.encode(DEFINITIONS.initial(name))


@pytest.mark.parametrize("distro", DISTROS[1:])
def test_a_scene_sends_the_same_bytes_in_each_distribution(distro: Distro) -> None:
    with Job("dd100_flat") as jazzy, Job("dd100_flat", distro=distro) as other:
        for job in (jazzy, other):
            job.run(0.5)
        assert len({topic for topic, _, _ in jazzy.recorder.stream}) > 5
        assert jazzy.recorder.digest == other.recorder.digest
        sent = {message_type for _, message_type, _ in other.recorder.stream}
    assert all(shipped(distro).type_hash(name) == DEFINITIONS.type_hash(name) for name in sent)


def test_a_type_with_equal_definitions_has_one_class_in_all_distributions() -> None:
    for distro in DISTROS:
        assert shipped(distro).message_class("geometry_msgs/msg/Twist") is messages.Twist


def test_a_type_missing_in_a_distribution_is_unknown_there() -> None:
    assert shipped("kilted").definition(POSE_2D)
    with pytest.raises(MessageTypeError, match="no message type"):
        shipped("lyrical").definition(POSE_2D)


def test_the_types_of_folders_are_kept_when_the_distribution_changes(tmp_path: Path) -> None:
    (tmp_path / "my_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "my_msgs" / "msg" / "Step.msg").write_text("lifecycle_msgs/TransitionEvent event\n")
    jazzy = DEFINITIONS.extended([tmp_path])
    lyrical = jazzy.for_distro("lyrical")
    assert [known.distro for known in (jazzy, lyrical, lyrical.for_distro("jazzy"))] == ["jazzy", "lyrical", "jazzy"]
    assert jazzy.type_hash("my_msgs/msg/Step") != lyrical.type_hash("my_msgs/msg/Step")
    assert hasattr(lyrical.initial("my_msgs/msg/Step").event, "stamp")


def test_a_definition_of_another_distribution_is_an_error_that_advises_distro(tmp_path: Path) -> None:
    (tmp_path / "lifecycle_msgs" / "msg").mkdir(parents=True)
    text = str(shipped("lyrical").definition(TRANSITION))
    (tmp_path / "lifecycle_msgs" / "msg" / "TransitionEvent.msg").write_text(text)
    (tmp_path / "my_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "my_msgs" / "msg" / "Step.msg").write_text("lifecycle_msgs/TransitionEvent event\n")
    assert shipped("lyrical").extended([tmp_path]).initial("my_msgs/msg/Step")
    with pytest.raises(MessageTypeError, match="differs from ROS 2 Jazzy's definition") as caught:
        DEFINITIONS.extended([tmp_path]).initial("my_msgs/msg/Step")
    assert any("--distro" in line for line in caught.value.help)


@pytest.mark.parametrize(("one", "other"), list(itertools.permutations(DISTROS, 2)))
def test_definitions_keep_their_distribution_in_another_process(one: Distro, other: Distro) -> None:
    assert pickle.loads(pickle.dumps(shipped(one))) is shipped(one)
    assert shipped(one).for_distro(other) is shipped(other)


@pytest.mark.parametrize(
    ("sourced", "chosen"), [("kilted", "kilted"), ("lyrical", "lyrical"), ("humble", "jazzy"), ("", "jazzy")]
)
def test_a_sourced_ros_chooses_its_own_distribution(sourced: str, chosen: str) -> None:
    assert sourced_distro({"ROS_DISTRO": sourced}) == chosen
    assert sourced_distro({}) == "jazzy"
