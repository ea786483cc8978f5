"""A scene that is packed is loaded in another process, where none of its files are."""

from __future__ import annotations

import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.format.errors import RecordingError
from graphengine.recording.packing import PackedScene
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests.jobs.harness import ROOT, Job, assemble
from tests.nodes.harness import write
from tests.physics.bases import MECANUM, ON_THE_FLOOR
from tests.physics.harness import FLOOR

ELSEWHERE = """
import pickle, sys, tempfile
from pathlib import Path
from graphengine.recording.sources import Workspace
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build
packed = pickle.load(sys.stdin.buffer)
with tempfile.TemporaryDirectory() as folder:
    scene = build.load(*packed.lay_out(Workspace(Path(folder))))
    transport = MemoryTransport(wants_all=True)
    with build.start(scene, LiveNetwork(lambda _: transport, 0, print)) as session:
        session.step(30)
    assert all(str(path).startswith(folder) for path in scene.files.used), list(scene.files.used)
    sys.stdout.buffer.write(pickle.dumps([transport.raw(claim.topic) for claim in scene.claims]))
"""


def project(folder: Path) -> Path:
    """A scene with a robot file and a graph of its own, beside what ships."""
    shutil.copytree(ROOT / "scenes" / "robots", folder / "bots")
    (folder / "tick.yaml").write_text(
        "format: 1\ngraph: tick\nnodes:\n  Tick: OnPlaybackTick\n  Say: {type: ROS2PublishClock, inputs: {topicName: tick}}\n"
        "  Time: IsaacReadSimulationTime\nconnections: [Tick.tick -> Say.execIn, Time.simulationTime -> Say.timeStamp]\n"
    )
    (folder / "scene.yaml").write_text(
        "format: 1\nscene: mine\nworld: worlds/flat_grid.xml\nrobots: {one: {use: bots/dd100.yaml}}\n"
        "graphs: {tick: {use: tick.yaml}}\n"
    )
    return folder / "scene.yaml"


def elsewhere(packed: PackedScene, folder: Path) -> list[list[bytes]]:
    """What the scene's topics carry in another process."""
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE],
        input=pickle.dumps(packed),
        capture_output=True,
        cwd=folder,
        env={"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr.decode()
    sent: list[list[bytes]] = pickle.loads(done.stdout)
    return sent


def test_a_packed_scene_sends_the_same_bytes_without_its_files(tmp_path: Path) -> None:
    path = project(tmp_path / "project")
    scene = build.load(path, Options(overrides={"Say.topicName": "tock"}))
    scene.findings.raise_errors()
    with Job(path, {"Say.topicName": "tock"}) as job:
        job.session.step(30)
        here = [job.transport.raw(claim.topic) for claim in scene.claims]
    packed = PackedScene.of(scene)
    shutil.rmtree(tmp_path / "project")
    assert elsewhere(packed, tmp_path) == here
    assert any(here)


def test_a_packed_scene_contains_no_path_of_this_machine(tmp_path: Path) -> None:
    packed = PackedScene.of(build.load(project(tmp_path / "project")))
    assert str(tmp_path) not in repr((packed.given, packed.scene, packed.options, list(packed.files)))
    assert packed.given == "project/project/scene.yaml"


def test_the_error_names_a_file_that_was_deleted_meanwhile(tmp_path: Path) -> None:
    scene = build.load(project(tmp_path / "project"))
    (tmp_path / "project" / "tick.yaml").unlink()
    with pytest.raises(RecordingError, match=r"tick\.yaml: cannot be read again"):
        PackedScene.of(scene)


def test_the_ray_casting_method_of_lidars_is_packed() -> None:
    assert PackedScene.of(assemble("dd100_flat")).options.rays in ("fast", "mujoco")


@pytest.mark.parametrize(("kind", "profile"), [("radar", "radar_77ghz"), ("range", "hc_sr04")])
def test_the_ray_casting_method_of_other_sensors_is_packed(tmp_path: Path, kind: str, profile: str) -> None:
    sensor = f"sensors: {{eye: {{type: {kind}, profile: {profile}, parent: base_link}}}}\n"
    write(tmp_path, MECANUM.files(sensor) | {"world.xml": FLOOR, "scene.yaml": ON_THE_FLOOR.format(height=0.05)})
    assert PackedScene.of(build.load(tmp_path / "scene.yaml")).options.rays in ("fast", "mujoco")
