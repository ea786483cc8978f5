"""Reloads of changed files in a running session: unchanged graphs send the same bytes as without the reload."""

from __future__ import annotations

import random
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import UsageError
from graphengine.format.spec import RobotUse
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests.jobs import crowd
from tests.jobs.harness import ROOT, Job
from tests.waiting import eventually

CMD_VEL = "/dd100_0000/cmd_vel"
LATE = RobotUse(use="robots/dd100.yaml", position=(1.0, 1.0, 0.025), namespace="late")


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """A copy of the graphs and scenes that ship, which can be changed."""
    for name in ("graphs", "scenes"):
        shutil.copytree(ROOT / name, tmp_path / "library" / name)
    return tmp_path / "library"


def change_every_graph(library: Path) -> None:
    """Give each graph one node more, which does nothing."""
    for path in (library / "graphs").rglob("*.yaml"):
        text = path.read_text(encoding="utf-8")
        name = f"Spare{text.count('Spare')}"
        path.write_text(
            text.replace("nodes:\n", f"nodes:\n  {name}: omni.graph.nodes.ConstantDouble\n", 1), encoding="utf-8"
        )


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def begin(library: Path, scene: str = "dd100_flat") -> Job:
    return Job(library / "scenes" / f"{scene}.yaml", shipped=library)


def run(job: Job, ticks: int, seed: int = 0) -> list[tuple[str, str, bytes]]:
    """What is sent meanwhile by a scene whose robots are commanded at odd times."""
    before, chance = len(job.recorder.stream), random.Random(seed)
    topics = [end.topic for end in job.session.services.claims if end.topic.endswith("cmd_vel")]
    for _ in range(ticks):
        for topic in topics:
            if chance.random() < 0.1:
                job.say(topic, chance.uniform(-1, 1), chance.uniform(-2, 2))
        job.session.step()
    return job.recorder.stream[before:]


@pytest.mark.parametrize(
    ("scene", "ticks"), [("dd100_flat", 1), ("dd100_flat", 50), ("demo", 50), ("tutorial/navigation", 50)]
)
def test_graphs_that_do_the_same_after_a_change_go_on_byte_by_byte(library: Path, scene: str, ticks: int) -> None:
    with begin(library, scene) as job:
        wanted = run(job, ticks, 1) + run(job, 60, 2)
    with begin(library, scene) as job:
        before = run(job, ticks, 1)
        change_every_graph(library)
        done = job.session.reload()
        assert set(done.changed) == {graph.name for graph in job.session.graphs}
        assert done.kept == done.nodes - len(done.changed)
        assert before + run(job, 60, 2) == wanted


def test_samples_and_noise_of_sensors_go_on(tmp_path: Path, library: Path) -> None:
    scene = crowd.scene(tmp_path, crowd.FIRST)
    with Job(scene, shipped=library) as job:
        wanted = run(job, 35, 1) + run(job, 35, 2)
    with Job(scene, shipped=library) as job:
        before = run(job, 35, 1)
        change_every_graph(library)
        assert job.session.reload().changed
        assert before + run(job, 35, 2) == wanted


@pytest.mark.parametrize("rewrite", ["touched", "commented", "reloaded twice"])
def test_a_file_that_says_the_same_changes_nothing(library: Path, rewrite: str) -> None:
    graph = library / "graphs" / "dd100" / "cmd_vel.yaml"
    with begin(library) as job:
        wanted = run(job, 40, 1) + run(job, 40, 2)
    with begin(library) as job:
        before, graphs = run(job, 40, 1), list(job.session.graphs)
        text = graph.read_text(encoding="utf-8")
        graph.write_text(text if rewrite == "touched" else f"# a comment\n{text}", encoding="utf-8")
        done = [job.session.reload(), *([job.session.reload()] if rewrite == "reloaded twice" else [])]
        assert not any(one.changed or one.restarted for one in done)
        assert list(job.session.graphs) == graphs
        assert before + run(job, 40, 2) == wanted


def test_messages_name_the_lines_of_the_new_file(library: Path) -> None:
    graph = library / "graphs" / "dd100" / "cmd_vel.yaml"
    with begin(library) as job:
        graph.write_text(f"# one\n# two\n{graph.read_text(encoding='utf-8')}", encoding="utf-8")
        (before,) = [one for one in job.session.graphs if one.name == "dd100/cmd_vel"]
        line = before.executor.graph.by_id("DiffController").span.line
        job.session.reload()
        assert before.executor.graph.by_id("DiffController").span.line == line + 2


