"""From a cmd_vel message to /odom: what is commanded is what comes out, and when it stops."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from tests.jobs.harness import Job, assemble, nanoseconds, yaw

CMD_VEL, ODOM = "/dd100_0000/cmd_vel", "/dd100_0000/odom"
TRUE_RADIUS, TRUE_DISTANCE = 0.049, 0.4523232  # m, of the robot's description
TUTORIAL_RADIUS, TUTORIAL_DISTANCE = 0.1, 0.45  # m, as the tutorial says

SHARE_OF_V = TRUE_RADIUS / TUTORIAL_RADIUS  # 0.49
SHARE_OF_W = TRUE_RADIUS * TUTORIAL_DISTANCE / (TUTORIAL_RADIUS * TRUE_DISTANCE)  # 0.4875

COMMANDS = [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)]


def near(value: float) -> Any:
    """Within 0.5 %, or of what is commanded beside it."""
    return pytest.approx(value, rel=0.005, abs=0.0025)


@pytest.mark.parametrize(("v", "w"), COMMANDS)
@pytest.mark.parametrize("scene", ["dd100_flat", "dd100_warehouse"])
def test_the_robot_does_what_it_is_told(scene: str, v: float, w: float) -> None:
    with Job(scene) as job:
        job.drive(CMD_VEL, v, w, 2.0)
        assert job.velocity(ODOM) == (near(v), near(w))


def test_the_robot_is_where_a_circle_would_take_it() -> None:
    """With v = w = 0.5 the circle has a radius of 1 m; from pose a to pose b it is turned by 0.5 a second."""
    with Job("dd100_flat") as job:
        job.drive(CMD_VEL, 0.5, 0.5, 2.0)
        before = job.newest(ODOM)
        job.drive(CMD_VEL, 0.5, 0.5, 2.0)
        after = job.newest(ODOM)
    turned = math.remainder(yaw(after.pose.pose.orientation) - yaw(before.pose.pose.orientation), 2 * math.pi)
    assert turned == pytest.approx(1.0, rel=0.005)
    dx = after.pose.pose.position.x - before.pose.pose.position.x
    dy = after.pose.pose.position.y - before.pose.pose.position.y
    assert math.hypot(dx, dy) == pytest.approx(2.0 * math.sin(0.5), rel=0.005)  # the chord


def test_the_wheels_turn_as_the_joint_states_say() -> None:
    with Job("dd100_flat") as job:
        job.drive(CMD_VEL, 0.5, 0.5, 2.0)
        state = job.newest("/dd100_0000/platform/joint_states")
    wheels = dict(zip(state.name, state.velocity, strict=True))
    for side, sign in (("left", -1.0), ("right", 1.0)):
        expected = (0.5 + sign * 0.5 * TRUE_DISTANCE / 2) / TRUE_RADIUS
        assert wheels[f"front_{side}_wheel_joint"] == pytest.approx(expected, rel=0.005)


@pytest.mark.parametrize("scene", ["tutorial/flat_grid", "tutorial/navigation"])
def test_the_tutorials_wheel_numbers_give_49_percent_of_the_speed_and_48_75_of_the_turn(scene: str) -> None:
    prefix = "/dd100_0000" if scene.endswith("navigation") else ""
    with Job(scene) as job:
        job.drive(f"{prefix}/cmd_vel", 0.5, 0.0, 2.0)
        assert job.velocity(f"{prefix}/odom")[0] == pytest.approx(0.5 * SHARE_OF_V, rel=0.002)
        job.drive(f"{prefix}/cmd_vel", 0.0, 0.5, 2.0)
        assert job.velocity(f"{prefix}/odom")[1] == pytest.approx(0.5 * SHARE_OF_W, rel=0.002)  # not 0.49 of it
        job.drive(f"{prefix}/cmd_vel", 0.5, 0.5, 2.0)
        assert job.velocity(f"{prefix}/odom") == (near(0.5 * SHARE_OF_V), near(0.5 * SHARE_OF_W))


@pytest.mark.parametrize("scene", ["tutorial/flat_grid", "tutorial/simple_warehouse", "tutorial/navigation"])
def test_a_check_of_the_tutorial_tells_why(scene: str) -> None:
    (finding,) = [one for one in assemble(scene).findings.warnings if one.code == "W201"]
    text = finding.render()
    assert "cmd_vel.yaml:" in text
    assert "wheelRadius is 0.1 m, but the wheels of /dd100 have 0.049 m" in text
    assert "the robot will drive at 0.49 times the commanded speed" in text
    assert "write wheelRadius: 0.049" in text


# Silence


def test_silence_for_half_a_second_stops_the_robot() -> None:
    with Job("dd100_flat") as job:
        job.drive(CMD_VEL, 0.5, 0.0, 2.0)
        last = job.session.clock.frame - 5  # drive says it every sixth tick
        job.run(2.0)
        speeds = {nanoseconds(m.header.stamp): m.twist.twist.linear.x for m in job.heard(ODOM)}
    slower = min(time for time, v in speeds.items() if time > last / 60 * 1e9 and v < 0.49)
    assert slower / 1e9 == pytest.approx(last / 60 + 0.5, abs=0.05)
    assert abs(list(speeds.values())[-1]) < 1e-3


def test_who_goes_on_speaking_goes_on_driving() -> None:
    with Job("dd100_flat") as job:
        job.drive(CMD_VEL, 0.5, 0.0, 4.0, every=24)  # every 0.4 s
        assert job.velocity(ODOM)[0] == near(0.5)


def test_in_the_tutorial_one_twist_drives_for_ever() -> None:
    with Job("tutorial/flat_grid") as job:
        job.say("/cmd_vel", 0.5, 0.0)
        job.run(30.0)
        assert job.velocity("/odom")[0] == pytest.approx(0.5 * SHARE_OF_V, rel=0.005)
        assert job.newest("/odom").pose.pose.position.x == pytest.approx(30.0 * 0.5 * SHARE_OF_V, rel=0.01)


def test_a_robot_that_nobody_speaks_to_stands_still() -> None:
    with Job("dd100_warehouse") as job:
        job.run(3.0)
        position = job.newest(ODOM).pose.pose.position
        assert math.hypot(position.x, position.y) < 1e-3
        assert job.velocity(ODOM) == pytest.approx((0.0, 0.0), abs=1e-3)


def test_two_robots_from_one_file_are_driven_apart(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(
        "scene: two\n"
        "world: worlds/flat_grid.xml\n"
        "settle: true\n"
        "robots:\n"
        "  left: {use: robots/dd100.yaml, position: [0, 1, 0.02], namespace: left}\n"
        "  right: {use: robots/dd100.yaml, position: [0, -1, 0.02], namespace: right}\n",
        encoding="utf-8",
    )
    with Job(tmp_path / "scene.yaml") as job:
        for tick in range(120):
            if tick % 6 == 0:
                job.say("/left/cmd_vel", 0.5, 0.0)
                job.say("/right/cmd_vel", -0.25, 0.5)
            job.session.step()
        assert job.velocity("/left/odom") == (near(0.5), near(0.0))
        assert job.velocity("/right/odom") == (near(-0.25), near(0.5))
