"""What the engine costs: generated ticks of DAGs of adds against a hand-written loop over the same adds, in one run;
and how long a graph with branches, gates, variables and types to be told takes from its file to the first tick.

`python tests/bench/engine.py` prints ratios; nothing is asserted, because the machine is not ours alone.
"""

from __future__ import annotations

import gc
import itertools
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from graphengine.compiler.library import GraphLibrary
from graphengine.compiler.planning import share_plans
from graphengine.compiler.registry import Registry, default_registry
from graphengine.compiler.resolve import resolve
from graphengine.compiler.subgraph_expansion import load_graph
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.messages.endpoints import Network
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out
from graphengine.node.clock import Clock
from graphengine.node.context.context import Context
from graphengine.node.context.session_services import Services
from graphengine.runtime.executor import Executor
from graphengine.runtime.graph_run import make_graph_run
from graphengine.runtime.node_faults import NodeFaults


class Tick(Node, type="bench.Tick"):
    """Fires every pass."""

    tick = ExecOut()
    value: float = Out()

    def compute(self) -> None:
        """Count."""
        self.value += 1.0


class Add(Node, type="bench.Add"):
    """Sum of two numbers, when executed."""

    exec_in = ExecIn()
    a: float = In(default=0.0)
    b: float = In(default=0.0)
    value: float = Out()
    exec_out = ExecOut()

    def compute(self) -> None:
        """Add."""
        self.value = self.a + self.b


class Branch(Node, type="bench.Branch"):
    """Fires one way or the other."""

    exec_in = ExecIn()
    condition: bool = In(default=True)
    exec_true = ExecOut()
    exec_false = ExecOut()

    def compute(self) -> Fire:
        """Choose."""
        return self.exec_true if self.condition else self.exec_false


def dag(size: int, gated: bool) -> str:
    """Adds in a row, x[i] = x[i-1] + x[i-7]; when gated, the second half hangs on a branch."""
    nodes = ["  T: bench.Tick", *(f"  N{i}: bench.Add" for i in range(1, size + 1))]
    wires = []
    if gated:
        nodes.append("  B: bench.Branch")
        wires.append("  - T.tick -> B.execIn")
    for i in range(1, size + 1):
        for port, source in (("a", i - 1), ("b", max(0, i - 7))):
            wires.append(f"  - {f'N{source}' if source else 'T'}.value -> N{i}.{port}")
        wires.append(f"  - {'B.execTrue' if gated and i > size // 2 else 'T.tick'} -> N{i}.execIn")
    return "\n".join(["graph: dag", "nodes:", *nodes, "connections:", *wires])


def generated(size: int, gated: bool) -> tuple[Callable[[], None], Executor]:
    """The pass of a DAG."""
    registry = Registry()
    for cls in (Tick, Add, Branch):
        registry.add(cls)
    findings = Findings()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dag.yaml"
        path.write_text(dag(size, gated))
        flat = load_graph(path, {}, GraphLibrary(Files.of(path)), findings)
        assert flat is not None
        planned = share_plans([resolve(flat, "dag", "/dag", registry, findings)], findings)
    findings.raise_errors()
    nodes = [instance.make_node() for instance in planned[0].instances]
    faults = NodeFaults(planned[0], nodes, lambda: (0, 0.0))
    executor = Executor(planned[0], nodes, lambda index: _no_context(), faults)
    executor.setup()
    return executor.run_pass, executor


def _no_context() -> Context:
    return Context.__new__(Context)


def by_hand(size: int) -> tuple[Callable[[], None], list[float]]:
    """The same adds as a loop over a list."""
    values = [0.0] * (size + 1)
    triples = [(i, i - 1, max(0, i - 7)) for i in range(1, size + 1)]

    def loop() -> None:
        values[0] += 1.0
        for out, a, b in triples:
            values[out] = values[a] + values[b]

    return loop, values