def test_a_changed_limit_holds_from_the_next_tick_on_and_the_robot_stays_where_it_is(library: Path) -> None:
    with begin(library) as job:
        job.drive(CMD_VEL, 1.0, 0.0, 3.0)
        here, time = job.session.services.world.entities.state("dd100").position, job.session.time
        edit(library / "graphs" / "dd100" / "cmd_vel.yaml", "maxLinearSpeed: 1.3", "maxLinearSpeed: 0.2")
        assert job.session.reload().changed == ("dd100/cmd_vel",)
        assert (job.session.services.world.entities.state("dd100").position, job.session.time) == (here, time)
        job.drive(CMD_VEL, 1.0, 0.0, 2.0)
        assert job.velocity("/dd100_0000/odom")[0] == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("scenes/dd100_flat.yaml", "position: [0", "position: [1"),
        ("scenes/robots/dd100.yaml", "static_friction: 1.0", "static_friction: 0.5"),
        ("scenes/dd100_flat.yaml", "tick_rate: 60", "tick_rate: 120"),
    ],
)
def test_another_world_begins_as_a_new_run_does(library: Path, file: str, old: str, new: str) -> None:
    with begin(library) as job:
        first = run(job, 30)
        edit(library / file, old, new)
        done = job.session.reload()
        assert (done.restarted, job.session.time, job.session.ticks) == (True, 0.0, 30)
        after = run(job, 80)
    with begin(library) as job:
        assert after == run(job, 80)
    edit(library / file, new, old)
    with begin(library) as job:
        assert first == run(job, 30)


@pytest.fixture
def job(library: Path) -> Iterator[Job]:
    with begin(library) as job:
        yield job


def test_a_spawned_robot_gets_the_changed_graphs_of_its_file_too(library: Path, job: Job) -> None:
    job.spawn("late", LATE)
    run(job, 20)
    edit(library / "graphs" / "dd100" / "cmd_vel.yaml", "maxLinearSpeed: 1.3", "maxLinearSpeed: 0.2")
    done = job.session.reload()
    assert (done.changed, done.restarted) == (("dd100/cmd_vel", "late/cmd_vel"), False)
    job.drive("/late/cmd_vel", 1.0, 0.0, 2.0)
    assert job.velocity("/late/odom")[0] == pytest.approx(0.2, abs=0.01)
    job.remove("late")
    assert job.session.reload().files == ()


def test_a_robot_that_was_removed_stays_away_when_its_graphs_change(library: Path, job: Job) -> None:
    job.remove("dd100")
    change_every_graph(library)
    assert job.session.reload().changed == ("clock",)
    assert [graph.name for graph in job.session.graphs] == ["clock"]


def test_a_robot_spawned_after_a_change_is_as_its_file_says_then(library: Path, job: Job) -> None:
    edit(library / "graphs" / "dd100" / "cmd_vel.yaml", "maxLinearSpeed: 1.3", "maxLinearSpeed: 0.2")
    job.session.reload()
    job.spawn("late", LATE)
    job.drive("/late/cmd_vel", 1.0, 0.0, 2.0)
    assert job.velocity("/late/odom")[0] == pytest.approx(0.2, abs=0.01)


def test_a_changed_robot_file_begins_anew_without_spawned_robots(tmp_path: Path, library: Path) -> None:
    own = library / "scenes" / "robots" / "own.yaml"
    own.write_text("robot: own\nextends: dd100.yaml\n", encoding="utf-8")
    with begin(library) as job:
        job.spawn("late", LATE.model_copy(update={"use": "robots/own.yaml"}))
        run(job, 5)
        own.write_text("robot: own\nextends: dd100.yaml\n# the same\n", encoding="utf-8")
        assert not job.session.reload().restarted
        own.write_text("robot: own\nextends: dd100.yaml\nmaterials: {Soft: {static_friction: 0.1}}\n", encoding="utf-8")
        done = job.session.reload()
        assert (done.restarted, done.lost, list(job.session.roster.spawned)) == (True, ("late",), [])
        assert str(done).endswith("restarted at t = 0; late must be spawned again")
        job.spawn("late", LATE)


