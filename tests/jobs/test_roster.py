"""Robots that come and go while a session runs."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from graphengine.compiler.registry import Registry, default_registry
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import NodeError, PhysicsError, StateError, UsageError
from graphengine.format.spec import Orientation, RobotUse
from graphengine.messages.endpoints import QoS
from graphengine.node import Context, ExecIn, Node
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.runtime.entity_commands import Delete, Spawn
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from tests.jobs.crowd import FIRST, LATE, ROBOT, physics, scene
from tests.jobs.harness import ROOT, Job, assemble, nanoseconds
from tests.physics.harness import CART
from tests.physics.pictures.harness import needs_opengl
from tests.waiting import eventually

LIMITED = "".join(
    f"  front_{side}_wheel_joint: {{drive: {{damping: 50, max_force: 0.3}}}}\n" for side in ("left", "right")
)
SENSING = ROBOT + f"graphs:\n  imu: {{use: graphs/imu.yaml}}\njoints:\n{LIMITED}"
SEEING = ROBOT + "graphs:\n  camera: {use: graphs/camera.yaml, parameters: {width: 64, height: 40}}\n"
ELSEWHERE = LATE.model_copy(update={"position": (200.0, 0.0, 0.025)})


@pytest.fixture
def job(tmp_path: Path) -> Iterator[Job]:
    """A scene with one robot, whose folder has files of more."""
    with Job(scene(tmp_path, FIRST)) as running:
        yield running


def test_a_robot_that_comes_leaves_time_and_others_as_they_are(job: Job) -> None:
    job.drive("/one/cmd_vel", 0.5, 0.2, 1.0)
    world, time = physics(job), job.session.time
    state = world.articulation(world.stage.find("/one")).positions(), world.data.qpos[:7].copy()
    job.spawn("late", LATE)
    assert job.session.time == time
    assert np.array_equal(world.articulation(world.stage.find("/one")).positions(), state[0])
    assert np.array_equal(world.data.qpos[:7], state[1])
    job.drive("/one/cmd_vel", 0.5, 0.2, 1.0)
    stamps = [message.clock for message in job.heard("/clock")]
    assert len(stamps) == 120
    assert len(job.heard("/one/odom")) == 120
    assert len(job.heard("/late/odom")) == 60


@pytest.mark.parametrize("robot", [SENSING, pytest.param(SEEING, marks=needs_opengl)], ids=["imu", "camera"])
def test_others_move_and_sense_as_if_nobody_had_come_or_gone(tmp_path: Path, robot: str) -> None:
    heard = []
    for visited in (False, True):
        path = scene(tmp_path, FIRST)
        (tmp_path / "noisy.yaml").write_text(robot, encoding="utf-8")
        with Job(path) as job:
            job.drive("/one/cmd_vel", 0.5, 0.2, 0.5)
            if visited:
                job.spawn("late", ELSEWHERE)
            job.drive("/one/cmd_vel", 0.5, 0.2, 0.5)
            if visited:
                job.remove("late")
            job.drive("/one/cmd_vel", 0.5, 0.2, 0.5)
            heard.append([(topic, data) for topic, _, data in job.recorder.stream if topic.startswith("/one/")])
    assert {"/one/sim_camera/imu", "/one/sim_camera/rgb"} & {topic for topic, _ in heard[0]}
    assert heard[0] == heard[1]


def test_objects_that_a_robot_pushes_are_not_affected_by_spawning_and_removing(tmp_path: Path) -> None:
    path, seen = scene(tmp_path, FIRST.replace("[0, 0,", "[-7.0, 2.4,")), []
    path.write_text(path.read_text(encoding="utf-8").replace("flat_grid", "full_warehouse"), encoding="utf-8")
    for visited in (False, True):
        with Job(path, heard=False) as job:
            world = physics(job)
            box, poses = world.body(world.stage.find("/World/box_01")), []
            for tick in range(120):
                job.say("/one/cmd_vel", 0.6, 0.0)
                if visited and tick in (80, 100):
                    job.spawn(f"late_{tick}", ELSEWHERE.model_copy(update={"namespace": f"late_{tick}"}))
                if visited and tick == 90:
                    job.remove("late_80")
                job.session.step()
                poses.append((box.pose(), box.velocity()))
            seen.append(poses)
    assert seen[0][-1][0][0][0] > seen[0][0][0][0][0] + 0.1
    assert seen[0] == seen[1]


def test_a_robot_that_came_is_driven_and_senses_like_any_other(job: Job) -> None:
    turned = LATE.model_copy(update={"orientation": Orientation(rpy_deg=(0.0, 0.0, 90.0))})
    job.run(0.5)
    job.spawn("late", turned)
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


def test_a_kind_of_robot_that_the_scene_never_had_may_come(tmp_path: Path, job: Job) -> None:
    corners = [(x, y, z) for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.05, 0.25)]
    faces = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    box = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {face}\n" for face in faces)
    (tmp_path / "box.obj").write_text(box, encoding="utf-8")
    cart = CART.replace('<box size=".4 .3 .1"/>', '<mesh filename="box.obj"/>')
    (tmp_path / "cart.urdf").write_text(cart, encoding="utf-8")
    (tmp_path / "cart.yaml").write_text("robot: cart\nurdf: cart.urdf\n", encoding="utf-8")
    job.run(0.1)
    for name, x in (("late", 2.0), ("later", 4.0)):
        job.spawn(name, RobotUse(use="cart.yaml", position=(x, 0.0, 0.05)))
    job.run(0.5)
    scan = job.newest("/one/sim_lidar/scan")
    assert scan.ranges[len(scan.ranges) // 2] == pytest.approx(1.8, abs=0.05)  # straight ahead; its noise is 1 cm
    job.remove("late")
    job.run(0.5)
    scan = job.newest("/one/sim_lidar/scan")
    assert scan.ranges[len(scan.ranges) // 2] == pytest.approx(3.8, abs=0.05)


def test_a_robot_that_goes_takes_its_topics_along(job: Job) -> None:
    job.spawn("late", LATE)
    job.run(0.2)
    job.remove("late")
    sent = len(job.heard("/late/odom"))
    job.run(0.2)
    assert sent == 12
    assert len(job.heard("/late/odom")) == sent
    assert not [claim.topic for claim in job.session.services.claims if claim.topic.startswith("/late")]
    assert "/late" not in physics(job).stage
    job.spawn("late", LATE)  # the name is free
    job.run(0.2)
    assert len(job.heard("/late/odom")) == 2 * sent


def test_a_removed_robot_says_goodbye_and_a_refused_removal_changes_nothing(tmp_path: Path) -> None:
    path = scene(tmp_path, FIRST)
    (tmp_path / "goodbye.yaml").write_text(
        "graph: goodbye\nnodes: {Closing: OnClosing, Bye: {type: ROS2Publisher, inputs: {messagePackage: std_msgs, "
        "messageName: Empty, topicName: bye}}}\nconnections: [Closing.execOut -> Bye.execIn]\n",
        encoding="utf-8",
    )
    (tmp_path / "noisy.yaml").write_text(f"{ROBOT}graphs:\n  goodbye: {{use: goodbye.yaml}}\n", encoding="utf-8")
    with Job(path) as job:
        job.spawn("late", LATE)
        job.run(0.1)
        assert job.heard("/bye") == []
        job.remove("late")
        assert len(job.heard("/bye")) == 1
        with pytest.raises(UsageError):
            job.remove("late")
    assert len(job.heard("/bye")) == 2  # the other one's, when the session ended


def test_stop_takes_a_robot_that_came_back_to_where_it_was_put(job: Job) -> None:
    job.run(0.5)
    job.spawn("late", LATE)
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
        job.spawn("late", LATE)
        job.run(1.0)
        assert job.velocity("/one/odom")[0] == pytest.approx(0.5, rel=0.005)


@pytest.mark.parametrize(
    ("name", "use", "words"),
    [
        ("one", LATE, "'one' is taken"),
        ("World", LATE, "'World' is taken"),
        ("a b", LATE, "not a valid name"),
        ("late", RobotUse(use="missing.yaml"), "missing.yaml"),
        ("late", RobotUse(use="noisy.yaml", count=2, spacing=(1.0, 1.0)), "is a fleet"),
        ("late", RobotUse(use="broken.yaml"), "no joint 'wheel'"),
        ("late", RobotUse(use="no_graph.yaml"), "nowhere.yaml"),
        ("late", RobotUse(use="bad_graph.yaml"), "no link 'elbow'"),
    ],
)
def test_a_robot_that_cannot_be_changes_nothing(tmp_path: Path, job: Job, name: str, use: RobotUse, words: str) -> None:
    (tmp_path / "broken.yaml").write_text("robot: b\nextends: noisy.yaml\njoints: {wheel: {}}\n", encoding="utf-8")
    (tmp_path / "no_graph.yaml").write_text(
        "robot: b\nextends: noisy.yaml\ngraphs: {a: {use: nowhere.yaml}}\n", encoding="utf-8"
    )
    (tmp_path / "bad_graph.yaml").write_text(
        "robot: b\nextends: noisy.yaml\nkeep_only_joints: []\narticulation_root: elbow\n", encoding="utf-8"
    )
    job.run(0.2)
    prims = [prim.path for prim in physics(job).stage.prims()]
    with pytest.raises(CheckError) as error:
        job.spawn(name, use)
    assert words in str(error.value)
    assert [prim.path for prim in physics(job).stage.prims()] == prims
    job.run(0.2)
    assert len(job.heard("/one/odom")) == 24


def test_a_robot_that_is_not_there_cannot_go(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST)) as job, pytest.raises(UsageError, match="no robot 'on'"):
        job.remove("on")


def test_a_robot_that_others_read_cannot_go(tmp_path: Path) -> None:
    watch = "graph: watch\nat: /World/watch\nnodes:\n  Tick: OnPlaybackTick\n  Odometry:\n"
    watch += "    type: ComputeOdometry\n    inputs: {chassisPrim: [/one/base_link]}\nconnections:\n"
    (tmp_path / "watch.yaml").write_text(watch + "  - Tick.tick -> Odometry.execIn\n", encoding="utf-8")
    path = scene(tmp_path, FIRST)
    path.write_text(path.read_text() + "  watch: {use: watch.yaml}\n", encoding="utf-8")
    with Job(path) as job:
        job.run(0.1)
        with pytest.raises(UsageError, match="/World/watch/Odometry of graph watch uses the robot"):
            job.remove("one")
        job.run(0.1)
        assert len(job.heard("/one/odom")) == 12


# What is refused


def test_a_missing_file_is_reported_to_the_client_and_nothing_is_spawned(tmp_path: Path, job: Job) -> None:
    mesh = CART.replace('<sphere radius=".05"/>', '<mesh filename="nowhere.stl"/>')
    (tmp_path / "cart.urdf").write_text(mesh, encoding="utf-8")
    (tmp_path / "cart.yaml").write_text("robot: cart\nurdf: cart.urdf\n", encoding="utf-8")
    with pytest.raises(CheckError, match=r"no file 'nowhere\.stl'"):
        job.spawn("late", RobotUse(use="cart.yaml"))
    assert "/late" not in physics(job).stage
    assert job.scene.findings.errors == []


def test_a_file_with_a_mistake_is_reported_each_time_until_it_is_right(tmp_path: Path, job: Job) -> None:
    late = tmp_path / "late.yaml"
    late.write_text("robot: late\nextends: noisy.yaml\njoints: {wheel: {}}\n", encoding="utf-8")
    use = LATE.model_copy(update={"use": "late.yaml"})
    for _ in range(2):
        with pytest.raises(CheckError, match="no joint 'wheel'"):
            job.spawn("late", use)
    late.write_text("robot: late\nextends: noisy.yaml\n", encoding="utf-8")
    job.spawn("late", use)
    job.run(0.1)
    assert len(job.heard("/late/odom")) == 6


def test_a_robot_that_would_publish_on_the_topics_of_another_is_refused(job: Job) -> None:
    with pytest.raises(CheckError, match=r"frame 'base_link' below 'odom' is published by both /one/.* and /late/"):
        job.spawn("late", LATE.model_copy(update={"namespace": "one"}))
    assert "/late" not in physics(job).stage
    job.spawn("late", LATE)
    job.remove("late")
    job.spawn("again", LATE)  # whose topics are free


def test_a_place_that_physics_cannot_count_is_refused_and_the_others_go_on(job: Job) -> None:
    job.run(0.1)
    prims, model = [prim.path for prim in physics(job).stage.prims()], physics(job).model
    with pytest.raises(PhysicsError, match=r"'late/base_link' is farther from the world's origin than 1e\+10 m"):
        job.spawn("late", LATE.model_copy(update={"position": (1e12, 0.0, 0.0)}))
    assert physics(job).model is model
    assert [prim.path for prim in physics(job).stage.prims()] == prims
    job.spawn("late", LATE)
    job.run(0.1)
    assert (len(job.heard("/one/odom")), len(job.heard("/late/odom"))) == (12, 6)


def test_a_robot_that_the_rays_asked_for_cannot_meet_is_refused_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fast = pytest.importorskip("graphengine.physics.ray_casting.fast.rays", reason="numba is not installed")
    with Job(scene(tmp_path, FIRST), rays="fast") as job:
        job.run(0.1)
        with monkeypatch.context() as patch:
            patch.setattr(fast, "MAX_TRIANGLES", -1)
            with pytest.raises(UsageError, match="rays 'fast' do not support more than"):
                job.spawn("late", LATE)
        assert "/late" not in physics(job).stage
        job.run(0.1)
        assert len(job.heard("/one/odom")) == 12


class Reluctant(Node, type="test.Reluctant"):
    """Opens a topic and asks for random numbers; refuses the second time, which after the check is the real one."""

    exec_in = ExecIn()
    asked: ClassVar[int] = 0

    def setup(self, context: Context) -> None:
        context.publisher("std_msgs/msg/String", "reluctant")
        context.random()
        Reluctant.asked += 1
        if Reluctant.asked % 2 == 0:
            raise RuntimeError("not now")


class Faulty(Node, type="test.Faulty"):
    """Raises."""

    exec_in = ExecIn()

    def compute(self) -> None:
        raise RuntimeError("never")


def registry_with(node: type[Node]) -> Registry:
    registry = default_registry().copy()
    registry.add(node)
    return registry


def with_last_node(folder: Path, node: type[Node]) -> RobotUse:
    """A robot with a graph that runs after its others, in which one node does something."""
    graph = "graph: last\nat: $(robot)/last\nparameters: {robot: {type: target}}\n"
    graph += f"nodes: {{Tick: OnPlaybackTick, Last: {node.type_name}}}\nconnections: [Tick.tick -> Last.execIn]\n"
    (folder / "last.yaml").write_text(graph, encoding="utf-8")
    robot = "robot: late\nextends: noisy.yaml\ngraphs: {last: {use: last.yaml}}\n"
    (folder / "late.yaml").write_text(robot, encoding="utf-8")
    return LATE.model_copy(update={"use": "late.yaml"})


def test_a_node_that_cannot_begin_leaves_nothing_of_its_robot(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST), registry=registry_with(Reluctant)) as job:
        job.run(0.1)
        before = known(job), left_of(job)
        with pytest.raises(NodeError, match="raised RuntimeError: not now"):
            job.spawn("late", with_last_node(tmp_path, Reluctant))
        assert (known(job), left_of(job)) == before
        assert Reluctant.asked == 2
        job.spawn("late", LATE)
        job.run(0.1)
        assert (len(job.heard("/one/odom")), len(job.heard("/late/odom"))) == (12, 6)
        job.remove("late")
        assert (known(job), left_of(job)) == before


def test_after_a_reset_a_robot_whose_node_raised_can_go_and_the_others_go_on(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST), registry=registry_with(Faulty)) as job:
        job.run(0.1)
        job.spawn("late", with_last_node(tmp_path, Faulty))
        with pytest.raises(NodeError, match="raised RuntimeError: never"):
            job.session.step()
        assert len(job.heard("/late/odom")) == 1  # it came before the fault
        with pytest.raises(StateError, match="the session failed"):
            job.remove("late")
        job.session.reset("time")
        job.remove("late")
        job.run(0.1)
        assert len(job.heard("/one/odom")) == 13


def left_of(job: Job) -> list[list[str]]:
    """What a session keeps for its robots: prims, claims, render products, random numbers, bodies."""
    services, model = job.session.services, physics(job).model
    return [
        [prim.path for prim in physics(job).stage.prims()],
        [claim.topic for claim in services.claims],
        list(services.render_products),
        list(services.generators),
        [model.body(index).name for index in range(model.nbody)],
        [run.name for run in job.session.graphs],
    ]


def test_within_a_tick_nothing_comes_or_goes_or_stops(job: Job) -> None:
    asked: list[str] = []
    session = job.session
    comings_and_goings: list[Callable[[], object]] = [
        lambda: job.spawn("late", LATE),
        lambda: job.remove("one"),
    ]

    def ask(_: bytes) -> None:
        for question in [*comings_and_goings, session.step, session.run, session.stop, session.reset]:
            with pytest.raises(UsageError, match="between two ticks") as error:
                question()
            asked.append(str(error.value))

    job.transport.reader("/clock", "rosgraph_msgs/msg/Clock", QoS(), ask)
    session.step()
    assert len(asked) == 6
    assert "/late" not in physics(job).stage

    def come(running: SessionCore) -> bool:
        Spawn(name="late", use=LATE).apply(running)
        return False

    asked.clear()
    session.run(on_tick=come)
    assert "/late" in physics(job).stage


# What is kept for a robot


@needs_opengl
def test_a_robot_with_the_name_of_a_removed_one_sees_with_its_own_camera(tmp_path: Path) -> None:
    path = scene(tmp_path, FIRST)
    (tmp_path / "noisy.yaml").write_text(SEEING, encoding="utf-8")
    pictures = []
    with Job(path) as job:
        for _ in range(2):
            before, sent = round(job.session.time * 1e9), len(job.heard("/late/sim_camera/rgb"))
            job.spawn("late", LATE)
            job.run(0.4)
            pictures.append(job.heard("/late/sim_camera/rgb")[sent:])
            assert nanoseconds(pictures[-1][0].header.stamp) > before
            job.remove("late")
        assert not [path for path in job.session.services.render_products if "late" in path]
    assert np.array_equal(pictures[0][-1].data, pictures[1][-1].data)


def test_values_of_the_command_line_are_for_those_who_come_too(tmp_path: Path) -> None:
    with Job(scene(tmp_path, FIRST), {"SubscribeTwist.timeout": 0.0}) as job:
        job.spawn("late", LATE)
        job.say("/late/cmd_vel", 0.5, 0.0)
        job.run(2.0)
        assert job.velocity("/late/odom")[0] == pytest.approx(0.5, rel=0.005)


@pytest.mark.parametrize("keep_going", [False, True])
def test_the_session_knows_who_is_there(tmp_path: Path, keep_going: bool) -> None:
    faults: list[NodeError] = []
    with Job(scene(tmp_path, FIRST), fault=faults.append if keep_going else None) as job:
        graphs, topics = known(job)
        job.spawn("late", LATE)
        assert known(job)[0] == [*graphs, "late/joint_states", "late/scan", "late/cmd_vel"]
        assert len(known(job)[1]) == 2 * len(topics) - 1  # there is one clock
        job.remove("late")
        assert known(job) == (graphs, topics)


def known(job: Job) -> tuple[list[str], list[str]]:
    """Names of graphs, and topics."""
    return [run.name for run in job.session.graphs], [claim.topic for claim in job.session.services.claims]


def test_another_process_sees_its_topics_come_and_go(tmp_path: Path, domain_id: int) -> None:
    domain = Domain(domain_id, "LOCALHOST")
    where = {"ROS_DOMAIN_ID": str(domain.id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "tests.jobs.onlooker", "one", "late"]
    network = LiveNetwork(lambda _: DdsTransport(JoinOptions(domain, "crowd")), 0, print)
    told: list[str] = []
    with (
        subprocess.Popen(command, env={**os.environ, **where}, stdout=subprocess.PIPE, text=True) as onlooker,
        build.start(assemble(scene(tmp_path, FIRST)), network) as session,
    ):
        listening = threading.Thread(target=lambda: told.extend(line.strip() for line in onlooker.stdout or ()))
        listening.start()

        def tells(*words: str) -> bool:
            return eventually(lambda: set(words) <= set(told), session.step)

        assert tells("one listens", "one talks"), told
        Spawn(name="late", use=LATE).apply(session)
        assert tells("late listens", "late talks"), told
        Delete(name="late").apply(session)
        assert tells("late is deaf"), told
        assert "one is deaf" not in told
        onlooker.kill()
        listening.join()
