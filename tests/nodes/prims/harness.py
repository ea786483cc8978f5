"""An arm that can turn and a box that lies beside it, alone and in a graph."""

from __future__ import annotations

from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, Playing, yaw
from tests.nodes.test_service_prim import ARM, SCENE, URDF, WORLD

BOX = "/World/box"


def box() -> RecordingContext:
    """A body that is turned about z."""
    context = RecordingContext()
    context.world.add_body(BOX, (1.0, 2.0, 3.0), yaw(0.5))
    return context


GRAPH = """
graph: prims
nodes:
  Tick: OnPlaybackTick
NODES
connections:
CONNECTIONS
"""


def arm(play: Player, nodes: str, connections: str, world: str = WORLD) -> Playing:
    """An arm that can turn, a free box, and some nodes."""
    lines = GRAPH.replace("NODES", nodes.strip("\n")).replace("CONNECTIONS", connections.strip("\n"))
    files = {"arm.yaml": ARM, "arm.urdf": URDF, "scene.yaml": SCENE, "world.xml": world, "prims.yaml": lines}
    return play.scene(files)


READING = """
  Steps: Multisequence
  Put:
    type: WritePrimAttribute
    inputs: {prim: /World/box, name: 'xformOp:translate', value: {type: 'double[3]', value: [7, 8, 9]}}
  Read: {type: ReadPrimAttribute, inputs: {prim: /World/box, name: 'xformOp:translate'}}
  Path: {type: ToToken, inputs: {value: /World/box}}
  Pose: GetPrimLocalToWorldTransform
  Point: GetMatrix4Translation
  Before: {type: PublishOdometry, inputs: {topicName: before}}
  After: {type: PublishOdometry, inputs: {topicName: after}}
  Last: {type: PublishOdometry, inputs: {topicName: last}}
"""
READING_WIRES = """
  - Tick.tick -> Steps.execIn
  - Steps.output0 -> Before.execIn
  - Steps.output1 -> Put.execIn
  - Steps.output2 -> After.execIn
  - Steps.output3 -> Last.execIn
  - Read.value -> Before.position
  - Read.value -> After.position
  - Path.converted -> Pose.primPath
  - Pose.localToWorldTransform -> Point.matrix
  - Point.translation -> Last.position
"""
