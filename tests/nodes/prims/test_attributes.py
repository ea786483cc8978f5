"""ReadPrimAttribute, WritePrimAttribute and the nodes of poses: alone, and in graphs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import BadValueError, ContextError, NodeError
from graphengine.node.prims.stage_prims import Prims
from graphengine.node.types import coerce
from graphengine.node.usd_types import PORT_TYPES, type_of_attribute
from graphengine.nodes.prims import (
    GetPrimDirectionVector,
    GetPrimLocalToWorldTransform,
    ReadPrimAttribute,
    ReadPrimLocalTransform,
    WritePrimAttribute,
)
from tests.nodes.harness import Player, computed, matrix, ready, yaw
from tests.nodes.prims.harness import BOX, READING, READING_WIRES, arm, box


@pytest.mark.parametrize("where", [{"prim": BOX}, {"prim_path": BOX, "use_path": True}])
def test_an_attribute_is_read_as_a_port_value(where: dict[str, Any]) -> None:
    node = computed(ReadPrimAttribute, box(), name="xformOp:translate", **where)
    assert node.value == (1.0, 2.0, 3.0)
    node = computed(ReadPrimAttribute, box(), name="xformOp:orient", **where)
    assert node.value == pytest.approx(yaw(0.5))


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("xformOp:translate", (4, 5.5, -6), (4.0, 5.5, -6.0)),
        ("xformOp:translate", np.array([4.0, 5.0, 6.0]), (4.0, 5.0, 6.0)),
        ("xformOp:orient", yaw(-1.0), yaw(-1.0)),
    ],
)
def test_written_attributes_are_read_back(name: str, value: Any, read: Any) -> None:
    context = box()
    ready(WritePrimAttribute, context, prim=BOX, name=name, value=value).compute()
    node = computed(ReadPrimAttribute, context, prim=BOX, name=name)
    assert node.value == pytest.approx(read)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ((1.0, 2.0), r"is a double\[3\]: expected 3 values, got 2"),
        ("up", r"is a double\[3\]: expected a list of 3 values, got 'up'"),
        ((1.0, 2.0, math.nan), r"xformOp:translate of /World/box: the value must be .*, not \[1.0, 2.0, nan\]"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_the_legal_values(value: Any, told: str) -> None:
    node = ready(WritePrimAttribute, box(), prim=BOX, name="xformOp:translate", value=value)
    with pytest.raises(BadValueError, match=told):
        node.compute()


def test_a_read_only_attribute_is_refused_with_the_writable_ones() -> None:
    with pytest.raises(ContextError, match="physics:mass of /World/box cannot be changed") as refused:
        ready(WritePrimAttribute, box(), prim=BOX, name="physics:mass", value=2.0)
    assert "writable attributes: xformOp:translate, xformOp:orient" in str(refused.value)


def test_an_unknown_attribute_is_reported_with_the_nearest_names() -> None:
    with pytest.raises(ContextError, match="has no attribute 'xformOp:translat'") as refused:
        ready(ReadPrimAttribute, box(), prim=BOX, name="xformOp:translat")
    assert "xformOp:translate" in str(refused.value)


def test_the_error_of_an_empty_prim_input_mentions_the_other_input_if_it_is_set() -> None:
    with pytest.raises(ContextError, match="prim is empty") as refused:
        ready(ReadPrimAttribute, box(), prim_path=BOX, name="xformOp:translate")
    assert "primPath is set, but is used only if usePath is true" in str(refused.value)


def test_a_pose_is_a_matrix_for_row_vectors() -> None:
    context = box()
    context.world.add_body("/World/box/lid", (1.0, 0.0, 0.0), yaw(0.25))
    whole = computed(GetPrimLocalToWorldTransform, context, prim_path=BOX)
    made = np.array(whole.local_to_world_transform).reshape(4, 4)
    assert made[:3, :3] == pytest.approx(matrix(yaw(0.5)).T)
    assert made[3].tolist() == [1.0, 2.0, 3.0, 1.0]
    local = computed(ReadPrimLocalTransform, context, prim="/World/box/lid")
    world = context.world.body(context.world.stage.find("/World/box/lid")).pose()
    row = np.array([*world[0], 1.0])
    assert np.array([0.0, 0.0, 0.0, 1.0]) @ np.array(local.value).reshape(4, 4) @ made == pytest.approx(row)


def test_the_axes_of_a_prim_follow_its_orientation() -> None:
    node = computed(GetPrimDirectionVector, box(), prim_path=BOX)
    right, up, backward = matrix(yaw(0.5)).T
    assert [node.right_vector, node.left_vector] == [pytest.approx(right), pytest.approx(-right)]
    assert [node.up_vector, node.down_vector] == [pytest.approx(up), pytest.approx(-up)]
    assert [node.backward_vector, node.forward_vector] == [pytest.approx(backward), pytest.approx(-backward)]


def test_in_a_graph_the_axes_of_a_prim_are_up_to_date(play: Player) -> None:
    nodes = """
  Turn: {type: WritePrimAttribute, inputs: {prim: /World/box, name: 'xformOp:orient', value: [0.0, 0.0, 1.0, 0.0]}}
  Axes: {type: GetPrimDirectionVector, inputs: {primPath: /World/box}}
  Look: {type: PublishOdometry}
