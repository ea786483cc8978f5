"""Inputs that get another value while a session runs."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.format.errors import GraphError, StateError, UsageError
from graphengine.runtime.addresses import find_port_at, find_ports
from graphengine.runtime.commands import parse
from tests.compiler.conftest import MakePlay
from tests.compiler.harness import Play

SUMS = """
    nodes:
      Tick: Tick
      One: {type: Constant, inputs: {value: 1.0}}
      Two: {type: Add, inputs: {b: 10.0}}
      Show: {type: Do, inputs: {b: 0.5}}
    connections:
      - Tick.tick -> Show.execIn
      - One.value -> Two.a
      - Two.sum -> Show.a
"""
TOPICS = """
    nodes:
      Tick: Tick
      Text: {type: Text, inputs: {a: sc, b: an}}
      First: Announce
      Second: {type: Announce, inputs: {topic: odom}}
    connections:
      - Tick.tick -> First.execIn
      - First.execOut -> Second.execIn
      - Text.text -> First.topic
"""


def put(run: Play, address: str, value: Any) -> None:
    parse("set", {"address": address, "value": value}).apply(run.session)


def test_an_input_has_its_new_value_from_the_next_tick_on(play: MakePlay) -> None:
    run = play(SUMS)
    assert run.tick() == ["Show 11.5"]
    put(run, "Show.b", 2)
    assert run.tick() == ["Show 13"]
    run.session.stop()
    assert run.tick()[-1] == "Show 13"


@pytest.mark.parametrize(("address", "shown"), [("One.value", "Show 15.5"), ("g0/Two.inputs:b", "Show 6.5")])
def test_constant_nodes_are_computed_again(play: MakePlay, address: str, shown: str) -> None:
    run = play(SUMS)
    run.tick()
    put(run, address, 5.0)
    assert run.tick() == [shown]


def test_a_node_that_reads_an_input_in_setup_is_set_up_again(play: MakePlay) -> None:
    run = play(TOPICS)
    run.tick()
    put(run, "Second.topic", "pose")
    put(run, "Text.b", "ans")
    assert run.tick() == ["Second opens /pose", "First opens /scans", "First sends on /scans", "Second sends on /pose"]


def test_after_a_failed_setup_the_input_has_its_old_value(play: MakePlay) -> None:
    run = play(TOPICS)
    run.tick()
    with pytest.raises(GraphError, match="this topic is forbidden"):
        put(run, "Second.topic", "forbidden")
    assert run.lines() == ["Second opens /odom"]
    assert run.tick() == ["First sends on /scan", "Second sends on /odom"]


def test_a_glob_sets_all_inputs_that_it_matches(play: MakePlay) -> None:
    run = play(SUMS, SUMS)
    put(run, "*/Show.b", 1.0)
    assert run.tick() == ["Show 12", "Show 12"]


@pytest.mark.parametrize(
    ("address", "value", "words"),
    [
        ("Show.a", 1.0, "g0/Show.a is wired: Two.sum -> Show.a"),
        ("Shwo.b", 1.0, "no node 'Shwo'\n  did you mean 'Show'?"),
        ("Show.sum", 1.0, "Do has no input 'sum'"),
        ("Show", 1.0, "write NODE.PORT"),
        ("Show.b", "fast", "g0/Show.b is a double: expected a number, got 'fast'"),
        ("Second.topic", 1.0, "g1/Second.topic is a string: expected"),
    ],
)
def test_an_illegal_set_is_reported_and_changes_nothing(play: MakePlay, address: str, value: Any, words: str) -> None:
    run = play(SUMS, TOPICS)
    with pytest.raises(UsageError) as caught:
        put(run, address, value)
    assert words in str(caught.value)
    assert run.tick()[-3] == "Show 11.5"


def test_an_unambiguous_end_of_an_address_finds_a_port(play: MakePlay) -> None:
    run = play(SUMS, SUMS)
    run.tick()
    graphs = run.session.graphs
    assert find_port_at(graphs, "g1/Show.sum").value == 11.5
    assert find_port_at(graphs, "g0/Two.inputs:b").value == 10.0
    assert [port.address for port in find_ports(graphs, "Show.*")][:2] == ["g0/Show.sum", "g0/Show.a"]
    with pytest.raises(UsageError, match=r"Show\.sum could mean 2 ports\n  write one of: g0/Show\.sum, g1/Show\.sum"):
        find_port_at(graphs, "Show.sum")
    with pytest.raises(UsageError, match="Do has no port with a value 'execIn'"):
        find_port_at(graphs, "g0/Show.execIn")


def test_a_failed_session_refuses_commands_until_its_time_is_reset(play: MakePlay) -> None:
    run = play("""
        nodes: {Tick: Tick, Raise: {type: Raise, inputs: {at: 2.0}}}
        connections: [Tick.tick -> Raise.execIn]
    """)
    with pytest.raises(GraphError):
        run.session.step(2)
    assert find_port_at(run.session.graphs, "Raise.count").value == 2.0
    for name, arguments in (("set", {"address": "Raise.at", "value": 9.0}), ("play", {}), ("step", {})):
        with pytest.raises(StateError, match="the session failed; reset it first"):
            parse(name, arguments).apply(run.session)
    with pytest.raises(StateError, match="reset it with the scope `time` to continue"):
        run.session.reset("state")
    run.session.reset()
    assert run.session.state == "paused"
    put(run, "Raise.at", 9.0)
    run.session.step(3)
