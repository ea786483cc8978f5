"""Expectations in real sessions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.api.expectations.expectations import (
    Expectation,
    always,
    count,
    holds,
    latency,
    never,
    rate,
    settles,
    until,
    within,
)
from graphengine.format.errors import ExpectationError, UnknownEntityError, UsageError

DRIVE = {"linear": {"x": 0.5}}


@pytest.fixture
def sim() -> Iterator[ge.Session]:
    with ge.load("dd100_flat").session() as session:
        yield session


def test_a_drive_to_a_point_meets_its_expectations_and_ends_when_all_are_decided(sim: ge.Session) -> None:
    start = sim.robots["dd100"].pose.position
    stays = sim.expect(always("tilt('dd100') < 0.1"))
    arrives = sim.expect(within(6.0, f"distance('dd100', [{start[0] + 1.0}, {start[1]}]) < 0.05"))
    sim.publish("/dd100_0000/cmd_vel", DRIVE, every=0.1)
    assert not sim.run(4.0, until=sim.decided)  # `always` is open as long as the run goes on
    sim.judge()
    assert (stays.outcome, arrives.outcome) == ("passed", "passed")
    assert arrives.verdict.decided == pytest.approx(2.0, abs=0.4)  # 0.95 m at 0.5 m/s
    assert 0.05 < stays.verdict.robustness < 0.1


def test_a_failed_expectation_ends_the_run_and_is_reported_with_its_values(sim: ge.Session) -> None:
    slow = sim.expect(always("velocity('dd100').linear[0] < 0.2"))
    sim.publish("/dd100_0000/cmd_vel", DRIVE, every=0.1)
    assert sim.run(4.0, until=sim.decided)
    assert slow.outcome == "failed"
    assert sim.time == slow.verdict.decided
    with pytest.raises(ExpectationError, match="failed: always velocity") as raised:
        sim.judge()
    assert isinstance(raised.value, AssertionError)
    report = str(raised.value).splitlines()
    assert report[1] == f"  decided at {sim.time:.3f} s"
    assert report[-1].startswith("  velocity('dd100') = linear (0.2")


def test_the_rate_and_latency_of_a_scan_topic_match_the_lidar(sim: ge.Session) -> None:
    topic = "/dd100_0000/sim_lidar/scan"
    met = sim.expect(rate(topic, at_least=5.0))
    too_fast, fresh = sim.expect(rate(topic, at_least=100.0)), sim.expect(latency(topic, 0.001))
    sim.run(2.5)
    with pytest.raises(ExpectationError):
        sim.judge()
    assert (met.outcome, too_fast.outcome, fresh.outcome) == ("passed", "failed", "passed")
    assert met.verdict.robustness == pytest.approx(too_fast.verdict.robustness + 100.0 - 5.0)
    assert fresh.verdict.robustness == pytest.approx(0.001)


def test_a_contact_counts_in_each_physics_step(sim: ge.Session) -> None:
    ground = sim.expect(always("contact('dd100', 'floor')"))
    walls = sim.expect(never("contact('dd100', '/World/wall*')"))
    lifted = sim.expect(count("contact('dd100', 'floor')", at_least=1, at_most=1))
    sim.run(0.5)
    sim.judge()
    assert {check.outcome for check in (ground, walls, lifted)} == {"passed"}


@pytest.mark.parametrize(
    ("expectation", "outcome", "robustness"),
    [
        (until("time < 1", "time >= 0.5"), "passed", None),
        (until("time < 0.3", "time >= 0.5"), "failed", None),
        (holds(0.5, "time > 0.4"), "passed", 0.1),
        (holds(0.7, "time > 0.4"), "failed", -0.1),
        (settles(0.5, "time > 0.4"), "passed", 0.1),
        (settles(0.2, "time > 0.4"), "failed", -0.2),
        (within(0.5, "time > 0.4"), "passed", 0.1),
        (count("port('OnPlaybackTick.time') > 0.5", at_least=2), "failed", -1.0),
    ],
)
def test_each_operator_judges_a_run_of_one_second(
    tmp_path: Path, expectation: Expectation, outcome: str, robustness: float | None
) -> None:
    (tmp_path / "tick.yaml").write_text("graph: tick\nnodes: {OnPlaybackTick: OnPlaybackTick}\n", encoding="utf-8")
    with ge.load(tmp_path / "tick.yaml").session() as session:
        check = session.expect(expectation)
        session.run(1.0)
        check.end()
        assert check.outcome == outcome
        if robustness is not None:
            assert check.verdict.robustness == pytest.approx(robustness, abs=0.02)


def test_a_reset_restarts_the_judgement_and_a_checkpoint_restores_it(sim: ge.Session) -> None:
    early = sim.expect(always("time < 0.5"))
    sim.run(0.25)
    mark = sim.checkpoint()
    sim.run(0.5)
    outcomes = [early.outcome]
    for again in (lambda: sim.restore(mark), lambda: sim.run(0.5), sim.reset, sim.step):
        again()
        outcomes.append(early.outcome)
    assert outcomes == ["failed", "open", "failed", "failed", "open"]


def test_conditions_share_a_reading_within_a_tick_only(sim: ge.Session) -> None:
    """Each of two expectations reads the pose; a restored tick has the number of an earlier one, and another pose."""
    x = "pose('dd100').position[0]"
    sim.run(0.1)
    mark = sim.checkpoint()
    sim.step()
    checks = sim.expect(always(f"{x} < 3"), count(f"{x} > 3", at_least=1))
    sim.step()
    assert [check.outcome for check in checks] == ["open", "open"]
    sim.restore(mark)
    sim.move("dd100", position=(4.0, 0.0, sim.robots["dd100"].pose.position[2]))
    again = sim.expect(always(f"{x} < 3"), count(f"{x} > 3", at_least=1))
    sim.step()
    sim.step()
    assert [check.outcome for check in again] == ["failed", "passed"]


def test_a_condition_that_cannot_be_evaluated_is_an_error_of_its_expectation(sim: ge.Session) -> None:
    broken = sim.expect(always("1 / (time - time) > 0"))
    silent = sim.expect(always("message('/dd100_0000/cmd_vel').linear.x < 1"))
    sim.run(1.0)
    with pytest.raises(ExpectationError) as raised:
        sim.judge()
    assert (broken.outcome, silent.outcome) == ("error", "error")
    assert "float division by zero" in str(raised.value)
    assert "never had a value" in str(raised.value)


@pytest.mark.parametrize(
    ("expectation", "told"),
    [
        (always("tilt('dd10') < 1"), "did you mean 'dd100'?"),
        (always("port('DiffControler.maxLinearSpeed') < 1"), "DiffController"),
        (always("message('/odm').x < 1"), "no graph uses topic '/odm'"),
        (always("distance('dd100', [1]) < 1"), "a point has two or three finite numbers"),
        (always("pose() < 1"), "missing 1 required positional argument: 'body'"),
    ],
)
def test_a_condition_with_an_unknown_name_is_refused_at_once(
    sim: ge.Session, expectation: Expectation, told: str
) -> None:
    with pytest.raises(UsageError) as refused:
        sim.expect(expectation)
    assert told in str(refused.value)


def test_invalid_limits_are_refused(sim: ge.Session) -> None:
    with pytest.raises(UsageError, match="at_least <= at_most"):
        count("time > 1", 3, 2)
    with pytest.raises(UsageError, match="0 s or more"):
        sim.expect(within(-1.0, "time > 1"))


def test_a_body_is_a_robot_an_object_or_a_prim(sim: ge.Session) -> None:
    robot = sim.robots["dd100"].pose
    assert sim.body("dd100").pose.position == robot.position
    lidar = sim.body("/dd100/Geometry/base_link/chassis_link/sim_lidar").pose.position
    assert 0.0 < math.dist(lidar, robot.position) < 1.0
    with pytest.raises(UnknownEntityError):
        sim.body("/dd100/nothing")


ODOM = "/dd100_0000/odom"


def test_readings_accept_the_named_arguments_of_their_functions(sim: ge.Session) -> None:
    free = sim.expect(never("contact('dd100', but='floor')"))
    fast = sim.expect(always(f"rate('{ODOM}', over=0.2) > 50"))
    sim.run(0.21)
    sim.judge()
    assert free.outcome == fast.outcome == "passed"
    assert fast.verdict.time == pytest.approx(0.2)
    with pytest.raises(UsageError, match="unexpected keyword argument 'nobut'"):
        sim.expect(never("contact('dd100', nobut='floor')"))


def test_rates_survive_a_reset_and_a_checkpoint(sim: ge.Session) -> None:
    rates = sim.expect(rate(ODOM, at_least=58, at_most=62))
    sim.run(0.5)
    sim.reset()
    sim.run(1.5)
    mark = sim.checkpoint()
    sim.run(0.4)
    sim.restore(mark)
    sim.run(2.0)
    assert rates.outcome == "open", rates.report()


def test_a_reset_after_one_tick_is_detected(sim: ge.Session) -> None:
    early = sim.expect(never("time > 0"))
    sim.step()
    assert early.outcome == "failed"
    sim.reset()
    sim.expect(always("time < 1"))
    sim.step()
    assert early.verdict.decided == pytest.approx(1 / 60)


def test_the_oldest_message_of_a_tick_counts_for_the_latency(sim: ge.Session) -> None:
    def stamped(seconds: float) -> None:
        sim.publish(ODOM, {"header": {"stamp": {"sec": int(seconds), "nanosec": round(seconds % 1 * 1e9)}}})

    check = sim.expect(latency(ODOM, 0.5))
    sim.run(2.0)
    outcomes = [check.outcome]
    stamped(0.0)
    stamped(2.1)
    sim.step()
    assert [*outcomes, check.outcome] == ["open", "failed"]


def test_a_judged_failure_does_not_end_later_runs(sim: ge.Session) -> None:
    sim.expect(always("time < 0.1"))
    sim.run(1.0, until=sim.decided)
    with pytest.raises(ExpectationError, match=r"failed: always time < 0\.1"):
        sim.judge()
    sim.expect(within(0.5, "time > 5"))
    assert sim.run(1.0, until=sim.decided)
    with pytest.raises(ExpectationError, match=r"failed: within 0\.5 s: time > 5"):
        sim.judge()


def test_after_a_failure_that_ended_a_run_early_a_longer_run_judges_the_rest(sim: ge.Session) -> None:
    sim.expect(always("time < 0.1"))
    late = sim.expect(within(0.3, "time > 5"))
    sim.run(1.0, until=sim.decided)
    sim.reset()
    sim.step(12)
    with pytest.raises(ExpectationError):
        sim.judge()
    assert late.outcome == "failed"


def test_clearance_and_logged_messages_are_readings(sim: ge.Session) -> None:
    near = sim.expect(always("clearance('dd100') >= 2"))
    quiet = sim.expect(always("log('warning') == 0"))
    sim.run(0.1)
    sim._runner._log("error", "/World/g/N", "broken")
    sim.step()
    assert (near.outcome, quiet.outcome) == ("open", "failed")
    with pytest.raises(UsageError, match="no severity 'warn'"):
        sim.expect(always("log('warn') == 0"))
