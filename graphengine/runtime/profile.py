"""Measures in sampled ticks how often nodes run and fire and how long they compute; all other ticks run at full speed."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from graphengine.runtime.executor import Observed
from graphengine.runtime.graph_run import GraphRun


@dataclass(slots=True)
class NodeProfile:
    """Measurements of one node over all sampled ticks.

    Attributes:
        path: path of the node, `robot/graph/node`.
        type: registered name of the node type.
        runs: number of calls of `compute`.
        fired: number of these calls that fired an execution output; for nodes of kind `pusher`, number of fired outputs.
        seconds: wall time of these calls, s; for nodes of kind `pusher`, without the nodes that their outputs run.
        last: number of the last call among the calls of all nodes, which shows the order of execution.
    """

    path: str
    type: str
    runs: int = 0
    fired: int = 0
    seconds: float = 0.0
    last: int = 0


class Profile:
    """Measures the nodes of graphs in every n-th tick.

    Args:
        every: n; 1 samples every tick.
    """

    def __init__(self, every: int = 10) -> None:
        self.sampled = 0
        """Number of sampled ticks that have ended."""
        self._every = every
        self._begun, self._sampling = -1, False
        self._nodes: dict[str, NodeProfile] = {}
        self._calls = itertools.count(1)
        self._watched: dict[GraphRun, Observed] = {}
        """For each measured graph, the function that switches the measurement on or off."""

    def begin_tick(self, number: int, graphs: Sequence[GraphRun]) -> None:
        """Switch the measurement on or off for the next tick; call this before each tick, and once after the last tick.

        Args:
            number: number of ticks that have already run.
            graphs: graphs that run in the next tick.
        """
        if number == self._begun:
            return
        sampled, before = number % self._every == 1 % self._every, self._sampling  # the first tick is like no other
        if sampled or before:
            self._watched = {run: self._watched.get(run) or self._watch(run) for run in graphs}
            for switch in self._watched.values():
                switch(sampled)
        self._begun, self._sampling = number, sampled
        self.sampled += before

    def end(self) -> None:
        """Stop sampling until the next `begin_tick`."""
        for switch in self._watched.values():
            switch(False)
        self._watched.clear()
        self._begun, self._sampling = -1, False

    def nodes(self) -> list[NodeProfile]:
        """Return the measurements of all nodes that ran, sorted by computing time, the longest first."""
        return sorted((node for node in self._nodes.values() if node.runs), key=lambda node: -node.seconds)

    def _watch(self, run: GraphRun) -> Observed:
        executor = run.executor

        def wrap(index: int, compute: Callable[[], Any]) -> Callable[[], Any]:
            instance = executor.graph.instances[index]
            cls, path = instance.cls, f"{executor.graph.name}/{instance.id}"
            node = self._nodes.setdefault(path, NodeProfile(path, cls.type_name))
            outputs = any(port.mask for port in cls.fields.values())
            always = outputs and cls.kind() in ("action", "event") and not cls.gated
            return _timed(node, compute, self._calls, pusher=cls.kind() == "pusher", always=always)

        return executor.observe(wrap)


def _timed(
    node: NodeProfile, compute: Callable[[], Any], calls: Iterator[int], *, pusher: bool, always: bool
) -> Callable[[], Any]:
    """Return a function that calls `compute` of a node, counts the calls and measures their time.

    Args:
        node: measurements to which the function adds.
        compute: the method to call.
        calls: counts the calls of all nodes.
        pusher: whether `compute` is a generator of fired outputs.
        always: whether each call counts as fired, whatever `compute` returns.
    """
    now = time.perf_counter

    def timed() -> Any:
        begin = now()
        node.last = next(calls)
        try:
            fired = compute()
        finally:
            node.seconds += now() - begin
            node.runs += 1
        node.fired += bool(fired or always)
        return fired

    def timed_pushes() -> Iterator[int]:
        pushes = compute()
        node.runs += 1
        node.last = next(calls)
        while True:
            begin = now()
            try:
                port = next(pushes)
            except StopIteration:
                return
            finally:
                node.seconds += now() - begin
            node.fired += 1
            yield port

    return timed_pushes if pusher else timed
