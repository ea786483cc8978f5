"""`isaac:namespace` from files to topics: where it may be written, from where nodes collect it, and what comes of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.spec import RobotUse
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene
from tests.jobs.crowd import physics
from tests.jobs.harness import Job

CHASSIS = "/bot/Geometry/base_link/chassis_link"
SCENE = """scene: spaces
world: world.xml
robots:
  bot: {use: bot.yaml, position: [0, 0, 0.025]}
graphs:
  say: {use: say.yaml}
  clock: {use: graphs/clock.yaml, at: /World/clock}
"""
ROBOT = """robot: bot
extends: robots/dd100.yaml
namespaces: {base_link: "", sim_lidar: "", sim_camera: ""}
"""
SAY = """graph: say
at: %s/say
nodes:
  Tick: OnPlaybackTick
  Joints: {type: PublishJointState, inputs: {targetPrim: /bot%s}}
  TF: {type: PublishRawTransformTree, inputs: {parentFrameId: a, childFrameId: b%s}}
  Product: {type: CreateRenderProduct, inputs: {cameraPrim: /bot/base_link/chassis_link/sim_lidar/Lidar}}
  Scan: {type: RtxLidarHelper, inputs: {frameId: sim_lidar%s}}
connections:
  - Tick.tick -> Joints.execIn
  - Tick.tick -> TF.execIn
  - Tick.tick -> Product.execIn
  - Product.execOut -> Scan.execIn
  - Product.renderProductPath -> Scan.renderProductPath
"""
WORLD = """<mujoco><worldbody>
  <geom type="plane" size="0 0 1"/>
  <body name="hall"><body name="crane"><geom size="0.1" contype="0" conaffinity="0"/></body></body>
