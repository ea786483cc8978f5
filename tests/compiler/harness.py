"""Graphs from YAML text to running: one executor for rules of a pass, a real Session for rules of a tick."""

from __future__ import annotations

import importlib
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from graphengine.compiler.graph import Graph
from graphengine.compiler.library import GraphLibrary
from graphengine.compiler.literals import Override
from graphengine.compiler.planning import share_plans
from graphengine.compiler.registry import Registry
from graphengine.compiler.resolve import resolve
from graphengine.compiler.subgraph_expansion import load_graph
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import NodeError
from graphengine.format.files import Files
from graphengine.messages.endpoints import EndpointClaim, Network, Publisher
from graphengine.node.clock import Clock
from graphengine.node.context.session_services import Services
from graphengine.node.dropped_values import DroppedValues
from graphengine.runtime.graph_run import make_graph_run
from graphengine.runtime.roster import Roster
from graphengine.runtime.session_core import SessionCore
from graphengine.runtime.ticker import Ticker
from graphengine.scene.loaded_scene import BadValues
from tests.compiler import nodes_for_tests

REGISTRY = Registry()
REGISTRY.add_module(nodes_for_tests, "tests", built_in=True)
for flow_control in ("graphengine.nodes.action", "graphengine.nodes.core.flow"):  # by their full names only
    REGISTRY.add_module(importlib.import_module(flow_control), "graphengine")


class Journal(Network):
    """A network on which every message is a line of the journal."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.logged: list[str] = []
        self.frozen = 0
        self.open = 0

    def publisher(self, claim: EndpointClaim) -> Publisher:
        self.open += 1
        return _Pen(claim, self)

    def freeze(self) -> None:
        self.frozen += 1

    def log(self, severity: str, message: str) -> None:
        self.logged.append(f"{severity}: {message}")

    def read(self) -> list[str]:
        """What was written since it was last read."""
        lines = list(self.lines)
        self.lines.clear()
        return lines


class _Pen(Publisher):
    def __init__(self, claim: EndpointClaim, journal: Journal) -> None:
        super().__init__(claim)
        self.journal = journal

    def publish(self, message: Any) -> None:
        self.journal.lines.append(message)

    def close(self) -> None:
        self.journal.open -= 1


def write(folder: Path, text: str, name: str = "g.yaml") -> Path:
    """A graph file; `format` and `graph` are added when the text does not say them."""
    text = textwrap.dedent(text).lstrip("\n")
    path = folder / name
    path.write_text(text if "graph:" in text else f"graph: {path.stem}\n{text}", encoding="utf-8")
    return path


def resolved(
    path: Path,
    findings: Findings,
    bindings: Mapping[str, Any] | None = None,
    overrides: Sequence[Override] = (),
    library: GraphLibrary | None = None,
) -> Graph | None:
    """A file up to its instances and wires; a library reads it once for all its uses."""
    flat = load_graph(path, bindings or {}, library or GraphLibrary(Files.of(path)), findings)
    return resolve(flat, path.stem, f"/World/{path.stem}", REGISTRY, findings, overrides) if flat is not None else None


def planned(path: Path, findings: Findings, library: GraphLibrary | None = None) -> Graph | None:
    """A file up to a graph that has a plan; None when something is wrong with it."""
    graph = resolved(path, findings, library=library)
    planned = share_plans([graph], findings) if graph is not None and not findings.errors else []
    return planned[0] if planned else None


class Bench:
    """One graph that runs pass by pass, latent nodes after each, without a session."""

    def __init__(
        self,
        path: Path,
        *,
        keep_going: bool = False,
        bad_values: BadValues = "drop",
        library: GraphLibrary | None = None,
    ) -> None:
        self.findings = Findings()
        graph = planned(path, self.findings, library)
        assert graph is not None, "\n".join(finding.render() for finding in self.findings.items)
        self.graph = graph
        self.plan = graph.plan
        self.journal = Journal()
        self.services = Services(DryWorld(Stage()), self.journal)
        self.services.dropped = DroppedValues() if bad_values == "drop" else None
        self.clock = Clock((1, 100))
        self.faults: list[NodeError] = []
        fault = self.faults.append if keep_going else None
        self.run = run = make_graph_run(graph, self.services, self.clock, fault)
        self.executor, self.variables, self.context_of = run.executor, run.variables, run.contexts

    def __getitem__(self, node_id: str) -> Any:
        """A node by its name in the file."""
        return self.executor.node(node_id)

    def index(self, node_id: str) -> int:
        return self.graph.by_id(node_id).index

    def setup(self) -> Bench:
        self.executor.setup()
        return self

    def begin_tick(self) -> None:
        """What a session does before a pass."""
        for queue in self.services.queues.values():
            queue.freeze()
        for variable in self.variables.values():
            variable.freeze()
        self.clock.set_frame(self.clock.frame + 1)

    def tick(self) -> list[str]:
        """One pass, then the latent nodes; what was written meanwhile."""
        self.begin_tick()
        self.executor.run_pass()
        self.executor.run_latent()
        return self.journal.read()

    def stop(self) -> None:
        """As a session stops."""
        self.executor.stop()
        for variable in self.variables.values():
            variable.clear()
        for queue in self.services.queues.values():
            queue.clear()
        self.clock.stop()

    def ticks(self, count: int) -> list[list[str]]:
        return [self.tick() for _ in range(count)]

    @property
    def codes(self) -> list[str]:
        return [finding.code for finding in self.findings.items]

    def message(self, code: str) -> str:
        """Message of the only finding with a code."""
        (found,) = (finding.message for finding in self.findings.items if finding.code == code)
        return found


class Physics(DryWorld):
    """A world that writes down what the session asks of it."""

    def __init__(self, journal: Journal, tick_period: tuple[int, int], substeps: int) -> None:
        super().__init__(Stage(), tick_period, substeps)
        self.journal = journal
        self.closed = 0

    def step(self) -> None:
        self.journal.lines.append("step")

    def begin_tick(self, tick: int) -> None:
        self.journal.lines.append(f"begin {tick}")

    def zero_commands(self) -> None:
        self.journal.lines.append("zero commands")

    def reset_state(self) -> None:
        self.journal.lines.append("reset state")

    def reset_time(self) -> None:
        self.journal.lines.append("reset time")

    def close(self) -> None:
        self.closed += 1


class Play:
    """A real session of some graphs, in the order given; `play.lines()` is what happened since last asked."""

    def __init__(self, *paths: Path, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        self.journal = Journal()
        self.world = Physics(self.journal, tick_period, substeps)
        self.services = Services(self.world, self.journal)
        ticker = Ticker(self.services)
        for path in paths:
            findings = Findings()
            graph = planned(path, findings)
            assert graph is not None, "\n".join(finding.render() for finding in findings.items)
            ticker.add([graph])
        self.session, self.clock = SessionCore(ticker, Roster()), ticker.clock
        self.journal.lines.clear()

    def node(self, node_id: str, graph: int = 0) -> Any:
        return self.session.graphs[graph].executor.node(node_id)

    def tick(self) -> list[str]:
        """One tick; what the nodes wrote."""
        self.session.step()
        return self.lines()

    def lines(self) -> list[str]:
        """What the nodes wrote since last asked, without what the world did."""
        return [line for line in self.journal.read() if not line.startswith(("step", "begin"))]
