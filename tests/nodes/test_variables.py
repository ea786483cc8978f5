"""ReadVariable, WriteVariable and OnVariableChange: alone, and in graphs."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.node.variable import Variable
from graphengine.nodes.action.events import OnVariableChange
from graphengine.nodes.variables import ReadVariable, WriteVariable
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, computed, ready


@pytest.fixture
def context() -> RecordingContext:
    made = RecordingContext()
    made.variables["speed"] = Variable(1.5)
    return made


def test_a_variable_written_by_one_node_is_read_by_another(context: RecordingContext) -> None:
    reader = computed(ReadVariable, context, variable_name="speed")
    assert reader.value == 1.5
    writer = computed(WriteVariable, context, variable_name="speed", value_in=2.5)
    reader.compute()
    assert (reader.value, writer.value_out) == (2.5, 2.5)


def test_a_change_is_an_event_of_the_next_tick_only(context: RecordingContext) -> None:
    watcher = ready(OnVariableChange, context, variable_name="speed")
    seen = []
    for value in (1.5, 2.0, 2.0, 1.5):
        context.variables["speed"].value = value
        context.variables["speed"].freeze()
        seen.append(watcher.compute() == watcher.changed)
    assert seen == [False, True, False, True]


def test_a_number_that_stays_nan_does_not_change() -> None:
    variable = Variable(float("nan"))
    variable.value = float("nan")
    variable.freeze()
    assert not variable.changed


@pytest.mark.parametrize(("port_type", "value"), [("double[2]", "[0.0, .nan]"), ("double[]", "[.nan]")])
def test_a_variable_that_stays_nan_fires_no_change(play: Player, port_type: str, value: str) -> None:
    text = COUNTING.format(type=f"'{port_type}'", default=value, value=f"{{type: '{port_type}', value: {value}}}")
    playing = play.graph(text).tick(4)
    assert playing.node("Count").count == 0


COUNTING = """
variables: {{total: {{type: {type}, default: {default}}}}}
nodes:
  Tick: OnPlaybackTick
  Write: {{type: WriteVariable, inputs: {{variableName: total, value: {value}}}}}
  Read: {{type: ReadVariable, inputs: {{variableName: total}}}}
  Changed: {{type: OnVariableChange, inputs: {{variableName: total}}}}
  Count: Counter
connections: [Tick.tick -> Write.execIn, Changed.changed -> Count.execIn]
"""


@pytest.mark.parametrize(
    ("type_name", "default", "value", "expected"),
    [
        ("double", "1", "2", 2.0),
        ("token", "a", "b", "b"),
        ("int64", "1", "-5", -5),
        ("double[3]", "[1, 2, 3]", "{type: 'double[3]', value: [4, 5, 6]}", (4.0, 5.0, 6.0)),
        ("double[3]", "[1, 2, 3]", "[4, 5, 6]", (4.0, 5.0, 6.0)),
        ("target", "[/a]", "[/b, /c]", ("/b", "/c")),
    ],
)
def test_a_literal_gets_the_type_of_the_variable(
    play: Player, type_name: str, default: str, value: str, expected: object
) -> None:
    playing = play.graph(COUNTING.format(type=f"'{type_name}'", default=default, value=value)).tick(3)
    written = playing.node("Write").value_out
    assert (written, type(written)) == (expected, type(expected))
    assert playing.node("Count").count == 1


def test_a_literal_that_is_not_of_the_type_of_the_variable_is_refused(play: Player) -> None:
    with pytest.raises(CheckError, match="Write: value must be an int, but it is a token"):
        play.graph(COUNTING.format(type="int", default="1", value="fast"))


def test_a_wire_from_a_variable_has_its_type(play: Player) -> None:
    text = """
        variables: {where: {type: 'vectord[3]', default: [1, 2, 3]}}
        nodes:
          Tick: OnPlaybackTick
          Read: {type: ReadVariable, inputs: {variableName: where}}
          Odometry: PublishOdometry
        connections: [Tick.tick -> Odometry.execIn, Read.value -> Odometry.position]
        """
    playing = play.graph(text).tick()
    position = playing.published(playing.topics["Odometry"])[0].pose.pose.position
    assert (position.x, position.y, position.z) == (1.0, 2.0, 3.0)
    with pytest.raises(CheckError, match=r"is a vectord\[3\], Odometry.timeStamp takes a double"):
        play.graph(text.replace("Odometry.position", "Odometry.timeStamp"))


def test_an_unknown_variable_is_reported_with_the_known_ones(play: Player) -> None:
    text = COUNTING.format(type="int", default="1", value="2").replace("variableName: total", "variableName: totl", 1)
    with pytest.raises(CheckError, match="the graph has no variable 'totl'"):
        play.graph(text)
