"""Replays of recordings made before the key `sees_own_robot` existed, when no ray sensor saw its own robot."""

from __future__ import annotations

from pathlib import Path

from tests.cli.harness import Graphrun

OLD = Path(__file__).parent / "recordings" / "own_robot.mcap"
"""The beam ahead of its lidar went through a mast of the lidar's robot, 0.28 m away, to a wall 3 m away."""
SCENE = """scene: mast_world
world: wall.xml
robots:
  bot: {use: bot.yaml}
graphs:
  scan: {use: graphs/publishers/scan.yaml, parameters: {robot: /bot, lidar: base_link/scan/Lidar, frame: scan}}
"""
ROBOT = """robot: bot
urdf: bot.urdf
fixed_base: true
sensors:
  scan:
    type: lidar
    parent: base_link
    position: [0, 0, 0.3]
    profile: {rate: 10.0, beams: {first_deg: -90, last_deg: 90, count: 7}, near: 0.05, far: 5.0}
"""
DESCRIPTION = """<robot name="bot">
  <link name="base_link"/>
  <link name="mast">
    <collision><origin xyz="0 0 0.3"/><geometry><cylinder radius="0.02" length="0.6"/></geometry></collision>
  </link>
  <joint name="mast_joint" type="fixed"><parent link="base_link"/><child link="mast"/><origin xyz="0.3 0 0"/></joint>
</robot>
"""
WALL = '<mujoco><worldbody><geom type="box" size="0.1 3 1" pos="3.1 0 1"/></worldbody></mujoco>'


def test_a_recording_from_before_lidars_saw_their_robot_is_replayed_to_the_byte(graphrun: Graphrun) -> None:
    result = graphrun("replay", str(OLD))
    assert (result.code, result.out) == (0, "identical: 6 messages in 30 ticks, 0.500 s\n")


def test_lidars_see_their_robot_in_scenes_and_new_recordings(graphrun: Graphrun, tmp_path: Path) -> None:
    for name, text in {"scene.yaml": SCENE, "bot.yaml": ROBOT, "bot.urdf": DESCRIPTION, "wall.xml": WALL}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    scene, made = str(tmp_path / "scene.yaml"), str(tmp_path / "new.mcap")
    result = graphrun("replay", str(OLD), "--against", scene)
    assert "ranges[3]: recorded 3.0, replayed 0.2800000011920929" in result.out
    graphrun("run", scene, "--transport", "memory", "--for", "0.5s", "--record", made, code=0)
    assert graphrun("replay", made, code=0).out == "identical: 6 messages in 30 ticks, 0.500 s\n"
