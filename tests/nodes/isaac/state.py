"""Cases of IsaacReadWorldPose, IsaacJointNameResolver and IsaacReadIMU."""

from __future__ import annotations

import pytest

from graphengine.nodes.core.articulation import IsaacJointNameResolver
from graphengine.nodes.core.transforms import IsaacReadWorldPose
from graphengine.testing import RecordingContext
from tests.nodes import scenes
from tests.nodes.harness import Player, computed
from tests.nodes.isaac.book import Case, at, runs

RESOLVER = "isaacsim.core.nodes.IsaacJointNameResolver"


@runs("isaacsim.core.nodes.IsaacReadWorldPose", "translated cube")
def a_cube_is_where_it_was_put(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body("/Cube", at(case["inputs"]["translate"]))
    node = computed(IsaacReadWorldPose, context, prim="/Cube")
    for name, expected in case["expect"].items():
        assert getattr(node, name) == pytest.approx(expected, abs=case["tolerance"])


@runs(RESOLVER, "pass through", "override -> prim name")
def names_are_replaced_by_the_joints_own(case: Case, play: Player) -> None:
    context = RecordingContext()
    joints = [f"panda_joint{number}" for number in range(1, 8)]
    context.world.add_robot("/panda", joints)
    for joint in joints:
        override = case["inputs"].get("overrides", {}).get(joint, "")
        context.world.stage.add(f"/panda/Physics/{joint}", "joint", name_override=override, facts={"joint": joint})
    node = computed(IsaacJointNameResolver, context, robot_path="/panda", joint_names=case["inputs"]["jointNames"])
    assert node.joint_names_out == tuple(case["expect"]["jointNames"])
    assert node.robot_path_out == case["expect"].get("robotPath", "/panda")


@runs("isaacsim.sensors.physics IMU", "finite difference acceleration")
def an_imu_feels_what_accelerates_it(case: Case, play: Player) -> None:
    playing = play.scene(scenes.pulled_imu(case["inputs"]["acceleration"])).tick(30)
    expected = case["expect"]["linear acceleration"]
    assert playing.node("Imu").lin_acc == pytest.approx((expected, 0.0, 0.0), abs=case["tolerance"])
