"""The steps of scenarios, in real sessions."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import action_graph, service_graph
from tests.experiments.harness import DRIVING, result_of, scenario_file

X = 'pose("dd100").position[0]'


def passes(path: Path) -> float:
    result = result_of(path)
    assert result.outcome == "passed", result.report()
    return result.time


def test_a_run_without_expectations_ends_with_the_last_step(tmp_path: Path) -> None:
    assert passes(scenario_file(tmp_path, "do: [wait: 0.5s, wait: 250ms]\n")) == pytest.approx(0.75, abs=1 / 60)


def test_a_publication_ends_after_its_time_and_the_next_step_begins_at_once(tmp_path: Path) -> None:
    text = f"""
do:
  - {DRIVING.removesuffix("}")}, for: 1s}}
  - wait: 3s
expect:
  - settles: abs(velocity("dd100").linear[0]) < 0.01
    after: 2.9s
  - count: velocity("dd100").linear[0] > 0.45
    at_least: 1
"""
    passes(scenario_file(tmp_path, text))


def test_a_step_waits_for_a_condition(tmp_path: Path) -> None:
    time = passes(scenario_file(tmp_path, f"do:\n  - {DRIVING}\n  - wait: {X} > 0.5\n"))
    assert 1.0 < time < 2.0  # 0.25 s of acceleration, then 0.5 m/s


def test_a_step_waits_for_a_message(tmp_path: Path) -> None:
    assert passes(scenario_file(tmp_path, "do: [wait: {topic: /dd100_0000/odom}]\n")) < 0.1


def test_sequences_in_parallel_end_with_the_longest(tmp_path: Path) -> None:
    text = "do: [{parallel: [[wait: 0.2s, wait: 0.3s], [wait: 0.1s]]}, wait: 0.5s]\n"
    assert passes(scenario_file(tmp_path, text)) == pytest.approx(1.0, abs=1 / 60)


def test_commands_of_ctl_can_be_steps(tmp_path: Path) -> None:
    text = f"""
do:
  - move: {{entity: dd100, position: [3, 0]}}
  - wait: {X} > 2.9
  - push: {{entity: dd100, impulse: [0, 20, 0], duration: 100ms}}
  - set: {{address: DiffController.maxLinearSpeed, value: 0.2}}
  - {DRIVING}
  - wait: 2s
expect:
  - never: velocity("dd100").linear[0] > 0.25
"""
    passes(scenario_file(tmp_path, text))


def test_a_service_is_called_and_its_response_compared(tmp_path: Path) -> None:
    (tmp_path / "light.yaml").write_text(f"graph: light\n{service_graph.SERVER}")
    call = "call: {service: /light, request: {data: true}, response: {success: %s}}"
    passes(scenario_file(tmp_path, f"do: [{call % 'true'}]\n", scene="light.yaml"))
    result = result_of(scenario_file(tmp_path, f"do: [{call % 'false'}]\n", scene="light.yaml"))
    assert result.outcome == "error"
    assert "response of /light: expected success = False, got True" in result.reason


def test_a_goal_is_sent_and_its_status_compared(tmp_path: Path) -> None:
    (tmp_path / "count.yaml").write_text(f"graph: count\n{action_graph.SERVER}")
    action = "action: {name: /fibonacci, goal: {order: 3}, result: %s}"
    passes(scenario_file(tmp_path, f"do: [{action % 'succeeded'}]\n", scene="count.yaml"))
    result = result_of(scenario_file(tmp_path, f"do: [{action % 'canceled'}]\n", scene="count.yaml"))
    assert result.outcome == "error"
    assert "action /fibonacci: expected canceled, got succeeded" in result.reason
