"""IsaacReadRaycastSensor and IsaacReadLightBeam."""

from __future__ import annotations

import numpy as np
import pytest

from graphengine.devices.light_beam import BeamReading, LightBeamStub
from graphengine.devices.raycast import RaycastReading, RaycastSensorStub
from graphengine.format.errors import PrimError
from graphengine.nodes.ray_sensors import IsaacReadLightBeam, IsaacReadRaycastSensor
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, computed, ready

ROWS = np.arange(6.0).reshape(2, 3)


def test_a_raycast_reading_is_output_as_flat_arrays_and_cleared_at_a_stop(context: RecordingContext) -> None:
    context.world.add_robot("/robot")
    sensor = context.world.add_device(RaycastSensorStub, "/robot/Rays")
    sensor.measured = RaycastReading(
        0.25, np.array([1.5, 100.0]), ROWS, ROWS + 10, ("/World/box", ""), ROWS + 20, ROWS + 30
    )
    node = computed(IsaacReadRaycastSensor, context, raycast_sensor_prim="/robot/Rays")
    assert (node.sensor_time, node.num_rays, node.hit_prim_paths) == (0.25, 2, ("/World/box", ""))
    assert node.depths.tolist() == [1.5, 100.0]
    assert node.hit_positions.tolist() == [0, 1, 2, 3, 4, 5]
    assert node.hit_normals.tolist() == [10, 11, 12, 13, 14, 15]
    assert node.beam_origins.tolist() == (ROWS + 20).tolist()
    assert node.beam_end_points.tolist() == (ROWS + 30).tolist()
    context.stop(node)
    assert (node.sensor_time, node.num_rays, len(node.depths)) == (0.0, 0, 0)


def test_a_light_beam_reading_is_output_and_cleared_at_a_stop(context: RecordingContext) -> None:
    context.world.add_robot("/robot")
    sensor = context.world.add_device(LightBeamStub, "/robot/Beam")
    sensor.measured = BeamReading(0.5, np.array([True, False]), np.array([1.5, 100.0]), ROWS, ROWS + 10, ROWS + 20)
    node = computed(IsaacReadLightBeam, context, lightbeam_prim="/robot/Beam")
    assert (node.num_rays, node.beam_hit_data.tolist()) == (2, [True, False])
    assert node.linear_depth_data.tolist() == [1.5, 100.0]
    assert node.hit_pos_data.tolist() == ROWS.tolist()
    assert node.beam_origins.tolist() == (ROWS + 10).tolist()
    assert node.beam_end_points.tolist() == (ROWS + 20).tolist()
    context.stop(node)
    assert (node.num_rays, len(node.beam_hit_data)) == (0, 0)


def test_a_prim_that_is_not_the_sensor_is_refused(context: RecordingContext) -> None:
    context.world.add_robot("/robot")
    context.world.add_device(RaycastSensorStub, "/robot/Rays")
    with pytest.raises(PrimError, match="is a raycast sensor, not a light beam sensor"):
        ready(IsaacReadLightBeam, context, lightbeam_prim="/robot/Rays")


@pytest.mark.parametrize(
    ("runs", "event", "out"), [("tick", "OnPlaybackTick", "tick"), ("physics_step", "OnPhysicsStep", "step")]
)
def test_a_box_on_a_belt_breaks_a_light_beam_and_rays_measure_it(play: Player, runs: str, event: str, out: str) -> None:
    """The front of the box is at the beam when it has gone 0.5 m, at 1 m/s, and its back 0.1 m later."""
    playing = play.scene(
        {
            "world.xml": """
                <mujoco><worldbody>
                <body name="belt"><geom type="box" size="5 .5 .5" friction="1"/></body>
                <body name="box" pos="-.55 0 .55"><freejoint/><geom type="box" size=".05 .05 .05" mass="1"/></body>
                </worldbody></mujoco>
                """,
            "post.urdf": '<robot name="post"><link name="base_link"/></robot>',
            "post.yaml": """
                robot: post
                urdf: post.urdf
                fixed_base: true
                sensors:
                  beam: {type: light_beam, parent: base_link, profile: {min_range: 0.1, max_range: 2.0}}
                  rays:
                    type: raycast
                    parent: base_link
                    profile:
                      min_range: 0.1
                      max_range: 2.0
                      ray_directions: [[1, 0, 0], [0, 0, -1]]
                      output_frame: WORLD
                      report_hit_prim_paths: true
                """,
            "scene.yaml": """
                scene: case
                world: world.xml
                physics: {tick_rate: 60, substeps: 4}
                robots: {post: {use: post.yaml, position: [0, -1, 0.55], orientation: {rpy_deg: [0, 0, 90]}}}
                graphs: {graph: {use: graph.yaml, at: /World/graph}, move: {use: move.yaml, at: /World/move}}
                """,
            "move.yaml": """
                graph: move
                nodes: {Tick: OnPlaybackTick, Belt: {type: Conveyor, inputs: {conveyorPrim: /World/belt, velocity: 1.0}}}
                connections: [Tick.tick -> Belt.onStep]
                """,
            "graph.yaml": f"""
                graph: graph
                runs: {runs}
                nodes:
                  Event: {event}
                  Beam: {{type: ReadLightBeam, inputs: {{lightbeamPrim: /post/base_link/beam}}}}
                  Rays: {{type: ReadRaycastSensor, inputs: {{raycastSensorPrim: /post/base_link/rays}}}}
                connections: [Event.{out} -> Beam.execIn, Event.{out} -> Rays.execIn]
                """,
        }
    )
    box = playing.session.services.world.body(playing.session.services.world.stage.find("/World/box"))
    beam, rays, seen = playing.node("Beam"), playing.node("Rays"), []
    for _ in range(60):
        playing.tick()
        place = box.pose()[0][0]
        if abs(abs(place) - 0.05) > 1e-3:
            assert beam.beam_hit_data.tolist() == [abs(place) < 0.05]
            seen.append(bool(beam.beam_hit_data[0]))
            assert beam.linear_depth_data[0] == pytest.approx(0.95 if seen[-1] else 2.0, abs=1e-3)
            assert rays.depths[0] == pytest.approx(beam.linear_depth_data[0])
            assert rays.hit_prim_paths == ("/World/box" if seen[-1] else "", "")
            if seen[-1]:
                assert rays.hit_positions[:3].tolist() == pytest.approx([0.0, -0.05, 0.55], abs=1e-3)
                assert rays.hit_normals[:3].tolist() == pytest.approx([0.0, -1.0, 0.0], abs=1e-3)
    first = seen.index(True)
    assert all(seen[first : first + sum(seen)])  # once
    assert 5 <= sum(seen) <= 7  # a tenth of a second
    assert rays.sensor_time == pytest.approx(1.0)
