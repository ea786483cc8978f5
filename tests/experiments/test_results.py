"""Results files: one row a run, resumed runs, shards, and what `graphrun test` says about files that it cannot use."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path

import pytest

from graphengine.experiments.pytest_command import reads_results
from graphengine.experiments.result_rows import ResultsFile, merged, read_rows
from graphengine.experiments.runs import parse_shard, shard
from graphengine.format.errors import UsageError
from tests.experiments.falling import FAILS, PASSES, STEP, G, rows, run, without_wall, write_scenario


def test_each_run_is_a_row_with_its_verdicts_metrics_and_digest(tmp_path: Path) -> None:
    write_scenario(tmp_path, [0, 1], [PASSES, FAILS])
    said = run(tmp_path, "--results", "rows.jsonl", "-n", "2", code=1)
    assert "4 runs: 2 failed, 2 passed" in said
    assert "failed: falls[1-5], seed 1: falls.scenario.yaml:6: failed: always" in said
    first, failed, second, _ = rows(tmp_path / "rows.jsonl")
    assert (first["file"], first["case"], first["seed"]) == ("falls.scenario.yaml", "falls[0-0]", 0)
    assert [row["outcome"] for row in (first, failed, second)] == ["passed", "failed", "passed"]
    assert [verdict["outcome"] for verdict in first["verdicts"]] == ["passed"] * 3
    # The ball falls by g * step**2 * n * (n + 1) / 2 in n ticks, and has the speed g * n * step.
    ticks = next(n for n in range(100) if G * STEP**2 * n * (n + 1) / 2 > 0.5)
    assert first["metrics"]["low"] == pytest.approx(ticks * STEP)
    assert first["metrics"]["speed"] == pytest.approx(-G * first["time"])
    assert first["verdicts"][0]["robustness"] == pytest.approx(4.5, abs=0.01)
    assert failed["verdicts"][0]["robustness"] == pytest.approx(-0.5, abs=0.01)
    assert first["metrics"]["number"] != second["metrics"]["number"]  # the noise has another seed
    assert first["digest"] == second["digest"]  # the clock has no noise
    assert failed["digest"] != first["digest"]  # it ended earlier
    assert first["inputs"] == failed["inputs"]


def test_shards_of_several_machines_merge_to_the_rows_of_one(tmp_path: Path) -> None:
    machines = [tmp_path / name for name in ("whole", "one", "two")]
    for folder in machines:
        folder.mkdir()
        write_scenario(folder, range(3), [PASSES, FAILS])
    run(machines[0], "--results", "rows.jsonl", code=1)
    for number, folder in enumerate(machines[1:], 1):
        run(folder, "--results", "rows.jsonl", "--shard", f"{number}/2", code=number % 2 == 0)
    run(tmp_path, "merge", "one/rows.jsonl", "two/rows.jsonl", "-o", "all.jsonl")
    assert without_wall(tmp_path / "all.jsonl") == without_wall(tmp_path / "whole" / "rows.jsonl")


def test_a_shard_without_runs_passes_and_says_so(tmp_path: Path) -> None:
    write_scenario(tmp_path, [0], [PASSES])
    assert "shard 2/2 has no cases" in run(tmp_path, "--results", "rows.jsonl", "--shard", "2/2")
    assert (tmp_path / "rows.jsonl").read_bytes() == b""
    run(tmp_path, "--results", "rows.jsonl", "--shard", "1/1", "--resume")
    assert len(rows(tmp_path / "rows.jsonl")) == 1


def test_a_resumed_matrix_makes_only_the_runs_that_are_missing(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, range(3), [PASSES])
    run(tmp_path, "--results", "rows.jsonl")
    path = tmp_path / "rows.jsonl"
    whole, before = path.read_bytes(), without_wall(path)
    path.write_bytes(whole[:-40])  # as a kill leaves it
    assert "3 runs: 1 passed" in run(tmp_path, "--results", "rows.jsonl", "--resume")
    assert without_wall(path) == before
    assert "nothing left to do" in run(tmp_path, "--results", "rows.jsonl", "--resume")
    assert "exists; continue it with --resume" in run(tmp_path, "--results", "rows.jsonl", code=4)
    scenario.write_text(scenario.read_text().replace("4.5", "4.4"))  # other inputs: other runs
    assert "3 runs: 3 passed" in run(tmp_path, "--results", "rows.jsonl", "--resume")
    assert len(rows(path)) == 6


def test_a_run_with_an_error_has_a_row_and_is_repeated_when_the_matrix_is_resumed(tmp_path: Path) -> None:
    write_scenario(tmp_path, [0], [PASSES])
    graph = tmp_path / "graph.yaml"
    text = graph.read_text()
    graph.write_text(text.replace("OnPlaybackTick", "OnPlaybackTock"))
    run(tmp_path, "--results", "rows.jsonl", code=1)
    (row,) = rows(tmp_path / "rows.jsonl")
    assert row["outcome"] == "error"
    assert "OnPlaybackTock" in row["reason"]
    graph.write_text(text)
    run(tmp_path, "--results", "rows.jsonl", "--resume")
    assert [row["outcome"] for row in rows(tmp_path / "rows.jsonl")] == ["passed"]


def test_a_failed_case_is_repeated_on_request(tmp_path: Path) -> None:
    write_scenario(tmp_path, [0], [PASSES, FAILS])
    said = run(tmp_path, "--results", "rows.jsonl", "--rerun", "3", code=1)
    assert "failed: falls[0-5], seed 0 (failed always, in 3 of 3)" in said
    passed, failed = rows(tmp_path / "rows.jsonl")
    assert "rerun" not in passed
    assert failed["rerun"] == "failed always, in 3 of 3"


NOISY = """
scenario: noisy
scene: scene.yaml
runs: 3
pass: PASS
expect: [{always: port("Script.number") < LIMIT}]
metrics: {number: {final: port("Script.number")}}
stop: {after: 0.01s}
"""


def test_as_many_runs_of_a_case_may_fail_as_the_scenario_allows(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, [], [])

    def noisy(passes: int, limit: float, code: int) -> list[float]:
        text = NOISY.replace("PASS", str(passes)).replace("LIMIT", str(limit))
        scenario.write_text(text, encoding="utf-8")
        run(tmp_path, "--results", "rows.jsonl", "--resume", code=code)
        lines = (tmp_path / "rows.jsonl").read_text(encoding="utf-8").splitlines()
        return sorted(json.loads(line)["metrics"]["number"] for line in lines[-3:])

    _, second, largest = noisy(3, 9.0, 0)
    limit = (second + largest) / 2  # which one of three runs exceeds
    noisy(3, limit, 1)
    noisy(2, limit, 0)


def test_only_one_process_writes_to_a_results_file(tmp_path: Path) -> None:
    first = ResultsFile(tmp_path / "rows.jsonl", resume=True)
    with pytest.raises(UsageError, match="another process writes to this file"):
        ResultsFile(tmp_path / "rows.jsonl", resume=True)
    first.close()
    ResultsFile(tmp_path / "rows.jsonl", resume=True).close()


def test_a_digest_of_all_topics_covers_topics_without_subscribers(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, [0], [PASSES])
    text = scenario.read_text(encoding="utf-8")
    scenario.write_text(text.replace("  - rate: {topic: /clock, at_least: 99, over: 0.1}\n", ""), encoding="utf-8")
    run(tmp_path, "--results", "read.jsonl")
    run(tmp_path, "--results", "all.jsonl", "--digest-all")
    (read,), (whole,) = rows(tmp_path / "read.jsonl"), rows(tmp_path / "all.jsonl")
    assert read["digest"] == hashlib.blake2b(b"", digest_size=16).hexdigest()
    assert whole["digest"] != read["digest"]
    assert whole["verdicts"] == read["verdicts"]


def test_a_line_that_is_not_a_row_is_reported_with_its_file_and_number(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text('{"a": 1}\n')
    with pytest.raises(UsageError, match=r"rows.jsonl:1: not a row of `graphrun test --results`"):
        read_rows(path)


def test_a_merged_file_has_each_run_once_and_prefers_rows_without_an_error() -> None:
    row = {"file": "a", "case": "c", "seed": 0, "inputs": "", "versions": {}, "outcome": "failed"}
    error, other = row | {"outcome": "error"}, row | {"seed": 3}
    assert merged([[row, error], [other], [error]]) == [row, other]


@pytest.mark.parametrize("total", [1, 3, 8])
def test_shards_share_all_items(total: int) -> None:
    parts = [shard(range(20), f"{number}/{total}") for number in range(1, total + 1)]
    assert sorted(item for part in parts for item in part) == list(range(20))
    assert {len(part) for part in parts} <= {math.floor(20 / total), math.ceil(20 / total)}


@pytest.mark.parametrize("text", ["", "3", "0/8", "9/8", "a/b", "-1/2", "1/0"])
def test_a_malformed_shard_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="expected NUMBER/TOTAL"):
        parse_shard(text)


@pytest.mark.parametrize(
    ("paths", "reads"),
    [
        (["show", "a.jsonl"], True),
        (["merge", "a.jsonl", "b.jsonl"], True),
        (["show"], False),
        (["show", "tests"], False),
        (["./show", "a.jsonl"], False),
        (["a.jsonl"], False),
    ],
)
def test_a_folder_named_show_is_not_lost(paths: list[str], reads: bool) -> None:
    assert reads_results(paths) == reads


def test_rows_are_json_for_all_types_of_parameters(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, [0], [PASSES])
    scenario.write_text(scenario.read_text().replace("Script.harm: [0]", "Script.harm: [.inf]"))
    run(tmp_path, "--results", "rows.jsonl", code=1)
    (row,) = [json.loads(line) for line in (tmp_path / "rows.jsonl").read_text().splitlines()]
    assert row["parameters"]["Script.harm"] is None
