"""Packages that a xacro file names and that are not there: what is said of them, and the robot without them."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element, parse
from graphengine.descriptions.xacro import xacro
from graphengine.descriptions.xacro.absent_packages import drop_meshes
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cart"><link name="base_link"/>\n'
LIDAR = '<xacro:include filename="$(find lidars)/urdf/a2.xacro" ns="lidar"/>\n<xacro:lidar.a2 parent="base_link"/>\n'
ARM = '<xacro:property name="arms" value="$(find arms)/urdf"/>\n<xacro:include filename="${arms}/arm.xacro"/>\n'
TEXT = "<gazebo><plugin><parameters>$(find control)/config.yaml</parameters></plugin></gazebo>\n"


def expanded(folder: Path, inside: str, *without: str) -> tuple[Element | None, Findings]:
    path, findings = folder / "bot.xacro", Findings()
    path.write_text(f"{HEAD}{inside}</robot>", encoding="utf-8")
    packages = Packages(folder, (), Files((folder.resolve(),)))
    return xacro.expand(path, {}, packages, findings, without=without), findings


def test_every_absent_package_is_named_with_its_content(tmp_path: Path) -> None:
    root, findings = expanded(tmp_path, LIDAR + ARM)
    assert root is None
    lidars, arms = findings.errors
    assert lidars.message == "xacro: no package 'lidars'"
    assert lidars.help[:2] == (
        "includes: $(find lidars)/urdf/a2.xacro",
        "macros that are called but not defined: lidar.a2",
    )
    assert arms.help[-1] == "or leave out all 2 packages: --without lidars --without arms"
    assert not any("--without" in line for line in lidars.help)
    assert lidars.span is not None
    assert lidars.span.line == 2
    assert "includes: $(find arms)/urdf/arm.xacro" in arms.help


def test_a_robot_without_its_packages_keeps_all_other_links(tmp_path: Path) -> None:
    root, findings = expanded(tmp_path, LIDAR + ARM, "lidars", "arms")
    assert root is not None
    assert [child.tag for child in root.children] == ["link"]
    assert findings.errors == []
    assert "left out on request: package 'lidars'" in [finding.message for finding in findings.items]


def test_an_installed_package_can_be_left_out(tmp_path: Path) -> None:
    (tmp_path / "lidars/urdf").mkdir(parents=True)
    macro = '<xacro:macro name="a2" params="parent"><link name="laser"/></xacro:macro>'
    (tmp_path / "lidars/urdf/a2.xacro").write_text(
        f'<robot xmlns:xacro="http://www.ros.org/wiki/xacro">{macro}</robot>', encoding="utf-8"
    )
    root, _ = expanded(tmp_path, LIDAR)
    assert root is not None
    assert len(root.all("link")) == 2
    root, _ = expanded(tmp_path, LIDAR, "lidars")
    assert root is not None
    assert len(root.all("link")) == 1


def test_a_package_that_only_a_text_names_is_not_needed(tmp_path: Path) -> None:
    root, findings = expanded(tmp_path, TEXT)
    assert root is not None
    assert [part.text for part in root.walk() if part.tag == "parameters"] == ["package://control/config.yaml"]
    assert findings.errors == []


def test_a_mistake_is_reported_beside_a_package_that_only_a_text_names(tmp_path: Path) -> None:
    _, findings = expanded(tmp_path, f"{TEXT}<xacro:a2/>")
    told = [finding.message for finding in findings.errors]
    assert told == ["xacro: no package 'control'", "xacro: unknown macro name: xacro:a2"]


@pytest.mark.parametrize("name", ["lidars/../..", "..", "/etc"])
def test_a_package_name_with_a_path_reads_no_file(tmp_path: Path, name: str) -> None:
    root, findings = expanded(tmp_path, f'<xacro:include filename="$(find {name})/passwd"/>', name)
    assert root is None or [child.tag for child in root.children] == ["link"]
    assert all("root:" not in finding.message for finding in findings.items)


def test_meshes_of_a_package_are_dropped_and_others_stay() -> None:
    shape = '<visual><geometry><mesh filename="package://{}/a.stl"/></geometry></visual>'
    text = f'<robot><link name="a">{shape.format("arms")}{shape.format("arms2")}</link></robot>'
    root, findings = parse(text.encode(), "a.urdf", Findings(), "S103"), Findings()
    assert root is not None
    drop_meshes(root, ["arms"], findings)
    assert [part.get("filename") for part in root.walk() if part.tag == "mesh"] == ["package://arms2/a.stl"]
    assert len(findings.items) == 1
