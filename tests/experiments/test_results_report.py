"""What `graphrun test show` says: rates with Wilson's interval, and the worst runs with the commands that run them again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from graphengine.cli import main
from graphengine.experiments.results_report import report


def row(value: float, seed: int, outcome: str, robustness: float | None = None) -> dict[str, Any]:
    return {
        "scenario": "s",
        "file": "a b.scenario.yaml",
        "case": f"s[{value}]",
        "parameters": {"speed": value},
        "seed": seed,
        "inputs": "",
        "outcome": outcome,
        "reason": f"because\nof {seed}" if outcome != "passed" else "",
        "verdicts": [{"robustness": robustness}, {"robustness": 9.0}, {"robustness": None}],
        "versions": {},
    }


ROWS = [row(0.5, seed, "passed", 0.1) for seed in range(18)]
ROWS += [row(0.5, 18, "failed", -0.2), row(0.5, 19, "failed", -0.7), row(1.0, 0, "error")]


def test_rates_have_the_interval_of_wilson() -> None:
    lines = list(report(ROWS))
    assert lines[0] == "21 runs: 1 error, 2 failed, 18 passed"
    # Wilson's interval of 18 of 20: (p + z²/2n ± z √(p (1 - p) / n + z²/4n²)) / (1 + z²/n)
    z, n, p = 1.959963984540054, 20, 0.9
    half = z * (p * (1 - p) / n + z * z / (4 * n * n)) ** 0.5
    low, high = ((p + z * z / (2 * n) + sign * half) / (1 + z * z / n) for sign in (-1, 1))
    assert lines[1:5] == [
        "scenario  parameter  value  passed  errors  rate   95 % interval",
        f"s                           18/20   1       90.0%  {low:.1%} to {high:.1%}",
        f"s         speed      0.5    18/20   0       90.0%  {low:.1%} to {high:.1%}",
        "s         speed      1.0    0/0     1",
    ]


def test_the_worst_runs_come_first_with_their_commands() -> None:
    lines = list(report(ROWS))
    assert lines[5:10] == [
        "\nfailed: s[0.5], seed 19",
        "  because",
        "  of 19",
        "  graphrun test 'a b.scenario.yaml::s[0.5]' --record-failures failures",
        "\nfailed: s[0.5], seed 18",
    ]
    assert lines[-4] == "\nerror: s[1.0], seed 0"


def test_ten_runs_are_named_and_control_characters_are_not_printed() -> None:
    rows = [row(1.0, seed, "failed", -1.0) | {"reason": "\x1b[31mred"} for seed in range(30)]
    lines = list(report(rows))
    assert sum(line.startswith("\nfailed") for line in lines) == 10
    assert not any("\x1b" in line for line in lines)


def test_show_and_merge_read_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("one.jsonl").write_text("".join(f"{json.dumps(each)}\n" for each in ROWS[10:]), encoding="utf-8")
    Path("two.jsonl").write_text("".join(f"{json.dumps(each)}\n" for each in ROWS[:12]), encoding="utf-8")
    assert main(["test", "merge", "one.jsonl", "two.jsonl", "-o", "all.jsonl"]) == 0
    assert main(["test", "show", "all.jsonl"]) == 0
    assert capsys.readouterr().out == "".join(f"{line}\n" for line in report(ROWS))
    assert main(["test", "merge", "one.jsonl"]) == 4
    assert "give the file to write with -o FILE" in capsys.readouterr().err
    assert main(["test", "show", "none.jsonl"]) == 4
    assert "none.jsonl: no such file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--results", "r.jsonl", "-k", "x"], "-k: not with --results"),
        (["--resume"], "--resume: only with --results"),
        (["--workers", "ray"], "--workers: only with --results"),
        (["-o", "x"], "--output: only with merge"),
        (["--results", "r.jsonl", "--workers", "slurm"], "expected ray, ray:auto or ray:ADDRESS"),
        (["--results", "r.jsonl", "-n", "0"], "expected a number of at least 1, or auto"),
        (["--results", "r.jsonl", "nothing"], "nothing: no such file or folder"),
        (["--results", "r.jsonl", "--shard", "9/8"], "expected NUMBER/TOTAL"),
    ],
)
def test_arguments_that_do_not_belong_together_are_refused(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["test", *arguments]) == 4
    assert message in " ".join(capsys.readouterr().err.split())
