"""Expectations that one generated function judges, compared with expectations that are judged alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.api.expectations.expectations import (
    Expectation,
    ExpectationCheck,
    always,
    count,
    holds,
    never,
    settles,
    until,
    within,
)

PORT = "port('OnPlaybackTick.time')"
EXPECTATIONS = (
    always("time < 5"),
    always(f"1 / (0.5 - {PORT}) != 0"),  # a division by zero at 0.5 s
    never(f"{PORT} > 0.8 and time < 4"),
    within(0.5, f"abs({PORT} - 0.3) < 0.01"),
    until(f"{PORT} < 0.7", "time ** 2 >= 0.25"),
    holds(0.2, f"0.3 <= {PORT} <= 0.6"),
    settles(0.5, f"{PORT} > 0.4"),
    count(f"sin(20 * {PORT}) > 0.5", at_least=2),
    always("time == inf or len([1, 2]) == 2"),
)


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[ge.Session]:
    (tmp_path / "tick.yaml").write_text("graph: tick\nnodes: {OnPlaybackTick: OnPlaybackTick}\n", encoding="utf-8")
    with ge.load(tmp_path / "tick.yaml").session() as session:
        yield session


def results(sim: ge.Session, *expectations: Expectation) -> list[str]:
    """The reports of expectations that begin together at time 0, after one second."""
    sim.reset()
    checks = [sim.expect(expectation) for expectation in expectations]
    sim.run(1.0)
    sim.end_expectations()
    return [f"{check.report()} {check.verdict if not check.error else ''}" for check in checks]


def test_expectations_that_are_judged_together_have_the_results_of_those_judged_alone(sim: ge.Session) -> None:
    alone = [*(results(sim, expectation)[0] for expectation in EXPECTATIONS)]
    assert results(sim, *EXPECTATIONS) == alone
    assert [report.partition(":")[0] for report in alone] == [
        *("passed", "error", "failed", "passed", "passed"),
        *("passed", "passed", "passed", "passed"),
    ]


def test_a_reset_judges_an_expectation_again_that_had_an_error(sim: ge.Session) -> None:
    broken, met = sim.expect(EXPECTATIONS[1], EXPECTATIONS[0])
    sim.run(0.6)
    assert (broken.outcome, met.outcome) == ("error", "open")
    sim.reset()
    sim.run(0.4)
    assert (broken.outcome, met.outcome) == ("open", "open")


def test_an_expectation_from_after_a_checkpoint_restarts_when_the_checkpoint_is_restored(sim: ge.Session) -> None:
    early = sim.expect(always("time < 0.3"))
    mark = sim.checkpoint()
    late: ExpectationCheck = sim.expect(within(0.3, "time > 5"))
    sim.run(0.5)
    assert (early.outcome, late.outcome) == ("failed", "failed")
    sim.restore(mark)
    sim.run(0.2)
    assert (early.outcome, late.outcome) == ("open", "open")


def test_a_judged_expectation_is_removed_and_the_others_go_on(sim: ge.Session) -> None:
    first, second = sim.expect(always("time < 0.3"), always("time < 0.9"))
    first.stop(sim._runner.after_ticks)
    sim.run(1.0)
    assert (first.outcome, second.outcome) == ("open", "failed")


def test_a_number_of_a_message_is_the_same_with_and_without_decoding_the_message() -> None:
    """The guard evaluates the second expression, and reads the decoded message."""
    number = "message('/dd100_0000/odom').twist.twist.linear.x"
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        quick, whole = sim.measure(ge.metric(mean=number)), sim.measure(ge.metric(mean=f"[{number}][0]"))
        sim.run(1.0)
        assert quick.value == whole.value
        assert quick.value is not None
        assert quick.value > 0.1
