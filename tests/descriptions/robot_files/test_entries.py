"""The keys of a robot file that is written are those that a robot file may have."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.descriptions.description_reader import robot_file
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import parse
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.descriptions.robot_files.entries import Entry
from graphengine.descriptions.urdf.urdf_reader import read_urdf
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files


def cart(folder: Path) -> tuple[Draft, Findings]:
    """The draft of a cart of one link, whose element is in line 2 of its file, and an empty list of findings."""
    findings, text = Findings(), "<?xml version='1.0'?>\n  <robot name='cart'><link name='base_link'/></robot>"
    root = parse(text.encode(), "cart.urdf", findings, "S103")
    assert root is not None
    description = read_urdf(root, Packages(folder, (), Files((folder,))), findings)
    assert description is not None
    return Draft(description, "cart", "cart.urdf", "cart.urdf"), findings


def test_a_finding_on_values_without_a_text_refers_to_the_description(tmp_path: Path) -> None:
    draft, findings = cart(tmp_path)
    assert robot_file(draft, findings) is not None
    draft.settings["self_collision"] = "perhaps"
    assert robot_file(draft, findings) is None
    (finding,) = findings.errors
    assert (finding.code, str(finding.span)) == ("G108", "cart.urdf:2:3")


@pytest.mark.parametrize("section", ["joints", "links", "wheel_colliders", "materials", "sensors", "graphs"])
def test_a_key_that_no_robot_file_has_is_an_error(section: str, tmp_path: Path) -> None:
    draft, findings = cart(tmp_path)
    getattr(draft, section)["base_link"] = Entry({"spin": 1.0})
    assert robot_file(draft, findings) is None
    assert any("spin" in finding.message for finding in findings.errors)
