"""The friction of materials, read and written."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import BadValueError
from graphengine.nodes.prims import WritePrimAttribute
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, Playing, ready
from tests.other_process import in_another_process

SLOPE = """
<mujoco>
  <worldbody><geom name="floor" type="plane" size="0 0 1" friction="0.4" euler="0 20 0"/></worldbody>
</mujoco>
"""
BLOCK = """
<robot name="block">
  <link name="base_link">
    <inertial><mass value="5"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".4 .3 .1"/></geometry></collision>
  </link>
</robot>
"""
SLIDING = {
    "world.xml": SLOPE,
    "block.urdf": BLOCK,
    "block.yaml": """
robot: block
urdf: block.urdf
materials: {Rubber: {static_friction: 0.7, dynamic_friction: 0.6, bind: [base_link]}}
""",
    "scene.yaml": """
scene: slope
world: world.xml
robots:
  block: {use: block.yaml, position: [0, 0, 0.0535], orientation: {rpy_deg: [0, 20, 0]}}
graphs:
  friction: {use: friction.yaml, at: /World/friction}
""",
    "friction.yaml": """
graph: friction
nodes:
  Tick: OnPlaybackTick
  Write:
    type: WritePrimAttribute
    inputs: {prim: /block/Materials/Rubber, name: 'physics:dynamicFriction', value: 0.6}
  Read: {type: ReadPrimAttribute, inputs: {prim: /block/Materials/Rubber, name: 'physics:dynamicFriction'}}
  Text: ToString
  Print: PrintText
connections:
  - Tick.tick -> Write.execIn
  - Write.execOut -> Print.execIn
  - Read.value -> Text.value
  - Text.converted -> Print.text
""",
}
RUBBER = "/block/Materials/Rubber"
MATERIAL = {
    "static_friction": 0.7,
    "dynamic_friction": 0.6,
    "bind": ("base_link",),
    "bodies": {"block/base_link": False},
}


def speed_on_slope(playing: Playing) -> float:
    return math.hypot(*playing.session.services.world.entities.state("block").linear_velocity)


def slide(play: Player) -> list[float]:
    """Speeds of the block: at rest, sliding a quarter of a second and a half, and after its friction was restored."""
    playing, speeds = play.scene(SLIDING), []
    for ticks, friction in ((60, 0.6), (15, 0.1), (15, 0.1), (60, 0.6)):
        playing.set("Write", "value", friction)
        playing.tick(ticks)
        speeds.append(speed_on_slope(playing))
        assert float(playing.node("Print").text) == pytest.approx(friction)
    return speeds


def test_a_block_slides_while_its_friction_is_below_the_tangent_of_the_slope(play: Player) -> None:
    # the mean with the floor's 0.4 is 0.5 or 0.25, and tan 20 deg = 0.364
    resting, early, late, stopped = slide(play)
    assert resting < 1e-3
    expected = 9.81 * (math.sin(math.radians(20)) - 0.25 * math.cos(math.radians(20)))
    assert (late - early) / 0.25 == pytest.approx(expected, rel=0.02)
    assert stopped < 1e-3


def slide_in(folder: Path) -> list[float]:
    player = Player(folder)
    with contextlib.closing(player):
        return slide(player)


def test_runs_of_two_processes_in_which_friction_is_written_are_the_same(tmp_path: Path) -> None:
    assert in_another_process(slide_in, tmp_path) == slide_in(tmp_path)


def test_a_new_robot_has_its_own_friction_and_a_stop_resets_written_friction(play: Player) -> None:
    playing = play.scene(SLIDING)
    world = playing.session.services.world
    material = world.stage.find(RUBBER)
    playing.set("Write", "value", 0.0)
    playing.tick(2)
    assert world.friction(material) == (0.7, 0.0)
    playing.command("spawn", name="other", use={"use": "block.yaml", "position": [0.0, 5.0, 0.0535]})
    assert world.friction(world.stage.find("/other/Materials/Rubber")) == (0.7, 0.6)
    start = speed_on_slope(playing)
    playing.tick(30)
    expected = 9.81 * (math.sin(math.radians(20)) - 0.2 * math.cos(math.radians(20)))
    assert (speed_on_slope(playing) - start) / 0.5 == pytest.approx(expected, rel=0.02)
    playing.session.stop()
    assert world.friction(material) == (0.7, 0.6)
    playing.set("Write", "value", 0.6)
    playing.session.play()
    playing.tick(30)
    assert speed_on_slope(playing) < 1e-3


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, "slippery"])
@pytest.mark.parametrize("name", ["physics:staticFriction", "physics:dynamicFriction"])
def test_a_negative_or_infinite_friction_is_refused(name: str, value: Any, context: RecordingContext) -> None:
    material = context.world.stage.add(RUBBER, "material", facts=dict(MATERIAL))
    node = ready(WritePrimAttribute, context, prim=RUBBER, name=name)
    node.value = value
    with pytest.raises(BadValueError, match=f"{name} of {RUBBER}"):
        node.compute()
    assert context.world.friction(material) == (0.7, 0.6)


def test_the_friction_of_a_link_that_is_the_world_cannot_be_changed(play: Player) -> None:
    files = {
        "block.urdf": BLOCK.replace("base_link", "world"),
        "block.yaml": SLIDING["block.yaml"].replace("base_link", "world").replace("urdf:", "base_link: world\nurdf:"),
    }
    with pytest.raises(CheckError, match=f"physics:dynamicFriction of {RUBBER} cannot be changed"):
        play.scene(SLIDING | files)


def test_each_of_the_two_frictions_is_written_alone(context: RecordingContext) -> None:
    material = context.world.stage.add(RUBBER, "material", facts=dict(MATERIAL))
    ready(WritePrimAttribute, context, prim=RUBBER, name="physics:staticFriction", value=1).compute()
    assert context.world.friction(material) == (1.0, 0.6)
    ready(WritePrimAttribute, context, prim=RUBBER, name="physics:dynamicFriction", value=0).compute()
    assert context.world.friction(material) == (1.0, 0.0)
