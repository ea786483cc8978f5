"""The Python classes of ROS 2 types, found without a package beside those that rclpy itself needs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from graphengine.ros.transports.rcl.rcl_profiles import ros_class

MESSAGE = "class {0}:\n    get_fields_and_field_types = None\n"
SERVICE = "class {0}:\n    class Request: pass\n"
ACTIONS = f"""
{MESSAGE.format("Feedback")}
{SERVICE.format("Service")}
class Walk:
    class Impl:
        SendGoalService = GetResultService = Service
        FeedbackMessage = Feedback
{MESSAGE.format("Slow_Walk")}
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package of types on the path of modules, as rosidl generates it."""
    for folder, text in (("msg", MESSAGE.format("Tag")), ("srv", SERVICE.format("Ask")), ("action", ACTIONS)):
        path = tmp_path / "generated_msgs" / folder / "__init__.py"
        path.parent.mkdir(parents=True)
        path.write_text(text, encoding="utf-8")
    (tmp_path / "generated_msgs" / "__init__.py").touch()
    (tmp_path / "generated_msgs" / "generated_msgs_s__rosidl_typesupport_c.so").touch()
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.startswith("generated_msgs")]:
        monkeypatch.delitem(sys.modules, name)


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("kind", "service", "name"),
    [
        ("generated_msgs/msg/Tag", False, "Tag"),
        ("generated_msgs/srv/Ask", True, "Ask"),
        ("generated_msgs/action/Slow_Walk", False, "Slow_Walk"),
        ("generated_msgs/action/Walk_SendGoal", True, "Service"),
        ("generated_msgs/action/Walk_GetResult", True, "Service"),
        ("generated_msgs/action/Walk_FeedbackMessage", False, "Feedback"),
    ],
)
def test_types_and_parts_of_actions_have_python_classes(kind: str, service: bool, name: str) -> None:
    found = ros_class(kind, service=service)
    assert (found.__module__, found.__name__) == (kind.rpartition("/")[0].replace("/", "."), name)
    with pytest.raises(ValueError, match="it is not a message" if service else "it is not a service"):
        ros_class(kind, service=not service)


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("kind", ["absent_msgs/msg/Tag", "generated_msgs/msg/Absent", "Tag"])
def test_a_type_that_is_not_installed_has_no_class(kind: str) -> None:
    with pytest.raises((AttributeError, ImportError, ValueError)):
        ros_class(kind, service=False)


@pytest.mark.parametrize("kind", ["stranger/msg/Tag", "stranger.msg/Tag", "stranger/Tag"])
def test_a_package_that_is_not_generated_from_ros_types_is_not_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    (tmp_path / "stranger" / "msg").mkdir(parents=True)
    (tmp_path / "stranger" / "msg" / "__init__.py").write_text(MESSAGE.format("Tag"), encoding="utf-8")
    (tmp_path / "stranger" / "__init__.py").write_text(MESSAGE.format("Tag"), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ImportError):
        ros_class(kind, service=False)
    assert not {"stranger", "stranger.msg"} & sys.modules.keys()


@pytest.mark.ros
@pytest.mark.parametrize("kind", ["nav_msgs/msg/Odometry", "std_srvs/srv/SetBool", "action_msgs/srv/CancelGoal"])
def test_classes_of_an_installed_ros_are_found(kind: str) -> None:
    assert ros_class(kind, service="/srv/" in kind).__name__ == kind.rpartition("/")[2]
