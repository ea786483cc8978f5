"""The parameters of a session, as its graphs give them."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.format.errors import UsageError
from graphengine.messages.parameters import ParameterType
from graphengine.node import types
from graphengine.runtime.parameter_table import Parameter, graph_parameters, is_representable, session_parameters
from tests.compiler.conftest import MakePlay
from tests.compiler.harness import Play

TUNED = """
    variables:
      speed: {type: double, default: 1.5}
      goal: {type: "double[3]", default: [1, 2, 3]}
      path: {type: "double[3][]", default: []}
    nodes:
      Tick: Tick
      Number: {type: Constant, inputs: {value: 1.0}}
      Tuned: {type: Tunable, inputs: {share: 0.25}}
      Show: Do
    connections:
      - Tick.tick -> Tuned.execIn
      - Tick.tick -> Show.execIn
      - Number.value -> Tuned.gain
      - Number.value -> Show.a
"""


def table(run: Play) -> dict[str, Parameter]:
    return graph_parameters(run.session.graphs)


def put(run: Play, name: str, value: Any) -> None:
    command = table(run)[name].command
    assert command is not None
    command(value).apply(run.session)


def test_unwired_inputs_that_no_setup_reads_and_variables_are_parameters(play: MakePlay) -> None:
    names = table(play(TUNED))
    tuned = [name.removeprefix("g0.Tuned.") for name in names if name.startswith("g0.Tuned.")]
    assert tuned == [
        "share", "enabled", "level", "number", "big", "mode", "title", "axis", "turn", "weights", "names", "image",
    ]  # fmt: skip
    assert {"g0.Number.value", "g0.Show.b", "g0.variables.speed", "g0.variables.goal"} <= set(names)
    assert {"g0.Show.a", "g0.variables.path"}.isdisjoint(names)


@pytest.mark.parametrize(
    ("name", "kind", "value"),
    [
        ("share", ParameterType.DOUBLE, 0.25),
        ("enabled", ParameterType.BOOL, True),
        ("level", ParameterType.INTEGER, 3),
        ("mode", ParameterType.STRING, "slow"),
        ("axis", ParameterType.DOUBLE_ARRAY, (1.0, 0.0, 0.0)),
        ("weights", ParameterType.DOUBLE_ARRAY, types.parse("double[]")),
        ("names", ParameterType.STRING_ARRAY, ()),
        ("image", ParameterType.INTEGER_ARRAY, types.parse("uchar[]")),
    ],
)
def test_a_parameter_has_the_type_and_the_value_of_its_input(
    play: MakePlay, name: str, kind: ParameterType, value: Any
) -> None:
    parameter = table(play(TUNED))[f"g0.Tuned.{name}"]
    assert parameter.type is kind
    assert parameter.has(value.zero if isinstance(value, types.PortType) else value)


@pytest.mark.parametrize(
    ("name", "limits", "constraint"),
    [
        ("level", (0, 255), ""),
        ("number", None, ""),
        ("big", (0, 2**63 - 1), ""),
        ("share", None, "> 0 and ≤ 1"),
        ("mode", None, "one of slow, fast"),
        ("axis", None, "3 values"),
        ("turn", None, "4 values: x, y, z, w"),
    ],
)
def test_a_parameter_has_the_limits_of_its_port(play: MakePlay, name: str, limits: object, constraint: str) -> None:
    parameter = table(play(TUNED))[f"g0.Tuned.{name}"]
    signs = {"> 0 and ≤ 1": "≤ 1 and > 0"}
    assert parameter.limits == limits
    assert parameter.constraint in (constraint, signs.get(constraint))


def test_doc_unit_and_closed_limits_come_from_the_port(play: MakePlay) -> None:
    gain = table(play(TUNED.replace("      - Number.value -> Tuned.gain\n", "")))["g0.Tuned.gain"]
    assert (gain.doc, gain.unit, gain.limits, gain.constraint) == ("what it multiplies with", "m/s", (0.0, 2.0), "")


def test_a_set_value_holds_from_the_next_tick_on(play: MakePlay) -> None:
    run = play(TUNED)
    put(run, "g0.Show.b", 2)
    put(run, "g0.Number.value", 3.0)
    assert run.tick() == ["Show 5"]
    assert table(run)["g0.Show.b"].read() == 2.0


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("g0.Tuned.share", 0.0, "expected a value"),
        ("g0.Tuned.level", 256, "expected a value from 0 to 255"),
        ("g0.Tuned.level", 1.5, "expected a whole number"),
        ("g0.Tuned.mode", "quick", "expected one of slow, fast"),
        ("g0.Tuned.axis", [1.0], "expected 3 values"),
        ("g0.Tuned.enabled", 1, "expected true or false"),
        ("g0.variables.speed", "fast", "variable speed of g0 is a double: expected a number"),
        ("g0.variables.goal", [1.0, 2.0], "expected 3 values"),
    ],
)
def test_an_illegal_value_is_refused_with_the_reason(play: MakePlay, name: str, value: Any, words: str) -> None:
    run = play(TUNED)
    before = table(run)[name].read()
    with pytest.raises(UsageError, match=words):
        put(run, name, value)
    assert table(run)[name].has(before)


def test_a_variable_is_read_in_the_next_tick_and_returns_at_a_reset(play: MakePlay) -> None:
    run = play("""
        variables: {speed: {type: double, default: 1.0}}
        nodes: {Tick: Tick, Read: {type: ReadVariable, inputs: {variableName: speed}}, Show: Show}
        connections:
          - Tick.tick -> Show.execIn
          - Read.value -> Show.value
    """)
    assert run.tick() == ["Show 1"]
    put(run, "g0.variables.speed", 2.5)
    assert run.tick() == ["Show 2.5"]
    run.session.reset("time")
    assert table(run)["g0.variables.speed"].read() == 1.0


def test_a_full_path_of_a_node_matches_only_this_node(play: MakePlay) -> None:
    run = play("nodes: {Tick: Tick, Show: {type: Do, inputs: {b: 1.0}}}", "nodes: {Show: {type: Do, inputs: {b: 1.0}}}")
    put(run, "g0.Show.b", 5.0)
    assert [table(run)[f"g{number}.Show.b"].read() for number in (0, 1)] == [5.0, 1.0]


@pytest.mark.parametrize("factor", [0.5, 2, 0.0])
def test_the_real_time_factor_is_the_pace(play: MakePlay, factor: float) -> None:
    session = play(TUNED).session
    parameter = session_parameters(session)["real_time_factor"]
    assert parameter.command is not None
    parameter.command(factor).apply(session)
    assert session.pace == (factor or None)
    assert parameter.read() == factor


@pytest.mark.parametrize("wrong", [-1.0, 0.001, float("nan"), float("inf"), True, "fast"])
def test_illegal_real_time_factors_are_refused(play: MakePlay, wrong: Any) -> None:
    command = session_parameters(play(TUNED).session)["real_time_factor"].command
    assert command is not None
    with pytest.raises(UsageError, match=r"real_time_factor: expected"):
        command(wrong)


@pytest.mark.parametrize("name", ["target", "any", "bundle", "double[3][]", "execution"])
def test_some_types_cannot_be_parameters(name: str) -> None:
    kind = types.parse(name)
    assert isinstance(kind, types.PortType)
    assert not is_representable(kind)
