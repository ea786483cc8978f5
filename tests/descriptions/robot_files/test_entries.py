"""The keys of a robot file that is written are those that a robot file may have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.descriptions.description_reader import robot_file
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import parse
from graphengine.descriptions.robot_files import entries
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.descriptions.urdf.urdf_reader import read_urdf
from graphengine.format import robot_spec
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.spec import GraphUse, Spec

SPECS: dict[type[Any], type[Spec]] = {
    entries.DriveKeys: robot_spec.DriveSpec,
    entries.JointKeys: robot_spec.JointSpec,
    entries.LinkKeys: robot_spec.LinkSpec,
    entries.WheelKeys: robot_spec.WheelColliderSpec,
    entries.MaterialKeys: robot_spec.MaterialSpec,
    entries.SensorKeys: robot_spec.SensorSpec,
    entries.GraphKeys: GraphUse,
}


@pytest.mark.parametrize("keys", SPECS)
def test_each_key_is_one_of_the_spec(keys: type[Any]) -> None:
    assert set(keys.__annotations__) <= set(SPECS[keys].model_fields)


def test_each_keys_class_has_a_spec_to_compare_with() -> None:
    assert {name for name in vars(entries) if name.endswith("Keys")} == {keys.__name__ for keys in SPECS}


def test_a_finding_on_values_without_a_text_refers_to_the_description(tmp_path: Path) -> None:
    findings, text = Findings(), "<?xml version='1.0'?>\n  <robot name='cart'><link name='base_link'/></robot>"
    root = parse(text.encode(), "cart.urdf", findings, "S103")
    assert root is not None
    description = read_urdf(root, Packages(tmp_path, (), Files((tmp_path,))), findings)
    assert description is not None
    draft = Draft(description, "cart", "cart.urdf", "cart.urdf")
    assert robot_file(draft, findings) is not None
    draft.settings["self_collision"] = "perhaps"
    assert robot_file(draft, findings) is None
    (finding,) = findings.errors
    assert (finding.code, str(finding.span)) == ("G108", "cart.urdf:2:3")