def branching(size: int) -> str:
    """Groups of a sum, a comparison, a branch, a gate and a variable that is written; each group follows the one before."""
    nodes, wires = ["  Tick: OnPlaybackTick"], []
    execution, value = "Tick.tick", "Tick.frame"
    for i in range(size // 5):
        nodes += [
            f"  Add{i}: Add",
            f"  Compare{i}: {{type: Compare, inputs: {{operation: '<'}}}}",
            f"  Branch{i}: Branch",
        ]
        nodes += [f"  Gate{i}: IsaacSimulationGate"]
        nodes += [f"  Write{i}: {{type: omni.graph.core.WriteVariable, inputs: {{variableName: x}}}}"]
        wires += [f"{value} -> {end}" for end in (f"Add{i}.a", f"Add{i}.b", f"Compare{i}.b")]
        wires += [
            f"Add{i}.sum -> Compare{i}.a",
            f"Compare{i}.result -> Branch{i}.condition",
            f"Add{i}.sum -> Write{i}.value",
        ]
        wires += [f"{execution} -> Branch{i}.execIn", f"Branch{i}.execFalse -> Gate{i}.execIn"]
        wires += [f"Branch{i}.execTrue -> Write{i}.execIn", f"Gate{i}.execOut -> Write{i}.execIn"]
        execution, value = (f"Write{i}.execOut", value) if i % 5 else ("Tick.tick", f"Add{i}.sum")
    lines = [*nodes, "connections:", *(f"  - {wire}" for wire in wires)]
    return "\n".join(["graph: branching", "variables: {x: {type: double}}", "nodes:", *lines])


def chain(size: int) -> str:
    """Sums in a row, of which each gets its type from the one before."""
    nodes = ["  Tick: OnPlaybackTick", *(f"  N{i}: Add" for i in range(size)), "  Show: ToString"]
    sources = ["Tick.frame", *(f"N{i}.sum" for i in range(size))]
    wires = [f"  - {sources[i]} -> N{i}.{port}" for i in reversed(range(size)) for port in "ab"]
    return "\n".join(["graph: chain", "nodes:", *nodes, "connections:", *wires, f"  - {sources[-1]} -> Show.value"])


def built(text: str) -> tuple[float, float]:
    """Processor seconds from the file to the first tick, and of a pass."""
    findings = Findings()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "graph.yaml"
        path.write_text(text)
        start = time.process_time()
        flat = load_graph(path, {}, GraphLibrary(Files.of(path)), findings)
        assert flat is not None
        planned = share_plans([resolve(flat, "graph", "/graph", default_registry(), findings)], findings)
    findings.raise_errors()
    clock = Clock((1, 60))
    run = make_graph_run(planned[0], Services(DryWorld(Stage()), Network()), clock)
    run.executor.setup()
    needed = time.process_time() - start
    clock.set_frame(1)
    return needed, min(seconds(run.executor.run_pass, 20) for _ in range(20))


def seconds(function: Callable[[], None], repeats: int) -> float:
    """Processor time of one call."""
    start = time.process_time()
    for _ in range(repeats):
        function()
    return (time.process_time() - start) / repeats


def compare(size: int, gated: bool, rounds: int = 15) -> tuple[float, float]:
    """Median ratio of interleaved rounds, and the engine's microseconds a pass at its best."""
    run, executor = generated(size, gated)
    loop, values = by_hand(size)
    repeats = max(20, 40_000 // size)
    ratios, best = [], float("inf")
    for _ in range(rounds):
        hand, engine = seconds(loop, repeats), seconds(run, repeats)
        ratios.append(engine / hand)
        best = min(best, engine)
    if executor.nodes[size].value != values[size]:  # type: ignore[attr-defined]
        raise SystemExit("the engine and the loop disagree")
    return statistics.median(ratios), best * 1e6


def csp_microseconds(size: int) -> float | None:
    """The same DAG of csp's Python nodes, microseconds a tick; None where csp is not installed."""
    try:
        import csp
        from csp import ts
    except ImportError:
        return None
    from datetime import datetime, timedelta

    @csp.node
    def add(a: ts[float], b: ts[float]) -> ts[float]:
        if csp.ticked(a, b) and csp.valid(a, b):
            return a + b

    @csp.graph
    def chain() -> None:
        cells = [csp.count(csp.timer(timedelta(microseconds=1))) * 1.0]
        for i in range(1, size + 1):
            cells.append(add(cells[i - 1], cells[max(0, i - 7)]))
        csp.add_graph_output("out", cells[-1])

    ticks = max(2000, 200_000 // size)
    start = time.perf_counter()
    csp.run(chain, starttime=datetime(2024, 1, 1), endtime=timedelta(microseconds=ticks))
    return (time.perf_counter() - start) / ticks * 1e6


def py_trees_microseconds(size: int) -> float | None:
    """A py_trees sequence of as many behaviours, microseconds a tick; None where py_trees is not installed."""
    try:
        import py_trees
    except ImportError:
        return None
    values = [0.0] * (size + 1)

    class AddBehaviour(py_trees.behaviour.Behaviour):  # type: ignore[misc]
        def __init__(self, out: int, a: int, b: int) -> None:
            super().__init__(f"add{out}")
            self.cells = (out, a, b)

        def update(self) -> py_trees.common.Status:
            out, a, b = self.cells
            values[out] = values[a] + values[b]
            return py_trees.common.Status.SUCCESS

    root = py_trees.composites.Sequence("root", memory=False)
    root.add_children([AddBehaviour(i, i - 1, max(0, i - 7)) for i in range(1, size + 1)])
    return seconds(root.tick_once, max(20, 4000 // size)) * 1e6


def main() -> None:
    """Print the table."""
    gc.set_threshold(10_000)  # as `graphrun` does; at the default, a quarter of the time to build goes to collections
    print(
        f"Python {sys.version.split()[0]}; ratio = time of the generated pass over that of a hand-written loop, same run"
    )
    for gated, bars in ((False, {20: 1.8, 100: 1.8}), (True, {20: 2.2, 100: 2.2})):
        what = "half of the nodes behind a branch" if gated else "every node runs"
        for size in (20, 100, 1000):
            ratio, best = compare(size, gated)
            bar = f"(bar {bars[size]})" if size in bars else ""
            print(
                f"{size:5} nodes, {what:33}  x{ratio:.2f} {bar:10} {best:8.2f} us a pass, {best / size * 1e3:.0f} ns a node"
            )
    (_, small), (needed, large) = (
        min(built(branching(20)) for _ in range(5)),
        min(built(branching(1000)) for _ in range(5)),
    )
    ratio = (large / 1000) / (small / 20)
    print(
        f" 1000 nodes with branches: built in {needed:.2f} s (bar 0.5), a node costs x{ratio:.2f} (bar 2) of one of 20"
    )
    sizes = (1000, 2000, 4000)
    rounds = [[built(branching(size)) for size in sizes] for _ in range(4)]
    rows = [
        (size, min(found[i][0] for found in rounds), min(found[i][1] for found in rounds))
        for i, size in enumerate(sizes)
    ]
    for (_, build, run), (size, longer, slower) in itertools.pairwise(rows):
        print(
            f" {size} nodes with branches: build x{longer / build:.2f} (bar 2.1), pass x{slower / run:.2f}, of half as many"
        )
    short, long = (min(built(chain(size))[0] for _ in range(3)) for size in (250, 1000))
    print(f" 1000 sums in a row, types told one by one: built in {long:.2f} s, x{long / short:.1f} of 250")
    for size in (20, 100):
        for name, other in (("csp, Python nodes", csp_microseconds), ("py_trees", py_trees_microseconds)):
            theirs = other(size)
            _, ours = compare(size, False, 3)
            if theirs is None:
                print(f"{size:5} nodes: {name} is not installed")
            else:
                print(f"{size:5} nodes: {name} {theirs:.2f} us a tick, {theirs / ours:.1f} times ours")


if __name__ == "__main__":
    main()