</worldbody></mujoco>"""


def files(folder: Path, at: str, namespaces: str = "", inputs: str = "", robot: str = "") -> Path:
    """A scene whose graph `say`, at a prim, publishes joints and TF, and through a helper what a lidar sees."""
    (folder / "world.xml").write_text(WORLD, encoding="utf-8")
    (folder / "bot.yaml").write_text(ROBOT + robot, encoding="utf-8")
    (folder / "say.yaml").write_text(SAY % (at, inputs, inputs, inputs), encoding="utf-8")
    written = f"namespaces: {{{namespaces}}}\n" if namespaces else ""
    (folder / "scene.yaml").write_text(SCENE + written, encoding="utf-8")
    return folder / "scene.yaml"


def topics(assembly: LoadedScene, graph: str = "say") -> list[str]:
    assert not assembly.findings.errors, "\n".join(finding.render() for finding in assembly.findings.errors)
    return [claim.topic for claim in assembly.claims if claim.graph == graph]


@pytest.mark.parametrize(
    ("at", "namespaces", "expected"),
    [
        (CHASSIS, "/bot/base_link: a", ["/a/joint_states", "/a/tf", "/a/scan"]),
        (CHASSIS, "/bot/base_link/chassis_link: a", ["/a/joint_states", "/a/tf", "/a/scan"]),
        (CHASSIS, "/bot: a, /bot/base_link: b", ["/a/b/joint_states", "/a/tf", "/a/b/scan"]),
        (CHASSIS, '/bot: "", /bot/base_link: b', ["/b/joint_states", "/b/tf", "/b/scan"]),
        (CHASSIS, f"/bot: a, {CHASSIS}/sim_lidar: b", ["/a/joint_states", "/a/tf", "/a/b/scan"]),
        (CHASSIS, f"{CHASSIS}/sim_lidar/Lidar: b", ["/joint_states", "/tf", "/b/scan"]),
        (CHASSIS, "/bot/base_link/chassis_link/say: g", ["/g/joint_states", "/g/tf", "/scan"]),
        (CHASSIS, f"/bot: a, {CHASSIS}/say/Joints: n", ["/a/n/joint_states", "/a/tf", "/a/scan"]),
        (f"{CHASSIS}/sim_lidar", f"/bot: a, {CHASSIS}/sim_lidar: b", ["/a/b/joint_states", "/a/tf", "/a/b/scan"]),
        ("/World/hall/crane", "/World/hall: h, /World/hall/crane: c", ["/h/c/joint_states", "/h/tf", "/scan"]),
        ("/World/graphs", "/World/graphs: g", ["/g/joint_states", "/g/tf", "/scan"]),
        ("/World/graphs", "/World: w, /World/graphs/say: s", ["/w/s/joint_states", "/w/tf", "/scan"]),
        (CHASSIS, '/bot: "~/_a_", /bot/base_link: "b//"', ["/a_/b/joint_states", "/a/tf", "/a_/b/scan"]),
    ],
)  # fmt: skip
def test_any_prim_may_have_a_namespace(tmp_path: Path, at: str, namespaces: str, expected: list[str]) -> None:
    assert topics(build.load(files(tmp_path, at, namespaces))) == expected


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        (", nodeNamespace: x/y", ["/x/y/joint_states", "/x/y/tf", "/x/y/scan"]),
        (", nodeNamespace: /", ["/joint_states", "/tf", "/scan"]),
        (", topicName: /t", ["/a/b/t", "/a/t", "/a/b/t"]),
        (", topicName: ~/t_", ["/a/b/t", "/a/t", "/a/b/t"]),
        (", topicName: u/t", ["/a/b/u/t", "/a/u/t", "/a/b/u/t"]),
    ],
)
def test_an_input_overrides_the_collected_namespace_and_a_topic_stays_within_it(
    tmp_path: Path, inputs: str, expected: list[str]
) -> None:
    path = files(tmp_path, CHASSIS, "/bot: a, /bot/base_link: b", inputs)
    assembly = build.load(path)
    assert [claim.topic for claim in assembly.claims if claim.graph == "say"] == expected


@pytest.mark.parametrize("written", ["/a/", "/a", "a/", "//a//"])
def test_slashes_around_a_namespace_do_not_count(tmp_path: Path, written: str) -> None:
    path = files(tmp_path, CHASSIS, f'/bot: "{written}", /bot/base_link: "/b/"')
    assert topics(build.load(path))[0] == "/a/b/joint_states"


def test_the_namespace_of_a_prim_in_a_scene_replaces_the_robot_files(tmp_path: Path) -> None:
    path = files(tmp_path, CHASSIS, "/bot/base_link: scene")
    (tmp_path / "bot.yaml").write_text(ROBOT.replace('base_link: ""', "base_link: robot"), encoding="utf-8")
    assert topics(build.load(path))[0] == "/scene/joint_states"


def test_a_robot_that_comes_back_has_the_namespaces_that_the_scene_gives_it(tmp_path: Path) -> None:
    path = files(tmp_path, "/World", "/bot/base_link: a")
    path.write_text(path.read_text(encoding="utf-8").replace("  say: {use: say.yaml}\n", ""), encoding="utf-8")
    with Job(path) as job:
        before = topics(job.scene, "bot/scan")
        job.remove("bot")
        job.spawn("bot", RobotUse(use="bot.yaml", position=(0.0, 0.0, 0.025)))
        assert topics(job.scene, "bot/scan") == before == ["/a/scan"]
        assert "/bot" in physics(job).stage


@pytest.mark.parametrize(
    ("namespaces", "place", "words"),
    [
        ("/World/hal: a", "scene.yaml:8:14: error S104", "no prim at '/World/hal'"),
        ("World: a", "scene.yaml:8:14: error S104", "'World' is not a prim path"),
        (f"{CHASSIS}/sai: a", "scene.yaml:8:14: error S104", "has no child 'sai'"),
        ("/bot: 2nd", "scene.yaml:8:20: error G109", "'2nd' cannot be part of a ROS 2 namespace"),
        ("/bot: a b", "scene.yaml:8:20: error G109", "'a b' cannot be part"),
        ("/bot: a//b", "scene.yaml:8:20: error G109", "no part is empty"),
        ("/bot: über", "scene.yaml:8:20: error G109", "'über' cannot be part"),
        ("/bot: robotä", "scene.yaml:8:20: error G109", "'robotä' cannot be part"),
    ],
)
def test_an_invalid_namespace_is_reported_at_its_place(tmp_path: Path, namespaces: str, place: str, words: str) -> None:
    (only,) = build.load(files(tmp_path, CHASSIS, namespaces)).findings.errors
    assert only.render().startswith(f"{tmp_path}/{place}")
    assert words in only.render()


def test_an_invalid_namespace_in_a_robot_file_is_reported_at_its_place(tmp_path: Path) -> None:
    path = files(tmp_path, CHASSIS)
    (tmp_path / "bot.yaml").write_text(ROBOT.replace('base_link: ""', "base_link: 0"), encoding="utf-8")
    assert "bot.yaml:3:25: error G108" in build.load(path).findings.errors[0].render()
    (tmp_path / "bot.yaml").write_text(ROBOT.replace('base_link: ""', 'base_link: "0"'), encoding="utf-8")
    (only,) = build.load(path).findings.errors
    assert "bot.yaml:3:25: error G109: base_link: '0' cannot be part of a ROS 2 namespace" in only.render()


def test_a_spawned_robot_with_an_invalid_namespace_is_refused(tmp_path: Path) -> None:
    with (
        Job(files(tmp_path, CHASSIS)) as job,
        pytest.raises(CheckError, match=r"namespace '/a b' \(from 'a b'\) has ' '"),
    ):
        job.spawn("late", RobotUse(use="bot.yaml").model_copy(update={"namespace": "a b"}))
