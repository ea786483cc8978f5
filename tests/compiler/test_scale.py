"""Long, wide and tangled graphs: compiled and run; the generated text grows with the graph and not faster."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphengine.compiler.codegen import source_of
from graphengine.compiler.digraph import Digraph
from graphengine.compiler.planning.regions import MAX_PUSHERS
from graphengine.format.diagnostics import Findings
from tests.compiler.harness import Bench, planned, write


def make(folder: Path, nodes: list[str], wires: list[str]) -> Bench:
    path = folder / "g.yaml"
    lines = ["graph: g", "nodes:", *(f"  {node}" for node in nodes), "connections:", *(f"  - {wire}" for wire in wires)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Bench(path).setup()


def size(run: Bench) -> int:
    """Lines of the generated text for each node."""
    return len(source_of(run.plan).lines) // len(run.executor.nodes)


def test_a_chain_of_2000_executed_nodes(tmp_path: Path) -> None:
    n = 2000
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"N{i}: {{type: Sum, inputs: {{b: 1.0}}}}" for i in range(n)), "Show: Do"],
        ["Tick.tick -> N0.execIn"]
        + [f"N{i}.execOut -> N{i + 1}.execIn" for i in range(n - 1)]
        + [f"N{i}.sum -> N{i + 1}.a" for i in range(n - 1)]
        + [f"N{n - 1}.execOut -> Show.execIn", f"N{n - 1}.sum -> Show.a"],
    )
    assert run.tick() == ["Show 2000"]
    assert size(run) < 10


def test_a_chain_of_2000_data_nodes(tmp_path: Path) -> None:
    n = 2000
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"N{i}: {{type: Add, inputs: {{b: 1.0}}}}" for i in range(n)), "Show: Do"],
        ["Tick.tick -> Show.execIn", "Tick.number -> N0.a", f"N{n - 1}.sum -> Show.a"]
        + [f"N{i}.sum -> N{i + 1}.a" for i in range(n - 1)],
    )
    assert run.ticks(2) == [["Show 2001"], ["Show 2002"]]
    assert size(run) < 10


def test_a_chain_in_which_each_data_node_adds_what_an_executed_one_gave(tmp_path: Path) -> None:
    n = 300
    run = make(
        tmp_path,
        ["Tick: Tick", "Show: Do"]
        + [f"S{i}: {{type: Sum, inputs: {{b: 1.0}}}}" for i in range(n)]
        + [f"A{i}: Add" for i in range(n)],
        ["Tick.tick -> S0.execIn", f"S{n - 1}.execOut -> Show.execIn", f"A{n - 1}.sum -> Show.a"]
        + [f"S{i}.execOut -> S{i + 1}.execIn" for i in range(n - 1)]
        + [f"S{i}.sum -> A{i}.a" for i in range(n)]
        + [f"A{i}.sum -> A{i + 1}.b" for i in range(n - 1)],
    )
    assert run.tick() == ["Show 300"]


def test_300_branches_in_a_row(tmp_path: Path) -> None:
    n = 300
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"B{i}: {{type: Branch, inputs: {{condition: true}}}}" for i in range(n))]
        + [f"No{i}: Do" for i in range(n)],
        ["Tick.tick -> B0.execIn"]
        + [f"B{i}.execTrue -> B{i + 1}.execIn" for i in range(n - 1)]
        + [f"B{i}.execFalse -> No{i}.execIn" for i in range(n)],
    )
    assert len(run.tick()) == n
    run["B150"].condition = False
    assert run.tick()[-2:] == ["B150 False", "No150 0"]
    deepest = max(len(line) - len(line.lstrip()) for line in source_of(run.plan).lines)
    assert deepest <= 20  # nothing nests: CPython does not compile 100 nested blocks


def sums_and_branches(n: int) -> tuple[list[str], list[str]]:
    """A chain of sums, and branches that one tick fires; each branch fires a node, which prints."""
    nodes = [f"{kind}{i}: {kind}" for kind in ("Add", "Branch", "Do") for i in range(n)]
    wires = ["Tick.number -> Add0.a", *(f"Add{i}.sum -> Add{i + 1}.a" for i in range(n - 1))]
    wires += [f"Branch{i}.execTrue -> Do{i}.execIn" for i in range(n)]
    return ["Tick: Tick", *nodes], wires


def at_once(n: int) -> list[str]:
    return [f"Tick.tick -> Branch{i}.execIn" for i in range(n)]


def one_after_the_other(n: int) -> list[str]:
    return ["Tick.tick -> Branch0.execIn", *(f"Branch{i}.execFalse -> Branch{i + 1}.execIn" for i in range(n - 1))]


def the_last_sum(n: int) -> list[str]:
    return [f"Add{n - 1}.sum -> Do{i}.a" for i in range(n)]


def all_sums_from_the_last(n: int) -> list[str]:
    return [f"Add{n - 1 - i}.sum -> Do{i}.a" for i in range(n)]


def sums_of_what_branches_computed(n: int) -> list[str]:
    return [f"Do{i}.sum -> Add{i}.b" for i in range(n)] + [f"Add{i}.sum -> Do{i + 1}.a" for i in range(n - 1)]


@pytest.mark.parametrize("fire", [at_once, one_after_the_other])
@pytest.mark.parametrize("read", [the_last_sum, all_sums_from_the_last, sums_of_what_branches_computed])
def test_the_code_of_sums_that_are_read_behind_branches_grows_with_the_graph(
    tmp_path: Path, fire: Callable[[int], list[str]], read: Callable[[int], list[str]]
) -> None:
    sizes = []
    for n in (50, 100):
        nodes, wires = sums_and_branches(n)
        sizes.append(size(make(tmp_path, nodes, [*wires, *fire(n), *read(n)])))
    assert sizes[1] <= sizes[0] + 1
    assert sizes[1] < 15


def test_2000_sums_that_two_branches_read_are_computed_once_and_only_when_a_branch_is_taken(tmp_path: Path) -> None:
    n = 2000
    nodes = ["Tick: Tick", *(f"N{i}: {{type: Add, inputs: {{b: 1.0}}}}" for i in range(n))]
    nodes += ["Left: Branch", "Right: Branch", "One: Do", "Two: Do"]
    wires = ["Tick.number -> N0.a", *(f"N{i}.sum -> N{i + 1}.a" for i in range(n - 1))]
    wires += ["Tick.tick -> Left.execIn", "Tick.tick -> Right.execIn"]
    wires += ["Left.execTrue -> One.execIn", "Right.execTrue -> Two.execIn"]
    run = make(tmp_path, nodes, [*wires, f"N{n - 1}.sum -> One.a", f"N{n - 1}.sum -> Two.a"])
    assert run.tick() == ["Left False", "Right False"]
    assert run["N0"].sum == 0.0
    run["Right"].condition = True
    assert run.tick() == ["Left False", "Right True", "Two 2002"]
    run["Left"].condition = True
    counted: list[int] = []

    def count(index: int, compute: Callable[[], Any]) -> Callable[[], Any]:
        def counting() -> Any:
            counted.append(index)
            return compute()

        return counting

    observe = run.executor.observe(count)
    observe(True)
    assert run.tick()[-1] == "Two 2003"
    assert counted.count(run.index("N7")) == 1
    observe(False)
    computed = run["N7"].computes
    assert run.tick() == ["Left True", "Right True", "One 2004", "Two 2004"]
    assert run["N7"].computes == computed + 1


def test_a_branch_below_a_branch_computes_nothing_again(tmp_path: Path) -> None:
    nodes = ["Tick: Tick", "Add: Add", "Outer: Branch", "Inner: Branch", "One: Do", "Two: Do"]
    wires = ["Tick.number -> Add.a", "Tick.tick -> Outer.execIn", "Outer.execTrue -> One.execIn"]
    wires += ["Outer.execTrue -> Inner.execIn", "Inner.execTrue -> Two.execIn", "Add.sum -> One.a", "Add.sum -> Two.a"]
    run = make(tmp_path, nodes, wires)
    text = source_of(run.plan).text
    assert text.count(f"c{run.index('Add')}()") == 1
    assert "refresh" not in text


def test_200_pushers_that_share_a_tail(tmp_path: Path) -> None:
    pushers, tail = 200, 100
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"P{i}: Sequence" for i in range(pushers)), *(f"T{i}: Sum" for i in range(tail)), "Show: Do"],
        [f"Tick.tick -> P{i}.execIn" for i in range(pushers)]
        + [f"P{i}.{port} -> T0.execIn" for i in range(pushers) for port in "ac"]
        + [f"T{i}.execOut -> T{i + 1}.execIn" for i in range(tail - 1)]
        + [f"T{tail - 1}.execOut -> Show.execIn"],
    )
    assert len(run.tick()) == 2 * pushers
    assert size(run) < 10


def test_200_pushers_in_a_row(tmp_path: Path) -> None:
    n = 200
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"P{i}: Sequence" for i in range(n)), "Show: Do"],
        ["Tick.tick -> P0.execIn"]
        + [f"P{i}.b -> P{i + 1}.execIn" for i in range(n - 1)]
        + [f"P{n - 1}.a -> Show.execIn"],
    )
    assert run.tick() == ["Show 0"]


def test_2000_nodes_that_one_tick_fires(tmp_path: Path) -> None:
    n = 2000
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"N{i}: Counter" for i in range(n)), "Join: Join"],
        [f"Tick.tick -> N{i}.execIn" for i in range(n)] + [f"N{i}.execOut -> Join.first" for i in range(n)],
    )
    assert run.tick()[-1] == "Join first=2000 second=0 hold=0"


def test_control_wires_that_lead_forward_are_ordered_without_a_search_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    n, has_path = 300, Digraph.has_path
    searches: list[tuple[int, int]] = []

    def counted(graph: Digraph, source: int, target: int) -> bool:
        searches.append((source, target))
        return has_path(graph, source, target)

    monkeypatch.setattr(Digraph, "has_path", counted)
    chain = [f"N{i}.execOut -> N{i + 1}.execIn" for i in range(n - 1)]
    resets = [f"Tick.tick -> N{i}.reset" for i in range(n)]
    back = f"N{n - 1}.execOut -> N0.reset"
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"N{i}: Counter" for i in range(n))],
        ["Tick.tick -> N0.execIn", *chain, *resets, back],
    )
    assert searches == [(run.index("N0"), run.index(f"N{n - 1}"))]


@pytest.mark.parametrize(("depth", "codes"), [(MAX_PUSHERS, []), (MAX_PUSHERS + 1, ["G105"])])
def test_pushers_below_pushers_run_to_a_depth_and_beyond_it_are_refused(
    tmp_path: Path, depth: int, codes: list[str]
) -> None:
    nodes = ["T: Tick", *(f"M{i}: Sequence" for i in range(depth)), "Do: Do"]
    wires = ["T.tick -> M0.execIn", *(f"M{i}.a -> M{i + 1}.execIn" for i in range(depth - 1))]
    wires.append(f"M{depth - 1}.a -> Do.execIn")
    path = write(tmp_path, "nodes:\n  " + "\n  ".join(nodes) + "\nconnections: [" + ", ".join(wires) + "]\n")
    findings = Findings()
    planned(path, findings)
    assert [found.code for found in findings.errors] == codes
    if not codes:
        assert Bench(path).setup().tick() == ["Do 0"]


def test_no_generated_function_has_thousands_of_variables(tmp_path: Path) -> None:
    n = 3000
    run = make(
        tmp_path,
        ["Tick: Tick", *(f"B{i}: {{type: Branch, inputs: {{condition: true}}}}" for i in range(n)), "Show: Do"],
        ["Tick.tick -> B0.execIn", f"B{n - 1}.execTrue -> Show.execIn"]
        + [f"B{i}.execTrue -> B{i + 1}.execIn" for i in range(n - 1)],
    )
    assert run.tick() == [*(f"B{i} True" for i in range(n)), "Show 0"]
    codes = [const for const in source_of(run.plan).code.co_consts if hasattr(const, "co_nlocals")]
    assert max(code.co_nlocals for code in codes) < 1000
