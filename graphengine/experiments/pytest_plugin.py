"""The pytest plugin: collects `*.scenario.yaml`, one test for each case, and gives tests a fixture `session`.

This module is imported by each start of pytest in an environment with graphengine; the parts of graphengine are imported when
pytest finds a scenario or a test uses the fixture.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from graphengine.experiments.scenario_options import add_scenario_options

if TYPE_CHECKING:
    from graphengine.api.session import Session
    from graphengine.experiments.case_run import CaseResult
    from graphengine.experiments.scenario import Case, Scenario

SUFFIX = ".scenario.yaml"
_IS_EMPTY_SHARD = pytest.StashKey[bool]()
"""Whether there are tests, but none in the shard; with xdist, the workers report it."""
_SESSIONS = pytest.StashKey[list["Session"]]()
"""Sessions that a test has started by the fixture."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of scenarios."""
    group = parser.getgroup("graphengine", "scenarios of graphengine")
    add_scenario_options(group.addoption)
    group.addoption(
        "--allow-scenario-scripts", action="store_true", help="let graphs run the Python code of their ScriptNodes"
    )


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the tests of the shard, after all other options have chosen tests."""
    if config.option.shard is not None:
        from graphengine.experiments.runs import shard
        from graphengine.format.errors import UsageError

        try:
            kept = shard(items, config.option.shard)
        except UsageError as error:
            raise pytest.UsageError(str(error)) from None
        config.hook.pytest_deselected(items=[item for item in items if item not in set(kept)])
        config.stash[_IS_EMPTY_SHARD] = bool(items) and not kept
        items[:] = kept


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Take over from a worker of xdist whether the shard has no tests."""
    node.config.stash[_IS_EMPTY_SHARD] = getattr(node, "workeroutput", {}).get("is_empty_shard", False)


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Let a shard without tests end with the exit code 0: there are more shards than tests."""
    empty = session.config.stash.get(_IS_EMPTY_SHARD, False)
    if empty and exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.OK
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["is_empty_shard"] = empty


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say that the shard has no tests."""
    if config.stash.get(_IS_EMPTY_SHARD, False):
        from graphengine.experiments.runs import NO_CASES

        terminalreporter.write_line(NO_CASES.format(config.option.shard))


