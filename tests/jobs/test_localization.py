"""`--localization truth`: map -> odom -> base link is the pose of a robot in the world, in every tick."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.devices.rotation import Pose, compose
from graphengine.format.spec import RobotUse
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests.jobs.harness import Job, assemble, nanoseconds

WHEELS = "robot: dd100\nextends: robots/dd100.yaml\ngraphs: {joint_states: {use: graphs/wheel_odometry.yaml}}\n"
SCENE = "scene: s\nworld: worlds/flat_grid.xml\nrobots:\n  dd100: {use: robot.yaml, position: [1.0, 2.0, 0.02]}\n"
TF, CMD_VEL = "/dd100_0000/tf", "/dd100_0000/cmd_vel"


def scene_with(folder: Path, robot: str) -> Path:
    (folder / "robot.yaml").write_text(robot, "utf-8")
    (folder / "scene.yaml").write_text(SCENE, "utf-8")
    return folder / "scene.yaml"


def transforms(job: Job) -> dict[tuple[str, str], dict[int, Pose]]:
    """Poses by stamp for each pair of frames on tf."""
    found: dict[tuple[str, str], dict[int, Pose]] = {}
    for message in job.heard(TF):
        for edge in message.transforms:
            t, r = edge.transform.translation, edge.transform.rotation
            pose = (t.x, t.y, t.z), (r.x, r.y, r.z, r.w)
            found.setdefault((edge.header.frame_id, edge.child_frame_id), {})[nanoseconds(edge.header.stamp)] = pose
    return found


def drive_and_compare(job: Job, before: int = 0) -> float:
    """Drive a curve after some ticks; check that each tick has a transform; return the greatest error of map -> base_link."""
    true = dict[int, Any]()
    for tick in range(180):
        if tick % 6 == 0:
            job.say(CMD_VEL, 0.5, 0.6)
        job.session.step()
        state = job.session.services.world.entities.state("dd100")
        true[round(job.session.time * 1e9)] = (state.position, state.orientation)
    edges = transforms(job)
    corrections, odometry = edges["map", "odom"], edges["odom", "base_link"]
    assert corrections.keys() == odometry.keys()
    assert len(corrections) == 180 + before
    errors = []
    for stamp, correction in list(corrections.items())[before:]:
        nearest = min(true, key=lambda time: abs(time - stamp))
        assert abs(nearest - stamp) < 10
        position, orientation = compose(correction, odometry[stamp])
        errors.append(np.abs(np.subtract(position, true[nearest][0])).max())
        errors.append(1.0 - abs(np.dot(orientation, true[nearest][1])))
    return float(max(errors))


@pytest.mark.parametrize("scene", ["dd100_flat", "dd100_warehouse"])
def test_a_robot_with_exact_odometry_is_where_it_is(scene: str) -> None:
    with Job(scene, localization="truth") as job:
        assert drive_and_compare(job) < 1e-9


def test_drifting_wheel_odometry_is_corrected_in_every_tick(tmp_path: Path) -> None:
    with Job(scene_with(tmp_path, WHEELS), {"WheelOdometry.slip": 0.05}, localization="truth") as job:
        assert drive_and_compare(job) < 1e-9
        (x, y, _), _ = transforms(job)["map", "odom"].popitem()[1]
    assert math.hypot(x - 1.0, y - 2.0) > 0.005  # it drifts


def test_map_to_odom_starts_again_after_a_reset() -> None:
    with Job("dd100_flat", localization="truth") as job:
        first = drive_and_compare(job)
        job.ask("reset")
        job.run(0.1)
        last = list(transforms(job)["map", "odom"])
    assert first < 1e-9
    assert nanoseconds(job.heard(TF)[-1].transforms[0].header.stamp) < 200_000_000
    assert last


def test_it_goes_on_when_the_odometry_is_set_up_again() -> None:
    with Job("dd100_flat", localization="truth") as job:
        job.run(0.1)
        job.ask("set", address="PublishRawTF.queueSize", value=5)
        assert drive_and_compare(job, before=6) < 1e-9


def test_a_robot_that_is_spawned_has_it_too() -> None:
    with Job("dd100_flat", localization="truth") as job:
        job.spawn("other", RobotUse(use="robots/dd100.yaml", namespace="other", position=(0.0, 3.0, 0.02)))
        job.run(0.1)
        edges = [edge for message in job.heard("/other/tf") for edge in message.transforms]
        x, y, _ = job.session.services.world.entities.state("other").position
    assert [edge.child_frame_id for edge in edges].count("odom") == 6
    first = next(edge.transform.translation for edge in edges if edge.child_frame_id == "odom")
    assert (first.x, first.y) == pytest.approx((x, y), abs=1e-3)


def test_without_listeners_nothing_is_published() -> None:
    with Job("dd100_flat", localization="truth", heard=False) as job:
        job.run(0.2)
        assert job.transport.raw(TF) == []


def test_the_frames_of_each_robot_of_a_fleet_are_in_its_namespace(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(
        "scene: s\nworld: worlds/flat_grid.xml\nrobots:\n"
        "  a: {use: robots/dd100.yaml, namespace: a}\n  b: {use: robots/dd100.yaml, namespace: b, position: [0, 3, 0.02]}\n",
        "utf-8",
    )
    claims = [claim for claim in assemble(tmp_path / "scene.yaml", localization="truth").claims if claim.transforms]
    assert {claim.topic for claim in claims if ("map", "odom") in claim.transforms} == {"/a/tf", "/b/tf"}


def test_a_robot_without_odometry_is_a_warning_that_says_what_to_add(tmp_path: Path) -> None:
    scene = scene_with(
        tmp_path, "robot: dd100\nextends: robots/dd100.yaml\ngraphs: {joint_states: {use: graphs/robot_state.yaml}}\n"
    )
    findings = build.load(scene, Options(localization="truth")).findings
    assert findings.errors == []
    (missing,) = (finding for finding in findings.warnings if finding.message.startswith("no node publishes odometry"))
    assert missing.message == (
        "no node publishes odometry of /dd100 on /dd100_0000/tf, a transform from odom to the base link, so "
        "map -> odom will not be published"
    )
    assert "graphs/wheel_odometry.yaml" in missing.help[0]


def test_a_robot_that_is_fixed_to_the_world_gets_none(tmp_path: Path) -> None:
    scene = scene_with(tmp_path, "robot: dd100\nextends: robots/dd100.yaml\nfixed_base: true\n")
    graphs = [graph.name for graph in build.load(scene, Options(localization="truth")).graphs]
    assert "dd100/localization" not in graphs


def test_a_graph_that_runs_before_the_odometry_is_a_warning_of_the_run(tmp_path: Path) -> None:
    robot = (
        "robot: dd100\nextends: robots/dd100.yaml\ngraphs:\n  joint_states: {use: graphs/localization.yaml}\n"
        "  odometry: {use: graphs/dd100/joint_states.yaml}\n"
    )
    logged = list[str]()
    with Job(scene_with(tmp_path, robot)) as job:
        job.session.services.log = lambda severity, node, message: logged.append(message)
        job.run(0.1)
        assert ("map", "odom") not in transforms(job)
    assert logged[0].startswith("map -> odom is not published: the odometry of this tick must be published first")
