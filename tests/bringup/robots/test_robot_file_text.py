"""The text of a robot file has the values of the draft from which it is written."""

from __future__ import annotations

from pathlib import Path

from graphengine.descriptions.robot_files.writer import render
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document, parse
from graphengine.format.yaml_text import read_back
from tests.bringup.robots.arms import limb, robot
from tests.bringup.robots.harness import CASTER, imported, rover
from tests.bringup.robots.test_remarks import EVERYTHING


def compared(folder: Path, text: str, package_paths: tuple[str, ...] = ()) -> Document:
    """Import a description, and compare what a reader gets from the text of its robot file with the values of its draft."""
    found = imported(folder, text)
    found.draft.package_paths = package_paths
    findings = Findings()
    read = parse(render(found.draft), str(folder / "rover.yaml"), findings)
    assert read is not None, findings.items
    assert read.data == read_back(found.draft.data())
    return read


def test_a_document_is_what_a_reader_gets(tmp_path: Path) -> None:
    document = compared(tmp_path, EVERYTHING, ("a folder/$x", "/b"))
    assert document.data["package_paths"] == ["a folder/$x", "/b"]
    assert {"joints", "links", "wheel_colliders", "materials", "sensors", "graphs"} <= document.data.keys()


def test_a_document_of_an_arm_is_what_a_reader_gets(tmp_path: Path) -> None:
    compared(tmp_path, robot(limb("j", 6)))


def test_names_that_need_quotes_are_placed_too(tmp_path: Path) -> None:
    text = rover(CASTER).replace('"left_wheel"', '"left: wheel"').replace('"left_joint"', '"left $(x)"')
    document = compared(tmp_path, text)
    assert document.data["graphs"]["base"]["parameters"]["left"] == ["left $$(x)"]  # a graph would replace $(x)


def test_a_comment_stays_at_the_link_of_the_world(tmp_path: Path) -> None:
    bolt = '<joint name="bolt" type="fixed"><parent link="world"/><child link="base_link"/></joint>'
    own = "<gazebo><selfCollide>true</selfCollide></gazebo>"
    document = compared(tmp_path, robot('<link name="world"/>', bolt, limb("j", 2), own))
    lines = document.source.lines
    assert "base_link: world    # which is the world itself: the robot is bolted to it" in lines
    assert "self_collision: true" in lines
