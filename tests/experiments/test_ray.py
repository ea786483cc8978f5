"""Runs on a Ray cluster have the rows of runs in processes; Ray makes runs again whose process was killed."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from graphengine.experiments.matrix import make_rows
from graphengine.experiments.ray_pool import RayPool
from graphengine.experiments.runs import plan_runs
from graphengine.experiments.worker_process import RunSettings
from graphengine.experiments.workers import Limits
from tests.experiments.falling import (
    ABORTS,
    FAILS,
    HANGS,
    PASSES,
    finish,
    processes,
    run,
    start,
    without_wall,
    write_scenario,
)
from tests.waiting import eventually

ray: Any = pytest.importorskip("ray")
pytestmark = pytest.mark.filterwarnings(
    "ignore::ResourceWarning", "ignore::DeprecationWarning", "ignore::FutureWarning"
)


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """The address of a cluster with two nodes."""
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    made.add_node(num_cpus=1)
    yield made.address
    made.shutdown()


def workers() -> list[int]:
    """Return the processes of Ray in which runs are made."""
    return processes(b"ray::make_here")


def test_200_cases_on_two_nodes_have_the_rows_of_processes(tmp_path: Path, cluster: str) -> None:
    write_scenario(tmp_path, range(100), [PASSES, FAILS])
    run(tmp_path, "--results", "processes.jsonl", "-n", "2", code=1)
    for number in range(1, 4):
        run(tmp_path, "--results", f"shard{number}.jsonl", "--shard", f"{number}/3", code=1)
    run(tmp_path, "merge", *(f"shard{number}.jsonl" for number in range(1, 4)), "-o", "shards.jsonl")
    run(tmp_path, "--results", "ray.jsonl", "--workers", f"ray:{cluster}", code=1)
    rows = without_wall(tmp_path / "ray.jsonl")
    assert len(rows) == 200
    assert rows == without_wall(tmp_path / "processes.jsonl") == without_wall(tmp_path / "shards.jsonl")


def test_crashes_and_hangs_have_the_same_rows_on_a_cluster(tmp_path: Path, cluster: str) -> None:
    write_scenario(tmp_path, [0], [PASSES, ABORTS, HANGS])
    limit = ("--time-limit", "5")
    run(tmp_path, "--results", "processes.jsonl", "-n", "2", *limit, code=1)
    run(tmp_path, "--results", "ray.jsonl", "--workers", f"ray:{cluster}", *limit, code=1)
    assert without_wall(tmp_path / "ray.jsonl") == without_wall(tmp_path / "processes.jsonl")


def test_a_killed_process_of_ray_and_a_killed_driver_leave_the_same_rows_in_the_end(
    tmp_path: Path, cluster: str
) -> None:
    write_scenario(tmp_path, range(60), [PASSES])
    run(tmp_path, "--results", "processes.jsonl", "-n", "2")
    path = tmp_path / "ray.jsonl"
    arguments = ("--results", "ray.jsonl", "--workers", f"ray:{cluster}")

    def lines() -> int:
        return path.read_bytes().count(b"\n") if path.exists() else 0

    with start(tmp_path, *arguments) as driver:
        assert eventually(lambda: lines() >= 5 and workers())
        os.kill(workers()[0], signal.SIGKILL)
        before = lines()
        assert eventually(lambda: lines() >= before + 5)
        driver.kill()
    assert lines() < 60
    finish(start(tmp_path, *arguments, "--resume"), 0)
    assert without_wall(path) == without_wall(tmp_path / "processes.jsonl")


def test_scene_files_are_sent_to_the_machines_of_ray_and_errors_name_the_original_paths(
    tmp_path: Path, cluster: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = write_scenario(tmp_path, [0], [PASSES])
    text = scenario.read_text(encoding="utf-8")
    scenario.write_text(text.replace("Script.harm: [0]", "Clock.topicName: [clock, no topic]"), encoding="utf-8")
    run(tmp_path, "--results", "processes.jsonl", code=1)
    monkeypatch.chdir(tmp_path)
    runs = plan_runs(["falls.scenario.yaml"], scripts=True)
    for name in ("falls.scenario.yaml", "scene.yaml", "graph.yaml", "world.xml"):
        (tmp_path / name).unlink()
    make_rows(runs, RayPool(cluster, RunSettings(scripts=True), Limits()), tmp_path / "ray.jsonl")
    passed, refused = (
        json.loads(row) for row in sorted((tmp_path / "ray.jsonl").read_text(encoding="utf-8").splitlines())
    )
    assert passed["outcome"] == "passed"
    assert refused["reason"].startswith("graph.yaml:")
    assert without_wall(tmp_path / "ray.jsonl") == without_wall(tmp_path / "processes.jsonl")
