"""Many robots in one session, and robots that come and go."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graphengine.context import QoS
from graphengine.diagnostics import CheckError, UsageError
from graphengine.spec import Orientation, RobotUse
from graphengine.world.simulation import Simulation
from tests.jobs.harness import Job

ROBOT = """robot: noisy
extends: robots/dd100.yaml
sensors:
  sim_lidar: {type: lidar, profile: microscan3_light, parent: base_link/chassis_link, position: [0, 0, 0.15], noise_std: 0.01}
"""
SCENE = "scene: crowd\nworld: worlds/flat_grid.xml\nsettle: true\nrobots:\n%s"
FIRST = "  one: {use: noisy.yaml, position: [0, 0, 0.025], namespace: one}\n"
OTHERS = "  other: {use: noisy.yaml, count: 9, per_row: 3, spacing: [6, 6], position: [200, 200, 0.025]}\n"
CLOCK = "graphs:\n  clock: {use: graphs/clock.yaml, at: /World/clock}\n"
LATE = RobotUse(use="noisy.yaml", position=(0.0, 5.0, 0.025), namespace="late")


def scene(folder: Path, *robots: str) -> Path:
    (folder / "noisy.yaml").write_text(ROBOT, encoding="utf-8")
    (folder / "scene.yaml").write_text(SCENE % "".join(robots) + CLOCK, encoding="utf-8")
    return folder / "scene.yaml"


def physics(job: Job) -> Simulation:
    world = job.session.services.world
    assert isinstance(world, Simulation)
    return world


def test_ten_robots_have_their_own_topics_and_one_clock() -> None:
    with Job("dd100_fleet") as job:
        job.run(0.1)
        topics = set(job.types())
    own = {"odom", "platform/joint_states", "sim_lidar/scan", "tf", "tf_static"}
    assert topics == {"/clock"} | {f"/dd100_{index:04}/{name}" for index in range(10) for name in own}


def test_each_robot_of_a_fleet_follows_its_own_commands() -> None:
    with Job("dd100_fleet") as job:
        for _ in range(60):
            job.say("/dd100_0003/cmd_vel", 0.5, 0.0)
            job.session.step()
        moved = [job.newest(f"/dd100_{index:04}/odom").pose.pose.position.x for index in range(10)]
    assert moved[3] == pytest.approx(0.5 - 0.5**2 / 2, rel=0.03)  # a second, of which it speeds up for a half, at 1 m/s2
    assert np.delete(moved, 3) == pytest.approx(np.zeros(9), abs=1e-6)


def test_what_a_robot_does_does_not_depend_on_who_else_is_there(tmp_path: Path) -> None:
    forever = {"SubscribeTwist.timeout": 0.0}
    heard: dict[bool, dict[str, list[bytes]]] = {}
    for alone in (True, False):
        said: dict[str, list[bytes]] = {"nav_msgs/msg/Odometry": [], "sensor_msgs/msg/LaserScan": []}
        with Job(scene(tmp_path, FIRST, *([] if alone else [OTHERS])), forever, heard=False) as job:
            job.say("/one/cmd_vel", 0.6, 0.3)
            for index in range(0 if alone else 9):
                job.say(f"/other_{index:04}/cmd_vel", 0.2 * (index - 4), 0.1 * index)
            job.run(59.0)
            job.transport.reader("/one/odom", "nav_msgs/msg/Odometry", QoS(), said["nav_msgs/msg/Odometry"].append)
            job.transport.reader(
                "/one/sim_lidar/scan", "sensor_msgs/msg/LaserScan", QoS(), said["sensor_msgs/msg/LaserScan"].append
            )
            job.run(1.0)
        heard[alone] = said
    assert [len(said) for said in heard[True].values()] == [60, 20]
    assert heard[True] == heard[False]  # to the last bit, and the noise of the lidar is the same


def test_a_robot_that_comes_leaves_time_and_others_as_they_are(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST)) as job:
        job.drive("/one/cmd_vel", 0.5, 0.2, 1.0)
        world, time = physics(job), job.session.time
        state = world.articulation(world.stage.find("/one")).positions(), world.data.qpos[:7].copy()
        job.session.spawn("late", LATE)
        assert job.session.time == time
        assert np.array_equal(world.articulation(world.stage.find("/one")).positions(), state[0])
        assert np.array_equal(world.data.qpos[:7], state[1])
        job.drive("/one/cmd_vel", 0.5, 0.2, 1.0)
        stamps = [message.clock for message in job.heard("/clock")]
    assert len(stamps) == 120
    assert len(job.heard("/one/odom")) == 120
    assert len(job.heard("/late/odom")) == 60


def test_others_move_as_if_nobody_had_come_or_gone(tmp_path: Path) -> None:
    heard = []
    for visited in (False, True):
        with Job(scene(tmp_path, FIRST)) as job:
            job.drive("/one/cmd_vel", 0.5, 0.2, 0.5)
            if visited:
                job.session.spawn("late", LATE.model_copy(update={"position": (200.0, 0.0, 0.025)}))
            job.drive("/one/cmd_vel", 0.5, 0.2, 0.5)
            if visited:
                job.session.remove("late")
            job.drive("/one/cmd_vel", 0.5, 0.2, 0.5)
            heard.append([data for topic, _, data in job.recorder.stream if topic.startswith("/one/")])
    assert heard[0] == heard[1]


def test_a_robot_that_came_is_driven_and_senses_like_any_other(tmp_path: Path) -> None:
    turned = LATE.model_copy(update={"orientation": Orientation(rpy_deg=(0.0, 0.0, 90.0))})
    with Job(scene(tmp_path, FIRST)) as job:
        job.run(0.5)
        job.session.spawn("late", turned)
        job.run(0.5)  # it drops a centimetre
        job.drive("/late/cmd_vel", 0.5, 0.0, 2.0)
        assert job.velocity("/late/odom")[0] == pytest.approx(0.5, rel=0.005)
        assert job.newest("/late/odom").pose.pose.position.x > 0.7
        assert job.velocity("/one/odom")[0] == pytest.approx(0.0, abs=1e-6)
        scan = job.newest("/one/sim_lidar/scan")
        world = physics(job)
        (x, y, _), _ = world.body(world.stage.find("/late/base_link/chassis_link")).pose()
    beam = round((np.arctan2(y, x) - scan.angle_min) / scan.angle_increment)
    assert scan.ranges[beam] == pytest.approx(np.hypot(x, y), abs=0.4)  # half a robot


def test_a_robot_that_goes_takes_its_topics_along(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST)) as job:
        job.session.spawn("late", LATE)
        job.run(0.2)
        job.session.remove("late")
        sent = len(job.heard("/late/odom"))
        job.run(0.2)
        assert sent == 12
        assert len(job.heard("/late/odom")) == sent
        assert not [claim.topic for claim in job.session.services.claims if claim.topic.startswith("/late")]
        assert "/late" not in physics(job).stage
        job.session.spawn("late", LATE)  # the name is free
        job.run(0.2)
        assert len(job.heard("/late/odom")) == 2 * sent


def test_stop_takes_a_robot_that_came_back_to_where_it_was_put(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST)) as job:
        job.run(0.5)
        job.session.spawn("late", LATE)
        world = physics(job)
        start = world.body(world.stage.find("/late/base_link")).pose()
        first = world.body(world.stage.find("/one/base_link")).pose()
        job.drive("/late/cmd_vel", 0.5, 0.0, 1.0)
        job.drive("/one/cmd_vel", 0.5, 0.0, 1.0)
        job.session.stop()
        assert world.body(world.stage.find("/late/base_link")).pose() == start
        assert world.body(world.stage.find("/one/base_link")).pose()[0] == pytest.approx(first[0], abs=1e-5)


def test_commands_outlive_a_newcomer(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST), {"SubscribeTwist.timeout": 0.0}) as job:
        job.say("/one/cmd_vel", 0.5, 0.0)
        job.run(2.0)
        job.session.spawn("late", LATE)
        job.run(1.0)
        assert job.velocity("/one/odom")[0] == pytest.approx(0.5, rel=0.005)


@pytest.mark.parametrize(
    ("name", "use", "words"),
    [
        ("one", LATE, "'one' is taken"),
        ("World", LATE, "'World' is taken"),
        ("a b", LATE, "not a name"),
        ("late", RobotUse(use="missing.yaml"), "missing.yaml"),
        ("late", RobotUse(use="noisy.yaml", count=2, spacing=(1.0, 1.0)), "is a fleet"),
        ("late", RobotUse(use="broken.yaml"), "no joint 'wheel'"),
        ("late", RobotUse(use="no_graph.yaml"), "nowhere.yaml"),
        ("late", RobotUse(use="bad_graph.yaml"), "no link 'elbow'"),
    ],
)
def test_a_robot_that_cannot_be_changes_nothing(tmp_path: Path, name: str, use: RobotUse, words: str) -> None:
    (tmp_path / "broken.yaml").write_text("robot: b\nextends: noisy.yaml\njoints: {wheel: {}}\n", encoding="utf-8")
    (tmp_path / "no_graph.yaml").write_text(
        "robot: b\nextends: noisy.yaml\ngraphs: {a: {use: nowhere.yaml}}\n", encoding="utf-8"
    )
    (tmp_path / "bad_graph.yaml").write_text(
        "robot: b\nextends: noisy.yaml\nkeep_only_joints: []\narticulation_root: elbow\n", encoding="utf-8"
    )
    with Job(scene(tmp_path, FIRST)) as job:
        job.run(0.2)
        prims = [prim.path for prim in physics(job).stage.prims()]
        with pytest.raises(CheckError) as error:
            job.session.spawn(name, use)
        assert words in str(error.value)
        assert [prim.path for prim in physics(job).stage.prims()] == prims
        job.run(0.2)
        assert len(job.heard("/one/odom")) == 24


def test_a_robot_that_is_not_there_cannot_go(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST)) as job, pytest.raises(UsageError, match="no robot 'on'"):
        job.session.remove("on")


def test_a_robot_that_others_read_cannot_go(tmp_path: Path) -> None:
    watch = "graph: watch\nat: /World/watch\nnodes:\n  Tick: OnPlaybackTick\n  Odometry:\n"
    watch += "    type: ComputeOdometry\n    inputs: {chassisPrim: [/one/base_link]}\nconnections:\n"
    (tmp_path / "watch.yaml").write_text(watch + "  - Tick.tick -> Odometry.execIn\n", encoding="utf-8")
    path = scene(tmp_path, FIRST)
    path.write_text(path.read_text() + "  watch: {use: watch.yaml}\n", encoding="utf-8")
    with Job(path) as job:
        job.run(0.1)
        with pytest.raises(UsageError, match="/World/watch/Odometry of graph watch reads something of it"):
            job.session.remove("one")
        job.run(0.1)
        assert len(job.heard("/one/odom")) == 12
