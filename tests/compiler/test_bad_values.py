"""R14: a value from a wire that a node cannot use ends the node's branch for this tick, and nothing else."""

from __future__ import annotations

import pytest

from graphengine.format.errors import NodeError
from tests.compiler.conftest import MakeBench, MakeFile, MakePlay
from tests.compiler.harness import Bench, Play

BRANCH = """
    nodes:
      Tick: Tick
      Refuses: {type: Refuses, inputs: {bad: 2.0}}
      Below: Do
      Beside: Do
    connections:
      - Tick.tick -> Refuses.execIn
      - Tick.number -> Refuses.value
      - Refuses.execOut -> Below.execIn
      - Tick.tick -> Beside.execIn
      - Refuses.shown -> Beside.a
"""


def counts(run: Bench | Play) -> dict[str, int]:
    assert run.services.dropped is not None
    return {path.rpartition("/")[2]: ticks for path, ticks in run.services.dropped.ticks.items()}


def test_a_literal_is_a_fault(bench: MakeBench) -> None:
    run = bench(BRANCH.replace("      - Tick.number -> Refuses.value\n", "").replace("bad: 2.0", "bad: 0.0"))
    with pytest.raises(NodeError, match=r"node Refuses .* raised BadValueError: value cannot be 0.0"):
        run.tick()
    assert counts(run) == {}


def test_a_constant_is_checked_before_the_first_tick(file: MakeFile) -> None:
    run = Bench(
        file("""
        nodes: {Tick: Tick, Zero: {type: Whole, inputs: {value: 0}}, Inverse: RefusesZero, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Zero.out -> Inverse.value
          - Inverse.result -> Show.a
    """)
    )
    with pytest.raises(NodeError, match=r"node Inverse .* value cannot be 0.0"):
        run.setup()


def test_another_exception_still_ends_the_run(bench: MakeBench) -> None:
    run = bench(BRANCH.replace("bad: 2.0", "bad: -1.0"))
    run["Below"].a = None
    with pytest.raises(NodeError, match=r"node Below "):
        run.tick()


def test_with_the_option_stop_a_bad_value_ends_the_run(file: MakeFile) -> None:
    run = Bench(file(BRANCH), bad_values="stop").setup()
    run.tick()
    with pytest.raises(NodeError, match=r"node Refuses .* raised BadValueError: value cannot be 2.0") as caught:
        run.tick()
    assert "at tick 2" in str(caught.value)


def test_with_stop_and_keep_going_a_bad_value_is_a_fault(file: MakeFile) -> None:
    run = Bench(file(BRANCH), keep_going=True, bad_values="stop").setup()
    assert run.ticks(2)[1] == ["Beside 1"]
    assert ["BadValueError" in str(fault) for fault in run.faults] == [True]


def test_a_run_that_keeps_going_drops_values_and_reports_faults(file: MakeFile) -> None:
    run = Bench(file(BRANCH), keep_going=True).setup()
    run.ticks(2)
    assert (counts(run), run.faults) == ({"Refuses": 1}, [])


def test_bad_values_cause_warnings_at_counts_1_2_4_8(bench: MakeBench) -> None:
    run = bench(BRANCH.replace("bad: 2.0", "bad: 2.0, from: 2.0"))
    said: list[tuple[str, str, str]] = []
    run.services.log = lambda *message: said.append(message)
    run.ticks(40)
    assert counts(run) == {"Refuses": 39}
    ticks = [int(text.partition("dropped at tick ")[2].split("\n")[0].split(",")[0]) for _, _, text in said]
    assert ticks == [2, 3, 5, 9, 17, 33]  # the 1st, 2nd, 4th, 8th, 16th and 32nd
    severity, node, text = said[2]
    assert (severity, node) == ("warning", "/World/g/Refuses")
    first, place = text.split("\n  ")
    assert first == "value cannot be 5.0; dropped at tick 5, as in 3 of the ticks before"
    assert place.endswith("g.yaml:4:3: test.Refuses in graph g")
    assert run.journal.logged == [f"{severity}: {node}: {text}" for severity, node, text in said]


NAMES_TOPICS = """
    nodes: {Tick: Tick, Spell: Spell, Announce: {type: Announces, inputs: {forbidden: t2}}, After: Do}
    connections:
      - Tick.tick -> Spell.execIn
      - Spell.execOut -> Announce.execIn
      - Announce.execOut -> After.execIn
      - Spell.text -> Announce.topic
"""


def test_a_name_over_a_wire_that_setup_refuses_is_dropped(bench: MakeBench) -> None:
    run = bench(NAMES_TOPICS)
    run.journal.read()
    assert run.ticks(3) == [["Announce sends on t1", "After 0"], [], ["Announce sends on t3", "After 0"]]
    assert counts(run) == {"Announce": 1}
    assert "topic cannot be 't2': no such topic" in run.journal.logged[0]


def test_a_session_of_several_graphs_goes_on_in_all_of_them(play: MakePlay) -> None:
    run = play(BRANCH, BRANCH.replace("bad: 2.0", "bad: 3.0"))
    assert [run.tick() for _ in range(3)] == [
        ["Below 0", "Beside 1"] * 2,
        ["Beside 1", "Below 0", "Beside 2"],
        ["Below 0", "Beside 3", "Beside 2"],
    ]
    assert run.services.dropped is not None
    assert run.services.dropped.ticks == {"/World/g0/Refuses": 1, "/World/g1/Refuses": 1}
