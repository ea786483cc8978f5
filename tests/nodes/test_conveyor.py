"""IsaacConveyor: velocities as in Isaac Sim's tests, and what they do to a cube."""

from __future__ import annotations

import math
from typing import Any

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import BadValueError, PrimError
from graphengine.nodes.conveyor import IsaacConveyor
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, computed, ready

STILL = (0.0, 0.0, 0.0)


def belt(context: RecordingContext) -> Any:
    """The stub of a belt's surface."""
    context.world.add_body("/World/belt")
    return context.world.conveyor(context.world.stage.find("/World/belt"))


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 2.0)])
def test_the_velocity_is_speed_times_direction(
    context: RecordingContext, direction: tuple[float, float, float]
) -> None:
    surface = belt(context)
    computed(IsaacConveyor, context, conveyor_prim="/World/belt", velocity=0.1, direction=direction)
    assert (surface.linear, surface.angular) == (pytest.approx([0.1 * part for part in direction]), STILL)


def test_a_curved_belt_turns(context: RecordingContext) -> None:
    surface = belt(context)
    node = computed(IsaacConveyor, context, conveyor_prim="/World/belt", velocity=0.1, direction=(0, 0, 1), curved=True)
    assert (surface.linear, surface.angular) == (STILL, pytest.approx((0.0, 0.0, 0.1)))
    node.curved = False
    node.compute()
    assert (surface.linear, surface.angular) == (pytest.approx((0.0, 0.0, 0.1)), STILL)


def test_a_disabled_conveyor_keeps_its_velocity(context: RecordingContext) -> None:
    surface = belt(context)
    node = computed(IsaacConveyor, context, conveyor_prim="/World/belt", velocity=0.5)
    node.enabled, node.velocity = False, 0.0
    node.compute()
    assert surface.linear == (0.5, 0.0, 0.0)


@pytest.mark.parametrize("speed", [math.nan, math.inf])
def test_a_velocity_that_is_not_finite_is_refused(context: RecordingContext, speed: float) -> None:
    surface = belt(context)
    node = ready(IsaacConveyor, context, conveyor_prim="/World/belt")
    node.velocity = speed
    with pytest.raises(BadValueError, match="velocity must be finite"):
        node.compute()
    assert surface.linear == STILL


def test_the_error_of_a_prim_without_a_body_lists_the_bodies(context: RecordingContext) -> None:
    belt(context)
    context.world.stage.add("/World/group", "scope")
    with pytest.raises(PrimError, match="'/World/group' is a scope, which has no rigid body\nbodies: /World/belt"):
        ready(IsaacConveyor, context, conveyor_prim="/World/group")


FILES = {
    "world.xml": """
        <mujoco><worldbody><geom type="plane" size="0 0 1" pos="0 0 -.5"/>
        <body name="belt"><geom type="box" size="2 .5 .5"/></body>
        <body name="cube" pos="-1 0 .55"><freejoint/><geom type="box" size=".05 .05 .05" mass="1"/></body></worldbody></mujoco>
        """,
    "scene.yaml": """
        scene: case
        world: world.xml
        physics: {tick_rate: 60, substeps: 4}
        graphs: {graph: {use: graph.yaml, at: /World/ConveyorBeltGraph}}
        """,
    "graph.yaml": """
        graph: graph
        variables: {Velocity: {type: float, default: 0.1}}
        nodes:
          OnTick: OnPlaybackTick
          ConveyorNode: {type: isaacsim.asset.gen.conveyor.IsaacConveyor, inputs: {conveyorPrim: /World/belt}}
          read_speed: {type: ReadVariable, inputs: {variableName: Velocity}}
        connections:
          - OnTick.tick -> ConveyorNode.onStep
          - read_speed.value -> ConveyorNode.velocity
        """,
}
"""With the graph that Isaac Sim makes for a conveyor, without the time that nothing uses."""


def test_a_cube_on_a_conveyor_reaches_its_speed(play: Player) -> None:
    playing = play.scene(FILES)
    entities = playing.session.services.world.entities
    playing.tick(60)
    assert entities.state("cube").linear_velocity == pytest.approx((0.1, 0.0, 0.0), abs=1e-6)
    saved, ends = playing.session.checkpoint(), []
    for _ in range(2):
        playing.tick(60)
        ends.append(entities.state("cube"))
        playing.session.restore(saved)
    assert ends[0] == ends[1]
    assert ends[0].position[0] == pytest.approx(-1.0 + 0.2, abs=5e-3)
    playing.session.reset()
    assert entities.state("cube").position[0] == -1.0
    playing.tick(60)
    assert entities.state("cube").linear_velocity == pytest.approx((0.1, 0.0, 0.0), abs=1e-6)


def test_a_body_on_a_joint_is_an_error_of_the_graph(play: Player) -> None:
    graph = FILES["graph.yaml"].replace("conveyorPrim: /World/belt", "conveyorPrim: /World/cube")
    with pytest.raises(CheckError, match="'/World/cube' cannot be a conveyor: a joint moves it"):
        play.scene({**FILES, "graph.yaml": graph})
