"""Scenario files: a scene, what happens in it, and what is expected; and their cases, one for each combination of the matrix."""

from __future__ import annotations

import itertools
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from graphengine.api.expectations.conditions import parse
from graphengine.api.expectations.readings import READINGS
from graphengine.api.scene import Scene
from graphengine.api.scene_loading import load
from graphengine.experiments.operator_specs import ExpectationSpec, MetricSpec
from graphengine.experiments.steps import StepSpec
from graphengine.format.diagnostics import CheckError, Finding, Findings
from graphengine.format.document import Document, Location
from graphengine.format.document import load as load_document
from graphengine.format.errors import UsageError
from graphengine.format.files import find_file
from graphengine.format.legal_names import Name
from graphengine.format.scene_spec import LockstepSpecs, MoverSpec
from graphengine.format.spec import FileSpec, Format, Period
from graphengine.format.spec_reader import Loaded, read
from graphengine.format.wording import printable

SUFFIX = ".scenario.yaml"
MAX_CASES = 100_000
"""Maximum number of cases of one file."""
SEED = "seed"
"""Key of the matrix that sets the seed of all random generators."""


class StopSpec(FileSpec):
    """When a run ends at the latest; it ends earlier when all expectations are decided, or one has failed."""

    after: Period = 60.0
    """Simulation time."""


class ScenarioSpec(FileSpec):
    """A scenario file."""

    format: Format = 1
    scenario: Name
    """Name of the scenario."""
    doc: str = ""
    """Description for readers of the file."""
    scene: str
    """Scene: a file, relative to this file, or the name of a scene of the package, such as dd100_warehouse."""
    seed: int = 0
    """Seed of all random generators."""
    set: dict[str, Any] = {}
    """Values of inputs by address `[robot/][graph/]Node.port`, as the option `--set` of `graphrun run`."""
    matrix: dict[str, Annotated[tuple[Any, ...], Field(strict=False)]] = {}
    """Values to vary: lists by `seed`, or by the address of an input; each combination is a case of its own."""
    runs: int = Field(default=1, ge=1, le=MAX_CASES, description="Number of runs of each case, with successive seeds.")
    pass_: int | None = Field(
        default=None, alias="pass", ge=1, description="Number of runs that must pass; default: all."
    )
    requires: tuple[str, ...] = Field(default=(), strict=False)
    """Python packages and programs without which the scenario is skipped, such as rclpy or nav2_bt_navigator."""
    transport: Literal["memory", "auto", "dds", "rclpy"] | None = None
    """Network of the session; default: `auto` if a step starts a program, else `memory`, without a network."""
    movers: dict[Name, MoverSpec] = {}
    """Persons, vehicles and things that move, as the key `movers` of a scene, in addition to those of the scene."""
    lockstep: LockstepSpecs | None = None
    """Topics on which the run waits for a program, as the key `lockstep` of a scene; replaces that of the scene."""
    do: tuple[StepSpec, ...] = Field(default=(), strict=False)
    """Steps, executed one after the other."""
    expect: tuple[ExpectationSpec, ...] = Field(default=(), strict=False)
    """What is expected of the run."""
    metrics: dict[Name, MetricSpec] = {}
    """Numbers that describe the run, by name, as {top_speed: {max: velocity("dd100").linear[0]}}."""
    stop: StopSpec = StopSpec()
    """When the run ends, as {after: 30s}."""

    @model_validator(mode="after")
    def _can_fail(self) -> ScenarioSpec:
        if not self.expect and not self.do:
            raise ValueError("the scenario has neither steps (`do`) nor expectations (`expect`)")
        empty = [name for name, values in self.matrix.items() if not values]
        if empty:
            raise ValueError(f"matrix: {empty[0]!r} has no values")
        if self.pass_ is not None and self.pass_ > self.runs:
            raise ValueError(f"pass: {self.pass_} of {self.runs} runs cannot pass")
        return self

    @property
    def starts_programs(self) -> bool:
        """Whether a step starts a program."""
        steps: list[Any] = list(self.do)
        for step in self.do:
            steps += itertools.chain(*(step.parallel or ()))
        return any(step.start is not None for step in steps)


@dataclass(frozen=True, slots=True)
class Case:
    """One combination of a scenario's matrix.

    Attributes:
        name: name such as `stops_before_the_pallet[0-0.6]`, as pytest writes the values of parameters.
        parameters: values of the matrix by key.
        seed: seed of the first run.
        settings: values of inputs by address.
    """

    name: str
    parameters: dict[str, Any]
    seed: int
    settings: dict[str, Any]


