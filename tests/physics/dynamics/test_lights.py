"""The lights of a world as prims, and what pictures show of a change."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import Vector3, rotate
from graphengine.devices.stage import Prim, Stage
from graphengine.format.spec import RobotUse
from graphengine.node.prims.stage_prims import Prims
from graphengine.physics.model.world_prims import add_world
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project
from tests.physics.pictures.harness import EYE, FORWARD, camera_of, needs_opengl

LIT = """
<mujoco>
  <visual><headlight active="0"/></visual>
  <worldbody>
    <geom type="box" size=".1 9 9" pos="3 0 0" rgba="1 1 1 1"/>
    <light name="sun" type="directional" dir="1 0 0" diffuse=".6 .6 .6" ambient=".1 .1 .1" specular="0 0 0"/>
    <body name="lamp" pos="0 0 9"><light pos="0 0 -1" dir="0 1 0" type="spot" active="false"/><geom size=".01"/></body>
  </worldbody>
</mujoco>
"""


def lit(world: str = LIT) -> Simulation:
    model, stage = mujoco.MjModel.from_xml_string(world), Stage()
    add_world(stage, model, ())
    facts = {"size": (64, 48), "fov_deg": (90.0, 75.0), "clip": (0.05, 50.0), "rate": 30.0, "latency": 0.05}
    stage.add("/Camera", "camera", position=EYE, orientation=FORWARD, facts=facts)
    return Simulation(model, stage, Fraction(60), 1)


def sun(simulation: Simulation) -> Prim:
    return simulation.stage.find("/World/sun")


def colour_of_wall(simulation: Simulation) -> NDArray[np.float64]:
    rgb = camera_of(simulation).picture().rgb
    assert rgb is not None
    mean: NDArray[np.float64] = rgb.reshape(-1, 3).mean(axis=0)
    return mean


@needs_opengl
def test_a_picture_is_as_bright_as_the_light() -> None:
    simulation = lit()
    light = sun(simulation)
    bright = colour_of_wall(simulation)
    # a wall that faces the light shows diffuse + ambient, each times the intensity
    assert bright == pytest.approx([0.7 * 255] * 3, abs=1.0)
    simulation.set_light(light, (0.5, simulation.light(light)[1]))
    assert colour_of_wall(simulation) == pytest.approx(bright / 2, abs=1.0)
    simulation.set_light(light, (1.0, (0.6, 0.0, 0.0)))
    assert colour_of_wall(simulation) == pytest.approx([0.7 * 255, 0.1 * 255, 0.1 * 255], abs=1.0)
    simulation.set_light(light, (0.0, (0.6, 0.6, 0.6)))
    assert colour_of_wall(simulation) == pytest.approx([0.0] * 3)
    simulation.reset()
    assert colour_of_wall(simulation) == pytest.approx(bright)


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (0.6, 0.0, -0.8)])
def test_a_light_is_a_prim_that_shines_along_its_negative_z_axis(way: Vector3) -> None:
    stage = lit(LIT.replace('dir="1 0 0"', f'dir="{way[0]} {way[1]} {way[2]}"')).stage
    assert rotate(stage.find("/World/sun").orientation, (0.0, 0.0, -1.0)) == pytest.approx(way)


def test_a_light_without_a_name_is_numbered_and_hangs_on_its_body() -> None:
    simulation = lit()
    lamp = simulation.stage.find("/World/lamp/light_1")
    assert simulation.frame(lamp).pose()[0] == pytest.approx((0.0, 0.0, 8.0))
    assert simulation.light(lamp)[0] == 1.0


def test_lights_have_the_types_of_usd() -> None:
    prims = Prims(lit())
    assert [kind for _, kind in prims.below("/World/sun")] == ["DistantLight"]
    assert [kind for _, kind in prims.below("/World/lamp/light_1")] == ["SphereLight"]


def test_a_changed_light_stays_changed_until_a_reset_when_robots_are_added_and_removed(project: Project) -> None:
    dim = '<body name="lamp"><light name="bulb" diffuse=".5 .5 .5"/><geom size=".1" pos="9 9 9"/></body>'
    loaded = project.world(dim).load()
    simulation = loaded.simulation
    bulb = simulation.stage.find("/World/lamp/bulb")
    simulation.set_light(bulb, (2.0, (0.5, 0.25, 0.0)))
    loaded.add("other", RobotUse(use="bot.yaml", position=(0.0, 5.0, 0.2)))
    assert simulation.model.light("bulb").diffuse.tolist() == [1.0, 0.5, 0.0]
    loaded.remove("other")
    assert simulation.model.light("bulb").diffuse.tolist() == [1.0, 0.5, 0.0]
    simulation.reset()
    assert simulation.model.light("bulb").diffuse.tolist() == [0.5, 0.5, 0.5]
    assert simulation.light(bulb) == (1.0, (0.5, 0.5, 0.5))
