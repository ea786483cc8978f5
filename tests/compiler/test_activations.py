"""How often a node computes, and what it sees of the wires that fired it (R6, R7)."""

from __future__ import annotations

from tests.compiler.conftest import MakeBench

# R6: control pins


def test_r6_a_control_pin_acts_before_the_pins_that_fire_with_it(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Gate: Gate, A: Do}
        connections:
          - Tick.tick -> Gate.enter
          - Tick.tick -> Gate.toggle
          - Gate.exit -> A.execIn
    """)
    assert run.ticks(3) == [["Gate opens", "A 0"], ["Gate closes"], ["Gate opens", "A 0"]]


def test_r6_a_control_wire_that_closes_a_cycle_acts_for_the_next_activation(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Gate: Gate, A: Do}
        connections:
          - Tick.tick -> Gate.enter
          - Gate.exit -> A.execIn
          - A.execOut -> Gate.toggle
    """)
    run["Gate"].open = True
    assert run.codes == []
    assert run.ticks(3) == [["A 0"], ["Gate closes"], []]


def test_r6_an_ordinary_node_sees_its_pending_control_pin_once(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Every: {type: Every, inputs: {n: 1}}, Join: Join, Door: Door}
        connections:
          - Every.fired -> Join.first
          - Join.execOut -> Door.execIn
          - Door.execOut -> Join.hold
    """)
    assert run.tick() == ["Join first=1 second=0 hold=0"]
    run["Door"].open = False
    assert run.tick() == ["Join first=1 second=0 hold=1"]
    assert run.tick() == ["Join first=1 second=0 hold=0"]


def test_r6_a_pending_control_pin_waits_for_an_activation(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: Door, Join: Join, After: Do}
        connections:
          - Tick.tick -> Door.execIn
          - Door.execOut -> Join.second
          - Join.execOut -> After.execIn
          - After.execOut -> Join.hold
    """)
    assert run.tick()[0] == "Join first=0 second=1 hold=0"
    run["Door"].open = False
    assert run.ticks(2) == [[], []]
    run["Door"].open = True
    assert run.tick()[0] == "Join first=0 second=1 hold=1"


# R7: counts


def test_r7_an_ordinary_node_computes_once_and_sees_how_often_it_was_fired(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Join: Join}
        connections:
          - One.tick -> Join.first
          - Two.tick -> Join.first
          - Two.tick -> Join.second
    """)
    assert run.ticks(2) == [["Join first=2 second=1 hold=0"]] * 2


def test_r7_a_node_that_counts_computes_once_for_each_activation_in_order_of_wires(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter}
        connections:
          - Two.tick -> Counter.second
          - One.tick -> Counter.execIn
    """)
    assert run.ticks(2) == [
        ["Counter in=0 second=1 reset=0 count=1", "Counter in=1 second=0 reset=0 count=2"],
        ["Counter in=0 second=1 reset=0 count=3", "Counter in=1 second=0 reset=0 count=4"],
    ]


def test_r7_control_activations_come_first_whatever_the_order_of_wires(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter}
        connections:
          - One.tick -> Counter.execIn
          - Two.tick -> Counter.reset
    """)
    once = ["Counter in=0 second=0 reset=1 count=0", "Counter in=1 second=0 reset=0 count=1"]
    assert run.ticks(2) == [once, once]


def test_r7_a_counting_node_counts_the_activations_of_a_counting_node(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, First: Counter, Second: Counter}
        connections:
          - One.tick -> First.execIn
          - Two.tick -> First.execIn
          - First.execOut -> Second.execIn
          - Two.tick -> Second.second
    """)
    assert run.tick()[-1] == "Second in=0 second=1 reset=0 count=3"
    assert run["Second"].count == 3.0


def test_r7_activations_of_untaken_branches_do_not_count(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: {type: Door, inputs: {open: false}}, Counter: Counter}
        connections:
          - Tick.tick -> Counter.execIn
          - Tick.tick -> Door.execIn
          - Door.execOut -> Counter.second
    """)
    assert run.ticks(2) == [
        ["Counter in=1 second=0 reset=0 count=1"],
        ["Counter in=1 second=0 reset=0 count=2"],
    ]


def test_r7_a_counting_node_in_a_loop_counts_iterations(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Counter: Counter, Show: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Counter.execIn
          - ForLoop.finished -> Show.execIn
          - Counter.count -> Show.a
          - Tick.tick -> Counter.second
    """)
    run.tick()
    assert run["Counter"].count == 4.0


def test_r7_each_activation_sees_data_that_the_one_before_changed(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter, Next: {type: Add, inputs: {b: 1.0}}}
        connections:
          - One.tick -> Counter.execIn
          - Two.tick -> Counter.second
          - Counter.count -> Next.a
          - Next.sum -> Counter.step
    """)
    run.tick()
    assert run["Counter"].count == 3.0  # 0 + (0 + 1), then 1 + (1 + 1)


def test_r7_a_node_sees_how_often_a_counting_node_fired_its_only_wire(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter, Second: Counter, Join: Join}
        connections:
          - One.tick -> Counter.execIn
          - Two.tick -> Counter.second
          - Counter.execOut -> Second.execIn
          - Counter.execOut -> Join.first
    """)
    run.tick()
    assert run["Second"].count == 2.0
    assert run.tick()[-1] == "Join first=2 second=0 hold=0"
