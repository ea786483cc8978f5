"""R12: nodes that are called again in later ticks."""

from __future__ import annotations

from tests.compiler.conftest import MakeBench

ONCE = """
    nodes:
      Go: {type: Every, inputs: {n: 1}}
      Tick: Tick
      Delay: {type: Delay, inputs: {duration: 0.03}}
      End: Do
      Each: Do
    connections:
      - Go.fired -> Delay.execIn
      - Delay.finished -> End.execIn
      - Tick.tick -> Each.execIn
"""


def test_r12_the_end_of_a_latent_node_is_an_event_of_the_next_pass(bench: MakeBench) -> None:
    run = bench(ONCE)
    first = run.tick()
    run["Go"].n = 1000
    assert [first, *run.ticks(5)] == [
        ["Each 0"],
        ["Each 0"],
        ["Each 0"],
        ["Each 0", "Delay ends"],
        ["End 0", "Each 0"],
        ["Each 0"],
    ]


def test_r12_a_new_activation_starts_it_again(bench: MakeBench) -> None:
    run = bench(ONCE)
    run.ticks(3)  # started in each
    run["Go"].n = 1000
    lines = [line for lines in run.ticks(5) for line in lines if line != "Each 0"]
    assert lines == ["Delay ends", "End 0"]
    assert run["Delay"].started == 0.03


def test_r12_a_latent_node_fires_several_ports_one_or_both(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Go: {type: Every, inputs: {n: 1}}, Stages: {type: Stages, inputs: {plan: '01230'}}, A: Do, B: Do}
        connections:
          - Go.fired -> Stages.execIn
          - Stages.first -> A.execIn
          - Stages.second -> B.execIn
    """)
    first = run.tick()
    run["Go"].n = 1000
    assert [first, *run.ticks(5)] == [[], [], ["A 0"], ["B 0"], ["A 0", "B 0"], []]


def test_r12_a_latent_node_whose_first_port_leads_nowhere_fires_the_second(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Go: {type: Every, inputs: {n: 1}}, Stages: {type: Stages, inputs: {plan: '1020'}}, B: Do}
        connections:
          - Go.fired -> Stages.execIn
          - Stages.second -> B.execIn
    """)
    run.tick()
    run["Go"].n = 1000
    assert run.ticks(5) == [[], [], ["B 0"], [], []]


def test_r12_latent_outputs_never_order(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Reader: Do, Delay: {type: Delay, inputs: {duration: 9.0}}}
        connections:
          - Tick.tick -> Reader.execIn
          - Reader.execOut -> Delay.execIn
          - Delay.updates -> Reader.a
    """)
    assert run.codes == []
    assert run.ticks(3) == [["Reader 0"], ["Reader 1"], ["Reader 2"]]


def test_r12_several_latent_nodes_are_updated_in_the_order_they_started(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Early: {type: Delay, inputs: {duration: 0.0}}, Late: {type: Delay, inputs: {duration: 0.0}}}
        connections:
          - Tick.tick -> Late.execIn
          - Tick.tick -> Early.execIn
    """)
    assert run.tick() == ["Late ends", "Early ends"]


def test_r12_what_a_latent_node_below_a_pusher_fires_runs_once_in_the_next_pass(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Go: {type: Every, inputs: {n: 1}}, ForLoop: ForLoop, Delay: {type: Delay, inputs: {duration: 0.0}}, End: Join}
        connections:
          - Go.fired -> ForLoop.execIn
          - ForLoop.loopBody -> Delay.execIn
          - Delay.finished -> End.first
          - ForLoop.finished -> End.second
    """)
    assert run.tick() == ["End first=0 second=1 hold=0", "Delay ends"]
    run["Go"].n = 1000
    assert run.ticks(2) == [["End first=1 second=0 hold=0"], []]


def test_r12_a_latent_node_that_counting_nodes_listen_to_counts_once(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Delay: {type: Delay, inputs: {duration: 0.0}}, Counter: Counter}
        connections:
          - Tick.tick -> Delay.execIn
          - Delay.finished -> Counter.execIn
          - Tick.tick -> Counter.second
    """)
    run.tick()
    assert run["Counter"].count == 1.0
    run.tick()
    assert run["Counter"].count == 3.0


def test_r12_stop_ends_latent_nodes_and_forgets_what_they_fired(bench: MakeBench) -> None:
    run = bench(ONCE.replace("0.03", "0.0"))
    assert run.tick() == ["Each 0", "Delay ends"]
    run["Go"].n = 1000
    run.stop()
    assert run.ticks(2) == [["Each 0"], ["Each 0"]]


def test_r12_a_latent_node_that_nothing_starts_does_not_make_its_followers_reachable(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, A: Do, Delay: Delay, Lost: Do}
        connections:
          - Tick.tick -> A.execIn
          - Delay.finished -> Lost.execIn
    """)
    assert [run.graph.instances[i].id for i in run.plan.order] == ["Tick", "A"]