class Scenario:
    """A scenario, read from a file that has no errors.

    Args:
        loaded: spec of the scenario, and the document with the positions of its entries.
    """

    def __init__(self, loaded: Loaded[ScenarioSpec]) -> None:
        self.spec = loaded.spec
        self.document = loaded.document
        self.path = loaded.document.path

    @property
    def scene(self) -> str:
        """Path of the scene, or its name if it belongs to the package.

        Raises:
            UsageError: the scene lies neither in the folder of the scenario, nor in the current folder, nor below one of these.
        """
        beside = self.path.parent / self.spec.scene
        if not beside.is_file():
            return self.spec.scene
        if not any(beside.resolve().is_relative_to(folder.resolve()) for folder in (self.path.parent, Path.cwd())):
            text = f"{self.spec.scene} lies outside of the folder of the scenario and of the current folder"
            raise UsageError(f"{text}; start in a folder that contains both")
        return str(beside)

    def load(self, settings: Mapping[str, Any] = MappingProxyType({}), *, allow_scripts: bool = False) -> Scene:
        """Load the scene, with the movers of the scenario.

        Args:
            settings: values of inputs by address.
            allow_scripts: whether graphs may run the Python code of their ScriptNodes.

        Raises:
            CheckError: the scene has errors.
            UsageError: there is no such scene.
        """
        if not self.spec.movers:
            return load(self.scene, set=settings, allow_scripts=allow_scripts)
        path, findings = find_file(self.scene), Findings()
        document = load_document(path, findings)
        findings.raise_errors()
        assert document is not None
        own = {name: mover.model_dump(mode="json", exclude_unset=True) for name, mover in self.spec.movers.items()}
        for mover in own.values():
            if (self.path.parent / mover["shape"]).is_file():
                mover["shape"] = os.path.relpath(self.path.parent / mover["shape"], path.parent)
        scene = {**document.data, "movers": {**(document.data.get("movers") or {}), **own}}
        try:
            return load(scene, folder=path.parent, set=settings, allow_scripts=allow_scripts)
        except CheckError as error:
            raise CheckError([self._placed(finding, document) for finding in error.findings]) from None

    def _placed(self, finding: Finding, scene: Document) -> Finding:
        """Return a finding with its place in the scenario if it is about a mover of the scenario, otherwise in the scene."""
        if finding.span is None or not (key := finding.span.source.keys.get(finding.span.line)):
            return finding
        location = key.partition("[")[0].split(".")
        is_own = location[0] == "movers" and self.document.find(*location[:2]) is not None
        return replace(finding, span=(self.document if is_own else scene).span(*location))

    def place(self, *location: str | int) -> str:
        """Return the place of an entry, as `FILE:LINE`."""
        return f"{self.path}:{self.document.span(*location).line}"

    def cases(self) -> Iterator[Case]:
        """Return the cases, in the order in which pytest runs the parameters of a test."""
        keys = list(self.spec.matrix)
        named = [
            [(value, _shown(key, value, index)) for index, value in enumerate(values)]
            for key, values in self.spec.matrix.items()
        ]
        for choice in itertools.product(*named):
            parameters = {key: value for key, (value, _) in zip(keys, choice, strict=True)}
            label = "-".join(shown for _, shown in choice)
            seed = parameters.get(SEED, self.spec.seed)
            varied = {key: value for key, value in parameters.items() if key != SEED}
            name = f"{self.spec.scenario}[{label}]" if keys else self.spec.scenario
            yield Case(name, parameters, seed, {**self.spec.set, **varied})


def read_scenario(path: str | os.PathLike[str], findings: Findings) -> Scenario | None:
    """Read and check a scenario file; return None after errors, which are added to `findings` with their positions."""
    loaded = read(ScenarioSpec, path, findings)
    if loaded is None:
        return None
    scenario, spec = Scenario(loaded), loaded.spec
    number = 1
    for values in spec.matrix.values():
        number *= len(values)
    if number * spec.runs > MAX_CASES:
        text = f"matrix: {number * spec.runs} runs; at most {MAX_CASES} are possible"
        findings.add("G105", text, loaded.document.key_span("matrix"))
    for value in spec.matrix.get(SEED, ()):
        if type(value) is not int:
            findings.add("G108", f"seed: expected whole numbers, got {value!r}", loaded.document.span("matrix", SEED))
    names = [case.name for case in scenario.cases()] if not findings.errors else []
    for name, number in Counter(names).items():
        if number > 1:
            findings.add("G109", f"matrix: {number} cases have the name {name}", loaded.document.key_span("matrix"))
    for location, check in _checks(spec):
        try:
            check()
        except UsageError as error:
            findings.add("G109", str(error), loaded.document.span(*location))
    return scenario if not findings.errors else None


def _checks(spec: ScenarioSpec) -> Iterator[tuple[Location, Callable[[], object]]]:
    """Yield the location of each expectation, metric and condition of a step, with a function that raises UsageError."""
    for index, expectation in enumerate(spec.expect):
        yield ("expect", index), partial(_check_expectation, expectation)
    for name, metric in spec.metrics.items():
        yield ("metrics", name), partial(parse, metric.metric().text, READINGS)
    for index, step in enumerate(spec.do):
        for text in step.conditions():
            yield ("do", index), partial(parse, text, READINGS)


def _check_expectation(given: ExpectationSpec) -> None:
    for condition in given.expectation().conditions:
        parse(condition, READINGS)


def find_scenarios(path: Path) -> list[Path]:
    """Return the scenario files below a folder, sorted, or the file itself."""
    return sorted(path.rglob(f"*{SUFFIX}")) if path.is_dir() else [path]


def _shown(key: str, value: Any, index: int) -> str:
    """Return a value as pytest writes it in the name of a test."""
    return printable(str(value)) if isinstance(value, str | int | float | bool) else f"{key.rpartition('.')[2]}{index}"
