"""The commands of docs/guide/your_own_robot.md, with a small robot in the place of the one that it names."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
import yaml

from tests.cli.harness import ROOT, process
from tests.physics.importing.imported_bases import DIFFERENTIAL, description
from tests.readme.test_readme import blocks, quoted

GUIDE = (ROOT / "docs/guide/your_own_robot.md").read_text(encoding="utf-8")
HEADLESS = {"run burger.yaml --view": "run burger.yaml --for 1s --transport memory"}


def test_the_four_commands_work_one_after_the_other(tmp_path: Path) -> None:
    lines = [line for block in blocks(GUIDE, "sh") for line in block.splitlines()]
    new, change, *rest = lines
    source = tmp_path / shlex.split(new)[4]
    source.parent.mkdir(parents=True)
    namespace = (
        '<robot><xacro:arg name="namespace" default=""/><xacro:property name="namespace" value="$(arg namespace)"/>'
    )
    source.write_text(
        re.sub("<robot[^>]*>", namespace, description(DIFFERENTIAL).replace('"left"', '"${namespace}left"'))
    )
    made = process(*shlex.split(new)[1:], cwd=tmp_path, code=0)
    assert f"next: {change} && graphrun run burger.yaml" in made.out
    folder = tmp_path / shlex.split(change)[1]
    assert [line.split()[1] for line in rest] == ["run", "calibrate"]
    for line in rest:
        command = line.removeprefix("graphrun ")
        assert process(*shlex.split(HEADLESS.get(command, command)), cwd=folder).code == 0, line
    robot = folder / "robots" / f"{folder.name}.yaml"
    data = yaml.safe_load(robot.read_text(encoding="utf-8"))
    example = next(block for block in blocks(GUIDE, "yaml") if "sensors:" in block)
    for section, entries in yaml.safe_load(
        example.replace("base_footprint/", "")
    ).items():  # which the small robot has not
        data[section] = data.get(section, {}) | entries
    robot.write_text(json.dumps(data), encoding="utf-8")
    assert "/imu " in process("topics", f"{folder.name}.yaml", cwd=folder, code=0).out
    check = next(text for text in quoted(GUIDE) if "--check" in text)
    assert process(*shlex.split(check)[1:], cwd=folder).code == 0


def test_the_words_of_the_guide_are_those_of_the_report() -> None:
    printed = (ROOT / "graphengine/cli/import_report.py").read_text(encoding="utf-8")
    assert [what for what in re.findall(r"^- \*([^*]+)\*:", GUIDE, re.MULTILINE) if f'"{what}"' not in printed] == []


@pytest.mark.parametrize("name", ["differential", "mecanum", "ackermann"])
def test_the_graphs_of_bases_are_there(name: str) -> None:
    assert (ROOT / f"graphs/base/{name}.yaml").is_file()
