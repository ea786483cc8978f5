"""Reports what may be missing from the graphs of a script: errors, refused calls and calls that were not reached."""

from __future__ import annotations

import ast
import os
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path

from graphengine.format.wording import quoted
from graphengine.isaac.omniverse import og
from graphengine.isaac.omniverse.graph_recorder import MAX_PARTS, GraphRecorder
from graphengine.isaac.omniverse.og_edit import OPENED
from graphengine.isaac.omniverse.og_names import NotThereError, OmniGraphError
from graphengine.isaac.omniverse.script_notes import EndlessError
from graphengine.isaac.script.builders import BUILDING, builders, called, entries, handed_over
from graphengine.isaac.script.callbacks import lines_of
from graphengine.isaac.script.coverage import Failure, Unreached, Why, asking, holds
from graphengine.isaac.script.script_source import Script, Scripts
from graphengine.sandbox.confinement import MAX_MEMORY_BYTES, AccessDeniedError

MOST_ASKED = 5
"""Maximum number of `--assume` remedies, or of functions, in one finding."""
MOST_CALLABLE = 50
"""Maximum number of functions or conditions that one finding lists."""
NESTED = 8
"""Number of recent caught errors with which an error is compared, so that nested handlers do not keep it twice."""
MAX_CAUGHT = 2_000
"""Maximum number of caught errors that are kept."""
_LOOKS = frozenset(("get", "node", "node_type"))
"""Methods of OmniGraph's controllers that change nothing."""


class TimeIsUpError(BaseException):
    """The script exceeds its time limit."""


UNFORGIVEN = (OmniGraphError, AccessDeniedError, RecursionError, MemoryError, StopIteration, StopAsyncIteration)
"""Errors after which a script never continues: they would also occur in Omniverse, or they end iterations."""
_LATER = "the graphs lack the parts that it would have built later"
_ARGUMENTS = "pass arguments to the script after `--`: graphrun import FILE.py -- ARGUMENT …"
_ENDS = {EndlessError: "stop", TimeIsUpError: "stop", SystemExit: "exit"}
"""Words for exceptions that are not errors but end a script, for messages such as `the exit at line 5`."""


