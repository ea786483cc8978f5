"""Who reads and who writes a thing in one pass."""

from __future__ import annotations

import pytest

from tests.nodes.harness import Player
from tests.nodes.prims.harness import READING, READING_WIRES, arm


def test_a_later_reader_in_the_same_pass_gets_the_written_value(play: Player) -> None:
    playing = arm(play, READING, READING_WIRES).tick()
    before, after, last = (playing.node(name).position for name in ("Before", "After", "Last"))
    assert before == pytest.approx((0.0, 3.0, 1.0))
    assert after == last == (7.0, 8.0, 9.0)


def test_a_world_pose_that_was_written_is_read_in_the_same_pass(play: Player) -> None:
    wires = READING_WIRES.replace("Point.translation -> Last", "Look.translation -> Last")
    wires = wires.replace("Read.value -> Before", "Look.translation -> Before")
    playing = arm(play, f"{READING}  Look: {{type: IsaacReadWorldPose, inputs: {{prim: /World/box}}}}\n", wires).tick()
    assert playing.node("Before").position == pytest.approx((0.0, 3.0, 1.0))
    assert playing.node("Last").position == (7.0, 8.0, 9.0)


def test_an_unordered_reader_and_writer_give_a_warning(play: Player) -> None:
    wires = READING_WIRES.replace("Steps.output1", "Steps.output0")
    found = arm(play, READING, wires).findings
    told = [finding.message for finding in found.items if finding.code == "W105"]
    assert "Before reads and Put writes pose /World, but nothing determines their order" in told


HERE = "currentPosition: [1, 0, 0], currentOrientation: [0, 0, 0.6, 0.8]"


@pytest.mark.parametrize(
    "node",
    [
        "{type: IsaacComputeOdometry, inputs: {chassisPrim: /World/box}}",
        "{type: IsaacComputeTransformTree, inputs: {targetPrims: [/World/box]}}",
        "{type: IsaacComputeTransformTree, inputs: {targetPrims: [/arm], parentPrim: /World/box}}",
        "{type: QuinticPathPlanner, inputs: {targetPrim: /World/box, " + HERE + "}}",
    ],
)
def test_an_unordered_executed_reader_of_a_pose_and_a_writer_give_a_warning(play: Player, node: str) -> None:
    found = arm(play, f"{READING}  Look: {node}\n", f"{READING_WIRES}  - Tick.tick -> Look.execIn\n").findings
    told = [finding.message for finding in found.items if finding.code == "W105"]
    assert told == ["Look reads and Put writes pose /World, but nothing determines their order"]


def test_a_drive_target_set_by_a_controller_is_read_in_the_same_pass(play: Player) -> None:
    nodes = """
  Steps: Multisequence
  Tell: {type: ArticulationController, inputs: {robotPath: /arm, jointNames: [turn], positionCommand: [1.0]}}
  Target: {type: ReadPrimAttribute, inputs: {prim: /arm/Physics/turn, name: 'drive:angular:physics:targetPosition'}}
  Before: {type: LogMessage}
  After: {type: LogMessage}
  Text: ToString
"""
    wires = """
  - Tick.tick -> Steps.execIn
  - Steps.output0 -> Before.execIn
  - Steps.output1 -> Tell.execIn
  - Steps.output2 -> After.execIn
  - Target.value -> Text.value
  - Text.converted -> Before.message
  - Text.converted -> After.message
"""
    playing = arm(play, nodes, wires).tick()
    assert (playing.node("Before").message, playing.node("After").message) == ("0", "57.2958")