@pytest.mark.parametrize("file", ["graphs/dd100/cmd_vel.yaml", "scenes/dd100_flat.yaml", "scenes/robots/dd100.yaml"])
@pytest.mark.parametrize("mistake", ["nonsense: [", "", "nonsense: 1\n"])
def test_a_file_with_errors_changes_nothing_until_it_is_mended(library: Path, file: str, mistake: str) -> None:
    path = library / file
    right = path.read_text(encoding="utf-8")
    with begin(library) as job:
        wanted = run(job, 30, 1) + run(job, 30, 2) + run(job, 30, 3)
    with begin(library) as job:
        before = run(job, 30, 1)
        path.write_text(mistake + right if mistake else "", encoding="utf-8")
        with pytest.raises(CheckError) as error:
            job.session.reload()
        assert [finding.severity for finding in error.value.findings] == ["error"] * len(error.value.findings)
        assert job.session.findings[0].startswith(f"{path}:")
        middle = run(job, 30, 2)
        path.write_text(right, encoding="utf-8")
        done = job.session.reload()
        assert (done.mended, job.session.findings, done.changed, done.restarted) == (True, (), (), False)
        assert before + middle + run(job, 30, 3) == wanted


def test_added_graphs_start_and_removed_graphs_say_goodbye(library: Path, job: Job) -> None:
    scene = library / "scenes" / "dd100_flat.yaml"
    run(job, 5)
    edit(scene, "graphs/clock.yaml", "new.yaml")
    with pytest.raises(CheckError, match=r"no file 'new\.yaml'"):
        job.session.reload()
    assert scene.parent / "new.yaml" in job.session.reloader.watched()
    clock = (library / "graphs" / "clock.yaml").read_text(encoding="utf-8")
    (scene.parent / "new.yaml").write_text(clock.replace("graph: clock", "graph: other"), encoding="utf-8")
    edit(scene, "  clock: {", "  other: {")
    done = job.session.reload()
    assert (done.added, done.removed, done.mended) == (("other",), ("clock",), True)
    assert run(job, 1)


@pytest.mark.parametrize("scene", ["dd100_flat", "demo"])
@pytest.mark.parametrize("change", ["graphs", "world", "world and spawned"])
def test_a_checkpoint_restores_the_graphs_of_its_time(library: Path, scene: str, change: str) -> None:
    with begin(library, scene) as job:
        run(job, 30, 1)
        if change == "world and spawned":
            job.spawn("late", LATE, force=True)
            run(job, 10, 1)
        job.ask("checkpoint", name="before")
        robots = [prim.path for prim in job.session.services.stage.prims("robot")]
        wanted = run(job, 40, 2)
        change_every_graph(library)
        if change != "graphs":
            edit(library / f"scenes/{scene}.yaml", "  dd100:\n", "  other:\n")
        assert job.session.reload().restarted == (change != "graphs")
        job.ask("checkpoint", name="after")
        later = run(job, 20, 3)
        job.ask("restore", name="before")
        assert [prim.path for prim in job.session.services.stage.prims("robot")] == robots
        assert run(job, 40, 2) == wanted
        job.ask("restore", name="after")
        assert run(job, 20, 3) == later
        job.ask("restore", name="before")
        assert job.session.reload().changed
        run(job, 5)


def test_peers_over_dds_lose_no_message_and_see_no_endpoint_come_or_go(library: Path, domain_id: int) -> None:
    def join(name: str) -> DdsTransport:
        return DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), name))

    heard: list[int] = []

    def hear(data: bytes) -> None:
        stamp = messages.decode(data, "nav_msgs/msg/Odometry").header.stamp
        heard.append(round(60 * (stamp.sec + 1e-9 * stamp.nanosec)))

    peer = join("peer")
    peer.reader("/dd100_0000/odom", "nav_msgs/msg/Odometry", QoS(), hear)
    loaded = build.load(library / "scenes/dd100_flat.yaml", Options(shipped=library))
    with build.start(loaded, LiveNetwork(lambda _: join("run"), domain_id, print)) as session:
        assert eventually(lambda: heard, session.step)

        def endpoints() -> set[bytes]:
            return {end.gid for end in peer.graph().endpoints}

        before = endpoints()
        for _ in range(3):
            change_every_graph(library)
            assert session.reload().changed
            session.step()
        assert eventually(lambda: heard[-1] == session.clock.frame)
        assert heard == list(range(heard[0], session.clock.frame + 1))
        assert endpoints() == before
    peer.close()


def test_a_value_from_the_command_line_must_still_have_its_input(library: Path) -> None:
    limit = {"DiffController.maxLinearSpeed": 0.3}
    with Job(library / "scenes/dd100_flat.yaml", limit, shipped=library) as job:
        graph = library / "graphs/dd100/cmd_vel.yaml"
        edit(graph, "maxLinearSpeed: 1.3", "maxLinearSpeed: 1.0")
        assert job.session.reload().changed == ()
        edit(graph, "DiffController", "Renamed")
        with pytest.raises(UsageError, match="no node"):
            job.session.reload()
        assert "DiffController" in job.session.findings[0]
        run(job, 3)
        edit(graph, "Renamed", "DiffController")
        assert job.session.reload().mended