def pytest_report_header(config: pytest.Config) -> list[str]:
    """Return the line about the bag; without a bag, nothing."""
    if config.option.bag is None:
        return []
    from graphengine.experiments.bag_case import IGNORED

    return [f"bag: {config.option.bag}; nothing is simulated; ignored in scenarios: {', '.join(IGNORED)}"]


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Collect scenario files."""
    return ScenarioFile.from_parent(parent, path=file_path) if file_path.name.endswith(SUFFIX) else None


class ScenarioFile(pytest.File):
    """A scenario file."""

    def collect(self) -> Iterator[pytest.Item]:
        """Return a test for each case of the matrix."""
        from graphengine.experiments.scenario import read_scenario
        from graphengine.format.diagnostics import Findings

        findings = Findings()
        scenario = read_scenario(self.path, findings)
        if scenario is None:
            raise self.CollectError("\n".join(finding.render() for finding in findings.sorted()))
        for case in _cases(scenario, self.config.option.bag):
            yield ScenarioItem.from_parent(self, name=case.name, scenario=scenario, case=case)


def _cases(scenario: Scenario, bag: Path | None) -> Iterable[Case]:
    if bag is None:
        return scenario.cases()
    from graphengine.experiments.bag_case import bag_case

    return [bag_case(scenario, bag)]


class ScenarioItem(pytest.Item):
    """One case of a scenario. The case runs in the setup phase: pytest reports exceptions there as errors, not failures."""

    def __init__(self, *, scenario: Scenario, case: Case, **arguments: Any) -> None:
        super().__init__(**arguments)
        self._scenario = scenario
        self._case = case
        self._failure = ""

    def setup(self) -> None:
        """Make the runs of the case."""
        super().setup()
        results = []
        for result in self._results():
            results.append(result)
            if result.outcome == "skipped":
                pytest.skip(result.reason)
        self._note(results)
        errors = [result for result in results if result.outcome == "error"]
        if errors:
            pytest.fail(errors[0].report(), pytrace=False)
        spec = self._scenario.spec
        passed = sum(result.outcome == "passed" for result in results)
        if passed < min(len(results), spec.pass_ or spec.runs):
            failed = next(result for result in results if result.outcome == "failed")
            parts = [_share(passed, len(results)), self._again(failed.seed - self._case.seed), failed.report()]
            self._failure = "\n".join(filter(None, parts))

    def _results(self) -> Iterator[CaseResult]:
        """Make the runs of the case, or judge the bag, and yield the results."""
        if self.config.option.bag is not None:
            from graphengine.experiments.bag_case import judge_on_bag

            yield judge_on_bag(self._scenario, self.config.option.bag)
            return
        from graphengine.experiments.artefacts import run_and_keep
        from graphengine.format.interrupts import by_sigterm

        parent, file = self.config.option.record_failures, self.nodeid.partition("::")[0]
        for run in range(self._scenario.spec.runs):
            with by_sigterm():  # so that started programs end
                result = run_and_keep(self._scenario, self._case, self._options(), parent, file, run=run)
            yield result

    def runtest(self) -> None:
        """Fail if too few runs passed."""
        if self._failure:
            pytest.fail(self._failure, pytrace=False)

    def _again(self, run: int) -> str:
        """Return how often a failed run fails with the same seed, if it is to be repeated."""
        from graphengine.experiments.case_run import run_case
        from graphengine.experiments.statistics import rerun_text

        number = self.config.option.rerun or 1
        if number == 1 or self.config.option.bag is not None:
            return ""
        again = [run_case(self._scenario, self._case, self._options(), run=run) for _ in range(number - 1)]
        return rerun_text(1 + sum(result.outcome != "passed" for result in again), number)

    def _note(self, results: list[CaseResult]) -> None:
        """Add the seeds and robustnesses of the first run to the report and to the JUnit file."""
        first = results[0]
        self.user_properties.append(("seed", first.seed))
        self.user_properties += [(f"robustness: {check.text}", check.robustness) for check in first.checks]
        self.user_properties += [(f"metric: {name}", value) for name, value in first.metrics.items()]
        if first.domain is not None:
            self.add_report_section("setup", "graphengine", f"ROS domain {first.domain}\n")

    def _options(self) -> Any:
        from graphengine.experiments.case_run import CaseOptions

        options = self.config.option
        return CaseOptions(programs=options.allow_programs, scripts=options.allow_scenario_scripts)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return file, line and name of the test."""
        return self.path, 0, self.name


def _share(passed: int, runs: int) -> str:
    from graphengine.experiments.statistics import wilson_interval

    if runs == 1:
        return ""
    low, high = wilson_interval(passed, runs)
    return f"{passed} of {runs} runs passed; with a confidence of 95 %, {low:.1%} to {high:.1%} of all runs pass"


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, object, object]:
    """Judge the sessions of the fixture after a test has passed; a missed expectation is a failure of the test."""
    result = yield
    missed = []
    for one in pyfuncitem.stash.get(_SESSIONS, []):
        from graphengine.format.errors import GraphError

        try:
            one.judge()
        except GraphError as error:
            missed.append(str(error))
    if missed:
        pytest.fail("\n".join(missed), pytrace=False)
    return result


@pytest.fixture
def session(request: pytest.FixtureRequest) -> Iterator[Callable[..., Session]]:
    """Return a function that starts a session of a scene; its arguments are those of `Scene.session`, and `set` of `load`.

        def test_it_stays(session):
            sim = session("dd100_flat", seed=1)
            sim.expect(ge.always("tilt('dd100') < 0.1"))
            sim.run(2.0)

    At the end of a test that has passed, the expectations of its sessions are judged. Then the sessions are closed.
    """
    from contextlib import ExitStack

    from graphengine.api.scene import Scene
    from graphengine.api.scene_loading import load

    with ExitStack() as closing:
        started: list[Session] = []
        request.node.stash[_SESSIONS] = started

        def start(source: Any, *, set: Mapping[str, Any] | None = None, **options: Any) -> Session:
            scene = source if isinstance(source, Scene) else load(source, set=set or {})
            started.append(closing.enter_context(scene.session(**options)))
            return started[-1]

        yield start
