"""`--env` and `--allow-scripts`: what graphs may do only when whoever runs them says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.harness import Graphrun

GRAPH = """
graph: asking
nodes:
  Tick: OnPlaybackTick
  Name: {type: ReadEnvVar, inputs: {envVar: ROBOT_NAME}}
  Greet:
    type: ScriptNode
    inputs:
      attributes: ["inputs:name string"]
      script: |
        def compute(db):
            db.log_info(f"hello, {db.inputs.name}")
connections:
  - Tick.tick -> Greet.execIn
  - Name.value -> Greet.name
"""
ALLOWED = ("--env", "ROBOT_NAME", "--allow-scripts")


@pytest.fixture
def asking(project: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (project / "asking.yaml").write_text(GRAPH, encoding="utf-8")
    monkeypatch.setenv("ROBOT_NAME", "dd100")
    return "asking.yaml"


def test_a_check_without_permissions_names_the_needed_options(graphrun: Graphrun, asking: str) -> None:
    result = graphrun("check", asking, code=1)
    assert "allow it with --env ROBOT_NAME" in result.out
    assert "dd100" not in result.out
    result = graphrun("check", asking, *ALLOWED[:2])  # the script hangs on the variable
    assert result.code == 1
    assert "read the code, then allow it with --allow-scripts" in result.out
    assert graphrun("check", asking, *ALLOWED).code == 0


def test_a_graph_with_permissions_runs(graphrun: Graphrun, asking: str) -> None:
    result = graphrun("run", asking, "--transport", "memory", "--for", "0.05", *ALLOWED, code=0)
    assert "info: /World/asking/Greet: hello, dd100" in result.err


def test_a_recording_grants_no_permissions(graphrun: Graphrun, asking: str) -> None:
    recorded = ("--transport", "memory", "--for", "0.05", "--record", "run.mcap")
    assert graphrun("run", asking, *recorded, *ALLOWED).code == 0
    refused = graphrun("replay", "run.mcap", *ALLOWED[:2])
    assert refused.code != 0
    assert "--allow-scripts" in refused.out + refused.err
    assert graphrun("replay", "run.mcap", *ALLOWED).code == 0
    assert b"dd100" not in Path("run.mcap").read_bytes()
