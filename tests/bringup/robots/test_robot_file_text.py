"""The text of a robot file, and the positions of its values, without reading the text."""

from __future__ import annotations

from pathlib import Path

from graphengine.descriptions.robot_files.writer import render
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document, Value, parse
from tests.bringup.robots.arms import limb, robot
from tests.bringup.robots.harness import CASTER, imported, rover
from tests.bringup.robots.test_remarks import EVERYTHING


def assert_same(ours: Value, read: Value, at: str = "file") -> None:
    """Compare two values, the positions of all values and keys in them, and whether they are quoted."""
    assert (ours.span, ours.plain, ours.keys) == (read.span, read.plain, read.keys), at
    if isinstance(read.data, dict):
        assert list(ours.data) == list(read.data), at
        for key, value in read.data.items():
            assert_same(ours.data[key], value, f"{at}.{key}")
    elif isinstance(read.data, list):
        assert len(ours.data) == len(read.data), at
        for number, value in enumerate(read.data):
            assert_same(ours.data[number], value, f"{at}[{number}]")
    else:
        assert (type(ours.data), ours.data) == (type(read.data), read.data), at


def compared(folder: Path, text: str, package_paths: tuple[str, ...] = ()) -> Document:
    """Import a description, and compare its robot file with what a reader gets from the text."""
    found = imported(folder, text)
    found.draft.package_paths = package_paths
    document = render(found.draft, folder / "rover.yaml")
    findings = Findings()
    read = parse("\n".join(document.source.lines), str(folder / "rover.yaml"), findings)
    assert read is not None, findings.items
    assert read.source == document.source
    assert_same(document.root, read.root)
    assert document.data == read.data
    return document


def test_the_document_of_a_draft_equals_the_document_that_a_reader_parses(tmp_path: Path) -> None:
    document = compared(tmp_path, EVERYTHING, ("a folder/$x", "/b"))
    assert document.data["package_paths"] == ["a folder/$x", "/b"]
    assert {"joints", "links", "wheel_colliders", "materials", "sensors", "graphs"} <= document.data.keys()


def test_the_document_of_an_arm_equals_the_document_that_a_reader_parses(tmp_path: Path) -> None:
    compared(tmp_path, robot(limb("j", 6)))


def test_names_that_need_quotes_are_placed_too(tmp_path: Path) -> None:
    text = rover(CASTER).replace('"left_wheel"', '"left: wheel"').replace('"left_joint"', '"left $(x)"')
    document = compared(tmp_path, text)
    assert document.data["graphs"]["base"]["parameters"]["left"] == ["left $$(x)"]  # a graph would replace $(x)


def test_a_base_link_called_world_has_a_comment_in_the_robot_file(tmp_path: Path) -> None:
    bolt = '<joint name="bolt" type="fixed"><parent link="world"/><child link="base_link"/></joint>'
    own = "<gazebo><selfCollide>true</selfCollide></gazebo>"
    document = compared(tmp_path, robot('<link name="world"/>', bolt, limb("j", 2), own))
    lines = document.source.lines
    assert "base_link: world    # which is the world itself: the robot is bolted to it" in lines
    assert "self_collision: true" in lines
