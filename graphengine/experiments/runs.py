"""The runs of scenarios: one for each case and seed. A shard is a fixed part of them."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from graphengine.api.scene_files import SceneFiles
from graphengine.experiments.scenario import Case, Scenario, find_scenarios, read_scenario
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError, UsageError

T = TypeVar("T")
NO_CASES = "shard {} has no cases"
"""Message about a shard without a run or test; the run then ends with the exit code 0."""


@dataclass(frozen=True, slots=True)
class Bundle:
    """A scenario with all files that its runs read.

    Attributes:
        scenario: the scenario.
        files: files of its scene; None if the scene has errors, which each run then reports.
        inputs: digest of the contents of the files.
    """

    scenario: Scenario
    files: SceneFiles | None
    inputs: str


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a case.

    Attributes:
        bundle: the scenario.
        case: one of its cases.
        number: number of the run of this case, which is added to the seed.
    """

    bundle: Bundle
    case: Case
    number: int


def plan_runs(paths: Sequence[str], *, scripts: bool = False) -> list[Run]:
    """Return all runs of the scenarios, in the order of the files, cases and seeds.

    Args:
        paths: scenario files, folders, or `FILE::CASE` for one case.
        scripts: whether graphs may run the Python code of their ScriptNodes.

    Raises:
        CheckError: scenario files have errors.
        UsageError: a path does not exist, or a file does not have the case.
    """
    findings, runs = Findings(), list[Run]()
    for file, name in dict.fromkeys(itertools.chain.from_iterable(map(_files, paths))):
        scenario = read_scenario(file, findings)
        if scenario is None:
            continue
        cases = {case.name: case for case in scenario.cases()}
        if name and name not in cases:
            raise UsageError(f"{file}: no case {name!r}; --collect-only lists the cases")
        bundle = _bundle(scenario, scripts)
        chosen = [cases[name]] if name else cases.values()
        runs += [Run(bundle, case, number) for case in chosen for number in range(scenario.spec.runs)]
    findings.raise_errors()
    return runs


def parse_shard(text: str) -> tuple[int, int]:
    """Return the number of a shard, from 0 on, and the number of shards; `3/8` is the third of eight.

    Raises:
        UsageError: the text is not a shard.
    """
    number, _, total = text.partition("/")
    if not (number.isdecimal() and total.isdecimal() and 1 <= int(number) <= int(total)):
        raise UsageError(f"--shard {text}: expected NUMBER/TOTAL, as 3/8 for the third of eight parts")
    return int(number) - 1, int(total)


def shard(items: Sequence[T], part: str | None) -> Sequence[T]:
    """Return the part of a sequence that belongs to a shard, such as `3/8`: each eighth item; None returns all."""
    if part is None:
        return items
    number, total = parse_shard(part)
    return items[number::total]


def _files(given: str) -> Iterator[tuple[Path, str]]:
    """Yield the scenario files of an argument, relative to the current folder if they are below it, each with a case or ''."""
    path, _, name = given.partition("::")
    if not os.path.exists(path):
        raise UsageError(f"{path}: no such file or folder")
    for file in find_scenarios(Path(path)):
        relative = os.path.relpath(file)
        yield Path(file.absolute() if relative.startswith("..") else relative), name


def _bundle(scenario: Scenario, scripts: bool) -> Bundle:
    files = None
    with contextlib.suppress(GraphError):  # each run reports it
        files = SceneFiles.of(scenario.load(allow_scripts=scripts))
    return Bundle(scenario, files, _digest([scenario.path.read_bytes(), *(files.contents if files else ())]))


def _digest(contents: Iterable[bytes]) -> str:
    """Return the digest of contents of files, independent of the names of the files and their folders."""
    digests = sorted(hashlib.blake2b(content, digest_size=16).digest() for content in contents)
    return hashlib.blake2b(b"".join(digests), digest_size=16).hexdigest()