"""
    wires = "  - Tick.tick -> Turn.execIn\n  - Turn.execOut -> Look.execIn\n  - Axes.rightVector -> Look.position"
    playing = arm(play, nodes, wires).tick()
    assert playing.node("Look").position == pytest.approx((-1.0, 0.0, 0.0))


DRIVE = """
  Drive:
    type: WritePrimAttribute
    inputs: {prim: /arm/Physics/turn, name: 'drive:angular:physics:targetPosition', value: 45.0}
  Angle: {type: ReadPrimAttribute, inputs: {prim: /arm/Physics/turn, name: 'state:angular:physics:position'}}
  Target:
    type: ReadPrimAttribute
    inputs: {primPath: /arm/Physics/turn, usePath: true, name: 'drive:angular:physics:targetPosition'}
  Both: {type: ConstructArray, inputs: {arraySize: 2}}
  Each: ForEach
"""
WIRES = """
  - Tick.tick -> Drive.execIn
  - Drive.execOut -> Each.execIn
  - Angle.value -> Both.input0
  - Target.value -> Both.input1
  - Both.array -> Each.arrayIn
"""


def test_a_drive_takes_its_target_in_degrees_and_reaches_it(play: Player) -> None:
    playing = arm(play, DRIVE, WIRES).tick()
    angle, target = playing.node("Both").array.tolist()
    assert target == 45.0
    assert abs(angle) < 1.0
    playing.tick(600)
    assert playing.node("Both").array.tolist() == pytest.approx([45.0, 45.0], abs=0.5)
    assert playing.node("Both").array.dtype == np.float32


def test_a_wrong_value_stops_the_run_and_names_the_attribute(play: Player) -> None:
    playing = arm(play, READING.replace("[7, 8, 9]", "[7, 8, .nan]"), READING_WIRES)
    with pytest.raises(NodeError, match="must be an array of 3 finite numbers"):
        playing.tick()


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("up", r"Put: a value of type token cannot be written to xformOp:translate of type double\[3\]"),
        ("[7, 8]", r"Put: a value of type int\[2\] cannot be written to xformOp:translate of type double\[3\]"),
    ],
)
def test_a_value_of_the_wrong_kind_is_reported_before_the_run(play: Player, value: str, told: str) -> None:
    with pytest.raises(CheckError, match=told):
        arm(play, READING.replace("{type: 'double[3]', value: [7, 8, 9]}", value), READING_WIRES)


def test_a_list_can_be_written_without_a_type(play: Player) -> None:
    playing = arm(play, READING.replace("{type: 'double[3]', value: [7, 8, 9]}", "[7, 8, 9]"), READING_WIRES).tick()
    assert playing.node("Read").value == pytest.approx((7.0, 8.0, 9.0))


def test_a_read_only_attribute_is_reported_before_the_run(play: Player) -> None:
    with pytest.raises(CheckError, match="physics:mass of /World/box cannot be changed while the simulation runs"):
        arm(play, READING.replace("'xformOp:translate', value", "'physics:mass', value"), READING_WIRES)


def test_the_types_by_name_are_the_types_of_prims(play: Player) -> None:
    playing = arm(play, DRIVE, WIRES)
    prims, seen = Prims(playing.session.services.world), set()
    for path, _ in prims.below("/"):
        for name, kind in prims.attributes(path).items():
            found, value = prims.read(path, name)
            assert type_of_attribute(name) == PORT_TYPES[kind] == PORT_TYPES[found]
            coerce(value, PORT_TYPES[kind])
            seen.add(name)
    assert len(seen) > 6
    with pytest.raises(ContextError, match="no prim can have an attribute 'drive:angular:physics:stiffness'"):
        type_of_attribute("drive:angular:physics:stiffness")
