"""The published text of a description: the user's elements, with the changes that a robot file makes to joints."""

from __future__ import annotations

import pytest

from graphengine.descriptions.files.xml import Element, parse
from graphengine.format.diagnostics import Findings
from tests.descriptions.sdf.harness import document, joint, link, model, pose
from tests.physics.harness import ROBOT, SCENE, Project

CHANGES = "joints: {arm_joint: {position: [0.5, 0, 0.25], limits: [-0.5, 0.75]}}"


def joints_of(project: Project) -> dict[str, dict[str, dict[str, str]]]:
    """Attributes of the joints in the published text, by joint and tag."""
    root = parse(project.load().robots["bot"].urdf_text.encode(), "text", Findings(), "S103")
    assert root is not None
    return {each.get("name"): {part.tag: part.attributes for part in each.walk()} for each in root.all("joint")}


def test_a_changed_joint_is_changed_in_the_text_alone(project: Project) -> None:
    project.robot(CHANGES)
    joints = joints_of(project)
    assert joints["arm_joint"]["origin"] == {"xyz": "0.5 0.0 0.25"}
    assert joints["arm_joint"]["limit"] == {"lower": "-0.5", "upper": "0.75", "effort": "40", "velocity": "1"}
    assert joints["plate_joint"]["origin"] == {"xyz": "0 0 .3", "rpy": "0 0 1.5707963267948966"}
    kept = project.load().robots["bot"].description.joints["arm_joint"].element.first("origin")
    assert isinstance(kept, Element)
    assert kept.attributes == {"xyz": ".1 0 .1"}


def test_a_joint_without_an_origin_or_a_limit_gets_them(project: Project) -> None:
    origin, limit = '<origin xyz=".1 0 .1"/>', '<limit lower="-1" upper="1" effort="40" velocity="1"/>'
    project.cart(origin, "").robot(CHANGES)
    assert joints_of(project)["arm_joint"]["origin"] == {"xyz": "0.5 0.0 0.25"}
    project.cart(limit, "")
    assert joints_of(project)["arm_joint"]["limit"] == {"lower": "-0.5", "upper": "0.75"}


def test_the_prim_of_a_robot_has_the_text(project: Project) -> None:
    """Nodes publish the text from there."""
    world = project.load()
    assert world.stage.find("/bot").facts["urdf"] == world.robots["bot"].urdf_text


def test_a_welded_joint_is_fixed_in_the_text(project: Project) -> None:
    project.robot("joints: {arm_joint: {enabled: false, weld: true}}")
    joints = joints_of(project)
    assert joints["arm_joint"]["joint"]["type"] == "fixed"


def test_the_text_of_an_sdf_has_the_changes(project: Project) -> None:
    turns = "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>"
    content = (
        link("base_link")
        + link("arm", pose(1, 0, 0, 0, 0.5))
        + joint("arm_joint", "base_link", "arm", turns, "revolute")
    )
    project.write("bot.sdf", document(model(content))).write("bot.yaml", ROBOT.replace(".urdf", ".sdf") + CHANGES)
    found = joints_of(project)["arm_joint"]
    assert [float(part) for part in found["origin"]["rpy"].split()] == pytest.approx([0.0, 0.5, 0.0], abs=1e-15)
    assert found["origin"]["xyz"] == "0.5 0.0 0.25"
    assert (found["limit"]["lower"], found["limit"]["upper"]) == ("-0.5", "0.75")
    project.write("scene.yaml", SCENE.replace("bot.yaml", "bot.sdf"))
    assert joints_of(project)["arm_joint"]["origin"]["xyz"] == "1.0 0.0 0.0"
