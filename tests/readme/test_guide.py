"""The commands of docs/guide/your_own_robot.md, with a small robot in the place of the one that it names."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
import yaml

import graphengine as ge
from tests.bringup.robots.imported_arms import arm, bolted
from tests.bringup.robots.imported_bases import DIFFERENTIAL, description
from tests.cli.harness import ROOT, process
from tests.readme.test_readme import blocks, quoted

GUIDE = (ROOT / "docs/guide/your_own_robot.md").read_text(encoding="utf-8")
BASE, _, REST = GUIDE.partition("## Arms and legs")
ARM = REST.partition("\n## ")[0]
HEADLESS = {f"run {name}.yaml --view": f"run {name}.yaml --for 1s --transport memory" for name in ("burger", "ur5e")}


def test_the_four_commands_work_one_after_the_other(tmp_path: Path) -> None:
    lines = [line for block in blocks(BASE, "sh") for line in block.splitlines()]
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


def test_the_guide_quotes_the_report() -> None:
    printed = (ROOT / "graphengine/cli/import_report.py").read_text(encoding="utf-8")
    assert [what for what in re.findall(r"^- \*([^*]+)\*:", GUIDE, re.MULTILINE) if f'"{what}"' not in printed] == []


def test_an_arm_is_made_run_and_moved(tmp_path: Path) -> None:
    new, change, run, send = (line for block in blocks(ARM, "sh") for line in block.splitlines())
    _, _, _, action, kind, goal = shlex.split(send)
    trajectory = yaml.safe_load(goal)["trajectory"]
    source = tmp_path / shlex.split(new)[4]
    source.parent.mkdir(parents=True)
    text = bolted(arm(6, "plate"))
    for number, joint in enumerate(trajectory["joint_names"], 1):
        text = text.replace(f'"joint_{number}"', f'"{joint}"')
    arguments = '<xacro:arg name="name" default=""/><xacro:arg name="ur_type" default=""/>'
    source.write_text(text.replace('<robot name="bot">', f'<robot name="bot" xmlns:xacro="xacro">{arguments}'))
    assert (
        f"next: {change} && {run.removesuffix(' --view')}" in process(*shlex.split(new)[1:], cwd=tmp_path, code=0).out
    )
    folder = tmp_path / shlex.split(change)[1]
    process(*shlex.split(HEADLESS[run.removeprefix("graphrun ")]), cwd=folder, code=0)
    with ge.load(folder / "ur5e.yaml").session() as sim:
        request = {"goal_id": {"uuid": [7] * 16}, "goal": {"trajectory": trajectory}}
        assert sim.call(f"{action}/_action/send_goal", request, type=f"{kind}_SendGoal").accepted
        ended = sim.call(f"{action}/_action/get_result", {"goal_id": {"uuid": [7] * 16}}, type=f"{kind}_GetResult")
        assert (ended.status, ended.result.error_code) == (4, ended.result.SUCCESSFUL)
        reached = [sim.robots["ur5e"].joints[name].position for name in trajectory["joint_names"]]
    assert reached == pytest.approx(trajectory["points"][0]["positions"], abs=0.01)


GRAPHS = [f"base/{name}" for name in ("differential", "mecanum", "ackermann")]


@pytest.mark.parametrize("name", [*GRAPHS, *re.findall(r"^\| `([a-z_/]+)` \|", ARM, re.MULTILINE)])
def test_the_graphs_that_the_guide_names_are_there(name: str) -> None:
    assert (ROOT / f"graphs/{name}.yaml").is_file()
