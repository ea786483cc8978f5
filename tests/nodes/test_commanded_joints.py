"""What `check` says of commands for joints, by what could move the joint."""

from __future__ import annotations

from pathlib import Path

import pytest

import graphengine as ge
from graphengine.scene import build
from tests.nodes.harness import write
from tests.physics.harness import FLOOR

LINK = (
    '<link name="{name}"><inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>'
    "</link>"
)
ENDS = '<parent link="base_link"/><child link="{name}_link"/><axis xyz="0 0 1"/>'
JOINT = f'<joint name="{{name}}" type="continuous">{ENDS}{{more}}</joint>'
NAMES = {"driven": "", "sprung": "", "free": "", "follower": '<mimic joint="driven"/>'}
URDF = (
    f'<robot name="bot">{LINK.format(name="base_link")}'
    + "".join(LINK.format(name=f"{name}_link") + JOINT.format(name=name, more=more) for name, more in NAMES.items())
    + "</robot>"
)
ROBOT = "robot: bot\nurdf: bot.urdf\njoints:\n  driven: {drive: {damping: 5}}\n  sprung: {drive: {stiffness: 5}}\n"
SCENE = "scene: s\nworld: world.xml\nrobots: {bot: {use: bot.yaml}}\ngraphs: {g: {use: graph.yaml, at: /World/g}}\n"


@pytest.mark.parametrize(
    ("inputs", "codes"),
    [
        ("jointNames: [driven], velocityCommand: [1.0]", []),
        ("jointNames: [free], velocityCommand: [1.0]", ["G310"]),
        ("jointNames: [free], positionCommand: [1.0]", ["G310"]),
        ("jointIndices: [2], positionCommand: [1.0]", ["G310"]),
        ("jointNames: [driven, free], velocityCommand: [1.0, 1.0]", ["G310"]),
        ("jointNames: [free], effortCommand: [1.0]", []),
        ("jointNames: [free], velocityCommand: [1.0], effortCommand: [1.0]", []),
        ("jointNames: [free]", []),
        ("jointNames: [driven, follower], velocityCommand: [1.0, 1.0]", ["W209"]),
        ("jointNames: [sprung], velocityCommand: [1.0]", ["W209"]),
        ("jointNames: [sprung], velocityCommand: [1.0], positionCommand: [1.0]", []),
        ("velocityCommand: [1.0, 1.0, 1.0, 1.0]", ["W209"]),
    ],
)
def test_a_target_needs_a_drive_and_an_effort_needs_none(tmp_path: Path, inputs: str, codes: list[str]) -> None:
    node = f"{{type: ArticulationController, inputs: {{targetPrim: /bot, {inputs}}}}}"
    graph = f"graph: g\nnodes: {{Tick: OnPlaybackTick, Art: {node}}}\nconnections: [Tick.tick -> Art.execIn]\n"
    write(tmp_path, {"world.xml": FLOOR, "bot.urdf": URDF, "bot.yaml": ROBOT, "scene.yaml": SCENE, "graph.yaml": graph})
    findings = build.load(tmp_path / "scene.yaml").findings
    assert [finding.code for finding in findings.items if finding.code[0] in "GSW"] == codes
    assert bool(findings.errors) == ("G310" in codes)


def test_joints_clamped_in_the_same_tick_are_reported_in_one_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    names = [f"j{number}" for number in range(6)]
    parts = "".join(
        LINK.format(name=f"{n}_link") + JOINT.format(name=n, more='<limit lower="-1" upper="1"/>') for n in names
    )
    text = f'<robot name="bot">{LINK.format(name="base_link")}{parts}</robot>'.replace("continuous", "revolute")
    drives = "".join(f"  {name}: {{drive: {{stiffness: 5, damping: 5, max_velocity: 3}}}}\n" for name in names)
    graph = "graphs: {g: {use: graphs/joint_commands.yaml, parameters: {robot: /bot}}}"
    scene = SCENE[: SCENE.index("graphs:")] + graph
    robot = f"robot: bot\nurdf: bot.urdf\njoints:\n{drives}"
    write(tmp_path, {"world.xml": FLOOR, "bot.urdf": text, "bot.yaml": robot, "scene.yaml": scene})
    with ge.load(tmp_path / "scene.yaml").session() as sim:
        for _ in range(3):
            sim.publish("/joint_commands", {"name": names, "position": [2.0] * 6})
            sim.step(2)
    beyond = ", ".join(f"position of /bot/j{n} beyond -1 to 1" for n in range(4))
    [message] = caplog.messages
    assert message.startswith(f"commands are clamped: {beyond}, … (2 more)\n")
    assert "overtravel" in message