class Losses:
    """Collects the errors and executed statements of a run, and reports the parts that the graphs lack.

    Args:
        recorder: recorder of the graphs; its findings receive the reports.
        scripts: the script and the modules that run with it.
    """

    def __init__(self, recorder: GraphRecorder, scripts: Scripts) -> None:
        self.recorder, self.scripts = recorder, scripts
        self.ran: set[tuple[str, int, int]] = set()
        """Executed statements, as file, line and column."""
        self.may_differ = True
        """Whether the script might build other graphs if more prims existed on the stage."""
        self.stopped = False
        """Whether a statement of the script failed, but the graphs that the script built are kept."""
        self._caught: list[tuple[BaseException, int]] = []
        """Pairs of an error and the line where the script caught it; line 0 for the error that ended the script."""
        self._skipped = set[tuple[type[BaseException], str]]()
        """Type and position of each reported error after which the script continued."""

    def note(self, error: BaseException | None, line: int) -> None:
        """Keep an error that the script caught at a line, unless it is already kept."""
        known = (caught for caught, _ in self._caught[-NESTED:])  # `is`, because `id()` raises an audit event
        if error is not None and len(self._caught) < MAX_CAUGHT and not any(caught is error for caught in known):
            self._caught.append((error, line))

    def report_skipped(self, error: BaseException) -> None:
        """Report an error after which the script continued, once per error type and position."""
        self.stopped, place = True, self.scripts.place(error)
        if (type(error), str(place)) not in self._skipped:
            self._skipped.add((type(error), str(place)))
            what = f"{_text(error)}; the script continues after the failed statement"
            self.recorder.findings.add("W302", what, place, *_advice(error), *self._around(error))

    def report_end(self, error: BaseException) -> None:
        """Report the error or exit that ended the script.

        The graphs that were built before are kept if the script had rendered frames, or if the error may occur only because
        Omniverse is missing (`keep`).
        """
        self._caught = [(caught, line) for caught, line in self._caught if caught is not error] + [(error, 0)]
        findings, place = self.recorder.findings, self.scripts.place(error)
        advice: Sequence[str] = ()
        keep = False
        match error:
            case SystemExit(code=None | 0):
                return
            case EndlessError():
                what = "the script runs in an endless loop, such as a simulation loop, and was stopped here"
                findings.add("N302", what, place, _LATER)
                return
            case SystemExit():
                what, keep = f"the script ended with exit({error.code!r})", True
                advice = _advice(error)
            case TimeIsUpError():
                what, self.may_differ = "the script takes longer than its time limit", False
            case MemoryError():
                what, self.may_differ = f"the script takes more than {MAX_MEMORY_BYTES >> 20} MiB", False
            case RecursionError():
                what = "the script recurses without end"
            case AccessDeniedError():
                what, *advice = f"not allowed for scripts: {error}".splitlines()
            case OmniGraphError():
                self.may_differ = self.recorder.parts <= MAX_PARTS  # other prims do not lower the number
                what, advice = f"{OmniGraphError.__name__}: {error}", [OPENED] * isinstance(error, NotThereError)
            case _:
                what, advice, keep = _text(error), _advice(error), True
        if self.recorder.graphs and (self.recorder.frames.drawn or keep):
            self.stopped = True
            findings.add("W302", what, place, f"the script ends here; {_LATER}", *advice)
        else:
            findings.add("G401", what, place, *advice, *self._around(error), *self.hints())

    def report_refused(self) -> None:
        """Report the calls that OmniGraph would also refuse, if the script caught the error and continued."""
        for error, handler in self._caught:
            if isinstance(error, OmniGraphError) and handler:
                codes = [frame.f_code for frame, _ in traceback.walk_tb(error.__traceback__)]
                looks = any(code.co_filename == og.__file__ and code.co_name in _LOOKS for code in codes)
                lost = ", ".join(getattr(error, "__notes__", ["the failed call"]))
                what = f"{error}; the script continues, but did not execute: {lost}"
                self.recorder.findings.add("N302" if looks else "W302", what, self.scripts.place(error))

    def report_unreached(self) -> None:
        """Report graph-building calls that were not reached, and graph-building functions that were not called."""
        scripts = list(self.scripts)
        foreign = self.recorder.lacking
        names = BUILDING | {one.name for one in builders(*(script.tree for script in scripts), foreign=foreign)}
        failures = {failure: None for caught in self._caught for failure in self._failures(*caught)}
        for script in scripts:
            for call, why in Unreached(script, self.ran, {*names, "set"}, failures, foreign).calls():
                if called(call) == "set" and not (call.args and self._in_callback(script, call)):
                    continue
                what = f"{called(call)}() is never reached, because of {why.text}"
                place = script.span(call.lineno, call.end_lineno, call.col_offset)
                remedies = *self._remedies(script, why.condition), *why.advice
                self.recorder.findings.add("W302", what, place, *remedies)
        main = self.scripts.main
        reach = Unreached(main, self.ran)
        never = [builder for builder in entries(main.tree, foreign) if not any(map(reach.ran, builder.node.body))]
        if never and self.recorder.graphs:
            texts = ", ".join(f"{builder.text} (line {builder.node.lineno})" for builder in never[:MOST_ASKED])
            more = f" and {len(never) - MOST_ASKED} more" if len(never) > MOST_ASKED else ""
            what = f"functions that build graphs are not called: {texts}{more}"
            lost = handed_over(main.tree) & {builder.node.name for builder in never}
            self.recorder.findings.add(
                "W302" if lost else "N302", what, None, "to import what one of them builds, add --call"
            )

    def _in_callback(self, script: Script, call: ast.Call) -> bool:
        lines = lines_of(self.recorder.callbacks)
        return any(path == script.source.path and first <= call.lineno <= last for path, first, last in lines)

    def report_conditions(self) -> None:
        """Report the conditions that were assumed to be false because only Omniverse knows their values."""
        missed = ((name, *place) for place, names in self.recorder.missed.items() for name in names)
        made = self.recorder.graph_of
        asked = [f"{name} (line {line} of {Path(path).name})" for name, path, line in missed if not made(name)]
        if asked and self.recorder.graphs:
            what = f"assumed to be false or absent, because only Omniverse knows their values: {', '.join(asked[:MOST_CALLABLE])}"
            what += f" and {len(asked) - MOST_CALLABLE} more" if len(asked) > MOST_CALLABLE else ""
            self.recorder.findings.add("N302", what, None, "--assume NAME assumes that NAME is true or exists")

    def hints(self) -> Iterator[str]:
        """Yield the last lines that the script printed, and functions in it that build graphs and can be called with `--call`."""
        yield from (f"the script printed: {line}" for line in self.recorder.said)
        main = self.scripts.main
        found, reach = entries(main.tree, self.recorder.lacking), Unreached(main, self.ran)
        if any(reach.ran(part) for builder in found for part in builder.node.body):
            found = builders(main.tree, foreign=self.recorder.lacking)  # the functions that ran would fail again
        if found:
            yield "the script defines functions that build graphs; call one: --call \"build('/World/robot', rate=2)\":"
            yield from (f"  {builder.text}, line {builder.node.lineno}" for builder in found[:MOST_CALLABLE])

    def _around(self, error: BaseException) -> Iterator[str]:
        """Yield `--assume` options that make the `if` conditions around an error true."""
        for script, (line, *_) in list(self.scripts.trace(error))[-1:]:
            for node in ast.walk(script.tree):
                if isinstance(node, ast.If) and holds(node, line):
                    yield from self._remedies(script, node.lineno)

    def _remedies(self, script: Script, line: int) -> Iterator[str]:
        """Yield `--assume` options that make the condition at a line true."""
        missed, path = self.recorder.missed, script.source.path
        asked = {name: said for at in asking(script.tree, line) for name, said in missed.get((path, at), {}).items()}
        for name, said in list(asked.items())[:MOST_ASKED]:
            yield f"--assume {quoted(name)} assumes that {said}"

    def _failures(self, error: BaseException, handler: int) -> Iterator[Failure]:
        """Yield the expressions of the script and its modules through which an error passed, outermost first."""
        found = list(self.scripts.trace(error))
        for script, position in found:
            inner, (line, *_) = found[-1]
            where = f"line {line}" if inner is script else f"line {line} of {Path(inner.source.path).name}"
            end = _ENDS.get(type(error))
            why = Why(f"the {end} at {where}" if end else f"the error at {where}: {_text(error)}", 0, _advice(error))
            entered = (script, position) != found[-1] or not handler or isinstance(error, OmniGraphError)
            yield Failure(script.source.path, position, why, entered, handler)


def _text(error: BaseException) -> str:
    """Return the type and message of an error as one text."""
    try:
        text = str(error).partition("\n")[0] if isinstance(error, AccessDeniedError) else str(error)
    except BaseException:  # `__str__` of a script's exception
        text = ""
    return f"{type(error).__name__}: {text[:1000] or 'no message'}"


def _advice(error: BaseException) -> tuple[str, ...]:
    """Return remedies for an error, such as a command line option; empty if none is known."""
    if isinstance(error, AccessDeniedError):
        return tuple(str(error).splitlines()[1:])
    if isinstance(error, SystemExit):
        return (_ARGUMENTS,) * (error.code == 2)
    trace = list(traceback.walk_tb(error.__traceback__))
    asked = trace and trace[-1][0].f_code is type(os.environ).__getitem__.__code__
    return (f"set the environment variable: --env {quoted(error.args[0])}=VALUE",) if asked else ()
