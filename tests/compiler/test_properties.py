"""Graphs that nobody thought of: the engine does what the rules say, read off one by one; and never raises."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

from graphengine.compiler import codegen
from graphengine.compiler.library import GraphLibrary
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import NodeError
from graphengine.format.files import Files
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Node, types
from graphengine.node.mailbox import EventQueue
from graphengine.node.node_class import ENDINGS, grown
from graphengine.node.port import Port
from tests.compiler.harness import REGISTRY, Bench, planned, resolved
from tests.compiler.reference import Reference

PASSES = 4

DATA = ("Add", "Less", "Ticket", "ReadVariable", "Double", "Constant", "Whole")
EVENTS = ("Tick", "Every", "TwoEnds", "OnMessage")
ACTIONS = ("Do", "Branch", "Door", "Choose", "Join", "Counter", "Gate", "WriteVariable", "Show", "Post")
PUSHERS = ("Sequence", "Both", "ForLoop")
LATENT = ("Delay", "Stages")
PICKY = ("PickyAdd", "PickyTick", "PickyDo", "PickyChoice", "PickyCounter", "PickyLoop", "PickyDelay")
ACTION = "omni.graph.action."
FLOW = (
    *(ACTION + name for name in ("OnPlaybackTick", "OnTick", "OnCustomEvent", "OnVariableChange", "SendCustomEvent")),
    *(ACTION + name for name in ("OnStageEvent", "OnClosing")),
    *(
        ACTION + name
        for name in ("Branch", "Sequence", "SwitchToken", "Gate", "Multigate", "FlipFlop", "Once", "Counter")
    ),
    *(
        ACTION + name
        for name in ("SyncGate", "Multisequence", "ForLoop", "ForEach", "ForEachTarget", "Delay", "Countdown")
    ),
    *("isaacsim.core.nodes.IsaacSimulationGate", "WhileLoop", "Do", "Show", "WriteVariable"),
    *("Add", "Less", "Word", "Ticket", "ReadVariable") * 3,
)
LOOPS = ("WhileLoop", "WhileLoop", "ForLoop", f"{ACTION}Counter", f"{ACTION}Multisequence", "Do", *("Less", "Add") * 2)
NUMBERED = {
    f"{ACTION}Multisequence": ("output1", "output2"),
    f"{ACTION}Multigate": ("output1", "output2"),
    f"{ACTION}SwitchToken": ("output0", "output1"),
}
"""Ports that nodes grow when wires begin at them."""
PACES = ("once", "{ticks: 2}", "{hz: 30}")
LITERALS: dict[str, dict[str, Any]] = {
    f"{ACTION}OnTick": {"framePeriod": 1},
    f"{ACTION}OnCustomEvent": {"eventName": "again"},
    f"{ACTION}OnStageEvent": {"eventName": "Simulation Stop Play"},
    f"{ACTION}SendCustomEvent": {"eventName": "again"},
    f"{ACTION}OnVariableChange": {"variableName": "speed"},
    f"{ACTION}SwitchToken": {"value": "a", "branch0": "a", "branch1": "b"},
    f"{ACTION}ForLoop": {"start": 1, "stop": 3},
    f"{ACTION}ForEach": {"arrayIn": {"type": "double[]", "value": [1.0, 2.0]}},
    f"{ACTION}ForEachTarget": {"targets": ["/a", "/b"]},
    f"{ACTION}Delay": {"duration": 0.02},
    f"{ACTION}Countdown": {"duration": 2},
    "isaacsim.core.nodes.IsaacSimulationGate": {"step": 2},
    "Every": {"n": 2},
    "Less": {"b": 2.0},
    "ForLoop": {"stop": 2},
    "Whole": {"value": 3},
    "Delay": {"duration": 0.02},
    "Choose": {"bits": 3},
    "Stages": {"plan": "12"},
}


@dataclass
class Drawing:
    """A graph file in the making."""

    kinds: list[str] = field(default_factory=list)
    literals: list[dict[str, Any]] = field(default_factory=list)
    wires: list[str] = field(default_factory=list)
    paces: list[str] = field(default_factory=list)
    """What `every:` says of each node, if anything."""
    evaluator: str = "execution"

    def add(self, kind: str, pace: str = "", **literals: Any) -> int:
        self.kinds.append(kind)
        self.paces.append(pace)
        self.literals.append({**LITERALS.get(kind, {}), **literals})
        return len(self.kinds) - 1

    def cls(self, index: int) -> type[Node]:
        found = REGISTRY.find(self.kinds[index])
        assert found is not None
        return grown(found.cls, self.literals[index], DEFINITIONS, NUMBERED.get(self.kinds[index], ()))

    def ports(self, index: int, side: str, *, execution: bool) -> list[Port]:
        return [p for p in self.cls(index).fields.values() if p.side == side and p.is_exec == execution]

    def wire(self, source: int, port: str, target: int, into: str, names: Sequence[str]) -> None:
        self.wires.append(f"{names[source]}.{port} -> {names[target]}.{into}")

    def text(self, names: Sequence[str]) -> str:
        nodes = [
            f"  {name}: {{type: {kind}, inputs: {{{', '.join(f'{k}: {_yaml(v)}' for k, v in literals.items())}}}"
            f"{', every: ' * bool(pace)}{pace}}}"
            for name, kind, literals, pace in zip(names, self.kinds, self.literals, self.paces, strict=True)
        ]
        wires = [f"  - {wire}" for wire in self.wires]
        variables = ["variables: {speed: {type: double, default: 1.0}}"]
        head = ["graph: g", f"evaluator: {self.evaluator}", *variables, "nodes:"]
        return "\n".join([*head, *nodes, *(["connections:"] * bool(wires)), *wires, ""])


def _yaml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else f"'{value}'" if isinstance(value, str) else str(value)


NAMES = [f"N{i}" for i in range(200)]


def draw_graph(
    random: Random, kinds: Sequence[str], size: int, *, straight: bool = False, paced: float = 0.0
) -> Drawing:
    """Nodes of some kinds, wired at random: execution from earlier to later nodes, values from anywhere, all in any order.

    Args:
        random: decides.
        kinds: of nodes, each as likely as the others.
        size: number of nodes.
        straight: values go from earlier to later nodes too, and no wire closes a circle.
        paced: how many of the nodes have `every:`.
    """
    drawing = Drawing()
    for kind in ["Tick", *(random.choice(kinds) for _ in range(size))]:
        index = drawing.add(kind)
        if drawing.cls(index).kind() != "data" and random.random() < paced:
            drawing.paces[index] = random.choice(PACES)
    rank = random.sample(range(len(drawing.kinds)), len(drawing.kinds))
    rank[0] = -1
    wires: list[tuple[int, str, int, str]] = []
    for target in range(len(rank)):
        for into in drawing.ports(target, "inputs", execution=True):
            for _ in range(random.choice((1, 1, 1, 2, 3)) if not into.control else random.choice((0, 1))):
                back = not straight and random.random() < (0.5 if into.control else 0.01)
                wires += _exec_wire(random, drawing, rank, target, into, back=back)
        for into in _plain_inputs(drawing, target):
            if random.random() < 0.6:
                wires += _data_wire(random, drawing, rank, target, into, straight=straight)
    random.shuffle(wires)
    for wire in wires:
        drawing.wire(*wire, NAMES)
    return drawing


Ends = list[tuple[int, str, int, str]]


def _exec_wire(random: Random, drawing: Drawing, rank: list[int], target: int, into: Port, *, back: bool) -> Ends:
    sources = [i for i in range(len(rank)) if back or rank[i] < rank[target]]
    fires = [(i, port) for i in sources for port in drawing.ports(i, "outputs", execution=True)]
    source, out = random.choice(fires)
    return [(source, out.name, target, into.name)]


def _data_wire(random: Random, drawing: Drawing, rank: list[int], target: int, into: Port, *, straight: bool) -> Ends:
    """From any output, or now and then from an input; circles of data nodes are rare."""
    side = "inputs" if random.random() < 0.1 else "outputs"
    source = random.randrange(len(rank))
    ports = _plain_inputs(drawing, source) if side == "inputs" else drawing.ports(source, "outputs", execution=False)
    ports = [port for port in ports if _fits(port, into)]
    pure = drawing.cls(target).kind() == "data" and (side == "inputs" or drawing.cls(source).kind() == "data")
    ahead = rank[source] < rank[target]
    if not ports or not (ahead or not (straight or pure) or (not straight and random.random() < 0.02)):
        return []
    return [(source, ("inputs:" if side == "inputs" else "") + random.choice(ports).name, target, into.name)]


def _plain_inputs(drawing: Drawing, index: int) -> list[Port]:
    """Inputs whose values cannot break a node."""
    ports = drawing.ports(index, "inputs", execution=False)
    return [p for p in ports if str(p.type) in ("double", "bool", "any", "token") and not p.setup]


def _fits(out: Port, into: Port) -> bool:
    one, other = out.type, into.type
    if not isinstance(one, types.PortType) or not isinstance(other, types.PortType) or one == types.ANY:
        return False
    return types.conversion(one, other) is not None


EVERYTHING = (*DATA, *EVENTS, *ACTIONS, *PUSHERS, *LATENT)
QUICK = settings(suppress_health_check=list(HealthCheck))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("drawings")


_numbers = itertools.count()


def save(folder: Path, text: str) -> Path:
    path = folder / f"{next(_numbers)}" / "g.yaml"
    path.parent.mkdir()
    path.write_text(text, encoding="utf-8")
    return path


def outputs(nodes: Sequence[Node]) -> list[dict[str, str]]:
    """What every node shows, in a form in which nan is equal to nan."""
    shown = []
    for node in nodes:
        fields = [p.field for p in type(node).fields.values() if p.side == "outputs" and not p.is_exec]
        fields += ["computes"] if hasattr(node, "computes") else []
        shown.append({name: repr(getattr(node, name)) for name in fields})
    return shown


def post(run: Bench, number: int) -> None:
    """A message before each of the first two passes, if the graph listens."""
    box = run.services.queues.get("messages")
    if box is not None and number < 2:
        box.post(float(number))


def play(run: Bench) -> list[Any]:
    """Journal and outputs after each pass and each ending, with messages before the first two passes."""
    told = []
    for number in range(PASSES):
        post(run, number)
        told.append((run.tick(), outputs(run.executor.nodes)))
    for ending in ENDINGS:
        run.executor.run_ending(ending)
        told.append((run.journal.read(), outputs(run.executor.nodes)))
    return told


def play_both(path: Path) -> tuple[list[Any], list[Any]]:
    """Journal and outputs after each pass and each ending: of the engine, and of the rules."""
    library = GraphLibrary(Files.of(path))
    engine = Bench(path, library=library).setup()
    other = Bench(path, library=library)
    graph = resolved(path, Findings(), library=library)
    assert graph is not None
    rules = Reference(graph, other.context_of)
    done = play(engine)
    said: list[Any] = []
    for number in range(PASSES):
        post(other, number)
        other.begin_tick()
        rules.tick = other.clock.frame
        rules.run_pass()
        rules.run_latent()
        said.append((other.journal.read(), outputs(rules.nodes)))
    for ending in ENDINGS:
        rules.run_ending(ending)
        said.append((other.journal.read(), outputs(rules.nodes)))
    beyond = [i for i in range(len(rules.nodes)) if i not in engine.plan.order or rules.is_fixed(i)]
    for shown in (*done, *said):
        for index in beyond:
            shown[1][index].clear()  # constants, and what nobody reads, may be computed at any time
    assert engine.services.dropped is not None
    done.append(engine.services.dropped.ticks)
    dropped = {index: len(ticks) for index, ticks in rules.dropped.items() if index not in beyond}
    said.append({f"/World/g/{graph.instances[index].id}": ticks for index, ticks in dropped.items()})
    return done, said


def check(folder: Path, drawing: Drawing) -> None:
    """Compare the engine with the rules, unless the graph is refused for a cycle; regions may be split into several functions."""
    path, findings = save(folder, drawing.text(NAMES[: len(drawing.kinds)])), Findings()
    if planned(path, findings) is None:
        assert findings.errors
        assert {found.code for found in findings.errors} <= {"G209", "G210"}
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(codegen, "MAX_CALLS", (1, 4, codegen.MAX_CALLS)[len(drawing.wires) % 3])
        done, said = play_both(path)
    assert done == said


@settings(QUICK, max_examples=250)
@given(st.randoms(use_true_random=False), st.integers(2, 16))
def test_any_graph_does_what_the_rules_say_or_is_refused_for_a_cycle(folder: Path, random: Random, size: int) -> None:
    check(folder, draw_graph(random, EVERYTHING, size))


@settings(QUICK, max_examples=100)
@given(st.randoms(use_true_random=False), st.integers(2, 16), st.integers(0, 6))
def test_any_graph_goes_on_from_a_checkpoint_as_it_did(folder: Path, random: Random, size: int, passes: int) -> None:
    path = save(folder, draw_graph(random, EVERYTHING, size).text(NAMES[: size + 1]))
    if planned(path, Findings()) is None:
        return
    bench = Bench(path).setup()
    parts: list[Any] = [bench.run, bench.clock, bench.services]
    try:
        for _ in range(passes):
            bench.tick()
        saved = [part.save() for part in parts]
        first = play(bench)
    except NodeError as error:  # events that multiply from tick to tick
        if f"more than {EventQueue.LIMIT} events" not in str(error):
            raise
        reject()
    for _ in range(2):
        for part, state in zip(parts, saved, strict=True):
            part.restore(state)
        assert play(bench) == first


@settings(QUICK, max_examples=150)
@given(st.randoms(use_true_random=False), st.integers(2, 16))
def test_any_graph_of_flow_control_does_what_the_rules_say(folder: Path, random: Random, size: int) -> None:
    check(folder, draw_graph(random, FLOW, size, paced=0.2))


@settings(QUICK, max_examples=100)  # as many as find a fault of the kind that the next test plants
@given(st.randoms(use_true_random=False), st.integers(2, 16), st.booleans())
def test_any_graph_in_which_nodes_drop_values_does_what_the_rules_say(
    folder: Path, random: Random, size: int, push: bool
) -> None:
    drawing = draw_graph(random, (*EVERYTHING, *PICKY * 4), size)
    check(folder, replace(drawing, evaluator="push") if push else drawing)


def test_a_branch_that_would_go_on_after_a_bad_value_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def goes_on(lines: list[str], node: int, follow: Sequence[str] = (), otherwise: Sequence[str] = ()) -> list[str]:
        return attempt(lines, node, otherwise=follow, follow=follow)

    attempt = codegen._attempt
    monkeypatch.setattr(codegen, "_attempt", goes_on)
    for seed in range(100):
        path = save(folder, draw_graph(Random(seed), ("Do", "PickyDo", "PickyTick"), 8).text(NAMES[:9]))
        if planned(path, Findings()) is not None:
            done, said = play_both(path)
            if done != said:
                return
    pytest.fail("a hundred graphs, and none of them shows the fault")


BRANCHES = ("Branch", "Choose", "Door", "Do", "Counter", "WriteVariable", "PickyDo", "Sequence", "WhileLoop", "Delay")
SUMS = ("Add", "Add", "Less", "Ticket", "ReadVariable", "PickyAdd")


@settings(QUICK, max_examples=150)
@given(st.randoms(use_true_random=False), st.integers(10, 40), st.integers(0, 8))
def test_branches_that_read_the_same_data_nodes_do_what_the_rules_say(
    folder: Path, random: Random, size: int, marks: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(codegen, "MAX_MARKS", marks)
        check(folder, draw_graph(random, (*BRANCHES, *SUMS * 2), size))


def draw_sums(random: Random, size: int) -> Drawing:
    """A web of sums over what actions computed; each branch below an earlier one is decided by a sum, and fires an action."""
    drawing = Drawing()
    drawing.add("Tick")
    sources, fires = ["N0.number"], ["N0.tick"]
    for number in range(size):
        one, less, branch, act = (drawing.add(kind) for kind in ("Add", "Less", "Branch", "Do"))
        drawing.literals[less] = {"b": float(random.randrange(12))}
        drawing.literals[one] = {"b": float(random.randrange(3))}
        wires = [f"{random.choice(sources[-3:])} -> N{one}.a", f"{random.choice(sources)} -> N{less}.a"]
        sources.append(f"N{one}.sum")
        wires += [f"N{less}.result -> N{branch}.condition", f"{random.choice(sources)} -> N{act}.a"]
        wires += [f"{random.choice(fires)} -> N{branch}.execIn", f"N{branch}.execTrue -> N{act}.execIn"]
        wires += [f"N{branch}.execFalse -> N{act}.execIn"] * random.randrange(2)
        fires += [f"N{branch}.execTrue", f"N{branch}.execFalse", f"N{act}.execOut"]
        if number % 3 == 0:
            sources.append(f"N{act}.sum")
        drawing.wires += wires
    return drawing


@settings(QUICK, max_examples=60)
@given(st.randoms(use_true_random=False), st.integers(3, 12), st.integers(0, 4))
def test_sums_behind_branches_are_computed_as_the_rules_say(
    folder: Path, random: Random, size: int, marks: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(codegen, "MAX_MARKS", marks)
        check(folder, draw_sums(random, size))


@settings(QUICK, max_examples=80)
@given(st.randoms(use_true_random=False), st.integers(4, 14))
def test_a_loop_sees_what_its_body_computed(folder: Path, random: Random, size: int) -> None:
    check(folder, draw_graph(random, LOOPS, size))


@settings(QUICK, max_examples=80)
@given(st.randoms(use_true_random=False), st.integers(2, 16))
def test_any_push_graph_computes_every_node_in_the_order_of_all_wires(folder: Path, random: Random, size: int) -> None:
    check(folder, replace(draw_graph(random, (*EVERYTHING, *FLOW), size), evaluator="push"))


@settings(QUICK, max_examples=150)
@given(st.randoms(use_true_random=False), st.integers(2, 25))
def test_a_graph_without_circles_does_what_the_rules_say(folder: Path, random: Random, size: int) -> None:
    drawing = draw_graph(random, ("Do", "Branch", "Add", "Less", "Show", "Sequence"), size, straight=True)
    done, said = play_both(save(folder, drawing.text(NAMES[: size + 1])))
    assert done == said


def runnable(folder: Path, random: Random, size: int) -> Path | None:
    """A wild graph that is not refused."""
    path = save(folder, draw_graph(random, EVERYTHING, size).text(NAMES[: size + 1]))
    return path if planned(path, Findings()) is not None else None


RANDOM = st.randoms(use_true_random=False)
SOME = settings(QUICK, max_examples=60)


@SOME
@given(RANDOM, st.integers(2, 12))
def test_names_of_nodes_do_not_affect_the_execution(folder: Path, random: Random, size: int) -> None:
    drawing = draw_graph(random, EVERYTHING, size)
    names = random.sample(NAMES, size + 1)
    path = save(folder, drawing.text(NAMES[: size + 1]))
    renamed = save(folder, _renamed(drawing, names).text(names))
    if planned(path, Findings()) is None:
        assert planned(renamed, Findings()) is None
        return
    new = dict(zip(NAMES, names, strict=False))
    expected = [([_with_name(line, new) for line in lines], shown) for lines, shown in play(Bench(path).setup())]
    assert play(Bench(renamed).setup()) == expected


def _with_name(line: str, new: dict[str, str]) -> str:
    name, _, rest = line.partition(" ")
    return f"{new[name]} {rest}"


def _renamed(drawing: Drawing, names: Sequence[str]) -> Drawing:
    def rename(end: str) -> str:
        node, port = end.split(".")
        return f"{names[NAMES.index(node)]}.{port}"

    wires = [" -> ".join(map(rename, wire.split(" -> "))) for wire in drawing.wires]
    return replace(drawing, wires=wires)


STATELESS = (
    *("Do", "Show", "Branch", "Door", "Choose", "Add", "Less", "Word", "Whole", "Double", "Sequence", "Both"),
    f"{ACTION}ForEach",
)
BY_TIME = (f"{ACTION}OnPlaybackTick", f"{ACTION}OnTick", f"{ACTION}Delay", f"{ACTION}Countdown", f"{ACTION}SwitchToken")


@settings(QUICK, max_examples=80)
@given(RANDOM, st.integers(2, 12))
def test_the_order_of_lines_only_decides_ties(folder: Path, random: Random, size: int) -> None:
    drawing = draw_graph(random, (*STATELESS, *BY_TIME), size, straight=True, paced=0.2)
    names = NAMES[: size + 1]
    told, here = [], random.sample(range(size + 1), size + 1)
    shuffled = Drawing(wires=random.sample(drawing.wires, len(drawing.wires)))
    for i in here:
        shuffled.add(drawing.kinds[i], drawing.paces[i])
    for text in (drawing.text(names), shuffled.text([names[i] for i in here])):
        run = Bench(save(folder, text)).setup()
        if "W104" in run.codes:  # the order of lines says which wire reads the value of the pass before
            return
        latent = {instance.index for instance in run.graph.instances if instance.cls.kind() == "latent"}
        if any(
            wire.source in latent for wire in run.graph.data_wires
        ):  # and whether it reads what one shows at its start
            return
        ids = [instance.id for instance in run.graph.instances]
        told.append([(sorted(lines), dict(zip(ids, shown, strict=True))) for lines, shown in play(run)])
    assert told[0] == told[1]


@SOME
@given(RANDOM, st.integers(2, 20))
def test_the_schedule_is_a_topological_order_except_for_wires_with_a_warning(
    folder: Path, random: Random, size: int
) -> None:
    path = runnable(folder, random, size)
    if path is None:
        return
    run, graph = Bench(path), resolved(path, Findings())
    assert graph is not None
    rules = Reference(graph, run.context_of)
    told = {finding.span.line for finding in run.findings.items if finding.code == "W104" and finding.span is not None}
    for region in run.plan.regions:
        place = {call.node: number for number, call in enumerate(region.calls)}
        assert len(place) == len(region.calls)
        for wire in graph.exec_wires:
            if wire.source in place and wire.target in place and wire.order not in rules.backward:
                assert rules.kinds[wire.source] in ("pusher", "latent") or place[wire.source] < place[wire.target]
        for wire in graph.data_wires:
            source = rules.origin(wire).source
            if rules.kinds[wire.target] == "data" or rules.is_constant(wire) or wire.span.line in told:
                continue
            for read in rules.shows(source) if rules.kinds[source] == "data" else {source}:
                if read in place and wire.target in place and rules.kinds[read] != "latent" and read != wire.target:
                    assert place[read] < place[wire.target]


@SOME
@given(RANDOM, st.integers(2, 12))
def test_a_second_play_of_any_graph_is_like_the_first(folder: Path, random: Random, size: int) -> None:
    path = runnable(folder, random, size)
    if path is not None:
        run = Bench(path).setup()
        first = play(run)
        run.stop()
        assert play(run) == first


@SOME
@given(RANDOM, st.integers(2, 12))
def test_keep_going_does_not_change_the_run_of_a_random_graph_whose_nodes_do_not_raise(
    folder: Path, random: Random, size: int
) -> None:
    path = runnable(folder, random, size)
    if path is not None:
        keeps_going = Bench(path, keep_going=True).setup()
        assert play(keeps_going) == play(Bench(path).setup())
        assert keeps_going.faults == []
