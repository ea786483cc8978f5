"""Gravity and lights, read and written."""

from __future__ import annotations

import math
from typing import Any

import pytest

from graphengine.format.errors import BadValueError
from graphengine.nodes.prims import WritePrimAttribute
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready
from tests.nodes.prims.harness import arm

FALLING = """
<mujoco>
  <worldbody><body name="box" pos="0 3 100"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/></body></worldbody>
</mujoco>
"""
GRAVITY = """
  Weaken: {type: WritePrimAttribute, inputs: {prim: /physicsScene, name: 'physics:gravityMagnitude', value: 2}}
  Strength: {type: ReadPrimAttribute, inputs: {prim: /physicsScene, name: 'physics:gravityMagnitude'}}
  Way: {type: ReadPrimAttribute, inputs: {prim: /physicsScene, name: 'physics:gravityDirection'}}
  Loaded: OnLoaded
  Print: PrintText
  Text: ToString
  WayText: ToString
  PrintWay: PrintText
"""
GRAVITY_WIRES = """
  - Loaded.execOut -> Weaken.execIn
  - Tick.tick -> Print.execIn
  - Tick.tick -> PrintWay.execIn
  - Strength.value -> Text.value
  - Text.converted -> Print.text
  - Way.value -> WayText.value
  - WayText.converted -> PrintWay.text
"""


def test_bodies_fall_with_the_written_gravity_until_a_stop_resets_it(play: Player) -> None:
    playing = arm(play, GRAVITY, GRAVITY_WIRES, FALLING)
    world = playing.session.services.world
    assert world.gravity == (0.0, 0.0, -9.81)
    playing.tick(60)
    assert (playing.node("Print").text, playing.node("PrintWay").text) == ("2", "[0, 0, -1]")
    fallen = [world.entities.state("box").position[2]]
    playing.tick(60)
    fallen.append(world.entities.state("box").position[2])
    speed = world.entities.state("box").linear_velocity[2]
    playing.tick(60)
    assert world.entities.state("box").linear_velocity[2] - speed == pytest.approx(-2.0)
    playing.session.stop()
    assert world.gravity == (0.0, 0.0, -9.81)
    assert fallen[1] < fallen[0] < 100.0


@pytest.mark.parametrize("value", [-1.0, 1e9, math.nan, "up"])
def test_an_invalid_gravity_is_refused(value: Any, context: RecordingContext) -> None:
    context.world.stage.add("/physicsScene", "scope")
    node = ready(WritePrimAttribute, context, prim="/physicsScene", name="physics:gravityMagnitude")
    node.value = value
    with pytest.raises(BadValueError):
        node.compute()
    node = ready(WritePrimAttribute, context, prim="/physicsScene", name="physics:gravityDirection", value=(0, 0, 0))
    with pytest.raises(BadValueError, match="gravity needs a direction"):
        node.compute()
    assert context.world.gravity == (0.0, 0.0, -9.81)


def test_a_direction_is_of_length_one_and_keeps_the_magnitude(context: RecordingContext) -> None:
    context.world.stage.add("/physicsScene", "scope")
    ready(WritePrimAttribute, context, prim="/physicsScene", name="physics:gravityDirection", value=(3, 0, 4)).compute()
    assert context.world.gravity == pytest.approx((9.81 * 0.6, 0.0, 9.81 * 0.8))


LIT = """
<mujoco>
  <worldbody>
    <light name="sun" diffuse="0.5 0.5 0.5"/>
    <body name="box" pos="0 3 1"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/></body>
  </worldbody>
</mujoco>
"""
LIGHTS = """
  Dim: {type: WritePrimAttribute, inputs: {prim: /World/sun, name: 'inputs:intensity', value: 0.25}}
  Tint: {type: WritePrimAttribute, inputs: {prim: /World/sun, name: 'inputs:color', value: [1, 0.5, 0]}}
  Intensity: {type: ReadPrimAttribute, inputs: {prim: /World/sun, name: 'inputs:intensity'}}
  Colour: {type: ReadPrimAttribute, inputs: {prim: /World/sun, name: 'inputs:color'}}
  Text: ToString
  ColourText: ToString
  Print: PrintText
  PrintColour: PrintText
"""
LIGHT_WIRES = """
  - Tick.tick -> Dim.execIn
  - Dim.execOut -> Tint.execIn
  - Tint.execOut -> Print.execIn
  - Print.execOut -> PrintColour.execIn
  - Intensity.value -> Text.value
  - Text.converted -> Print.text
  - Colour.value -> ColourText.value
  - ColourText.converted -> PrintColour.text
"""


def test_a_light_is_read_and_written_until_a_stop(play: Player) -> None:
    playing = arm(play, LIGHTS, LIGHT_WIRES, LIT)
    world = playing.session.services.world
    light = world.stage.find("/World/sun")
    assert world.light(light) == (1.0, (0.5, 0.5, 0.5))
    playing.tick()
    assert (playing.node("Print").text, playing.node("PrintColour").text) == ("0.25", "[1, 0.5, 0]")
    assert world.light(light) == (0.25, (1.0, 0.5, 0.0))
    playing.session.stop()
    assert world.light(light) == (1.0, (0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("inputs:intensity", value) for value in (-1.0, math.nan, math.inf, 1e30, "up")),
        *(("inputs:color", value) for value in ((0.0, -0.1, 0.0), (0.0, 0.0, math.nan), (1e30, 0.0, 0.0), (1.0, 1.0))),
    ],
)
def test_an_invalid_light_is_refused(name: str, value: Any, context: RecordingContext) -> None:
    light = context.world.stage.add("/World/sun", "light", facts={"diffuse": (0.5, 0.5, 0.5)})
    node = ready(WritePrimAttribute, context, prim="/World/sun", name=name)
    node.value = value
    with pytest.raises(BadValueError, match=f"{name} of /World/sun"):
        node.compute()
    assert context.world.light(light) == (1.0, (0.5, 0.5, 0.5))
