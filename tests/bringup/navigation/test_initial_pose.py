"""Which transforms count as those of a robot that was given its initial pose."""

from __future__ import annotations

import pytest

from graphengine.bringup.navigation.initial_pose import may_belong


@pytest.mark.parametrize(
    ("frame", "belongs"),
    [("a/odom", True), ("/a/odom", True), ("odom", True), ("b/odom", False), ("fleet/a/odom", False)],
)
def test_a_frame_in_the_namespace_of_another_robot_is_ignored(frame: str, belongs: bool) -> None:
    assert may_belong(frame, "/a") is belongs
