"""Runs one case of a scenario and returns its result."""

from __future__ import annotations

import importlib.util
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from graphengine.api.expectations.expectations import ExpectationCheck
from graphengine.api.expectations.metrics import Measurement
from graphengine.api.run_options import Log
from graphengine.api.scene import Scene
from graphengine.api.session import Session
from graphengine.experiments.domains import free_domain
from graphengine.experiments.programs import Programs
from graphengine.experiments.scenario import Case, Scenario
from graphengine.experiments.step_context import StepContext
from graphengine.experiments.steps import Ticks, perform_all
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.wording import printable

Result = Literal["passed", "failed", "error", "skipped"]
LOOK = 0.1
"""Simulation time between two looks at the programs that a scenario started, s."""


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The result of one expectation.

    Attributes:
        text: the expectation.
        place: its place, `FILE:LINE`.
        outcome: `open` if the run ended with an error before it was decided.
        robustness: distance from the other outcome, in the unit of the condition; NaN if it had no value.
        decided: simulation time of the decision, s; None if it was not decided.
        report: outcome and reason, in several lines.
    """

    text: str
    place: str
    outcome: str
    robustness: float
    decided: float | None
    report: str


@dataclass(slots=True)
class CaseResult:
    """The result of one run of a case.

    Attributes:
        name: name of the case.
        parameters: values of the matrix.
        seed: seed of the run.
        outcome: `error` if the run could not be made or judged.
        reason: why it was skipped or could not be made; empty otherwise.
        checks: results of the expectations, in the order of the file.
        metrics: metrics of the scenario by name; None stands for a metric without a value.
        digest: digest of the bytes of all messages that nodes published; empty if it was not wanted.
        time: simulation time at the end, s.
        kept: report of a run that did not pass; None if nothing was kept.
        domain: ROS domain of the run; None without a network.
    """

    name: str
    parameters: Mapping[str, Any]
    seed: int
    outcome: Result = "error"
    reason: str = ""
    checks: list[CheckResult] = field(default_factory=list)
    metrics: dict[str, float | None] = field(default_factory=dict)
    digest: str = ""
    time: float = 0.0
    kept: Path | None = None
    domain: int | None = None

    def report(self) -> str:
        """Return the reason or the reports of the expectations that did not pass."""
        lines = [self.reason] if self.reason else []
        lines += [f"{check.place}: {check.report}" for check in self.checks if check.outcome in ("failed", "error")]
        lines += [f"kept: {self.kept}"] if self.kept is not None else []
        return "\n".join(map(printable, "\n".join(lines).split("\n")))


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseOptions:
    """How cases are run.

    Attributes:
        record: file for a recording of the run; None records nothing.
        programs: whether scenarios may start programs.
        scripts: whether graphs may run the Python code of their ScriptNodes.
        outputs: folder for the outputs of started programs; None keeps none.
        log: receives the messages of nodes, as the argument of `Scene.session`; None logs them.
        digest: whether the digest of the output covers all topics, or only those with subscribers; None computes no digest.
        load: loads the scene, as `Scenario.load`.
        watch: called with the session before the first tick.
        at_end: called with the session and its expectations at the end of a run that did not pass, while the session is open.
    """

    record: Path | None = None
    programs: bool = False
    scripts: bool = False
    outputs: Path | None = None
    log: Log | None = None
    digest: bool | None = None
    load: Callable[..., Scene] = Scenario.load
    watch: Callable[[Session], object] = lambda session: None
    at_end: Callable[[Session, list[ExpectationCheck]], object] = lambda session, checks: None


def run_case(scenario: Scenario, case: Case, options: CaseOptions = CaseOptions(), *, run: int = 0) -> CaseResult:
    """Run a case once and return its result; a mistake in the files is an outcome, not an exception.

    Args:
        scenario: the scenario.
        case: one of its cases.
        options: how it is run.
        run: number of the run, which is added to the seed.
    """
    result = CaseResult(case.name, case.parameters, case.seed + run)
    missing = [name for name in scenario.spec.requires if not _is_there(name)]
    if missing:
        result.outcome, result.reason = "skipped", f"requires {', '.join(missing)}"
        return result
    try:
        with ExitStack() as closing:
            _run(scenario, case, options, result, closing)
    except CheckError as error:
        result.outcome, result.reason = "error", str(error)
    except GraphError as error:
        result.outcome, result.reason = "error", f"{scenario.path}: {error}"
    return result


def _run(scenario: Scenario, case: Case, options: CaseOptions, result: CaseResult, closing: ExitStack) -> None:
    spec = scenario.spec
    transport = spec.transport or ("auto" if spec.starts_programs else "memory")
    domain = None
    if transport != "memory":
        domain = result.domain = closing.enter_context(free_domain())
    environ = os.environ | ({} if domain is None else {"ROS_DOMAIN_ID": str(domain)})
    try:
        scene = options.load(scenario, case.settings, allow_scripts=options.scripts)
    except UsageError as error:
        result.reason = _of_loading(scenario, str(error))
        return
    lockstep = spec.lockstep
    session = closing.enter_context(
        scene.session(
            transport=transport,
            seed=result.seed,
            domain=domain,
            record=options.record,
            force=options.record is not None,
            log=options.log,
            lockstep=[entry.model_dump() for entry in lockstep] if lockstep is not None else None,
        )
    )
    outputs = options.outputs or Path(closing.enter_context(tempfile.TemporaryDirectory(prefix="graphengine-")))
    programs = Programs(scenario.path.parent, environ, outputs, options.programs)
    closing.callback(programs.close)
    play = _Play(scenario, StepContext(session, programs))
    output = session.digest_output(everything=options.digest) if options.digest is not None else None
    try:
        play.begin(traced=options.record is not None)
        options.watch(session)
        session.run(spec.stop.after, until=play.advance)
        play.end()
    except GraphError as error:
        result.reason = f"{play.place}: {error}"
    result.time = session.time
    result.checks = [check_result(scenario, index, check) for index, check in enumerate(play.checks)]
    result.metrics = {name: measurement.value for name, measurement in play.measurements.items()}
    result.digest = output.value if output is not None else ""
    outcomes = {check.outcome for check in result.checks}
    if not result.reason and play.unfinished and "failed" not in outcomes:
        result.reason = f"{play.place}: the run ended at {session.time:.3f} s before this step did"
    result.outcome = "error" if result.reason or "error" in outcomes else "failed" if "failed" in outcomes else "passed"
    if result.outcome != "passed":
        options.at_end(session, play.checks)


def _of_loading(scenario: Scenario, error: str) -> str:
    """Return an error of loading the scene, with the place of the value or of the scene that it is about."""
    given = [(section, key) for section in ("matrix", "set") for key in getattr(scenario.spec, section)]
    about = next((where for where in given if error.startswith(f"--set {where[1]}")), ("scene",))
    return f"{scenario.place(*about)}: {error.removeprefix('--set ')}"


class _Play:
    """The expectations and the steps of one run."""

    def __init__(self, scenario: Scenario, context: StepContext) -> None:
        self._scenario, self._context = scenario, context
        self.checks: list[ExpectationCheck] = []
        self.measurements: dict[str, Measurement] = {}
        self._steps: Ticks = iter(())
        self._looked = 0.0
        self.unfinished = True
        self.place = str(scenario.path)
        """Place of the present expectation or step."""

    def begin(self, *, traced: bool) -> None:
        """Begin to judge, and prepare the first step; `traced` keeps the margins of all samples."""
        for index, entry in enumerate(self._scenario.spec.expect):
            self.place = self._scenario.place("expect", index)
            self.checks.append(self._context.session.expect(entry.expectation()))
            self.checks[-1].trace = [] if traced else None
        for name, metric in self._scenario.spec.metrics.items():
            self.place = self._scenario.place("metrics", name)
            self.measurements[name] = self._context.session.measure(metric.metric())
        self._steps = self._perform()

    def _perform(self) -> Ticks:
        for index, step in enumerate(self._scenario.spec.do):
            self.place = self._scenario.place("do", index)
            yield from perform_all([step], self._context)
        self.unfinished = False
        self.place = str(self._scenario.path)

    def advance(self, session: Session) -> bool:
        """Continue the steps between two ticks; return whether the run is over."""
        if session.decided() and not (self.unfinished and all(check.outcome == "passed" for check in self.checks)):
            return True
        self._context.end_publications()
        if self.unfinished:
            next(self._steps, None)
        if abs(session.time - self._looked) >= LOOK:
            self._looked = session.time
            self._context.programs.check()
        return not self.checks and not self.unfinished and not self._context.ending and session.tick > 0

    def end(self) -> None:
        """Decide all open expectations, unless a failure has ended the run early."""
        self._context.programs.check()
        self._context.session.end_expectations()


def check_result(scenario: Scenario, index: int, check: ExpectationCheck) -> CheckResult:
    """Return the result of the expectation at an index of `expect`."""
    verdict = check.verdict
    place = scenario.place("expect", index)
    return CheckResult(
        check.expectation.text, place, check.outcome, verdict.robustness, verdict.decided, check.report()
    )


def _is_there(name: str) -> bool:
    """Return whether a Python package or a program of this name is installed; nothing is imported."""
    try:
        return importlib.util.find_spec(name.partition(".")[0]) is not None or shutil.which(name) is not None
    except (ImportError, ValueError):
        return shutil.which(name) is not None
