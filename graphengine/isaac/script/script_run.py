"""Runs a script once with stubs of Omniverse's modules, and records its graphs and errors."""

from __future__ import annotations

import ast
import builtins
import inspect
import os
import re
import sys
import types
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphengine.format.diagnostics import Source, Span
from graphengine.format.wording import quoted
from graphengine.isaac.omniverse.asyncio_stub import finish, make_asyncio
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.modules import make_modules
from graphengine.isaac.omniverse.stubs import Builtins, StubObject, of_unknown
from graphengine.isaac.recorded_graph import IMPULSE, RecordedGraph, RecordedValue
from graphengine.isaac.script.callbacks import run_callbacks
from graphengine.isaac.script.coverage import FAILED, MARK, NUMBER, marked
from graphengine.isaac.script.import_finder import PACKAGE
from graphengine.isaac.script.losses import UNFORGIVEN, Losses, TimeIsUpError
from graphengine.isaac.script.script_answer import ScriptAnswer
from graphengine.isaac.script.script_source import Scripts
from graphengine.isaac.script.static_evaluation import evaluate
from graphengine.sandbox.untrusted import typed

ON_TICK = "omni.graph.action.OnTick"


class ScriptRun:
    """One run of a script in the confined process; `run` executes it, and `answer` returns the result."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.path: str = request["path"]
        self.calls: list[str] = request["calls"]
        self.request = request
        self.text: str = request["text"]
        self.allowed: bool = request["run"]
        """Whether the script may run as Python code; otherwise it is only evaluated statically."""
        self.forgiving = ast.AST if request["forgiving"] else ast.Module if self.calls else None
        """Class of syntax nodes in whose bodies the script continues after a failed statement; None: it never continues."""
        self.executed = False
        self.time_is_up = False
        self.running = False
        """Whether the script is running now, so that `end` may interrupt it."""
        vars(builtins).update({MARK: self._mark, NUMBER: of_unknown})
        self.folders: list[str] = [str(Path(self.path).absolute().parent), *request["allowed"]]
        self.scripts = Scripts(self.folders)
        types, absent = frozenset(request["types"]), frozenset(request["absent"])
        where, stack = self.scripts.where, self.scripts.stack
        self.recorder = GraphRecorder(where, types, assumed=request["assumed"], absent=absent, stack=stack)
        self.recorder.prims.update(request["assume"])
        self.modules: dict[str, Any] = dict(make_modules(self.recorder))
        self.modules["asyncio"] = make_asyncio(self.recorder)
        self.losses = Losses(self.recorder, self.scripts)

    def end(self, *_: Any) -> None:
        """Handle the signal of the timer: raise TimeIsUpError in the script, and again at each further statement."""
        self.time_is_up = True
        if self.running:
            raise TimeIsUpError

    def _mark(self, path: str, line: int, column: int) -> None:
        """Record that a statement is executed, and the exception that is being handled there, if any; called as `MARK`."""
        self.losses.ran.add((path, line, column))
        if self.time_is_up and self.running:
            raise TimeIsUpError
        error = sys.exception()
        if error is not None and self.running:
            self.losses.note(error, line)
            if column == FAILED:
                if self.request["forgiving"] and isinstance(error, UNFORGIVEN):
                    raise error
                self.losses.report_skipped(error)

    def run(self) -> None:
        """Run the script to its end, and report errors and skipped calls as findings."""
        try:
            self.scripts.load(self.path, self.text)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            start = getattr(error, "lineno", 0) or 1, getattr(error, "offset", 0) or 1
            what = getattr(error, "msg", "") or str(error) or type(error).__name__
            self.recorder.findings.add("G401", f"not valid Python: {what}", _foreign(self.path, *start))
            return
        sys.argv[:] = [self.path, *self.request["arguments"]]
        name = f"{PACKAGE}.{Path(self.path).stem}"
        module = types.ModuleType(name if self.calls else "__main__")
        names: dict[str, Any] = vars(builtins)
        if re.search(r"\bimport\s*\*", self.text):  # only then: `Builtins` slows down the look-up of names
            names = Builtins(names)
            names.recorder = self.recorder
        vars(module).update(__file__=self.path, __package__=PACKAGE, __builtins__=names)
        sys.modules["__main__"] = sys.modules[name] = module
        for path, graphs in self.request["stages"].items():
            self.recorder.stages[path] = typed(list[RecordedGraph], graphs, _foreign)
        self._run(vars(module))
        self.losses.report_refused()
        self.recorder.graphs = {**self.recorder.removed, **self.recorder.graphs}
        self._settle_impulses()
        self.losses.report_unreached()
        self.losses.report_conditions()
        hints = list(self.losses.hints())
        if self.allowed and hints and not self.recorder.graphs and not self.recorder.findings.errors:
            self.recorder.findings.add("W302", "the script builds no graph", None, *hints)

    def _run(self, namespace: dict[str, Any]) -> None:
        try:
            try:
                self.running = True
                recorder = evaluate(self.scripts.main) if self.request["literals"] else None
                if recorder is not None and recorder.graphs:
                    self.recorder = self.losses.recorder = recorder
                    self.losses.may_differ = False
                    return
                self.executed = True
                if self.allowed:
                    tree = marked(self.text, self.path, forgiving=self.forgiving)
                    exec(compile(tree, self.path, "exec"), namespace)
                    self._call(namespace)
                if self.time_is_up:
                    raise TimeIsUpError
            finally:
                self.running = False
        except BaseException as error:  # any exception of the script
            if isinstance(error, MemoryError):
                namespace.clear()  # frees the script's memory for the report
            self.losses.report_end(error)
        if self.recorder.callbacks and not self.time_is_up and not self.recorder.findings.errors:
            self.running = True
            run_callbacks(self.recorder, lambda error: self.losses.note(error, -1))
            self.running = False

    def _call(self, namespace: dict[str, Any]) -> None:
        """Make the calls of `--call` options; without such options, if no graph was built, call `on_startup` of extensions."""
        if self.calls and self.recorder.graphs:
            what = f"graphs that the script builds without --call are left out: {', '.join(self.recorder.graphs)}"
            self.recorder.findings.add("N302", what)
            self.recorder.graphs, self.recorder.removed = {}, {}
        for call in self.calls:
            names = {node.id for node in ast.walk(ast.parse(call)) if isinstance(node, ast.Name)}
            absent = sorted(names - {*namespace, *vars(builtins), re.split(r"\W", call)[0]})
            if absent:
                what = f"{', '.join(absent)} in --call: undefined names, assumed to be objects of Omniverse"
                self.recorder.findings.add("N302", what)
            result = eval(call, {name: StubObject(name, self.recorder) for name in absent} | namespace)
            if inspect.iscoroutine(result):
                finish(result, self.recorder)
        if not self.calls and not self.recorder.graphs:
            for thing in list(namespace.values()):
                if isinstance(thing, type) and getattr(thing, "_stands_for", "") == "omni.ext.IExt":
                    self.recorder.findings.add("N302", f"{thing.__name__}.on_startup is called, as Isaac Sim does")
                    thing().on_startup(thing.__module__)

    def assumed(self, file: str, *, folder: bool) -> str:
        """Return an existing path to replace a missing file or folder that is assumed to exist, otherwise an empty string."""
        file, suffix = file.rstrip("/"), os.path.splitext(file)[1]
        known = f"{file}/" in self.recorder.prims
        if not known and not self.recorder.assumed and not self.recorder.holds(file, "it exists"):
            return ""
        return self.folders[0] if folder or known or not suffix else self.path

    def compiled(self, text: bytes, path: str) -> types.CodeType | None:
        """Return the instrumented code of a module in a readable folder; None for all other modules."""
        own = self.scripts.at(path)
        return compile(marked(text, path, forgiving=self.forgiving), path, "exec", dont_inherit=True) if own else None

    def answer(self) -> ScriptAnswer:
        """Return the result of the run."""
        recorder = self.recorder
        graphs = [graph for graph in recorder.graphs.values() if graph.nodes or graph.path not in recorder.opened]
        return ScriptAnswer(
            graphs if self.losses.may_differ or not recorder.findings.errors else [],  # not needed in the response
            recorder.namespaces,
            recorder.findings.items,
            recorder.prims,
            recorder.opened_stages,
            recorder.granted,
            self.losses.may_differ,
            self.losses.stopped,
            self.executed,
        )

    def _settle_impulses(self) -> None:
        """Report nodes to which a loop of the script sends impulses; with `--impulse-every`, replace them by OnTick nodes."""
        findings, every = self.recorder.findings, self.request["impulse_every"]
        for (path, name), place in self.recorder.frames.impulses.items():
            graph = self.recorder.graphs.get(path)
            if graph is None or name not in graph.nodes:
                continue
            if not every:
                what = f"the impulses that a loop of the script sends to {path}/{name} are left out"
                control = f"or at run time: graphrun ctl impulse {quoted(name)}"
                findings.add("W302", what, place, "--impulse-every 1 lets the node fire every tick", control)
                continue
            node = graph.nodes[name]
            node.values.pop(IMPULSE, None)
            node.type, node.values["inputs:framePeriod"] = ON_TICK, RecordedValue(every - 1, span=place)
            fired = (name, "outputs:execOut")
            for number, wire in enumerate(graph.wires):
                if wire.ends[0] == fired:
                    graph.wires[number] = replace(wire, source_port="outputs:tick")
            what = f"{path}/{name}, to which a loop of the script sends impulses, is replaced by an OnTick node"
            findings.add("N301", what, place)


def _foreign(path: str, *numbers: int) -> Span:
    """Return a span with the given numbers (line, column, length) in a file whose text is not loaded."""
    return Span(Source(path, ()), *numbers)
